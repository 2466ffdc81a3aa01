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

-- "y - 1": where the row is along one axis.
local function along(axis, step)
  if step == 0 then return axis end
  return ("%s %s 1"):format(axis, step < 0 and "-" or "+")
end

-- The rows after a cell's own, in cell order. Each has the C expressions
-- inside, y and z (the latter "0" in 2D), over y ny z nz: coordinates of the
-- cell, and how many there are.
function stencil.rows(dims)
  local offset, rows = {}, {}
  for i = 1, dims - 1 do offset[i] = 0 end
  while next_offset(offset) do
    local row = { inside = inside(offset), y = "0", z = "0" }
    for i, step in ipairs(offset) do row[axes[i]] = along(axes[i], step) end
    rows[#rows + 1] = row
  end
  return rows
end

return stencil
