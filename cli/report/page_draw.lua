-- SPDX-License-Identifier: MIT
-- Tools to draw a page: HTML, tables and charts in SVG. Every text passes through `words`.
local report = ...
local most_shown = report.most_shown

local page = {} -- its text, piece by piece

local function add(format, ...) page[#page + 1] = format:format(...) end

local entities = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;" }
local function words(s)
  local letters = {}
  for i = 1, #s do letters[i] = entities[s:sub(i, i)] or s:sub(i, i) end
  return table.concat(letters)
end

function report.paragraph(format, ...) add("<p>%s</p>\n", words(format:format(...))) end

function report.section(heading, body)
  add("<section><h2>%s</h2>\n", heading)
  body()
  add("</section>\n")
end

-- Charts that lie side by side where there is space.
function report.charts(body)
  add('<div class="charts">\n')
  body()
  add("</div>\n")
end

-- A table whose rows become lists, each cell after its head, where the page is narrow.
-- align has a letter a column, l or r; the first row is the heads.
function report.rows_begin(align, heads)
  local row = function(tag, cells)
    add("<tr>")
    for i, cell in ipairs(cells) do
      local class = align:sub(i, i) == "r" and ' class="r"' or ""
      local head = tag == "td" and (' data-head="%s"'):format(words(heads[i])) or ""
      add("<%s%s%s>%s</%s>", tag, class, head, words(cell), tag)
    end
    add("</tr>\n")
  end
  add("<table>\n")
  row("th", heads)
  return function(cells) row("td", cells) end
end

function report.rows_end() add("</table>\n") end

local function key(colour, name)
  return ('<span class="key"><i style="background:var(--%s)"></i>%s</span>'):format(colour, words(name))
end

-- ---------------------------------------------------------------- charts

-- The frame of a chart in the units of its viewBox.
local width <const>, height <const> = 400, 250
local left <const>, right <const>, top <const>, bottom <const> = 48, 388, 14, 208

local function figure(title, tall, keys)
  add("<figure><figcaption>%s</figcaption>\n%s", words(title), keys or "")
  add('<svg class="chart" viewBox="0 0 %.0f %.0f" role="img" aria-label="%s">\n', width, tall, words(title))
end

local function figure_end() add("</svg></figure>\n") end

local function label(x, y, s, more)
  add('<text%s x="%.1f" y="%.1f">%s</text>\n', more or "", x, y, words(s))
end

-- About five ticks at 1, 2 or 5 times a power of ten.
local function step_for(span)
  local rough = span / 5
  local power = 10 ^ math.floor(math.log(rough, 10))
  local times = rough / power
  return power * (times <= 1 and 1 or times <= 2 and 2 or times <= 5 and 5 or 10)
end

-- Functions from values to places, and how far ticks are apart; y begins at 0.
local function find_scales(c)
  local low, high, values = c.mark or math.huge, c.mark or -math.huge, {}
  for _, s in ipairs(c.series) do
    for _, p in ipairs(s.points) do
      low, high = math.min(low, p.x), math.max(high, p.x)
      values[#values + 1] = p.y
    end
  end
  local most = most_shown(values)
  if not (high > low) then low, high = low - 0.5, high + 0.5 end
  most = most > 0 and most * 1.05 or 1
  local x = { low = low, high = high, step = math.max(step_for(high - low), c.counted and 1 or 0) }
  local y = { high = most, step = step_for(most) }
  x.at = function(value) return left + (right - left) * (value - low) / (high - low) end
  y.at = function(value) return bottom - (bottom - top) * math.min(value / most, 1) end
  return x, y
end

local function draw_axes(c, x, y)
  local middle = (left + right) / 2
  local centred <const> = ' text-anchor="middle"'
  local value = math.ceil(x.low / x.step - 1e-9) * x.step
  while value <= x.high + 1e-9 * x.step do
    local at = x.at(value)
    add('<line class="axis" x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f"/>', at, bottom, at, bottom + 4)
    label(at, bottom + 17, ("%.6g"):format(math.abs(value) < 1e-9 * x.step and 0 or value), centred)
    value = value + x.step
  end
  label(middle, height - 6, c.x_label, centred)
  for i = 0, y.high // y.step do
    local at = y.at(i * y.step)
    add('<line class="axis" x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f"/>', left, at, right, at)
    label(left - 5, at + 4, ("%.6g"):format(i * y.step), ' text-anchor="end"')
  end
  middle = (top + bottom) / 2
  label(12, middle, c.y_label, ('%s transform="rotate(-90 12 %.1f)"'):format(centred, middle))
end

local function draw_series(s, x, y)
  if not s.loose then
    add('<polyline stroke="var(--%s)" points="', s.colour)
    for _, p in ipairs(s.points) do add("%.1f,%.1f ", x.at(p.x), y.at(p.y)) end
    add('"/>\n')
  end
  for _, p in ipairs(s.points) do
    local at, height_of = x.at(p.x), y.at(p.y)
    if p.y > y.high then
      add('<path d="M%.1f %.1fl-4 7h8z" fill="var(--%s)"><title>%s</title></path>\n', at, height_of - 3, s.colour,
        words(p.says))
    else
      add('<circle cx="%.1f" cy="%.1f" r="%d" fill="var(--%s)"><title>%s</title></circle>\n', at, height_of,
        s.loose and 2 or 3, s.colour, words(p.says))
    end
  end
end

-- Says of the series how high what lies above the axis goes.
local function above_words(c, y)
  local n, most = 0, 0
  for _, s in ipairs(c.series) do
    for _, p in ipairs(s.points) do
      n = n + (p.y > y.high and 1 or 0)
      most = math.max(most, p.y)
    end
  end
  return n > 0 and ("%d above, up to %.3g ms"):format(n, most)
end

-- Points over x: title, x_label, y_label; series: a list of name, colour (of the page),
-- points with x, y and what they say; loose: no line through them. counted: x counts
-- things, with no ticks between whole numbers; mark: a dashed line up from this x.
function report.draw_chart(c)
  local x, y = find_scales(c)
  local keys = {}
  for _, s in ipairs(c.series) do
    if #s.points > 0 then keys[#keys + 1] = key(s.colour, s.name) end
  end
  local above = above_words(c, y)
  if above then keys[#keys + 1] = ('<span class="key">▲ %s</span>'):format(above) end
  figure(c.title, height, table.concat(keys))
  draw_axes(c, x, y)
  if c.mark then
    local at = x.at(c.mark)
    add('<line stroke="var(--mark)" stroke-dasharray="4 3" x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f"/>\n', at, top, at,
      bottom)
  end
  for _, s in ipairs(c.series) do
    if #s.points > 0 then draw_series(s, x, y) end
  end
  figure_end()
end

local function part_of(value, most) return most > 0 and value > 0 and math.min(value / most, 1) or 0 end

-- Behind a bar that is longer than could be shown.
local function cut_mark(value, most) return value > most and "… " or "" end

-- A bar at y that is cut into parts, each with name, value and colour.
function report.draw_parts(y, name, parts, all, most)
  local tall <const> = 8
  local x, shown = 16, 0
  label(2, y + tall, name)
  for _, part in ipairs(parts) do
    local wide = (width - 90) * (part_of(shown + part.value, most) - part_of(shown, most))
    shown = shown + part.value
    add('<rect x="%.2f" y="%.1f" width="%.2f" height="%.1f" fill="var(--s%d)"><title>%s</title></rect>\n', x, y, wide,
      tall, part.colour, words(("%s: %.3f ms"):format(part.name, part.value)))
    x = x + wide
  end
  label(x + 5, y + tall, all > 0 and ("%s%.3g ms"):format(cut_mark(all, most), all) or "no work")
  return y + tall + 3
end

-- Rows: a name, and beside it a bar with words behind it in each of two columns. A row
-- has name, says and two cells of part (of the longest bar, 0 to 1), colour, pale, words.
function report.draw_rows(title, heads, rows)
  local names <const>, behind <const>, tall <const>, bar <const> = 106, 110, 22, 12 -- pixels on a phone
  local column = (width - names) / 2
  local y = 4
  figure(title, tall * (#rows + 1) + 4)
  for i, head in ipairs(heads) do label(names + (i - 1) * column, y + bar - 2, head) end
  for _, row in ipairs(rows) do
    y = y + tall
    add("<g><title>%s</title>\n", words(row.says))
    label(2, y + bar - 2, row.name, ' class="name"')
    for i, cell in ipairs(row) do
      local x = names + (i - 1) * column
      local length = (column - behind) * cell.part
      if length > 0 then
        add('<rect x="%.1f" y="%.1f" width="%.2f" height="%.0f" rx="1.5" fill="var(--%s)"%s/>\n', x, y, length, bar,
          cell.colour, cell.pale and ' opacity=".4"' or "")
      end
      label(x + length + (length > 0 and 5 or 0), y + bar - 2, cell.words)
    end
    add("</g>\n")
  end
  figure_end()
end

function report.finish() return table.concat(page) end

report.add = add
report.words = words
report.key = key
report.figure = figure
report.figure_end = figure_end
report.label = label
report.part_of = part_of
report.cut_mark = cut_mark
return report
