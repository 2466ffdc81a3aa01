-- SPDX-License-Identifier: MIT
-- The neighbourhood of a cell, as rows along x, for any number of dimensions.
--
-- Cells side by side in x are one range of the sorted objects, so three of them
-- are one row. Each pair is found from the object that comes first in cell
-- order, so only the rows after the cell's own are needed: 1 in 2D, 4 in 3D.

local stencil = {}

local axes = { "y", "z", "w" }

-- Adds 1 to the digits -1, 0, 1, the first one fastest; false past the end.
local function next_offset(offset)
  for i = 1, #offset do
    offset[i] = offset[i] + 1
    if offset[i] <= 1 then return true end
    offset[i] = -1
  end
  return false
end

-- "y > 0 && z + 1 < nz": the row is inside the grid.
local function inside(offset)
  local tests = {}
  for i, step in ipairs(offset) do
    if step < 0 then tests[#tests + 1] = axes[i] .. " > 0" end
    if step > 0 then tests[#tests + 1] = ("%s + 1 < n%s"):format(axes[i], axes[i]) end
  end
  return table.concat(tests, " && ")
end

-- "key - row_y + row_z": the cell of the row at the same x.
local function cell(offset)
  local sum = "key"
  for i, step in ipairs(offset) do
    if step ~= 0 then sum = ("%s %s row_%s"):format(sum, step < 0 and "-" or "+", axes[i]) end
  end
  return sum
end

-- The axes above x, lowest first. at is the C expression of a cell's coordinate
-- along it, over its key; row, of how far apart in cell order two neighbours
-- along it are. n, at and row of an axis called y are named ny, y and row_y.
function stencil.axes(dims)
  local list, row = {}, "nx"
  for i = 1, dims - 1 do
    local name = axes[i]
    local at = ("key / row_%s"):format(name)
    if i < dims - 1 then at = ("%s %% n%s"):format(at, name) end
    list[i] = { name = name, row = row, at = at }
    row = ("row_%s * n%s"):format(name, name)
  end
  return list
end

-- The rows after a cell's own, in cell order: inside is the C condition that
-- the row is in the grid, cell the key of its cell at the same x.
function stencil.rows(dims)
  local offset, rows = {}, {}
  for i = 1, dims - 1 do offset[i] = 0 end
  while next_offset(offset) do
    rows[#rows + 1] = { inside = inside(offset), cell = cell(offset) }
  end
  return rows
end

return stencil
