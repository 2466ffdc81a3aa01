-- SPDX-License-Identifier: MIT
-- Without response bodies fly through each other and through sensors, and what touches is told.
for i = 0, 59 do
  local x, y = i % 10, i // 10
  add { centre = { 1.2 * x, 1.2 * y, 0.5 + 0.2 * (i % 3) },
        half_extents = { 0.4, 0.3, 0.3 }, sensor = i % 11 == 3,
        mass = i % 13 == 5 and 0 or 1, group = 1 << i % 2,
        velocity = { 3 - i % 7, i % 5 - 2, 0.1 * (i % 4) } }
end
return { dims = 3, wants = { 'events', 'sensors' }, event_mask = 1 }
