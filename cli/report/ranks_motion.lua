-- SPDX-License-Identifier: MIT
-- `duet cluster` tells this of a motion, of the object that --json prints.
local report = ...
local line, count = report.line, report.count

-- A step's mean, on rank 0: kernels that were launched, how often the host waited for its devices, and for other ranks.
local function tell_phases(phases, moves)
  line("\nrank 0, mean of the steps after the first; bodies were exchanged %s",
    moves == 1 and "once" or ("%.0f times"):format(moves))
  local row = report.columns("lrrrrrr", "phase", "ms", "launches", "waits", "exchanges", "sent kB", "wait ms")
  for _, p in ipairs(phases) do
    row(p.phase, ("%.3f"):format(p.ms), ("%.1f"):format(p.launches), ("%.1f"):format(p.waits),
      ("%.1f"):format(p.exchanges), ("%.1f"):format(p.bytes / 1e3), ("%.3f"):format(p.wait_ms))
  end
  line("")
end

return function(o)
  line("%s: %s bodies, %s of %.0f\n", o.scene, count(o.objects), report.things(o.ranks, "rank", "ranks"), o.parts)
  local row = report.columns("lrl")
  row("steps", count(o.steps), ("%.3f ms a step, to step %.0f"):format(o.ms_a_step, o.step))
  row("contacts", count(o.contacts), "push, in " .. report.things(o.colours, "colour", "colours"))
  row("ghosts", count(o.ghosts), "bodies that domains have of others")
  if o.ranks > 1 or o.parts > 1 then
    local by = { tuned = "tuned", given = "as given", default = "by default",
      trying = "being tried", tried = "tried" }
    row("exchanges", count(o.colours_between), ("%s at the most between two; %s"):format(
      o.colours_between == 1 and "colour" or "colours", by[o.colours_by] or "stored, " .. o.colours_by))
  end
  for _, t in ipairs(o.tried or {}) do
    row("", ("%.3f"):format(t.ms), ("ms a step with %s"):format(report.things(t.colours_between, "colour", "colours")))
  end
  if o.slowest_part and o.ranks > 1 then
    row("slowest", ("%.2f"):format(o.slowest_part), ("times the mean rank's work a step; rank %.0f last"):format(o.slowest_rank))
  end
  if o.phases then tell_phases(o.phases, o.moves) end
  if o.equal then row("check", "equal", "to one motion, in each step") end
  line("state hash %s", o.hash)
  return report.told
end
