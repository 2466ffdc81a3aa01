-- SPDX-License-Identifier: MIT
-- Small boxes on orbits around a point, as rings of a planet, in 2D. It moves.
--
-- Nothing touches, so a step is one kernel, of fourth order.

local p = parameters {
  n = 20000,
  seed = 1,
  strength = 1000, -- strength of the attraction, which falls with the square of the distance
  wobble = 0.05, -- part of the speed of a circle
}

local random = random(p.seed)

for _ = 1, p.n do
  local r = math.sqrt(random.uniform(100, 900)) -- even over the ring
  local angle = random.uniform(0, 2 * math.pi)
  local speed = math.sqrt(p.strength / r) * (1 + random.uniform(-p.wobble, p.wobble))
  local c, s = math.cos(angle), math.sin(angle)
  add {
    centre = { r * c, r * s },
    half_extents = { 0.2, 0.1 },
    angle = angle,
    velocity = { -speed * s, speed * c },
    angular_velocity =  speed / r,
  }
end

return {
  dims = 2,
  attraction = { centre = { 0, 0 }, strength = p.strength },
  integrator = "yoshida",
  dt = 1 / 60,
  substeps = 1,
}
