-- SPDX-License-Identifier: MIT
-- A pile without a skin.
for i = 0, 59 do
  add { centre = { i % 4 + 0.1 * (i % 3), i // 4 % 4, 0.6 + 1.05 * (i // 16) },
        half_extents = { 0.5, 0.45, 0.4 } }
end
return {
  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',
  world = { lower = { -1, -1, 0 }, upper = { 5, 5, 9 } },
  wants = { 'contact_response', 'sleep' },
}
