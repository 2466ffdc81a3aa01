-- SPDX-License-Identifier: MIT
-- Boxes fall through a sensor onto a floor, a sensor that stands in a box, and bodies of one group
-- that is told of; a fast sensor passes them all.
for i = 0, 47 do
  local x, y = i % 8, i // 8
  add { centre = { x + 0.01 * y, y, 1 + 0.31 * (i * 7 % 11) },
        half_extents = { 0.4, 0.45, 0.3 }, group = i % 5 == 0 and 2 or 1,
        velocity = { 0, 0, i % 3 == 0 and -2 or 1 } }
end
add { centre = { 3.5, 2.5, 1 }, half_extents = { 4, 3, 0.1 }, mass = 0,
      sensor = true }
add { centre = { 3.5, -2, 0.5 }, half_extents = { 4, 0.5, 0.5 }, mass = 0 }
add { centre = { 1, -2, 0.5 }, half_extents = { 0.2, 1, 0.2 }, mass = 0,
      sensor = true }
add { centre = { -1, 2, 1 }, half_extents = { 0.3, 0.3, 0.3 }, sensor = true,
      velocity = { 6, 0.4, 7 } }
return {
  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls', hit_speed = 0.6,
  world = { lower = { -2, -3, 0 }, upper = { 9, 7, 20 } },
  wants = { 'contact_response', 'events', 'sleep' }, event_mask = 3,
  body = { friction = 0.5, restitution = 0.4 },
}
