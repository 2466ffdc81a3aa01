-- SPDX-License-Identifier: MIT
-- The simplest kernel: two floats are read and one is written for each item.
local p = parameters { n = 1000000, seed = 1 }

-- What is right. Lua takes too long for many items: there another kernel finds it.
local function reference(v)
  for i = 0, v.items - 1 do v.y[i] = v.a * v.x[i] + v.y[i] end
end

return {
  kernel = "saxpy",
  args = {
    a = 2.0,
    x = { "float", p.n, init = "random", access = "slice" },
    y = { "float", p.n, init = "random", access = "in out slice" },
  },
  items = p.n,
  reference = p.n > 4e6 and "saxpy_plain" or reference,
  tolerance = 1e-6,
  key = { n = p.n },
}
