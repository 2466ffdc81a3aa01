-- SPDX-License-Identifier: MIT
-- Every body is read for every other: much arithmetic for few bytes.
local p = parameters { n = 8192, seed = 1 }
local softening = 0.01

-- How far a component may be from the reference's, to first order in the rounding unit u.
--
-- Roundings of a term, each counted as u (an ulp is at most 2 u), by the errors that OpenCL allows: the kernel's
-- have 26 (a difference 1, the square of the softened distance 6, rsqrt 3 + 4, its cube and mass 3 * 7 + 3, their
-- product 1 + 1), the reference's 23 (sqrt 3 + 6 and a division 5 in the place of rsqrt). The kernel adds blocks of
-- 256 bodies and then the blocks: n / 256 + 255 roundings follow each other at most. Kahan's sum in the reference
-- has 2, and each multiplies by gravity once. All of it is relative to the sum of the terms' sizes, which is below
-- the mass, here below 1, times the greatest d / (d^2 + softening)^(3/2), at d^2 = softening / 2.
local roundings = 26 + 23 + (math.ceil(p.n / 256) + 255) + 2 + 2
local greatest = 2 / (3 * math.sqrt(3)) / softening

return {
  kernel = "nbody",
  args = {
    n = p.n,
    softening = softening,
    gravity = 1 / p.n, -- so that the mass of all bodies is below 1
    bodies = { "float4", p.n, init = "random" },
    acceleration = { "float4", p.n, access = "out slice" },
  },
  items = p.n,
  reference = "nbody_plain",
  tolerance = roundings * 2 ^ -24 * greatest,
  key = { n = p.n },
}
