-- SPDX-License-Identifier: MIT
-- Spheres, capsules and rounded boxes that fall onto a floor between walls, and roll. It moves.

local p = parameters {
  n = 100000,
  seed = 1,
  friction = 0.3,
  restitution = 0.3,
  rolling_resistance = 0.0, -- 0.02: all come to rest
}

local random = random(p.seed)
local side = math.max(4, math.ceil((p.n / 8) ^ (1 / 3) * 2)) -- a column twice as wide as deep
local apart = 1.3
local per_layer = side * side

local function half_extents(kind)
  if kind == 0 then return { 0, 0, 0 } end -- a sphere
  if kind == 1 then return { random.uniform(0.1, 0.3), 0, 0 } end -- a capsule
  return { random.uniform(0.1, 0.25), random.uniform(0.1, 0.25), random.uniform(0.1, 0.25) }
end

for i = 0, p.n - 1 do
  local layer, place = i // per_layer, i % per_layer
  add {
    centre = {
      (place % side + 0.5) * apart + random.uniform(-0.1, 0.1),
      (place // side + 0.5) * apart + random.uniform(-0.1, 0.1),
      1 + layer * apart,
    },
    half_extents = half_extents(i % 3),
    radius = random.uniform(0.15, 0.3),
    rotation = { random.quaternion() },
  }
end

local layers = (p.n + per_layer - 1) // per_layer

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { side * apart, side * apart, 2 + layers * apart } },
  boundary = "walls",
  gravity = { 0, 0, -9.81 },
  body = { friction = p.friction, restitution = p.restitution, rolling_resistance = p.rolling_resistance },
  wants = { "contact_response", "sleep" },
  skin = 0.05,
}
