-- SPDX-License-Identifier: MIT
-- The carrier is no neighbour of most bodies. It comes last, turns, rises, and is a box that bodies lie
-- on, too; bodies fall asleep far from it.
for i = 0, 47 do
  add { centre = { i % 8 - 3.5, i // 8 - 2.5, 0.5 + i % 3 },
        half_extents = { 0.4, 0.4, 0.3 }, friction = 0.6 }
end
add { centre = { 0, 0, 0.1 }, half_extents = { 0.6, 0.6, 0.3 }, mass = 0,
      velocity = { 0, 0, 0.1 }, angular_velocity = { 0, 0, 0.5 } }
return {
  dims = 3, gravity = { 0, 0, -9.81 }, skin = 0.1,
  wants = { 'contact_response', 'sleep', 'events', 'continuous' },
  mesh = { vertices = { -9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0, 0, -4, 0.5, 0, 4, 0.5, 0.2, 0, 0 },
           triangles = { 0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 5 }, carrier = 48 },
}
