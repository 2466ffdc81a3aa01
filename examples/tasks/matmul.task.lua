-- SPDX-License-Identifier: MIT
-- Rows of a and c are shared; both devices read all of b.
local p = parameters { n = 256, seed = 1 }

-- How far an element may be from the reference's, to first order in the rounding unit u = 2^-24.
--
-- The first product of an element goes through n roundings in either kernel: the kernel rounds n times by fma, the
-- reference a product and n - 1 sums. Each is at most n u times the sum of the products' sizes off. That sum is of n
-- products, each of the sizes of two random numbers from -1 to 1: n / 4 in the mean, and by Hoeffding's inequality
-- above n / 4 + t in none of the n^2 elements but with a probability of n^2 exp(-2 t^2 / n), which is 1e-12 here.
local t = math.sqrt(p.n / 2 * (2 * math.log(p.n) + 12 * math.log(10)))
local sizes = math.min(p.n, p.n / 4 + t)

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
  tolerance = 2 * p.n * 2 ^ -24 * sizes,
  key = { n = p.n },
}
