-- SPDX-License-Identifier: MIT
-- Half of the bodies are a pile, and half of them touch nothing: equal numbers are unequal work.
for i = 0, 511 do
  add { centre = { i % 8, i // 8 % 8, 0.45 + 0.9 * (i // 64) }, half_extents = { 0.5, 0.5, 0.45 } }
  add { centre = { 40 + 3 * (i % 8), 3 * (i // 8 % 8), 200 + 3 * (i // 64) },
        half_extents = { 0.5, 0.5, 0.45 } }
end
return { dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',
         world = { lower = { -1, -1, 0 }, upper = { 90, 40, 300 } },
         wants = { 'contact_response' } }
