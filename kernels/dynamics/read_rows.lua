-- SPDX-License-Identifier: MIT
return {
  about = "rows of some objects together, and which rows have changed",
  uses = { "dynamics/border.h" },
  params = {
    common.GROUP(64),
    { "PER_ITEM", values = { 1, 64 }, default = function(limits) return limits.cpu and 64 or 1 end,
      about = "rows, or words of 32 rows, a work-item" },
  },
  args = {
    gather_rows = [[
      const uint *rows
      uint row_words
      const uint *ids
      uint n_ids
      uint *gathered
    ]],
    changed_rows = [[
      const uint *rows
      uint row_words
      uint n
      uint *last_rows
      uint *changed
    ]],
  },
}
