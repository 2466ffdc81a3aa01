-- SPDX-License-Identifier: MIT
return {
  about = "separating axis test of listed candidates, eight at a time",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/rounded.clh", "grid/places.h", "narrowphase/box_rows.clh", "narrowphase/collide.clh" },
  params = {
    common.DIMS,
    { "SHAPE", values = { 0 }, min = 0, max = 3, default = 0,
      about = "0 poses, 2 rounded boxes, 3 spheres; bounds need no test" },
    common.ROTATED, common.ORIGIN, common.ACCURACY,
    { "LANES", values = { 8 }, default = 8, about = "pairs side by side in a work-item" },
    { "WG", values = { 1 }, default = 1, about = "work-items a group" },
    { "AHEAD", values = { 0, 16, 32, 64 }, default = common.by_device(32, 0),
      about = "boxes asked for before they are needed" },
    { "PER_ITEM", values = { 256, 512, 1024 }, default = 512, about = "candidates a work-item tests at once" },
  },
  args = {
    narrow_simd = [[
      const float *boxes
      const uint2 *candidates
      uint candidate_capacity
      uint2 *pairs
      uint pair_capacity
      uint2 *undecided
      uint undecided_capacity
      volatile uint *counters
    ]],
  },
  valid = function(p, limits)
    if p.SHAPE == 1 then return false, "bounds need no test" end
    if p.SHAPE == 3 and p.ROTATED == 1 then return false, "spheres have no rotation" end
    if p.AHEAD > 0 and not limits.cpu then return false, "AHEAD is for CPUs" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
  end,
}
