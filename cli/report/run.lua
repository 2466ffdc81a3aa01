-- SPDX-License-Identifier: MIT
-- `duet run` tells this of a still scene, of the object that --json prints, and:
--
--   plan_given, accuracy_given   on the command line; a profile may have chosen a level by the accuracy
--   tuning                       the command that measures a plan for this scene
--   asked_cell                   the scene's
--   gain..., verdict             of the profile
local report = ...
local line, count, bytes, things = report.line, report.count, report.bytes, report.things

local function tell_grid(o)
  local cells = {}
  for i, n in ipairs(o.cells) do cells[i] = ("%.0f"):format(n) end
  line("%s%s cells of edge %.6g%s%s", table.concat(cells, " x "), o.hashed and " hashed" or "", o.cell,
    o.grid_levels > 1 and (" and coarser, %.0f grid levels"):format(o.grid_levels) or "",
    o.cell_widened and (", widened from %.6g to hold the largest box"):format(o.asked_cell) or "")
end

local function is_measured(o) return not o.plan_given and o.profile ~= "stale" and o.profile ~= "default" end

local function source_words(o)
  if o.plan_given then return "as given" end
  if o.profile == "stale" then return "the default, since the kernels changed after it was measured" end
  if o.profile == "default" then return "the default" end
  if o.verdict == "" then return "from the profile of another workload; what it gains here is not known" end
  return "from the profile, " .. o.profile .. (report.is_alone(o) and "" or "; " .. report.gain(o))
end

local function tell_plan(o)
  local settled = is_measured(o) or (o.plan_given and not o.accuracy_given)
  line("plan: %s%s", source_words(o), settled and "" or "; to measure a better one:")
  if not settled then report.command(o.tuning) end
  line("")
end

-- Stages of one name are one row: those of the device that went through more of them, then what only the other did.
local function gather_stages(stages)
  local own, rows, all = { A = {}, B = {} }, {}, { A = 0, B = 0 }
  for _, stage in ipairs(stages) do
    table.insert(own[stage.device], stage)
    all[stage.device] = all[stage.device] + stage.ms
  end
  for _, device in ipairs(#own.B > #own.A and { "B", "A" } or { "A", "B" }) do
    for _, stage in ipairs(own[device]) do
      local row = rows[stage.name] or { name = stage.name, A = 0, B = 0 }
      if not rows[stage.name] then rows[#rows + 1], rows[stage.name] = row, row end
      row[device] = row[device] + stage.ms
    end
  end
  return rows, all
end

-- A device that had nothing to do has no columns.
local function tell_stages(o)
  local rows, all = gather_stages(o.stages)
  local digits = math.max(all.A, all.B) < 0.1 and "%.5f" or "%.3f" -- a few boxes take less than 0.001 ms
  local devices = {}
  for _, device in ipairs { "A", "B" } do
    if all[device] > 0 then devices[#devices + 1] = device end
  end
  local add = report.columns("l" .. ("rrl"):rep(#devices), "")
  for _, device in ipairs(devices) do
    add(report.is_alone(o) and "ms" or device .. " ms", "%", (" "):rep(16))
  end
  for _, row in ipairs(rows) do
    add(row.name)
    for _, device in ipairs(devices) do
      local ms, part = row[device], row[device] / all[device]
      add(ms > 0 and digits:format(ms) or "-", ms > 0 and ("%.1f"):format(100 * part) or " ", report.bar(part, 16))
    end
  end
  add("together")
  for _, device in ipairs(devices) do add(digits:format(all[device]), " ", " ") end
  line("")
end

local function tell_totals(o)
  local row = report.columns("lrl", "candidates", count(o.candidates), "pairs whose bounds overlap", "pairs",
    count(o.pairs), ("collide, at level %s; hash %s"):format(o.level, o.hash))
  if o.undecided > 0 then
    row("undecided", count(o.undecided), "too close for float, decided by exact arithmetic on the host")
  end
  if o.bad > 0 then row("bad objects", count(o.bad), ("left out; the first is %.0f"):format(o.first_bad)) end
  row("memory", bytes(o.bytes_a + o.bytes_b),
    report.is_alone(o) and "" or ("A %s, B %s"):format(bytes(o.bytes_a), bytes(o.bytes_b)))
  row("time", ("%.3f ms"):format(o.total_ms), ("median of %.0f, %.3f to %.3f; %s boxes a second"):format(o["repeat"],
    o.least_ms, o.most_ms, report.rate(o.total_ms > 0 and o.objects / o.total_ms * 1e3 or 0)))
  if report.disturbed(o) then row("", "", report.disturbed(o)) end
end

local function tell_step(o)
  tell_grid(o)
  report.tell_devices(o)
  report.tell_grids(o)
  if o.accuracy_given and not is_measured(o) then
    line("level: %s, since no profile says that a cheaper one is accurate enough", o.level)
  end
  tell_plan(o)
  tell_stages(o)
  tell_totals(o)
end

return function(o)
  line("%s", report.scene_words(o))
  if o.objects > 0 then tell_step(o) end
  if o.check then report.tell_check(o.check) end
  return report.told
end
