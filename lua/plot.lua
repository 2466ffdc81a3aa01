-- SPDX-License-Identifier: MIT
-- Pictures by gnuplot, as PATH.svg and PATH.png; the SVG is dark on a dark page.
--
--   plot.draw("out/times", {
--     title = "...", x = "objects", y = "ms", -- what the axes say
--     kind = "lines",                         -- or "bars", "stack", "map"
--     log = "xy",                             -- axes in powers; "" without
--     series = { { name = "A", points = { { 1000, 1.5 }, { 2000, 2.9 } } } },
--   })
--
-- A point is { x, y } or { x, y, low, high } with an interval. Bars and stacks
-- begin at 0, and take the first series' x as names, which may be of several
-- lines. A series may have its style, "lines", "points" or "both", and its colour.
--
-- A kind "map" has no series but `columns` and `rows`, which are names, and
-- values[row][column], a number or false; each cell is coloured by its number
-- (by its logarithm where log has z) and says it, or what `nothing` says.

local plot = {}

-- Okabe and Ito's colours, which most colour-blind people can tell apart.
local colours = { "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442", "#555555", "#8B5A2B", "#AAAAAA" }

local function quoted(text)
  return '"' .. tostring(text):gsub('[\\"]', "\\%0"):gsub("\n", "\\n") .. '"'
end

local function number(value)
  if value == nil or value ~= value then return "NaN" end
  return ("%.9g"):format(value)
end

