-- SPDX-License-Identifier: MIT
return {
  about = "separating axis test of the candidates",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "narrowphase/sat.clh", "narrowphase/sat_double.clh",
    "narrowphase/rounded.clh", "grid/places.h", "narrowphase/boxes.clh" },
  params = {
    common.DIMS,
    { "SHAPE", values = { 0 }, min = 0, max = 3, default = 0,
      about = "0 poses, 2 rounded boxes, 3 spheres; bounds need no test" },
    common.ROTATED, common.ORIGIN, common.ACCURACY,
    { "SORTED", values = { 0, 1 }, default = 1, about = "where a box is read: 0 by id, 1 in cell order" },
    common.ONE_LANE,
    { "WG", values = { 1, 32, 64, 128, 256 }, default = common.by_device(1, 256), about = "work-items a group" },
    { "PER_ITEM", values = { 1, 2, 4, 256 }, default = common.by_device(256, 4),
      about = "candidates a work-item tests between two flushes" },
  },
  args = {
    narrow = [[
      const float *objects   if SORTED == 0
      const float4 *boxes    if SORTED == 1
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
    if p.WG * p.PER_ITEM * 8 + 64 > limits.local_bytes then return false, "pairs above the device's local memory" end
    if p.ACCURACY == 5 and not limits.fp64 then return false, "the device has no double" end
  end,
}
