-- SPDX-License-Identifier: MIT
-- Cubes of sizes 1 : 100, equally many in each factor of two.
--
-- One grid whose cells fit the largest puts thousands of small ones into a cell: this is
-- the scene for grids of several levels. Its density is the same for every n.

local p = parameters {
  n = 250000,
  seed = 1,
  ratio = 100.0, -- ratio of the largest edge to the smallest, which is 0.5
  rotated = true, -- false: all cubes stay parallel to the axes
}

local random = random(p.seed)
local edge = 24 * math.max(1, p.n) ^ (1 / 3) -- edge of the world: four candidates a cube

local function rotation()
  if not p.rotated then return 0, 0, 0, 1 end
  return random.quaternion()
end

for _ = 1, p.n do
  local x, y, z = random.uniform(0, edge), random.uniform(0, edge), random.uniform(0, edge)
  local half = 0.25 * math.exp(random.uniform(0, math.log(p.ratio)))
  add(x, y, z, half, half, half, rotation())
end

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { edge, edge, edge } },
}
