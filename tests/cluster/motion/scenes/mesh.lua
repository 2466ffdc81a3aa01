-- SPDX-License-Identifier: MIT
-- Rank 0 alone reads the triangles, and the boxes lie over all of them.
for i = 0, 23 do
  add { centre = { i % 6, i // 6, 1.5 + i % 3 }, half_extents = { 0.45, 0.45, 0.4 } }
end
return {
  dims = 3, gravity = { 0, 0, -9.81 }, wants = { 'contact_response' },
  mesh = { vertices = { -5, -5, 0, 10, -5, 0, 10, 10, 0.5, -5, 10, 0.5 },
           triangles = { 0, 1, 2, 0, 2, 3 } },
}
