-- SPDX-License-Identifier: MIT
-- Bodies that begin in each other are taken apart before they are divided.
for i = 0, 39 do
  add { centre = { 0.7 * (i % 8), 0.8 * (i // 8), 0.5 + 0.1 * (i % 3) },
        half_extents = { 0.5, 0.45, 0.4 } }
end
return {
  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',
  world = { lower = { -2, -2, 0 }, upper = { 12, 8, 20 } },
  wants = { 'contact_response', 'depenetration', 'events', 'sleep' },
  body = { friction = 0.5 },
}
