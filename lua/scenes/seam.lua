-- SPDX-License-Identifier: MIT
-- Balls, capsules and a rounded box on lanes of flush tiles: none trips over a seam. It moves.

local p = parameters {
  n = 900, -- tiles
  speed = 5,
}

local lanes = {
  { half_extents = { 0, 0, 0 }, radius = 0.25 },
  { half_extents = { 0, 0, 0 }, radius = 0.25, friction = 1, angular_velocity = { 0, p.speed / 0.25, 0 } },
  { half_extents = { 0.3, 0, 0 }, radius = 0.25 },
  { half_extents = { 0, 0.3, 0 }, radius = 0.25 },
  { half_extents = { 0.2, 0.3, 0.1 }, radius = 0.05 },
}

for i = 0, p.n - 1 do -- three side by side in each lane
  local lane, row = i // 3 % #lanes, i // (3 * #lanes)
  add { centre = { row, 4 * lane + i % 3 - 1, -0.5 }, half_extents = { 0.5, 0.5, 0.5 }, mass = 0, friction = 1 }
end
for lane, body in ipairs(lanes) do
  body.centre = { 0, 4 * (lane - 1) + 0.1, body.radius + body.half_extents[3] }
  body.velocity = { p.speed, 0, 0 }
  add(body)
end

return {
  dims = 3,
  gravity = { 0, 0, -9.81 },
  wants = { "contact_response" },
}
