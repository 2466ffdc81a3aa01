-- SPDX-License-Identifier: MIT
return {
  about = "bodies near the borders of a domain that is one of many",
  uses = { "dynamics/border.h" },
  params = { common.GROUP(64), common.ROWS_AN_ITEM },
  args = {
    list_near = [[
      const float *boxes
      uint n
      const uint2 *places
      const float *extents
      uint n_extents
      uint near_capacity
      volatile uint *near
    ]],
  },
}
