-- SPDX-License-Identifier: MIT
-- The page of `duet report`: HTML that stands by itself, light and dark. Returns a
-- function from what was measured to the page's text:
--
--   duet, made    the version that made the page, and when
--   store         path and profiles, each as `duet profiles show --json` has it; or nil
--   no_store      where there is none: a sentence that says so
--   files         results of bench, accuracy and explain, the earliest first
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
th,td{padding:.25em .5em;border-bottom:1px solid var(--line);text-align:left;overflow-wrap:break-word}
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

local report = ...
local text, number, list = report.text, report.number, report.list
local is_one_device, count, is_of_one = report.is_one_device, report.count, report.is_of_one
local greatest, most_shown_of, cut = report.greatest, report.most_shown_of, report.cut
local scene_words, add, words = report.scene_words, report.add, report.words
local paragraph, section, charts = report.paragraph, report.section, report.charts
local part_of, cut_mark, draw_rows = report.part_of, report.cut_mark, report.draw_rows
local alone, add_store, scenes_of = report.alone, report.add_store, report.scenes_of
local is_bench_of_one, add_bench = report.is_bench_of_one, report.add_bench

-- ---------------------------------------------------------------- levels and effects

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

-- ---------------------------------------------------------------- what was found

local function gain_words(p)
  return ("%s: a step takes %.3g ms, %.0f %% faster than on the better device alone; A has %.0f %% of the work"):format(
    report.workload_words(p), p.ms, 100 * p.gain, 100 * p.share)
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
  { "waited", "launches of a tuning that waited for a core, which another program had" },
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

local function is_same_subject(a, b)
  for _, name in ipairs { "scene", "a", "b" } do
    if text(a, name) ~= text(b, name) then return false end
  end
  return number(a, "objects") == number(b, "objects")
end

-- In the place of an earlier one of the same subject.
local function keep_latest(results, one)
  local place = 1
  while results[place] and not is_same_subject(results[place], one) do place = place + 1 end
  results[place] = one
end

-- The files' results by their kind: levels and effects of a subject once.
local function sort_results(data)
  data.levels, data.effects, data.bench = {}, {}, {}
  for _, o in ipairs(data.files) do
    local kind = text(o, "type")
    local is_bench = kind == "duet bench"
    if is_bench then data.bench[#data.bench + 1] = o end
    if kind == "duet accuracy" then keep_latest(data.levels, o) end
    if kind == "duet explain" then keep_latest(data.effects, o) end
    for _, one in ipairs(is_bench and list(o, "accuracy") or {}) do keep_latest(data.levels, one) end
    for _, one in ipairs(is_bench and list(o, "effects") or {}) do keep_latest(data.effects, one) end
  end
end

return function(data)
  sort_results(data)
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
  return report.finish()
end
