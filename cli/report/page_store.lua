-- SPDX-License-Identifier: MIT
-- The page's sections on the profile store: what was kept, how it was found, and what replaced it.
local report = ...
local number, list, count, is_of_one = report.number, report.list, report.count, report.is_of_one
local same_plan, cut, add, words = report.same_plan, report.cut, report.add, report.words
local paragraph, section, charts = report.paragraph, report.section, report.charts
local device_words, rows_begin, rows_end = report.device_words, report.rows_begin, report.rows_end
local draw_chart = report.draw_chart

local function title_of(p)
  local plan = is_of_one(p) and p.variant_b or ("%s | %s, %s"):format(p.variant_a, p.variant_b, p.mode)
  return ("%s: %s, level %s"):format(report.workload_words(p), plan, p.level)
end

local function pair_words(p)
  return is_of_one(p) and device_words(p.b) or ("A: %s. B: %s."):format(device_words(p.a), device_words(p.b))
end

-- "A alone" or "B alone"; nil if both work.
function report.alone(p) return p.share == 0 and "B alone" or p.share == 1 and "A alone" or nil end

-- Part of the launches that waited for a core.
local function waited(p) return p.watched > 0 and ("%.0f"):format(100 * p.disturbed / p.watched) or "-" end

local function kernels_of(p)
  return p.variant_a == p.variant_b and p.variant_b or ("%s | %s"):format(p.variant_a, p.variant_b)
end

local function profile_row(row, p)
  if is_of_one(p) then
    row { report.workload_words(p), p.variant_b, p.level,
      ("%.3f (%.3f to %.3f)"):format(p.ms, p.low_ms, p.high_ms), waited(p), p.created }
    return
  end
  local gain = ("%+.1f (%+.1f to %+.1f)"):format(100 * p.gain, 100 * p.gain_low, 100 * p.gain_high)
  row { report.workload_words(p), report.alone(p) or ("%.1f %%"):format(100 * p.share), p.mode, kernels_of(p),
    p.level, ("%.3f (%.3f to %.3f)"):format(p.ms, p.low_ms, p.high_ms),
    report.alone(p) and "-" or gain, report.alone(p) and "-" or p.verdict, waited(p), p.created }
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
          and rows_begin("lllrrl", { "workload", "kernels", "level", "step, ms", "waited, %", "measured, UTC" })
        or rows_begin("lrlllrrlrl", { "workload", "share of A", "mode", "kernels", "level", "step, ms",
        "gain, %", "verdict", "waited, %", "measured, UTC" })
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

-- Plans that no other beats in both time and energy, if energy was measured.
local function draw_energy(p)
  local front, chosen = {}, {}
  for _, plan in ipairs(list(p, "pareto")) do
    local says = ("share %.4f, %s | %s: %.3f ms, %.4g J"):format(plan.share, plan.variant_a, plan.variant_b, plan.ms, plan.joules)
    local points = same_plan(plan, p) and plan.share == p.share and chosen or front
    points[#points + 1] = { x = plan.ms, y = plan.joules, says = says }
    if points == chosen then front[#front + 1] = points[#points] end
  end
  if #front == 0 then return end
  draw_chart { title = title_of(p), x_label = "ms a launch", y_label = "J a launch", series = {
    { name = "plans that no other beats", colour = "a", points = front },
    { name = "the plan to use", colour = "step", points = chosen, loose = true },
  } }
end

local function add_energy(profiles)
  paragraph("The plans that no other plan beats in both time and energy.")
  charts(function()
    for _, p in ipairs(profiles) do
      if p.live then draw_energy(p) end
    end
  end)
end

local function any(profiles, holds)
  for _, p in ipairs(profiles) do
    if holds(p) then return true end
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

function report.add_store(store)
  local profiles = store.profiles
  if #profiles == 0 then
    paragraph("%s: no profiles yet; duet tune makes them.", store.path)
    return
  end
  section("Profiles", function() add_profiles(profiles) end)
  local function add_if(heading, add_it, holds)
    if any(profiles, holds) then section(heading, function() add_it(profiles) end) end
  end
  add_if("Searches", add_searches, function(p) return p.live and not is_of_one(p) end)
  add_if("Time and energy", add_energy, function(p) return p.live and p.pareto end)
  add_if("Levels of the profiles", add_accuracy, function(p) return p.level ~= profiles[1].level end)
  add_replaced(profiles)
end

return report
