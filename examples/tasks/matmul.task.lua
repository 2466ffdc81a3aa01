-- SPDX-License-Identifier: MIT
-- Rows of a and c are shared; both devices read all of b.
local p = parameters { n = 256, seed = 1 }
return {
  kernel = "matmul",
  args = {
    n = p.n,
    a = { "float", p.n * p.n, init = "random", min = -1, access = "slice" },
    b = { "float", p.n * p.n, init = "random", min = -1 },
    c = { "float", p.n * p.n, access = "out slice" },
  },
  items = p.n,
  work = p.n,
  reference = "matmul_plain",
  tolerance = 1e-4,
  key = { n = p.n },
}
