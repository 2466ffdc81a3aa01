-- SPDX-License-Identifier: MIT
-- Rows are shared, and each device reads one row more on each side: the halo.
local p = parameters { n = 512, width = 1024, seed = 1 }

-- What is right. Lua takes too long for many cells: there another kernel finds it.
local function reference(v)
  local before, w = v.before, v.width
  for y = 0, v.rows - 1 do
    for x = 0, w - 1 do
      local u = y * w + x
      local own = before[u]
      local left = x > 0 and before[u - 1] or own
      local right = x < w - 1 and before[u + 1] or own
      local above = y > 0 and before[u - w] or own
      local below = y < v.rows - 1 and before[u + w] or own
      v.after[u] = own + v.rate * (left + right + above + below - 4 * own)
    end
  end
end

return {
  kernel = "stencil",
  args = {
    width = p.width,
    rows = p.n,
    rate = 0.2,
    before = { "float", p.n * p.width, init = "random", access = "slice", halo = 1 },
    after = { "float", p.n * p.width, access = "out slice" },
  },
  items = p.n,
  work = p.width,
  reference = p.n * p.width > 4e6 and "stencil_plain" or reference,
  tolerance = 1e-6,
  key = { n = p.n, width = p.width },
}
