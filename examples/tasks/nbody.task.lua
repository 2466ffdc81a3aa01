-- SPDX-License-Identifier: MIT
-- Every body is read for every other: much arithmetic for few bytes.
local p = parameters { n = 8192, seed = 1 }
return {
  kernel = "nbody",
  args = {
    n = p.n,
    softening = 0.01,
    bodies = { "float4", p.n, init = "random" },
    acceleration = { "float4", p.n, access = "out slice" },
  },
  items = p.n,
  reference = "nbody_plain",
  tolerance = 1e-4,
  key = { n = p.n },
}
