-- SPDX-License-Identifier: MIT
-- `duet cluster` tells this of a motion, of the object that --json prints.
local report = ...
local line, count = report.line, report.count

return function(o)
  line("%s: %s bodies, %s of %.0f\n", o.scene, count(o.objects), report.things(o.ranks, "rank", "ranks"), o.parts)
  local row = report.columns("lrl")
  row("steps", count(o.steps), ("%.3f ms a step, to step %.0f"):format(o.ms_a_step, o.step))
  row("contacts", count(o.contacts), "push, in " .. report.things(o.colours, "colour", "colours"))
  row("ghosts", count(o.ghosts), "bodies that domains have of others")
  if o.ranks > 1 or o.parts > 1 then
    local by = { tuned = "tuned", given = "as given", default = "by default" }
    row("exchanges", count(o.colours_between), ("%s at the most between two; %s"):format(
      o.colours_between == 1 and "colour" or "colours", by[o.colours_by] or "stored, " .. o.colours_by))
  end
  if o.slowest_part and o.ranks > 1 then
    row("slowest", ("%.2f"):format(o.slowest_part), ("times the mean rank's work a step; rank %.0f last"):format(o.slowest_rank))
  end
  if o.equal then row("check", "equal", "to one motion, in each step") end
  line("state hash %s", o.hash)
  return report.told
end
