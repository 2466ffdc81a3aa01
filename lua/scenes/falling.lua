-- SPDX-License-Identifier: MIT
-- Boxes that fall onto a floor between walls and pile up. It moves.
--
-- All of them turn, have friction and bounce a little. Made for `duet run --steps`.

local p = parameters {
  n = 100000,
  seed = 1,
  friction = 0.5,
  restitution = 0.1,
  sleep = true, -- a body that rests leaves the work
  sleep_speed = 0.15, -- a slower body rests; gravity gives 0.16 in a step
}

local random = random(p.seed)
local side = math.max(4, math.ceil((p.n / 8) ^ (1 / 3) * 2)) -- a column twice as wide as deep
local apart = 1.3
local per_layer = side * side

for i = 0, p.n - 1 do
  local layer, place = i // per_layer, i % per_layer
  add {
    centre = {
      (place % side + 0.5) * apart + random.uniform(-0.1, 0.1),
      (place // side + 0.5) * apart + random.uniform(-0.1, 0.1),
      1 + layer * apart,
    },
    half_extents = { random.uniform(0.25, 0.45), random.uniform(0.25, 0.45), random.uniform(0.25, 0.45) },
    rotation = { random.quaternion() },
  }
end

local layers = (p.n + per_layer - 1) // per_layer
local wants = { "contact_response" }
if p.sleep then wants[2] = "sleep" end

return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { side * apart, side * apart, 2 + layers * apart } },
  boundary = "walls",
  gravity = { 0, 0, -9.81 },
  body = { friction = p.friction, restitution = p.restitution },
  wants = wants,
  skin = 0.05,
  sleep_speed = p.sleep_speed,
}
