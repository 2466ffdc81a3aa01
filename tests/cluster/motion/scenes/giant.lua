-- SPDX-License-Identifier: MIT
-- The giant has more contacts than there are colours, in all domains.
for i = 0, 79 do
  local x, y = i % 9, i // 9
  add { centre = { x, y, 0.45 }, half_extents = { 0.4, 0.4, 0.4 } }
end
add { centre = { 4, 4, 1.9 }, half_extents = { 5, 5, 1 }, mass = 40 }
return {
  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',
  world = { lower = { -2, -2, 0 }, upper = { 11, 11, 20 } },
  body = { friction = 0.5, restitution = 0.3 },
}
