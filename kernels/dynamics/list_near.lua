-- SPDX-License-Identifier: MIT
-- How many bodies there are, and how they are told.
local told = [[
  uint n
  const uint2 *places
  const float *extents
  uint n_extents
  uint near_capacity
  volatile uint *near
]]

return {
  about = "bodies of a domain that are near its borders, or leave it",
  uses = { "primitives/sortable.clh", "dynamics/border.h", "dynamics/place_kind.clh" },
  params = { common.DIMS, common.DOUBLE, common.GROUP(64), common.ROWS_AN_ITEM },
  valid = common.can_double,
  args = {
    list_near = [[
      const float *boxes
    ]] .. told,
    list_meeting = [[
      const float *far_boxes
    ]] .. told,
    make_far_boxes = [[
      const float *boxes
      const real4 *velocities
      float far_time
      float far_margin
      uint n
      const uint2 *places
      const float *extents
      uint near_capacity
      volatile uint *near
      float *far_boxes
    ]],
  },
}
