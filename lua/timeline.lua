-- SPDX-License-Identifier: MIT
-- Draws the time lines of one step, as the paper's figures 10 and 11 do: for each device a line of
-- kernels and one of transfers. Returns a function from a table to the text of an SVG:
--
--   local draw = require "duet.timeline"
--   draw { title = "paper, 1 M", about = { "share 0.25" }, total_ms = result.total_ms,
--          devices = { A = "pocl:0", B = "nvidia:0" }, stages = result:stages() }
--
-- A bar goes from a stage's first command to the end of its last one. The SVG is dark on a dark page.

local colours <const> = { "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#B8A800", "#777777",
  "#8B5A2B", "#AAAAAA" }
local width <const>, left <const>, right <const> = 960, 190, 930
local bar <const>, gap <const> = 20, 4
local letter <const> = 6.4 -- the width of one, in pixels

local style <const> = [[
<style>
svg{background:#fff;font:12px sans-serif}text{fill:#222}.h{font-size:15px;font-weight:bold}.n{fill:#666}
.g{stroke:#ddd}.e{stroke:#b00;stroke-dasharray:4 3}.l{fill:#fff}
@media(prefers-color-scheme:dark){svg{background:#14181f}text{fill:#e3e8ef}.n{fill:#a3abb5}.g{stroke:#333c49}.l{fill:#fff}}
</style>
]]

local entities = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;" }

-- Without patterns, which the sandbox lacks.
local function words(text)
  local letters = {}
  for i = 1, #text do letters[i] = entities[text:sub(i, i)] or text:sub(i, i) end
  return table.concat(letters)
end

-- About eight ticks at 1, 2 or 5 times a power of ten.
local function tick_of(span)
  local power = 10.0 ^ math.floor(math.log(span / 8, 10))
  local times = span / 8 / power
  return power * (times <= 1 and 1 or times <= 2 and 2 or times <= 5 and 5 or 10)
end

-- The stages of one line, in order, each in the first row where no other is at its time.
local function place_in_rows(stages)
  local rows = {}
  table.sort(stages, function(a, b) return a.begin_ms < b.begin_ms end)
  for _, stage in ipairs(stages) do
    local row = 1
    while rows[row] and rows[row] > stage.begin_ms do row = row + 1 end
    rows[row] = stage.end_ms
    stage.row = row
  end
  return math.max(#rows, 1)
end

-- Lines from top to bottom, and the stages' colours by name. Stages that took no time are in none.
local function arrange(def)
  local lines, colour_of, names = {}, {}, {}
  for _, letter_of in ipairs { "A", "B" } do
    for _, transfers in ipairs { false, true } do
      local line = { name = letter_of .. "  " .. (transfers and "transfers" or def.devices[letter_of] or ""), stages = {} }
      for _, stage in ipairs(def.stages) do
        if stage.device == letter_of and stage.transfer == transfers and stage.end_ms > stage.begin_ms then
          local copy = {}
          for key, value in pairs(stage) do copy[key] = value end
          line.stages[#line.stages + 1] = copy
        end
      end
      line.rows = place_in_rows(line.stages)
      if #line.stages > 0 then lines[#lines + 1] = line end
      for _, stage in ipairs(line.stages) do
        if not colour_of[stage.name] then
          names[#names + 1] = stage.name
          colour_of[stage.name] = colours[(#names - 1) % #colours + 1]
        end
      end
    end
  end
  return lines, colour_of, names
end

local function span_of(def)
  local low, high = 0, def.total_ms or 0
  for _, stage in ipairs(def.stages) do
    low, high = math.min(low, stage.begin_ms), math.max(high, stage.end_ms)
  end
  return low, high > low and high or low + 1
end

-- The time of each stage on each device, in three columns.
local function legend(add, def, names, colour_of, top)
  local column_width = (width - 40) / 3
  for i, name in ipairs(names) do
    local x, y = 20 + (i - 1) % 3 * column_width, top + (i - 1) // 3 * 18
    local took = {}
    for _, stage in ipairs(def.stages) do
      if stage.name == name then took[#took + 1] = ("%s %.3f"):format(stage.device, stage.ms) end
    end
    add('<rect x="%.1f" y="%.1f" width="10" height="10" fill="%s"/>', x, y - 9, colour_of[name])
    add('<text x="%.1f" y="%.1f">%s <tspan class="n">%s ms</tspan></text>', x + 16, y, words(name), table.concat(took, ", "))
  end
  return top + (#names + 2) // 3 * 18
end

return function(def)
  local lines, colour_of, names = arrange(def)
  local low, high = span_of(def)
  local pieces, about = {}, def.about or {}
  local function add(format, ...) pieces[#pieces + 1] = format:format(...) end
  local function at(ms) return left + (right - left) * (ms - low) / (high - low) end

  add('<text class="h" x="20" y="28">%s</text>', words(def.title))
  for i, text in ipairs(about) do add('<text class="n" x="20" y="%d">%s</text>', 30 + 17 * i, words(text)) end
  local top = 48 + 17 * #about
  local bottom = top
  for _, line in ipairs(lines) do bottom = bottom + line.rows * (bar + gap) + 8 end

  local tick = tick_of(high - low)
  for i = math.ceil(low / tick), high // tick do
    add('<line class="g" x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f"/>', at(i * tick), top - 6, at(i * tick), bottom)
    add('<text class="n" x="%.1f" y="%.1f" text-anchor="middle">%.6g%s</text>', at(i * tick), bottom + 15, i * tick,
      (i + 1) * tick > high and " ms" or "")
  end
  local y = top
  for _, line in ipairs(lines) do
    add('<text x="20" y="%.1f">%s</text>', y + 14, words(line.name))
    for _, stage in ipairs(line.stages) do
      local x, bar_y = at(stage.begin_ms), y + (stage.row - 1) * (bar + gap)
      local long = math.max(at(stage.end_ms) - x, 1)
      add('<rect x="%.1f" y="%.1f" width="%.1f" height="%d" rx="2" fill="%s"><title>%s: %.3f ms, from %.3f to %.3f</title></rect>',
        x, bar_y, long, bar, colour_of[stage.name], words(stage.name), stage.ms, stage.begin_ms, stage.end_ms)
      if #stage.name * letter + 8 < long then
        add('<text class="l" x="%.1f" y="%.1f" pointer-events="none">%s</text>', x + 4, bar_y + 14, words(stage.name))
      end
    end
    y = y + line.rows * (bar + gap) + 8
  end
  local tall = legend(add, def, names, colour_of, bottom + 44) + 8
  if def.total_ms then
    -- The host's clock began a little apart from the devices': nothing that they do is behind what it has.
    local last = def.total_ms
    for _, stage in ipairs(def.stages) do last = math.max(last, stage.end_ms) end
    add('<line class="e" x1="%.1f" y1="%.1f" x2="%.1f" y2="%.1f"/>', at(last), top - 6, at(last), bottom)
    add('<line class="e" x1="20" y1="%d" x2="34" y2="%d"/>', tall - 4, tall - 4)
    add('<text class="n" x="40" y="%d">the host has the answer: %.3f ms</text>', tall, def.total_ms)
    tall = tall + 16
  end
  return ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" width="%d" height="%d">\n<title>%s</title>\n%s%s\n</svg>\n'):format(
    width, tall, width, tall, words(def.title), style, table.concat(pieces, "\n"))
end
