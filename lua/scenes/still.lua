-- SPDX-License-Identifier: MIT
-- Boxes that call for no effect, to be compared with falling.
--
-- There is no velocity, no gravity, nothing wanted: a step launches nothing.

local p = parameters { n = 100000, seed = 1 }

local random = random(p.seed)
local side = math.max(1, p.n ^ (1 / 3) * 2)

for _ = 1, p.n do
  local x, y, z = random.uniform(0, side), random.uniform(0, side), random.uniform(0, side)
  add(x, y, z, 0.5, 0.5, 0.5, random.quaternion())
end

return { dims = 3, world = { lower = { 0, 0, 0 }, upper = { side, side, side } } }
