-- SPDX-License-Identifier: MIT
-- `duet run --steps` tells this after the last step, of the object that --json prints; stages has its stages in order.
local report = ...
local line = report.line

-- The rest of a step is the host's own work and waits. Stages of two devices may take more together than the step does.
local function tell_times(o)
  local all, row = 0, report.columns("lrrl", "", "ms a step", "%", "")
  for _, stage in ipairs(o.stages) do all = all + stage.ms end
  local whole = math.max(o.ms_a_step, all)
  local function tell(name, ms)
    local part = whole > 0 and ms / whole or 0
    row(name, ("%.3f"):format(ms), ("%.1f"):format(100 * part), report.bar(part, 24))
  end
  for _, stage in ipairs(o.stages) do tell(stage.name, stage.ms) end
  if all < o.ms_a_step then tell("host and waits", o.ms_a_step - all) end
  if o.timed_steps + 1 < o.steps then line("of %s", report.things(o.timed_steps, "timed step", "timed steps")) end
  line("\n%.3f ms a step after the first, the slowest %.3f: %.4g steps a second", o.ms_a_step, o.slowest_ms,
    o.ms_a_step > 0 and 1e3 / o.ms_a_step or 0)
end

return function(o)
  line("")
  if #o.stages > 0 then
    tell_times(o)
  elseif #o.effects == 0 then
    line("nothing is called for, so that a step launches nothing")
  end
  line("state hash %s", o.hash)
  return report.told
end
