-- SPDX-License-Identifier: MIT
-- Unit cubes in Gaussian clusters, with empty space between.
--
-- Most cells hold nothing and a few hold many, so that equal shares of the cells or of
-- the objects are not equal shares of the work. Some cubes lie outside the world.

local p = parameters {
  n = 100000,
  seed = 1,
  clusters = 100,
  spread = 4.0, -- standard deviation of a cluster
  world = 200.0, -- its edge
  rotated = true, -- false: all cubes stay parallel to the axes
}

local random = random(p.seed)

local centres = {}
for i = 1, p.clusters do
  centres[i] = {
    x = random.uniform(0, p.world),
    y = random.uniform(0, p.world),
    z = random.uniform(0, p.world),
  }
end

local function rotation()
  if not p.rotated then return 0, 0, 0, 1 end
  return random.quaternion()
end

for _ = 1, p.n do
  local c = centres[random.integer(1, p.clusters)]
  local x, y, z = random.normal(c.x, p.spread), random.normal(c.y, p.spread), random.normal(c.z, p.spread)
  add(x, y, z, 0.5, 0.5, 0.5, rotation())
end

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { p.world, p.world, p.world } },
}
