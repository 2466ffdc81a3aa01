-- SPDX-License-Identifier: MIT
-- `duet tune --replay` tells this, of the object that --json prints.
local report = ...
local line, count = report.line, report.count

local function plan_words(row)
  return report.plan_words(row.share) .. (row.share > 0 and row.share < 1 and " " .. row.mode or "")
end

-- Objects, and what they are asked; a task has items alone.
local function subject(o)
  if not o.query then return count(o.objects) end
  if o.objects == 0 then return count(o.items) .. ", " .. o.query end
  return ("%s: %s %s"):format(count(o.objects), count(o.items), o.query)
end

local function tell_workload(o)
  line("%s, %s\nA: %s\nB: %s", o.scene, subject(o), o.a, o.b)
  line("best of %.0f recorded plans: %s, %.3f ms", o.plans, plan_words(o), o.best_ms)
  local row = report.columns("llrrrrrr", "strategy", "plan", "ms", "loss %", "worst", "search", "launches", "seconds")
  for _, one in ipairs(o.strategies) do
    row(one.strategy, plan_words(one), ("%.3f"):format(one.ms), ("%.1f"):format(100 * one.loss),
      ("%.1f"):format(100 * one.worst_loss), ("%.0f"):format(one.search_launches), ("%.0f"):format(one.launches),
      ("%.2f"):format(one.seconds))
  end
  line("")
end

return function(data)
  for _, o in ipairs(data.workloads) do tell_workload(o) end
  line("Each strategy was replayed %.0f times; its row is the run with the median loss.\n"
    .. "loss: by how much the plan takes longer than the best recorded one; worst: in\n"
    .. "the worst run. search: launches until the shares were searched; launches and\n"
    .. "seconds: with the races after it, and without compiling kernels.", data.runs)
  return report.told
end
