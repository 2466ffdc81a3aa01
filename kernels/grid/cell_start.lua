-- SPDX-License-Identifier: MIT
return {
  about = "where each cell begins among the sorted keys",
  params = {
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 256 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 1024 }, default = function(limits) return limits.cpu and 1024 or 1 end,
      about = "objects a work-item" },
  },
  args = {
    cell_start = [[
      const uint *keys
      uint n_keys
      uint key_end
      uint *key_starts
    ]],
    row_start = [[
      const uint *keys
      uint n_keys
      uint key_end
      uint *key_starts
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
