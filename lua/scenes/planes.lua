-- SPDX-License-Identifier: MIT
-- Unit boxes on planes and on a line that touch their neighbours exactly.
--
-- A floor and a wall of cubes, plates without thickness on the floor, and a row
-- of cubes along one edge. Tests closed sets (touching collides), for ties in the
-- sort, and for grids that are one cell thick.
--
-- All coordinates are multiples of 1/2 and all rotations quarter turns whose
-- quaternions are whole numbers, so that nothing is rounded and every contact
-- is exact.

local p = parameters {
  n = 100000,
  rotated = true, -- false: no quarter turns; the boxes are the same
}

local n_floor = p.n // 2
local n_wall = p.n // 4
local n_row = p.n // 8
local n_plates = p.n - n_floor - n_wall - n_row
local side = math.max(1, math.ceil(math.sqrt(n_floor))) -- size of floor and wall, in cubes

local quarter_turns = { { 0, 0, 0, 1 }, { 1, 0, 0, 1 }, { 0, 1, 0, 1 }, { 0, 0, 1, 1 }, { 1, 1, 1, 1 } }

local function add_cube(i, x, y, z)
  local q = quarter_turns[p.rotated and i % #quarter_turns + 1 or 1]
  add(x, y, z, 0.5, 0.5, 0.5, q[1], q[2], q[3], q[4])
end

for i = 0, n_floor - 1 do
  add_cube(i, i % side + 0.5, i // side + 0.5, 0.5)
end
for i = 0, n_wall - 1 do
  add_cube(i, -0.5, i % side + 0.5, i // side + 0.5)
end
for i = 0, n_row - 1 do
  add_cube(i, i + 0.5, -0.5, -0.5)
end
for i = 0, n_plates - 1 do
  add(i % side + 1, i // side + 1, 1, 0.5, 0.5, 0, 0, 0, 0, 1)
end

return {
  dims = 3,
  world = { lower = { -1, -1, -1 }, upper = { side + 1, side + 1, side + 1 } },
}
