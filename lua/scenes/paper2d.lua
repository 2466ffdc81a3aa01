-- SPDX-License-Identifier: MIT
-- The paper's scene in 2D: unit squares at random in a square, rotated.
--
-- The world is 2000 x 2000; a square has as many neighbours as a cube has in paper.lua.

local p = parameters {
  n = 1000000,
  seed = 1,
  world = 2000.0, -- its edge; grow it by the square root of n for one density
  rotated = true, -- false: all squares stay parallel to the axes
}

local random = random(p.seed)

for _ = 1, p.n do
  local x, y = random.uniform(0, p.world), random.uniform(0, p.world)
  add(x, y, 0.5, 0.5, p.rotated and random.angle() or 0)
end

return {
  dims = 2,
  world = { lower = { 0, 0 }, upper = { p.world, p.world } },
}
