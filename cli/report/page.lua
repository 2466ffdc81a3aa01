-- SPDX-License-Identifier: MIT
-- The page of `duet report`: HTML that stands by itself, light and dark. Returns a
-- function from what was measured to the page's text:
--
--   duet, made    the version that made the page, and when
--   store         path and profiles, each as `duet profiles show --json` has it; or nil
--   no_store      where there is none: a sentence that says so
--   levels, effects, bench   lists of results; of bench the earliest comes first
--
-- Results are untrusted: what is not the number or the name that it should be
-- counts as 0 and "", and every text passes through `words`.

-- A bar's colour is s0 to s11; the rest are roles: a and b for the devices.
local style = [[
:root{--paper:#fff;--ink:#1d2430;--dim:#5d6878;--line:#d5dbe3;--card:#f6f8fa;--a:#1f6fc4;--b:#d1600a;
  --step:#2d3646;--mark:#b3122f;--s0:#4e79a7;--s1:#f28e2b;--s2:#59a14f;--s3:#e15759;--s4:#76b7b2;--s5:#b59a1d;
  --s6:#b07aa1;--s7:#ff9da7;--s8:#9c755f;--s9:#8f8a87;--s10:#2f8f9d;--s11:#7a5cc0}
@media(prefers-color-scheme:dark){:root{--paper:#14181f;--ink:#e3e8ef;--dim:#9aa6b6;--line:#333c49;
  --card:#1b212a;--a:#6cb0f5;--b:#f59a52;--step:#d6dde8;--mark:#ff6b81}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,sans-serif}
main{max-width:1200px;margin:0 auto;padding:16px}
h1{font-size:1.6rem;margin:.4em 0}h2{font-size:1.2rem;margin:1.8em 0 .5em;border-bottom:1px solid var(--line)}
p{margin:.4em 0;color:var(--dim);overflow-wrap:anywhere}
.found{font-size:1.05rem;color:var(--ink);margin:.6em 0;padding-left:1.2em}.found li{margin:.2em 0}
h3{font-size:1rem;font-weight:600;margin:1.2em 0 .3em;overflow-wrap:anywhere}
table{border-collapse:collapse;font-size:.85rem}
th,td{padding:.25em .6em;border-bottom:1px solid var(--line);text-align:left;overflow-wrap:break-word}
@media(max-width:1080px){th{display:none}tr{display:grid;grid-template-columns:max-content 1fr;
  border-bottom:1px solid var(--line);padding:.4em 0}td{display:contents}
  td:before{content:attr(data-head);color:var(--dim);padding-right:1em;text-align:left}}
dl{display:grid;grid-template-columns:max-content 1fr;gap:.3em 1.2em;margin:.5em 0;font-size:.9rem}
dt{font-weight:600}dd{margin:0;color:var(--dim)}
th{color:var(--dim);font-weight:600}.r{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.charts{display:grid;gap:14px;grid-template-columns:repeat(auto-fill,minmax(min(340px,100%),1fr));
  align-items:start}
figure{margin:0;padding:10px;background:var(--card);border:1px solid var(--line);border-radius:8px}
figcaption{font-size:.85rem;overflow-wrap:anywhere}
.key{display:inline-block;margin-right:.9em;white-space:nowrap;font-size:.8rem}
.key i{display:inline-block;width:.8em;height:.8em;margin-right:.3em;border-radius:2px}
svg{display:block;width:100%;height:auto;margin-top:6px}
svg text{fill:var(--dim);font:11px system-ui,sans-serif}
svg .name{fill:var(--ink)}svg .axis{stroke:var(--line)}svg polyline{fill:none;stroke-width:2}
]]

-- ---------------------------------------------------------------- what is read

local function text(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "string" and value or ""
end

local function number(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "number" and math.abs(value) <= 2 ^ 53 and value or 0
end

local function list(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "table" and value or {}
end

-- One device alone is named as A and as B, and is the B that works.
local function is_one_device(a, b) return text(a, "selector") ~= "" and text(a, "selector") == text(b, "selector") end

-- A profile has no selectors: two equal devices that share nothing count as one.
local function is_of_one(p)
  return number(p, "share") == 0 and text(p.a, "name") == text(p.b, "name") and text(p.a, "part") == text(p.b, "part")
    and text(p.a, "driver") == text(p.b, "driver")
end

-- Whether two have the same mode and kernels.
local function same_plan(a, b)
  return text(a, "mode") == text(b, "mode") and text(a, "variant_a") == text(b, "variant_a")
    and text(a, "variant_b") == text(b, "variant_b")
end

local function greatest(rows, value)
  local most = 0
  for _, row in ipairs(rows) do most = math.max(most, value(row)) end
  return most
end

-- "1 234 567"
local function count(n)
  local digits, groups = ("%.0f"):format(math.floor(n)), {}
  for last = #digits, 1, -3 do table.insert(groups, 1, digits:sub(math.max(last - 2, 1), last)) end
  return table.concat(groups, " ")
end

-- What the longest bar or the axis stands for: the greatest value, or the greatest but a
-- few (at most a fifth) that lie far above all others and would make these flat.
local function most_shown(values)
  table.sort(values)
  local n = #values
  local bound = 3 * (values[math.ceil(0.75 * n)] or 0)
  for i = n, math.max(1, n - n // 5), -1 do
    if bound == 0 or values[i] <= bound then return values[i] end
  end
  return values[n] or 0
end

local function most_shown_of(rows, value)
  local values = {}
  for i, row in ipairs(rows) do values[i] = value(row) end
  return most_shown(values)
end

-- At most so many bytes, and no part of a character.
local function cut(s, most)
  if #s <= most then return s end
  while most > 0 and s:byte(most + 1) & 0xc0 == 0x80 do most = most - 1 end
  return s:sub(1, most)
end

-- ---------------------------------------------------------------- HTML

local page = {}

local function add(format, ...) page[#page + 1] = format:format(...) end

local entities = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;" }
local function words(s)
  local letters = {}
  for i = 1, #s do letters[i] = entities[s:sub(i, i)] or s:sub(i, i) end
  return table.concat(letters)
end

local function paragraph(format, ...) add("<p>%s</p>\n", words(format:format(...))) end

local function section(heading, body)
  add("<section><h2>%s</h2>\n", heading)
  body()
  add("</section>\n")
end

-- Charts that lie side by side where there is space.
local function charts(body)
  add('<div class="charts">\n')
  body()
  add("</div>\n")
end

-- A table whose rows become lists, each cell after its head, where the page is narrow.
-- align has a letter a column, l or r; the first row is the heads.
local function rows_begin(align, heads)
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

local function rows_end() add("</table>\n") end

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
local function draw_chart(c)
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
local function draw_parts(y, name, parts, all, most)
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
local function draw_rows(title, heads, rows)
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

-- ---------------------------------------------------------------- the profile store

local function title_of(p)
  local plan = is_of_one(p) and p.variant_b or ("%s | %s, %s"):format(p.variant_a, p.variant_b, p.mode)
  return ("%s, %s objects: %s, level %s"):format(cut(p.scene ~= "" and p.scene or "a scene", 60), count(p.objects),
    plan, p.level)
end

local function device_words(d)
  return ("%s%s, driver %s"):format(d.name, d.part ~= "" and (" [%s]"):format(d.part) or "", d.driver)
end

local function pair_words(p)
  return is_of_one(p) and device_words(p.b) or ("A: %s. B: %s."):format(device_words(p.a), device_words(p.b))
end

-- "A alone" or "B alone"; nil if both work.
local function alone(p) return p.share == 0 and "B alone" or p.share == 1 and "A alone" or nil end

local function profile_row(row, p)
  if is_of_one(p) then
    row { p.scene ~= "" and p.scene or "-", count(p.objects), p.variant_b, p.level,
      ("%.3f (%.3f to %.3f)"):format(p.ms, p.low_ms, p.high_ms), p.created }
    return
  end
  local gain = ("%+.1f (%+.1f to %+.1f)"):format(100 * p.gain, 100 * p.gain_low, 100 * p.gain_high)
  row { p.scene ~= "" and p.scene or "-", count(p.objects), alone(p) or ("%.1f %%"):format(100 * p.share), p.mode,
    p.variant_a, p.variant_b, p.level, ("%.3f (%.3f to %.3f)"):format(p.ms, p.low_ms, p.high_ms),
    alone(p) and "-" or gain, alone(p) and "-" or p.verdict, p.created }
end

-- A table for each device pair.
local function add_profiles(profiles)
  paragraph("What applications load.")
  local seen = {}
  for _, first in ipairs(profiles) do
    if first.live and not seen[pair_words(first)] then
      seen[pair_words(first)] = true
      add("<h3>%s</h3>\n", words(pair_words(first)))
      local row = is_of_one(first)
          and rows_begin("lrllrl", { "scene", "objects", "kernels", "level", "step, ms", "measured, UTC" })
        or rows_begin("lrrllllrrll", { "scene", "objects", "share of A", "mode", "A's kernels", "B's kernels",
        "level", "step, ms", "gain, %", "verdict", "measured, UTC" })
      for _, p in ipairs(profiles) do
        if p.live and pair_words(p) == pair_words(first) then profile_row(row, p) end
      end
      rows_end()
    end
  end
end

-- Trials of one share become one point, the one with their median time.
local function merge_points(points)
  local merged, from = {}, 1
  table.sort(points, function(a, b)
    if a.x ~= b.x then return a.x < b.x end
    return a.y < b.y
  end)
  while from <= #points do
    local to = from
    while to < #points and points[to + 1].x == points[from].x do to = to + 1 end
    merged[#merged + 1] = points[from + (to - from) // 2]
    from = to + 1
  end
  return merged
end

-- A search's trials over the share: those of the profile's mode and kernels are lines,
-- the others dots.
local function draw_search(p)
  local a, b, step, other = {}, {}, {}, {}
  local function put(points, what, trial, ms)
    local says = ("trial %d: share %.4f, %s %.3f ms"):format(trial.number, trial.share, what, ms)
    points[#points + 1] = { x = trial.share, y = ms, says = says }
  end
  for _, trial in ipairs(list(p, "trials")) do
    if trial.outcome == "ok" and same_plan(trial, p) then
      put(a, "A", trial, trial.a_ms)
      put(b, "B", trial, trial.b_ms)
      put(step, "step", trial, trial.ms)
    elseif trial.outcome == "ok" then
      put(other, trial.mode, trial, trial.ms)
    end
  end
  if #step + #other == 0 then return end
  draw_chart { title = title_of(p), x_label = "share of A", y_label = "ms", mark = p.share, series = {
    { name = "other plans", colour = "s9", points = other, loose = true },
    { name = "A", colour = "a", points = merge_points(a) },
    { name = "B", colour = "b", points = merge_points(b) },
    { name = "step", colour = "step", points = merge_points(step) },
  } }
end

-- One device has no share to search.
local function add_searches(profiles)
  paragraph("The median time of each share that was tried: of A's part, of B's, and of the step. The dashed line is "
    .. "the share that was chosen.")
  charts(function()
    for _, p in ipairs(profiles) do
      if p.live and not is_of_one(p) then draw_search(p) end
    end
  end)
end

local function has_shares(profiles)
  for _, p in ipairs(profiles) do
    if p.live and not is_of_one(p) then return true end
  end
  return false
end

local function has_levels(profiles)
  for _, p in ipairs(profiles) do
    if p.level ~= profiles[1].level then return true end
  end
  return false
end

local function add_accuracy(profiles)
  local row = rows_begin("llrr", { "workload", "level", "step, ms", "wrong pairs" })
  for _, p in ipairs(profiles) do
    if p.live then
      local wrong = number(p, "missed_rate") + number(p, "false_rate")
      row { title_of(p), p.level, ("%.3f"):format(p.ms), ("%.3g %%"):format(100 * wrong) }
    end
  end
  rows_end()
end

-- The profiles of one workload on one pair, by age.
local function ages_of(profiles, live)
  local points = {}
  for _, p in ipairs(profiles) do
    if p.pair_id == live.pair_id and p.workload_id == live.workload_id then
      local says = ("%s: %.3f ms, share %.4f"):format(p.created, p.ms, p.share)
      points[#points + 1] = { created = p.created_ns, y = p.ms, says = says }
    end
  end
  table.sort(points, function(a, b) return a.created < b.created end)
  for i, p in ipairs(points) do p.x = i end
  return points
end

-- Nothing where no profile took another's place.
local function add_replaced(profiles)
  local replaced = {}
  for _, p in ipairs(profiles) do
    local points = p.live and ages_of(profiles, p) or {}
    if #points > 1 then replaced[#replaced + 1] = { title = title_of(p), points = points } end
  end
  if #replaced == 0 then return end
  section("What became of the profiles", function()
    charts(function()
      for _, one in ipairs(replaced) do
        draw_chart { title = one.title, x_label = "profile, the live one last", y_label = "ms a step", counted = true,
          series = { { name = "profiles", colour = "step", points = one.points } } }
      end
    end)
  end)
end

local function add_store(store)
  local profiles = store.profiles
  if #profiles == 0 then
    paragraph("%s: no profiles yet; duet tune makes them.", store.path)
    return
  end
  section("Profiles", function() add_profiles(profiles) end)
  if has_shares(profiles) then section("Searches", function() add_searches(profiles) end) end
  if has_levels(profiles) then section("Levels of the profiles", function() add_accuracy(profiles) end) end
  add_replaced(profiles)
end

-- ---------------------------------------------------------------- levels and effects

local function scene_words(one)
  return ("%s, %s objects"):format(cut(text(one, "scene"), 60), count(number(one, "objects")))
end

local function wrong(row) return number(row, "missed") + number(row, "false") end
local function step_ms(row) return number(row, "step_ms") end
local function digits_of_wrong(row) return math.log(1 + wrong(row), 10) end

local function is_alone(result) return text(result, "a") ~= "" and text(result, "a") == text(result, "b") end

local function draw_levels(result, letter, colour)
  local levels, rows = list(result, "levels"), {}
  local slowest = most_shown_of(levels, step_ms)
  for _, row in ipairs(levels) do
    if text(row, "device") == letter then
      local beaten = row.front ~= true
      rows[#rows + 1] = {
        name = text(row, "level"),
        says = ("%s: %.4g ms a step; %.0f pairs missed, %.0f false"):format(cut(text(row, "level"), 20), step_ms(row),
          number(row, "missed"), number(row, "false")),
        { part = part_of(step_ms(row), slowest), colour = colour, pale = beaten,
          words = ("%s%.3g ms  %.3g×"):format(cut_mark(step_ms(row), slowest), step_ms(row), number(row, "relative")) },
        { part = part_of(digits_of_wrong(row), greatest(levels, digits_of_wrong)), colour = "mark", pale = beaten,
          words = wrong(row) > 0 and count(wrong(row)) .. " pairs" or "none" },
      }
    end
  end
  local title = ("%s, %s pairs; %s%s"):format(scene_words(result), count(number(result, "pairs")),
    is_alone(result) and "" or letter .. ": ", cut(text(result, letter:lower()), 60))
  draw_rows(title, { "a step, against sat15", "wrong pairs" }, rows)
end

local function add_levels(results)
  paragraph("Each level of accuracy, on each device alone: the median time of a step, and how many pairs it gets "
    .. "wrong, by powers of ten. Pale: another level there is at least as fast and as right.")
  charts(function()
    for _, result in ipairs(results) do
      if not is_alone(result) then draw_levels(result, "A", "a") end
      draw_levels(result, "B", "b")
    end
  end)
end

local function effect_ms(row) return number(row, "ms") end
local function bytes(row) return number(row, "bytes") end

local function draw_effects(result)
  local effects, rows = list(result, "effects"), {}
  local slowest = most_shown_of(effects, effect_ms)
  for _, row in ipairs(effects) do
    if type(row) == "table" and row.active == true then
      rows[#rows + 1] = {
        name = text(row, "effect"),
        says = ("%s, called for by: %s"):format(cut(text(row, "effect"), 20), cut(text(row, "called_by"), 200)),
        { part = part_of(effect_ms(row), slowest), colour = "step",
          words = row.ms == nil and "with others" or cut_mark(effect_ms(row), slowest)
            .. ("%.3f ms"):format(effect_ms(row)) },
        { part = part_of(bytes(row), greatest(effects, bytes)), colour = "a",
          words = ("%.0f bytes"):format(bytes(row)) },
      }
    end
  end
  draw_rows(("%s: %.3f ms a step with all of them"):format(scene_words(result), step_ms(result)),
    { "of a step", "of an object" }, rows)
end

local function add_effects(results)
  paragraph("The effects that each scene calls for: the time of a step less that of the same scene without what calls "
    .. "for the effect, and the state that an object has for it. An effect that others call for too has no time of its "
    .. "own.")
  charts(function()
    for _, result in ipairs(results) do draw_effects(result) end
  end)
end

-- ---------------------------------------------------------------- the standard set

-- The cases that were measured, by scene in the order of their first.
local function scenes_of(result)
  local scenes, by_name = {}, {}
  for _, one in ipairs(list(result, "cases")) do
    if text(one, "failed") == "" then
      local name = text(one, "scene")
      if not by_name[name] then
        by_name[name] = {}
        scenes[#scenes + 1] = by_name[name]
      end
      table.insert(by_name[name], one)
    end
  end
  return scenes, by_name
end

-- Over the share, by the mode and kernels of the scene's first case.
local function draw_shares(cases)
  local series = {
    { name = "A", colour = "a", field = "a_ms", points = {} },
    { name = "B", colour = "b", field = "b_ms", points = {} },
    { name = "step", colour = "step", field = "median_ms", points = {} },
  }
  for _, one in ipairs(cases) do
    if same_plan(one, cases[1]) then
      for _, s in ipairs(series) do
        local share, ms = number(one, "share"), number(one, s.field)
        table.insert(s.points, { x = share, y = ms, says = ("share %.2f: %.3f ms"):format(share, ms) })
      end
    end
  end
  draw_chart { title = scene_words(cases[1]), x_label = "share of A", y_label = "ms", series = series }
end

local stages_most <const> = 12 -- colours; more stages share the last

-- Stage names in the order in which results first have them, and their places: a name
-- keeps its colour on the whole page.
local function find_stages(result)
  local names, places = {}, {}
  for _, one in ipairs(list(result, "cases")) do
    for _, stage in ipairs(list(one, "stages")) do
      local name = text(stage, "name")
      if not places[name] and #names < stages_most then
        names[#names + 1] = name
        places[name] = #names - 1
      end
    end
  end
  return names, places
end

-- Stages of one name are one part, however often they ran. Returns all ms too.
local function parts_of(one, letter, places)
  local parts, by_colour, ms = {}, {}, 0
  for _, stage in ipairs(list(one, "stages")) do
    if text(stage, "device") == letter then
      local colour = places[text(stage, "name")] or stages_most - 1
      local part = by_colour[colour]
      if not part then
        part = { colour = colour, value = 0 }
        by_colour[colour] = part
        parts[#parts + 1] = part
      end
      part.name = text(stage, "name")
      part.value = part.value + number(stage, "ms")
      ms = ms + number(stage, "ms")
    end
  end
  return parts, ms
end

local function case_words(one, alone)
  if alone then return ("%s: %.3f ms"):format(cut(text(one, "variant_b"), 80), number(one, "median_ms")) end
  local a, b = text(one, "variant_a"), text(one, "variant_b")
  local kernels = a == b and cut(a, 40) or cut(a, 40) .. " | " .. cut(b, 40)
  return ("share %.2f, %s, %s: %.3f ms"):format(number(one, "share"), text(one, "mode"), kernels,
    number(one, "median_ms"))
end

local function draw_stages(cases, places, alone)
  local y, all = 0, {}
  local letters = alone and { "B" } or { "A", "B" }
  for _, one in ipairs(cases) do
    for _, letter in ipairs(letters) do all[#all + 1] = select(2, parts_of(one, letter, places)) end
  end
  local most = most_shown(all)
  figure(scene_words(cases[1]), (18 + 11 * #letters) * #cases + 6)
  for _, one in ipairs(cases) do
    label(2, y + 14, case_words(one, alone))
    y = y + 18
    for _, letter in ipairs(letters) do
      local parts, ms = parts_of(one, letter, places)
      y = draw_parts(y, alone and "" or letter, parts, ms, most)
    end
  end
  figure_end()
end

-- "2026-01-31T12:30:59Z" as "2026-01-31 12:30 UTC"
local function moment(result)
  local time = text(result, "time")
  if time:sub(11, 11) ~= "T" then return cut(time, 30) end
  return ("%s %s UTC"):format(time:sub(1, 10), time:sub(12, 16))
end

-- The best step of a scene in each of the results.
local function draw_history(results, first)
  local points = {}
  for i, result in ipairs(results) do
    local best
    local _, by_name = scenes_of(result)
    for _, one in ipairs(by_name[text(first, "scene")] or {}) do
      local alike = number(one, "objects") == number(first, "objects")
      if alike and (not best or number(one, "median_ms") < number(best, "median_ms")) then best = one end
    end
    if best then
      local ms = number(best, "median_ms")
      local says = ("%s, Duet %s: %.3f ms"):format(moment(result), cut(text(result, "duet"), 20), ms)
      points[#points + 1] = { x = i, y = ms, says = says }
    end
  end
  draw_chart { title = scene_words(first), x_label = "result, the latest last", y_label = "ms", counted = true,
    series = { { name = "best plan", colour = "step", points = points } } }
end

local function is_bench_of_one(result)
  local devices = list(result, "devices")
  return is_one_device(devices[1], devices[2])
end

local function add_subject(result)
  local alone = is_bench_of_one(result)
  paragraph("Measured %s by Duet %s.", moment(result), text(result, "duet"))
  for i, device in ipairs(list(result, "devices")) do
    if alone and i > 1 then break end
    paragraph("%s%s, %s, driver %s, %s", alone and "" or string.char(64 + i) .. ": ", text(device, "selector"),
      text(device, "name"), text(device, "driver"), text(device, "platform"))
  end
end

local function add_bench(results)
  local latest = results[#results]
  local scenes = scenes_of(latest)
  local names, places = find_stages(latest)
  local alone = is_bench_of_one(latest)
  if not alone then
    section("Standard set: shares", function()
      add_subject(latest)
      charts(function()
        for _, cases in ipairs(scenes) do draw_shares(cases) end
      end)
    end)
  end
  section("Standard set: stages", function()
    local keys = {}
    if alone then add_subject(latest) end
    for i, name in ipairs(names) do keys[i] = key("s" .. i - 1, name) end
    add("<p>%s</p>\n", table.concat(keys))
    charts(function()
      for _, cases in ipairs(scenes) do draw_stages(cases, places, alone) end
    end)
  end)
  if #results > 1 then
    section("Standard set: history", function()
      charts(function()
        for _, cases in ipairs(scenes) do draw_history(results, cases[1]) end
      end)
    end)
  end
end

-- ---------------------------------------------------------------- what was found

local function gain_words(p)
  return ("%s, %s objects: a step takes %.3g ms, %.0f %% faster than on the better device alone; A has %.0f %% of the work")
    :format(cut(p.scene ~= "" and p.scene or "a scene", 60), count(p.objects), p.ms, 100 * p.gain, 100 * p.share)
end

local function found_in_store(found, profiles)
  local live, best, n_faster = 0, nil, 0
  for _, p in ipairs(profiles) do
    live = live + (p.live and not is_of_one(p) and 1 or 0)
    if p.live and not alone(p) and p.verdict == "faster" then
      n_faster = n_faster + 1
      if not best or p.gain > best.gain then best = p end
    end
  end
  if live == 0 then return end
  found[#found + 1] = ("Sharing the work is faster than the better device alone for %d of %d profiles."):format(n_faster, live)
  if best then found[#found + 1] = gain_words(best) .. "." end
end

-- The fastest case of each scene.
local function found_in_bench(found, result)
  for _, cases in ipairs((scenes_of(result))) do
    local best = cases[1]
    for _, one in ipairs(cases) do
      if number(one, "median_ms") < number(best, "median_ms") then best = one end
    end
    found[#found + 1] = ("%s: the fastest step takes %.3g ms%s."):format(scene_words(best), number(best, "median_ms"),
      is_bench_of_one(result) and "" or (", with %.0f %% of the work on A"):format(100 * number(best, "share")))
  end
end

local function found_in_levels(found, results)
  for _, result in ipairs(results) do
    local exact, best
    for _, row in ipairs(list(result, "levels")) do
      if text(row, "device") == "B" and text(row, "level") == "certified" then exact = row end
    end
    for _, row in ipairs(list(result, "levels")) do
      local beats = exact and text(row, "device") == "B" and step_ms(row) < step_ms(exact)
      if beats and (not best or step_ms(row) < step_ms(best)) then best = row end
    end
    if exact then
      found[#found + 1] = ("%s: the exact step takes %.3g ms%s; %s"):format(scene_words(result), step_ms(exact),
        is_alone(result) and "" or " on B", best and ("level %s takes %.3g ms and gets %s pairs wrong."):format(cut(text(best, "level"), 20), step_ms(best),
          count(wrong(best))) or "no other level is faster.")
    end
  end
end

-- Devices by name: of the newest results, or else of the first profile.
local function subject_words(data)
  local devices = #data.bench > 0 and list(data.bench[#data.bench], "devices") or {}
  local live = data.store and data.store.profiles[1]
  local names = {}
  if is_one_device(devices[1], devices[2]) then
    devices = { devices[1] }
  elseif #devices == 0 and live then
    devices = is_of_one(live) and { live.b } or { live.a, live.b }
  end
  for i, device in ipairs(devices) do
    local at = text(device, "selector")
    names[i] = cut(text(device, "name"), 60) .. (at ~= "" and (" (%s)"):format(cut(at, 30)) or "")
  end
  return table.concat(names, " and ")
end

local function add_found(data)
  local found = {}
  if data.store then found_in_store(found, data.store.profiles) end
  if #data.bench > 0 then found_in_bench(found, data.bench[#data.bench]) end
  found_in_levels(found, data.levels)
  local subject = subject_words(data)
  if subject ~= "" then paragraph("On %s.", subject) end
  if #found == 0 then return end
  add('<ul class="found">\n')
  for _, line in ipairs(found) do add("<li>%s</li>\n", words(line)) end
  add("</ul>\n")
end

-- ---------------------------------------------------------------- the legend

local legend <const> = {
  { "A, B", "the two devices of a pair; A takes the share, B the rest" },
  { "share", "A's part of the objects, in percent or from 0 to 1" },
  { "step", "one search for all pairs that collide; times are medians, in milliseconds" },
  { "(… to …)", "the interval in which the median lies with at least 95 %" },
  { "gain", "how much faster a step is than on the better of the two devices alone" },
  { "verdict", "whether that is certain: faster, same, slower, or ambiguous where the interval does not say" },
  { "mode", "how grids are built: shared (B builds, A receives), own (each the whole), slab (each a part)" },
  { "kernels", "the variant that a device runs: auto chooses by device, simd, gpu or paper" },
  { "level", "of accuracy: certified is exact, the others are faster or simpler and can be wrong" },
  { "wrong pairs", "pairs that a level misses, and false ones that it adds" },
  { "profile", "what an application loads: kernels, mode and share for a scene on a device pair" },
  { "…, ▲", "a value that is too far above the others to be drawn to scale" },
}

local function add_legend()
  section("What the words mean", function()
    add("<dl>\n")
    for _, one in ipairs(legend) do add("<dt>%s</dt><dd>%s</dd>\n", words(one[1]), words(one[2])) end
    add("</dl>\n")
  end)
end

-- ---------------------------------------------------------------- all of it

return function(data)
  local title <const> = "Duet: what was measured"
  add('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n')
  add('<meta name="viewport" content="width=device-width,initial-scale=1">\n')
  add('<meta name="color-scheme" content="light dark">\n<title>%s</title>\n', title)
  add("<style>\n%s</style></head>\n<body><main>\n<h1>%s</h1>\n", style, title)
  add_found(data)
  paragraph("Made %s by Duet %s.", data.made, data.duet)
  if data.no_store then paragraph("%s", data.no_store) end
  if data.store then add_store(data.store) end
  if #data.levels > 0 then section("Accuracy against time", function() add_levels(data.levels) end) end
  if #data.effects > 0 then section("What effects cost", function() add_effects(data.effects) end) end
  if #data.bench > 0 then add_bench(data.bench) end
  add_legend()
  add("</main></body></html>\n")
  return table.concat(page)
end
