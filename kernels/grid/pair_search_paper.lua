-- SPDX-License-Identifier: MIT
return {
  about = "the paper's search: all cells around, through ids, one atomic a pair",
  uses = { "counters.h" },
  params = {
    common.DIMS,
    { "IDS", values = { 0, 1 }, default = 0, about = "1: the candidates are the answer" },
    common.CELLS_X, common.CELLS_Y, common.CELLS_Z,
    { "WG", values = { 1, 32, 64, 128, 256 }, default = 64, about = "work-items a group" },
  },
  args = {
    pair_search_paper = [[
      const uint *keys
      const uint *ids
      const uint *starts
      const float4 *bounds_by_id
      uint n
      uint first
      uint last
      int4 cells
      uint key_from
      uint n_home_cells
      uint n_own_cells
      uint2 *found
      uint found_capacity
      volatile uint *counters
    ]],
  },
  valid = function(p)
    if (p.CELLS_X == 0) ~= (p.CELLS_Y == 0) or (p.CELLS_X == 0) ~= (p.CELLS_Z == 0) then return false, "CELLS_X, CELLS_Y and CELLS_Z go together" end
  end,
  launch = function(p) return { group = p.WG, per_item = 1 } end,
}
