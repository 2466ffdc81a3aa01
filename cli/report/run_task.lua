-- SPDX-License-Identifier: MIT
-- `duet run --task` tells this, of the object that --json prints, and: tuning, the command that measures a plan.
local report = ...
local line = report.line

local function tell_plan(o)
  if o.plan_from == "default" then
    line("plan: the default; to measure a better one:")
    report.command(o.tuning)
  else
    line("plan: %s", o.plan_from == "given" and "as given" or "from the profile, " .. o.plan_from)
  end
  line("")
end

-- Stages of one name are one row.
local function tell_stages(o)
  local rows = {}
  for _, stage in ipairs(o.stages) do
    local row = rows[stage.name] or { name = stage.name, A = 0, B = 0 }
    if not rows[stage.name] then rows[#rows + 1], rows[stage.name] = row, row end
    row[stage.device] = row[stage.device] + stage.ms
  end
  local add = report.columns("lrr", "", "A ms", "B ms")
  for _, row in ipairs(rows) do add(row.name, ("%.3f"):format(row.A), ("%.3f"):format(row.B)) end
  add("together", ("%.3f"):format(o.a_ms), ("%.3f"):format(o.b_ms))
end

return function(o)
  line("%s: %s items of kernel %s", o.task, report.count(o.items), o.kernel)
  report.tell_devices(o)
  tell_plan(o)
  tell_stages(o)
  line("\ntime: %.3f ms, median of %.0f, %.3f to %.3f; %s items a second", o.total_ms, o.launches, o.least_ms, o.most_ms,
    report.rate(o.total_ms > 0 and o.items / o.total_ms * 1e3 or 0))
  line("right: every launch, %s what %s", o.tolerance > 0 and ("within %g of"):format(o.tolerance) or "exactly",
    o.reference == "" and "the task expects"
      or o.reference == o.kernel and ("kernel %s itself finds on B alone: only sharing is checked"):format(o.kernel)
      or ("kernel %s finds on B alone"):format(o.reference))
  return report.told
end
