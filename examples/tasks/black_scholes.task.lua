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

return {
  kernel = "black_scholes",
  args = {
    rate = 0.02,
    volatility = 0.3,
    price = { "float", p.n, init = "random", min = 5, max = 30, access = "slice" },
    strike = { "float", p.n, init = "random", min = 1, max = 100, access = "slice" },
    years = { "float", p.n, init = "random", min = 0.25, max = 10, access = "slice" },
    call = { "float", p.n, access = "out slice" },
    put = { "float", p.n, access = "out slice" },
  },
  items = p.n,
  reference = function(v)
    local s, r = v.volatility, v.rate
    for i = 0, v.items - 1 do
      local price, strike, years = v.price[i], v.strike[i], v.years[i]
      local spread = s * math.sqrt(years)
      local d1 = (math.log(price / strike) + (r + s * s / 2) * years) / spread
      local d2, paid = d1 - spread, strike * math.exp(-r * years)
      v.call[i] = price * normal(d1) - paid * normal(d2)
      v.put[i] = paid * normal(-d2) - price * normal(-d1)
    end
  end,
  tolerance = 1e-4,
  key = { n = p.n },
}
