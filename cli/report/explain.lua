-- SPDX-License-Identifier: MIT
-- `duet explain` tells this of a scene, of the object that --json prints.
local report = ...
local line = report.line

local function tell_substeps(s)
  local words = "chosen: nothing stands on another body at the start"
  if not s.chosen then
    words = "as the scene says"
  elseif s.layers >= 2 then
    words = ("chosen: they hold the column of %.0f bodies with an edge of %.3g that stands at the start"):format(s.layers,
      s.edge)
  end
  line("\n%s a step, %s", report.things(s.n, "substep", "substeps"), words)
end

local function tell_effects(o)
  local measured = o.steps > 0
  local row = report.columns(measured and "lllrlr" or "lllrl", "effect", "", "called for by", "bytes each", "kernels",
    measured and "ms a step" or nil)
  for _, e in ipairs(o.effects) do
    row(e.effect, e.active and "yes" or "-", e.called_by, ("%.0f"):format(e.bytes), e.active and e.kernels or "-",
      e.ms and ("%.3f"):format(e.ms) or measured and "-" or nil)
  end
  tell_substeps(o.substeps)
  if measured then
    line("\n%.3f ms a step with all of them, in steps 3 to %.0f of the scene", o.step_ms, o.steps + 2)
  end
  if report.disturbed(o) then line("%s", report.disturbed(o)) end
end

local function tell_search(o, s, i)
  line("%s%s%s, kernels '%s'\n", i > 1 and "\n" or "", o.a == o.b and "" or s.device .. "  ", o[s.device:lower()],
    s.variant)
  local row = report.columns("lll", "scene", "parameter", "what of it is in the kernels")
  for _, f in ipairs(s.facts) do row(f.name, ("%s=%.0f"):format(f.parameter, f.value), f.means) end
  line("")
  row = report.columns("lll")
  for _, k in ipairs(s.kernels) do row(k.runs and "runs" or "left out", k.why, k.name) end -- last: it is long
end

return function(o)
  if not o.search then tell_effects(o) end
  for i, s in ipairs(o.search or {}) do tell_search(o, s, i) end
  return report.told
end
