-- SPDX-License-Identifier: MIT
-- The scene that the paper measures: unit cubes at random in a cube, rotated.
--
-- The world is 200 x 200 x 200. Serves to compare with the paper and with other programs, and
-- as the scene that figures are quoted for.

local p = parameters {
  n = 1000000,
  seed = 1,
  world = 200.0, -- its edge; grow it by the cube root of n for one density
  rotated = true, -- false: all cubes stay parallel to the axes
  euler = false, -- uniform Euler angles, as in the paper, not uniform rotations
  tiny = 0.0, -- part of the cubes that are a thousandth as wide
  giants = 0, -- cubes as wide as the world, besides
}

local random = random(p.seed)

local function rotation()
  if not p.rotated then return 0, 0, 0, 1 end
  if p.euler then return euler(random.angle(), random.angle(), random.angle()) end
  return random.quaternion()
end

for _ = 1, p.n do
  local x, y, z = random.uniform(0, p.world), random.uniform(0, p.world), random.uniform(0, p.world)
  local half = p.tiny > 0 and random.uniform(0, 1) < p.tiny and 0.0005 or 0.5
  add(x, y, z, half, half, half, rotation())
end
for _ = 1, p.giants do
  local half = p.world / 2
  add(half, half, half, half, half, half, 0, 0, 0, 1)
end

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { p.world, p.world, p.world } },
}
