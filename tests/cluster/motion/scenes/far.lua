-- SPDX-License-Identifier: MIT
-- A pile and what flies on, 10 000 km from 0, over the edges of cells.
local x0, y0 = 1e7, -2e7
for i = 0, 47 do
  add { centre = { x0 + 1.1 * (i % 6), y0 + 1.1 * (i // 6 % 4), 1 + 1.2 * (i // 24) },
        half_extents = { 0.5, 0.45, 0.4 }, velocity = { 0.2 * (i % 3), 1, 0 } }
end
add { centre = { x0 + 3, y0 + 2, -1 }, half_extents = { 8, 8, 1 }, mass = 0 }
add { centre = { x0 + 3, y0 - 20, 5 }, half_extents = { 0.3, 0.3, 0.3 },
      velocity = { 40, 30, 10 } }
return {
  dims = 3, gravity = { 0, 0, -9.81 }, origin = 'cell', origin_edge = 4,
  body = { friction = 0.5, restitution = 0.3 }, hit_speed = 0.3,
  wants = { 'contact_response', 'sleep', 'events' },
}
