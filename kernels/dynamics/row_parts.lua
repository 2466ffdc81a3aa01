-- SPDX-License-Identifier: MIT
return {
  about = "parts of some bodies' rows together, and back",
  uses = {},
  params = {
    common.GROUP(64),
    { "PER_ITEM", values = { 1, 64 }, default = function(limits) return limits.cpu and 64 or 1 end,
      about = "rows a work-item" },
  },
  args = {
    pack_rows = [[
      const uint *rows
      uint row_words
      int4 row_parts
      uint of_four
      const uint *row_ids
      uint first_id
      uint n_ids
      uint *gathered
    ]],
    unpack_rows = [[
      uint *rows
      uint row_words
      int4 row_parts
      uint of_four
      const uint *row_ids
      uint first_id
      uint n_ids
      const uint *gathered
    ]],
  },
}
