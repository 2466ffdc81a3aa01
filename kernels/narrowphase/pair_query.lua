-- SPDX-License-Identifier: MIT
return {
  about = "separating axis test of pairs that the caller brings",
  uses = { "lanes.clh", "narrowphase/object.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/answer.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "SHAPE", values = { 0 }, default = 0, about = "poses: bounds need no test" },
    { "ROTATED", values = { 1 }, default = 1, about = "a pair's answer is its own, whatever the others are" },
    { "ACCURACY", values = { 0, 1, 2, 3, 4, 5 }, default = 0,
      about = "0 certified, 1 bounds, 2 spheres, 3 faces' axes, 4 all axes in float, 5 in double" },
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "pairs side by side in a work-item" },
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 512 }, default = function(limits) return limits.cpu and 512 or 1 end,
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
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
