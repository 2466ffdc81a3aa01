-- SPDX-License-Identifier: MIT
-- Boxes of many sizes at random in a cube that grows with their number.
--
-- The density is the same at any n. Each box has random numbers of its own, so a rank that needs
-- a part of the scene makes only that part. Made for large worlds, and for several machines.

local p = parameters {
  n = 1000000,
  seed = 1,
  rotated = true, -- false: all boxes stay parallel to the axes
  space = 8.0, -- volume of the world for each box
}

local edge = (p.n * p.space) ^ (1 / 3)

each(p.n, function(_, random)
  local x, y, z = random.uniform(0, edge), random.uniform(0, edge), random.uniform(0, edge)
  local a, b, c = random.uniform(0.2, 0.6), random.uniform(0.2, 0.6), random.uniform(0.2, 0.6)
  if not p.rotated then return add(x, y, z, a, b, c, 0, 0, 0, 1) end
  add(x, y, z, a, b, c, random.quaternion())
end)

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { edge, edge, edge } },
}
