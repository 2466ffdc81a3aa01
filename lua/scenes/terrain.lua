-- SPDX-License-Identifier: MIT
-- Boxes and balls that fall on hills, roll into the valleys and come to rest. It moves.

local p = parameters {
  n = 400,
  places = 65, -- heights along each axis
  spacing = 1,
  hill = 3, -- height
  seed = 1,
}

local half, values = (p.places - 1) * p.spacing / 2, {}
for j = 0, p.places - 1 do
  for i = 0, p.places - 1 do
    local x, y = (i * p.spacing - half) / 8, (j * p.spacing - half) / 8
    local rim = (x * x + y * y) / 4
    -- squares and products alone, so that hills are the same on every machine
    local u, v = x - 2 * math.floor((x + 1) / 2), y - 2 * math.floor((y + 1) / 2)
    values[#values + 1] = p.hill * ((1 - u * u) * (1 - v * v) + rim / 4)
  end
end

local source = random(p.seed)
local side = math.ceil(p.n ^ (1 / 3) * 1.6)
for i = 0, p.n - 1 do
  local layer, at = i // (side * side), i % (side * side)
  local body = {
    centre = { (at % side - side / 2) * 1.5 + source.uniform(-0.2, 0.2),
               (at // side - side / 2) * 1.5 + source.uniform(-0.2, 0.2), p.hill + 2 + 1.5 * layer },
    friction = 0.5,
  }
  if i % 3 == 0 then
    body.half_extents, body.radius = { 0, 0, 0 }, 0.4
    body.rolling_resistance = 0.05
  else
    body.half_extents = { source.uniform(0.2, 0.5), source.uniform(0.2, 0.5), source.uniform(0.2, 0.5) }
  end
  add(body)
end

return {
  dims = 3,
  gravity = { 0, 0, -9.81 },
  heights = { nx = p.places, ny = p.places, spacing = p.spacing, origin = { -half, -half, 0 }, values = values },
  wants = { "contact_response", "continuous", "sleep" },
  skin = 0.1,
}
