-- SPDX-License-Identifier: MIT
return {
  about = "where each cell begins among the sorted keys",
  params = {
    common.WG(256), common.PER_ITEM,
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
}
