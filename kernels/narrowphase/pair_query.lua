-- SPDX-License-Identifier: MIT
return {
  about = "separating axis test of pairs that the caller brings",
  uses = { "lanes.clh", "narrowphase/object.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/answer.clh" },
  params = {
    common.DIMS,
    { "SHAPE", values = { 0 }, default = 0, about = "poses: bounds need no test" },
    { "ROTATED", values = { 1 }, default = 1, about = "a pair's answer is its own, whatever the others are" },
    common.ACCURACY,
    { "LANES", values = { 1, 8 }, default = common.by_device(8, 1), about = "pairs side by side in a work-item" },
    common.WG(128),
    { "PER_ITEM", values = { 1, 512 }, default = common.by_device(512, 1),
      about = "pairs a work-item tests one after the other" },
  },
  args = {
    pair_query = [[
      const float *poses
      uint n
      uchar *answers
    ]],
  },
  valid = function(p, limits)
    if p.WG > limits.max_group then return false, "WG above the device's limit of " .. limits.max_group end
    if p.PER_ITEM % p.LANES ~= 0 then return false, "PER_ITEM not a multiple of LANES" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
  end,
}
