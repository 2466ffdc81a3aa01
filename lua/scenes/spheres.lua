-- SPDX-License-Identifier: MIT
-- Spheres of one size at random in a cube, as many as paper has cubes, and as wide.
--
-- To be compared with unrotated boxes: `paper` with rotated = false.

local p = parameters {
  n = 1000000,
  seed = 1,
  world = 200.0, -- its edge; grow it by the cube root of n for one density
  radius = 0.5,
}

each(p.n, function(_, random)
  local centre = { random.uniform(0, p.world), random.uniform(0, p.world), random.uniform(0, p.world) }
  add { centre = centre, radius = p.radius }
end)

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { p.world, p.world, p.world } },
}
