-- SPDX-License-Identifier: MIT
return {
  about = "what black_scholes finds, in double and by another normal distribution function",
  params = {},
  args = {
    black_scholes_plain = [[
      ulong first
      ulong last
      float rate
      float volatility
      const float *price
      const float *strike
      const float *years
      float *call
      float *put
    ]],
  },
  launch = function() return { group = 64, per_item = 1 } end,
}
