-- SPDX-License-Identifier: MIT
-- Two numbers are computed from three, by functions that take a while.
local p = parameters { n = 500000, seed = 1 }

-- The normal distribution function, by Abramowitz and Stegun's formula 26.2.17: its error is below 7.5e-8.
local function normal(x)
  if x < 0 then return 1 - normal(-x) end
  local t = 1 / (1 + 0.2316419 * x)
  local sum = t * (0.319381530 + t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))))
  return 1 - math.exp(-x * x / 2) / math.sqrt(2 * math.pi) * sum
end

-- How far a price may be from the reference's, as part of the greater of 1 and it, to first order in the rounding unit
-- u = 2^-24, by the errors that OpenCL allows (an ulp is at most 2 u): erfc 16 ulp, log, exp and sqrt 3, a division 2.5.
-- Let N1 and N2 be the normal distribution at d1 and d2, and f1 and f2 its density.
--
-- An error of d1 is in d2, too, and price f1 = paid f2: it leaves call and put as they are, whose next term is
-- below u / 10. Left are, in u:
--   of price N1: erfc 32 and the product 1, times price; its argument 2 |d1| f1 < 0.5, times price
--   of paid N2: erfc 32 and the product 1, paid itself 7.4 (exp 6, its argument 0.4, the product 1), times paid N2
--   of paid f2 = price f1: spread 8 (sqrt 6, the product 1, volatility as a float 1) times 0.95, which is the greatest,
--   its difference and the argument 3 |d2|: 8 * 0.95 f1 + 3 |d2| f1 < 5, times price
--   the last difference 1, times the result
-- A call is not below 0, so that paid N2 is at most price. A put is paid (1 - N2) - price (1 - N1), so that
-- paid (1 - N2) is at most the put and the price. Seen as a part of the greater of 1 and either, all of it is at most
-- 33.5 price + 40.4 (1 + price) + 5 price + 1. The reference's normal is 7.5e-8 off, times price and paid.
local most = { price = 30, strike = 100 }
local roundings = 33.5 * most.price + 40.4 * (1 + most.price) + 5 * most.price + 1

-- What is right. Lua takes too long for many options: there another kernel finds it, with the same formula in double.
local function reference(v)
  local s, r = v.volatility, v.rate
  for i = 0, v.items - 1 do
    local price, strike, years = v.price[i], v.strike[i], v.years[i]
    local spread = s * math.sqrt(years)
    local d1 = (math.log(price / strike) + (r + s * s / 2) * years) / spread
    local d2, paid = d1 - spread, strike * math.exp(-r * years)
    v.call[i] = price * normal(d1) - paid * normal(d2)
    v.put[i] = paid * normal(-d2) - price * normal(-d1)
  end
end

return {
  kernel = "black_scholes",
  args = {
    rate = 0.02,
    volatility = 0.3,
    price = { "float", p.n, init = "random", min = 5, max = most.price, access = "slice" },
    strike = { "float", p.n, init = "random", min = 1, max = most.strike, access = "slice" },
    years = { "float", p.n, init = "random", min = 0.25, max = 10, access = "slice" },
    call = { "float", p.n, access = "out slice" },
    put = { "float", p.n, access = "out slice" },
  },
  items = p.n,
  reference = p.n > 4e6 and "black_scholes_plain" or reference,
  tolerance = roundings * 2 ^ -24 + 7.5e-8 * (most.price + most.strike),
  key = { n = p.n },
}
