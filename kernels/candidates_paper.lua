-- SPDX-License-Identifier: MIT
return {
  about = "the paper's search: all cells around, through ids, one atomic a pair",
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "IDS", values = { 0, 1 }, default = 0, about = "1: the candidates are the answer" },
    { "WG", values = { 1, 32, 64, 128, 256 }, default = 64, about = "work-items a group" },
  },
  launch = function(p) return { group = p.WG, per_item = 1 } end,
}