local function add(lines, format, ...)
  lines[#lines + 1] = select("#", ...) > 0 and format:format(...) or format
end

-- ------------------------------------------------------------------ data

local function add_points(lines, i, series)
  add(lines, "$s%d << EOD", i)
  for _, p in ipairs(series.points) do
    add(lines, "%s %s %s %s", number(p[1]), number(p[2]), number(p[3] or p[2]), number(p[4] or p[2]))
  end
  add(lines, "EOD")
end

-- One row a name, one column a series.
local function add_bars(lines, chart)
  add(lines, "$bars << EOD")
  for row, p in ipairs(chart.series[1].points) do
    local cells = { quoted(p[1]) }
    for _, series in ipairs(chart.series) do
      local own = series.points[row] or {}
      cells[#cells + 1] = number(own[2])
      cells[#cells + 1] = number(own[3] or own[2])
      cells[#cells + 1] = number(own[4] or own[2])
    end
    add(lines, table.concat(cells, " "))
  end
  add(lines, "EOD")
end

-- A line a cell: column, row, number, what is written in it.
local function add_cells(lines, chart)
  add(lines, "$map << EOD")
  for row in ipairs(chart.rows) do
    for column in ipairs(chart.columns) do
      local value = chart.values[row][column]
      add(lines, "%d %d %s %s", column - 1, row - 1, number(value or nil), quoted(value and ("%.4g"):format(value) or chart.nothing or ""))
    end
  end
  add(lines, "EOD")
end

-- ------------------------------------------------------------------ commands

local function has_intervals(chart)
  for _, series in ipairs(chart.series) do
    for _, p in ipairs(series.points) do
      if p[3] then return true end
    end
  end
  return false
end

local function bar_parts(chart)
  local parts, errors = {}, has_intervals(chart) and chart.kind == "bars"
  for i, series in ipairs(chart.series) do
    local column = 3 * i - 1
    local using = errors and ("%d:%d:%d:xtic(1)"):format(column, column + 1, column + 2) or ("%d:xtic(1)"):format(column)
    parts[i] = ("$bars using %s title %s linecolor rgb %s"):format(using, quoted(series.name), quoted(series.colour or colours[(i - 1) % #colours + 1]))
  end
  return parts
end

local function line_parts(chart)
  local parts = {}
  for i, series in ipairs(chart.series) do
    local colour = quoted(series.colour or colours[(i - 1) % #colours + 1])
    local style = series.style or "both"
    local with = ({ lines = "lines linewidth 2", points = "points pointtype 7 pointsize 0.8",
      both = "linespoints linewidth 2 pointtype 7 pointsize 0.8" })[style]
    if has_intervals { series = { series } } then -- beneath the points, for gnuplot erases what is under a bar
      parts[#parts + 1] = ("$s%d using 1:2:3:4 with yerrorbars pointtype 0 linecolor rgb %s notitle"):format(i, colour)
    end
    parts[#parts + 1] = ("$s%d using 1:2 with %s linecolor rgb %s title %s"):format(i, with, colour, quoted(series.name))
  end
  return parts
end

local function map_parts()
  return { "$map using 1:2:3 with image pixels", "$map using 1:2:4 with labels textcolor rgb '#222222'" }
end

local function named_tics(axis, names)
  local tics = {}
  for i, name in ipairs(names) do tics[i] = ("%s %d"):format(quoted(name), i - 1) end
  return ("set %stics (%s)"):format(axis, table.concat(tics, ", "))
end

-- Cells from light to dark, so that the words in them can be read.
local function add_map_style(lines, chart)
  add(lines, "set title %s font ',14'\nset xlabel %s\nset ylabel %s", quoted(chart.title), quoted(chart.x), quoted(chart.y))
  add(lines, named_tics("x", chart.columns))
  add(lines, named_tics("y", chart.rows))
  add(lines, "set tics scale 0\nset border 0\nunset key\nunset colorbox")
  add(lines, "set xrange [-0.5:%g]\nset yrange [-0.5:%g]", #chart.columns - 0.5, #chart.rows - 0.5)
  add(lines, "set object 1 rectangle from graph 0,0 to graph 1,1 behind fillcolor rgb '#d9d9d9' fillstyle solid noborder")
  add(lines, "set palette defined (0 '#e8f4f0', 0.35 '#8fc9c0', 0.7 '#56a0c4', 1 '#e6a04a')")
  if (chart.log or ""):find "z" then add(lines, "set logscale cb") end
end

-- A logarithmic axis of less than two powers of ten is read by 1, 2 and 5 of each.
local function add_log_tics(lines, chart, axis)
  local least, most = math.huge, 0
  for _, series in ipairs(chart.series) do
    for _, p in ipairs(series.points) do
      for i = axis == "x" and 1 or 2, axis == "x" and 1 or #p do
        if p[i] > 0 then least, most = math.min(least, p[i]), math.max(most, p[i]) end
      end
    end
  end
  if most >= 100 * least then return end
  local tics, power = {}, 10.0 ^ math.floor(math.log(least, 10))
  for _ = 0, 3 do
    for _, times in ipairs { 1, 2, 5 } do tics[#tics + 1] = ("'%.4g' %.9g"):format(times * power, times * power) end
    power = 10 * power
  end
  add(lines, "set %stics (%s)", axis, table.concat(tics, ", "))
end

local function add_style(lines, chart)
  if chart.kind == "map" then return add_map_style(lines, chart) end
  add(lines, "set title %s font ',14'", quoted(chart.title))
  local _, breaks = tostring(chart.series[1].points[1][1]):gsub("\n", "") -- names may be of several lines
  add(lines, "set xlabel %s offset 0,%d\nset ylabel %s", quoted(chart.x), -breaks, quoted(chart.y))
  add(lines, "set border 3 linecolor rgb '#888888'\nset tics nomirror textcolor rgb '#333333'")
  add(lines, "set grid ytics linecolor rgb '#dddddd' linetype 1")
  add(lines, "set key outside right top vertical Left reverse samplen 1 spacing 1.3")
  for axis in (chart.log or ""):gmatch "[xy]" do
    add(lines, "set logscale %s", axis)
    if chart.kind == "lines" or axis == "y" then add_log_tics(lines, chart, axis) end
  end
  if chart.kind ~= "lines" and not (chart.log or ""):find "y" then add(lines, "set yrange [*<0:0<*]") end
  for axis, range in pairs { x = chart.xrange, y = chart.yrange } do
    add(lines, "set %srange [%s:%s]", axis, range[1] or "*", range[2] or "*")
  end
  if chart.kind == "bars" then
    add(lines, "set style data histograms\nset style fill solid 0.9 noborder\nset boxwidth 0.9")
    add(lines, "set errorbars linecolor rgb '#444444'")
    add(lines, "set style histogram %s", has_intervals(chart) and "errorbars gap 1.5 linewidth 1.2" or "clustered gap 1.5")
  elseif chart.kind == "stack" then
    add(lines, "set style data histograms\nset style fill solid 0.9 border rgb 'white'\nset boxwidth 0.65")
    add(lines, "set style histogram rowstacked")
  end
  if chart.kind ~= "lines" then add(lines, "set xtics scale 0") end
end

-- The whole text that gnuplot is given.
function plot.script(path, chart)
  local lines = {}
  if chart.kind == "map" then
    add_cells(lines, chart)
  elseif chart.kind == "lines" then
    for i, series in ipairs(chart.series) do add_points(lines, i, series) end
  else
    add_bars(lines, chart)
  end
  add_style(lines, chart)
  local parts = (chart.kind == "map" and map_parts or chart.kind == "lines" and line_parts or bar_parts)(chart)
  for _, form in ipairs {
    { "svg", "svg size 860,520 dynamic noenhanced font 'sans,12' background rgb 'white'" },
    { "png", "pngcairo size 1290,780 noenhanced font 'sans,14' background rgb 'white'" },
  } do
    add(lines, "set terminal %s", form[2])
    add(lines, "set output %s", quoted(path .. "." .. form[1]))
    add(lines, "plot %s", table.concat(parts, ", \\\n     "))
  end
  add(lines, "unset output")
  return table.concat(lines, "\n") .. "\n"
end

local function run(script_path)
  local program <close> = io.popen("gnuplot '" .. script_path .. "' 2>&1", "r")
  local said = program:read "a"
  local ok, _, code = program:close()
  if ok then return true end
  if code == 127 then return nil, "gnuplot is not installed, so there are no pictures (Debian: gnuplot-nox)" end
  return nil, "gnuplot: " .. (said:match "[^\n]*line %d+:[^\n]*" or said:gsub("%s+", " "))
end

-- The colours that gnuplot writes, and those of a dark page.
local on_dark = {
  { 'fill="#ffffff"', "#14181f" }, { 'fill="black"', "#e3e8ef" }, { 'fill="rgb(51,51,51)"', "#c6ceda" },
  { 'color="black"', "#e3e8ef" }, { 'stroke="black"', "#e3e8ef" }, { 'stroke="rgb(221, 221, 221)"', "#333c49" },
  { 'stroke="rgb( 68,  68,  68)"', "#c6ceda" }, { 'stroke="rgb(255, 255, 255)"', "#14181f" },
  { 'color="rgb( 85,  85,  85)"', "#a3abb5" }, { 'fill="rgb( 85,  85,  85)"', "#a3abb5" },
  { 'stroke="rgb( 85,  85,  85)"', "#a3abb5" },
}

local entities = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;" }

-- The SVG with the chart's title in place of gnuplot's name, and with a style for dark pages.
local function finish_svg(svg, chart)
  local rules = {}
  for i, rule in ipairs(on_dark) do
    rules[i] = ("[%s]{%s:%s}"):format(rule[1], rule[1]:match "^%a+", rule[2])
  end
  local head = ("<title>%s</title>\n<style>@media(prefers-color-scheme:dark){%s}</style>"):format(
    chart.title:gsub("\n", " "):gsub("[&<>]", entities), table.concat(rules))
  return (svg:gsub("<title>.-</title>", function() return head end, 1))
end

local function finish_file(path, chart)
  local file <close> = io.open(path, "r+")
  if not file then return nil, path .. ": gnuplot wrote no such file" end
  local svg = finish_svg(file:read "a", chart)
  file:seek("set")
  return file:write(svg)
end

-- true, or nil and a line that says why there is no picture.
function plot.draw(path, chart)
  if chart.kind ~= "map" and not (chart.series and chart.series[1]) then return nil, path .. ": there are no series" end
  for _, series in ipairs(chart.series or {}) do
    if #series.points == 0 then return nil, path .. ": series '" .. series.name .. "' has no points" end
  end
  local script_path = os.tmpname()
  local file <close>, message = io.open(script_path, "w")
  if not file then return nil, message end
  file:write(plot.script(path, chart))
  file:close()
  local ok, why = run(script_path)
  os.remove(script_path)
  if not ok then return nil, why end
  ok, why = finish_file(path .. ".svg", chart)
  return ok and true, why
end

return plot
