-- SPDX-License-Identifier: MIT
-- What the program's reports say of objects that no machine makes on request.
local facts = require "facts"

local function part(name, ...) return assert(loadfile(facts.root .. "/cli/report/" .. name))(...) end

-- The lines and cells that a script tells of an object, one below the other.
local function told(script, o)
  local report = part("words.lua", part "read.lua") or error "words.lua returns no report"
  local lines = {}
  for _, line in ipairs(part(script, report)(o)) do
    lines[#lines + 1] = type(line) == "table" and table.concat(line, " ", 2) or line
  end
  return table.concat(lines, "\n")
end

-- The shapes that a script draws.
local function drawn(script, o)
  return part(script, part("shapes.lua", part("words.lua", part "read.lua")))(o)
end

facts.holds("steps that waited are told if other programs had cores", function()
  local report = part("words.lua", part "read.lua")
  local row = { watched = 5, disturbed = 3, cpu_load = 0.4 }
  facts.equal(report.disturbed(row), "3 of 5 steps waited for a core; other programs had 40 % of the cores")
  row.cpu_load = 0.004
  facts.equal(report.disturbed(row), nil)
  row.cpu_load, row.disturbed = 0.4, 0
  facts.equal(report.disturbed(row), nil)
end)

facts.holds("a tuning tells one number of launches", function()
  local row = { workload = "paper, 9", share = 1, step_ms = 1, gain = 0, gain_low = 0, gain_high = 0, whole_ms = 0,
    verdict = "", seconds = 1, level = "certified", unused = "", launches = 33, disturbed = 305, watched = 326 }
  local says = told("tune.lua", { workloads = { row } })
  assert(says:find("paper, 9, level certified, 33 launches", 1, true), says)
  assert(says:find("  94 % of the launches waited for a core", 1, true), says)
  assert(not says:find("326", 1, true), says)
  row.disturbed = 1
  assert(not told("tune.lua", { workloads = { row } }):find("waited", 1, true))
end)

facts.holds("times of a few boxes have digits", function()
  local o = { scene = "s", kind = "boxes", objects = 3, dims = 3, cells = { 1, 1, 1 }, cell = 1, grid_levels = 1,
    a = "x:0", b = "x:0", a_name = "x", b_name = "x", share = 0, variant_a = "simd", variant_b = "simd",
    profile = "default", tuning = "duet tune s", candidates = 1, pairs = 1, level = "certified", hash = "0",
    undecided = 0, bad = 0, bytes_a = 0, bytes_b = 1, total_ms = 0.02, least_ms = 0.02, most_ms = 0.02, ["repeat"] = 5,
    stages = { { name = "hash", device = "B", ms = 0.0004 } } }
  assert(told("run.lua", o):find("0.00040", 1, true), told("run.lua", o))
  o.stages[1].ms = 4
  assert(told("run.lua", o):find("4.000", 1, true))
end)

facts.holds("a workload is told by what there is of it", function()
  local report = part "read.lua"
  facts.equal(report.workload_words { scene = "paper", objects = 100000 }, "paper, 100 000")
  facts.equal(report.workload_words { scene = "", objects = 9, moving = true }, "-, 9, moving")
  local task = { scene = "gravity", objects = 0, items = 2000, query = "task gravity" }
  facts.equal(report.workload_words(task), "gravity, 2 000, task gravity")
  facts.equal(report.workload_words { scene = "paper", objects = 9, items = 50, query = "rays" }, "paper, 9: 50 rays")
end)

-- Boxes around words of a plot; a letter is 0.6 of its size wide.
local function boxes_of(plot, is_label)
  local boxes = {}
  for _, s in ipairs(plot) do
    if s.kind == "words" and is_label(s) then
      boxes[#boxes + 1] = { s.x, s.y - 0.75 * s.size, s.x + 0.6 * s.size * #s.words, s.y }
    elseif s.kind == "dot" and s.x < 645 then
      boxes[#boxes + 1] = { s.x - s.radius, s.y - s.radius, s.x + s.radius, s.y + s.radius, dot = s }
    end
  end
  return boxes
end

local function overlap(a, b) return a[1] < b[3] and b[1] < a[3] and a[2] < b[4] and b[2] < a[4] end

facts.holds("numbers at the points of a plot lie on no point and on no other number", function()
  local rows = {}
  for i, at in ipairs { { 49, 0.297 }, { 50.5, 0.295 }, { 29, 0.35 }, { 31.5, 0.35 }, { 90, 0.25 }, { 20, 0.9 } } do
    rows[i] = { ms_a_second = at[1], error = at[2], finite = true, dt = 1 / 60, substeps = i, integrator = "euler",
      front = i == 1 }
  end
  local plot = drawn("timesteps_plot.lua", { scene = "s", objects = 9, time = 1, timesteps = rows,
    reference = { integrator = "euler", dt = 1 / 480 } })
  local boxes = boxes_of(plot, function(s) return s.words:match "^%d$" and s.x > 90 and s.y < 480 end)
  for i = 1, #boxes do
    for j = i + 1, #boxes do
      local both_dots = boxes[i].dot and boxes[j].dot
      assert(both_dots or not overlap(boxes[i], boxes[j]), ("%d and %d overlap"):format(i, j))
    end
  end
  assert(#boxes == 2 * #rows, #boxes)
end)

facts.finish()
