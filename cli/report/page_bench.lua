-- SPDX-License-Identifier: MIT
-- The page's sections on the standard set: shares, stages and history.
local report = ...
local text, number, list = report.text, report.number, report.list
local is_one_device, same_plan = report.is_one_device, report.same_plan
local most_shown, cut, scene_words = report.most_shown, report.cut, report.scene_words
local add, paragraph, section, charts = report.add, report.paragraph, report.section, report.charts
local key, figure, label, figure_end = report.key, report.figure, report.label, report.figure_end
local draw_chart, draw_parts = report.draw_chart, report.draw_parts

-- The cases that were measured, by scene in the order of their first.
function report.scenes_of(result)
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
    local _, by_name = report.scenes_of(result)
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

function report.is_bench_of_one(result)
  local devices = list(result, "devices")
  return is_one_device(devices[1], devices[2])
end

local function add_subject(result)
  local alone = report.is_bench_of_one(result)
  paragraph("Measured %s by Duet %s.", moment(result), text(result, "duet"))
  for i, device in ipairs(list(result, "devices")) do
    if alone and i > 1 then break end
    paragraph("%s%s, %s, driver %s, %s", alone and "" or string.char(64 + i) .. ": ", text(device, "selector"),
      text(device, "name"), text(device, "driver"), text(device, "platform"))
  end
end

function report.add_bench(results)
  local latest = results[#results]
  local scenes = report.scenes_of(latest)
  local names, places = find_stages(latest)
  local alone = report.is_bench_of_one(latest)
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

return report
