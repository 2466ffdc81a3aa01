-- SPDX-License-Identifier: MIT
-- A wall of boxes in layers, shot at by small bullets. It moves.
--
-- The bullets would pass through the wall between two steps; `continuous` holds them.

local p = parameters {
  n = 600, -- boxes of the wall; a tenth as many bullets
  seed = 1,
  speed = 150,
}

local random = random(p.seed)
local wide = math.max(1, math.ceil(math.sqrt(p.n)))
local high = (p.n + wide - 1) // wide

for i = 0, p.n - 1 do
  local row = i // wide
  add { centre = { 0, (i % wide - wide / 2) * 1.002 + row % 2 * 0.5, row * 0.6 + 0.3 }, half_extents = { 0.3, 0.5, 0.3 } }
end
for i = 1, p.n // 10 do
  add {
    centre = { -4 - i * 0.4, random.uniform(-wide / 2, wide / 2), random.uniform(0.5, high * 0.6) },
    half_extents = { 0.15, 0.15, 0.15 },
    velocity = { p.speed, 0, 0 },
    mass = 0.3,
  }
end
add { centre = { 0, 0, -0.5 }, half_extents = { wide, wide / 2 + 4, 0.5 }, mass = 0 }

return {
  dims = 3,
  gravity = { 0, 0, -9.81 },
  body = { friction = 0.6 },
  wants = { "contact_response", "continuous" },
  substeps = 8,
}
