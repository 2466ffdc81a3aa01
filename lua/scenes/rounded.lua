-- SPDX-License-Identifier: MIT
-- Boxes, capsules, spheres and boxes with rounded edges side by side.
--
-- All of them are boxes with a radius: a sphere has no extents, a capsule one, a plain box
-- has no radius. Its density is the same for every n.

local p = parameters {
  n = 100000,
  seed = 1,
  rotated = true, -- false: all stay parallel to the axes
}

local edge = 1.3 * math.max(1, p.n) ^ (1 / 3) -- edge of the world

each(p.n, function(i, random)
  local centre = { random.uniform(0, edge), random.uniform(0, edge), random.uniform(0, edge) }
  local rotation = p.rotated and { random.quaternion() } or { 0, 0, 0, 1 }
  local kind = i % 4
  if kind == 0 then
    add { centre = centre, half_extents = { 0.5, 0.4, 0.3 }, rotation = rotation }
  elseif kind == 1 then
    add { centre = centre, half_extents = { 0.4, 0, 0 }, rotation = rotation, radius = 0.25 }
  elseif kind == 2 then
    add { centre = centre, radius = random.uniform(0.3, 0.5) }
  else
    add { centre = centre, half_extents = { 0.4, 0.3, 0.2 }, rotation = rotation, radius = 0.1 }
  end
end)

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { edge, edge, edge } },
}
