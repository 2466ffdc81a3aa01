-- SPDX-License-Identifier: MIT
-- The shapes of a plot. A script sets its size, adds shapes and returns `report.plot`, which rendering.c draws in turn.
local report = ...
local plot = {}
report.plot = plot
report.ink, report.grey = { 0.13, 0.14, 0.16 }, { 0.42, 0.45, 0.50 }

local function add(kind, x, y, colour, shape)
  shape.kind, shape.x, shape.y, shape.colour = kind, x, y, colour
  plot[#plot + 1] = shape
end

function report.stroke(x, y, to_x, to_y, colour, width)
  add("line", x, y, colour, { to_x = to_x, to_y = to_y, width = width })
end

function report.box(x, y, width, height, colour) add("box", x, y, colour, { width = width, height = height }) end
function report.dot(x, y, radius, colour) add("dot", x, y, colour, { radius = radius }) end

function report.write(x, y, size, colour, format, ...)
  add("words", x, y, colour, { size = size, words = format:format(...) })
end

return report
