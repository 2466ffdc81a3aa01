-- SPDX-License-Identifier: MIT
-- A blow goes through a row from end to end.
for i = 0, 9 do
  add { centre = { i, 0, 0 }, radius = 0.5, mass = 1 + i % 2 }
  add { centre = { i, 0.3, 1.5 }, half_extents = { 0.5, 0.5, 0.5 } }
end
add { centre = { -3, 0, 0 }, radius = 0.5, velocity = { 9, 0, 0 } }
add { centre = { 13, 0.3, 1.5 }, half_extents = { 0.5, 0.5, 0.5 },
      velocity = { -7, 0, 0 } }
return { dims = 3, body = { restitution = 0.9, friction = 0.2 }, dt = 1 / 60,
         world = { lower = { -5, -2, -2 }, upper = { 15, 3, 4 } },
         wants = { 'contact_response', 'shocks' } }
