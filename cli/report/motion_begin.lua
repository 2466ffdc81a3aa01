-- SPDX-License-Identifier: MIT
-- `duet run --steps` tells this before the first step: the scene, its effects, the devices, where the plan is from, and
-- `tuning`, the command that measures one.
local report = ...
local line, things = report.line, report.things

local function source_words(o)
  if o.profile == "given" then return "as given" end
  if o.profile == "stale" then return "the default, since the kernels changed after it was measured" end
  if o.profile == "default" then return "the default" end
  return ("from the profile, %s: %s"):format(o.profile,
    o.step_ms > 0 and ("%.3f ms a step"):format(o.step_ms) or "that of another number of bodies")
end

return function(o)
  line("%s: %s, %.0fD; effects: %s", o.scene, things(o.objects, "box", "boxes"), o.dims,
    #o.effects > 0 and table.concat(o.effects, " ") or "none")
  line("%s of %.6g s", things(o.substeps, "substep", "substeps"), o.dt / o.substeps)
  report.tell_devices(o)
  report.tell_grids(o)
  -- A step without pairs, or whose pairs B finds, leaves A idle. Bodies that nothing happens to have no profile.
  local measured = (o.profile ~= "default" and o.profile ~= "stale") or #o.effects == 0
  line("plan: %s%s%s", source_words(o), o.share == 0 and o.a ~= o.b and "; A has nothing to do" or "",
    measured and "" or "; to measure a better one:")
  if not measured then report.command(o.tuning) end
  line("")
  return report.told
end
