-- SPDX-License-Identifier: MIT
-- `duet profiles show` tells this of a profile, of the object that --json prints.
local report = ...
local number = report.number

local function result_words(p)
  if p.one_device then return ("%s, level %s"):format(p.variant_b, p.level) end
  return ("share %.5f (%.0f of 65536), mode %s, A %s, B %s, level %s"):format(p.share, p.share * 65536, p.mode,
    p.variant_a, p.variant_b, p.level)
end

local function tell_result(row, p)
  row("plan", result_words(p), "step", ("%.4f ms (%.4f to %.4f)"):format(p.ms, number(p, "low_ms"), number(p, "high_ms")))
  if not p.one_device then row("gain", report.gain(p)) end
  if p.rounds > 0 then row("rounds", ("%.0f"):format(p.rounds)) end
  row("quiet", p.watched == 0 and "was not looked at" or report.waited(p))
  if p.whole_ms then row("whole", ("%.4f ms; %s"):format(p.whole_ms, report.whole(p.a.name, nil, p))) end
  row("accuracy", p.true_pairs and report.wrong_words(p) or "was not measured")
  if p.terms then row("terms", report.members(p.terms)) end
  row("kernels", p.kernels)
end

local function tell_session(row, p)
  local s = p.session
  if not s then return row("session", "none: put in by hand") end
  row("session", ("%s, %s, duet %s on %s machine, load %.2f, clock of %.0f ns"):format(s.id, s.state, s.tool_version,
    p.here and "this" or "another", number(s, "load"), number(s, "timer_ns")))
  row("search", ("%s, seed %.0f, %d trials, %.0f launches, resumed %.0f times"):format(s.strategy, s.seed, #p.trials,
    s.launches, s.resumed))
  row("options", report.members(report.list(s, "options")), "when", ("%s to %s UTC"):format(s.started, s.ended ~= "" and s.ended or "-"))
end

return function(p)
  local row = report.columns("ll", "profile", p.uid .. (p.live and "" or ", dead: " .. p.dead_reason))
  row(p.one_device and "device" or "A", report.device_words(p.a))
  if not p.one_device then row("B", report.device_words(p.b)) end
  local things = p.query and report.things(p.items, "item", "items") or report.things(p.objects, "object", "objects")
  row("workload", ("%s, %s: %s"):format(p.scene ~= "" and p.scene or "-", things, p.family))
  if p.objective ~= "time" then row("tuned", "for " .. p.objective) end
  tell_result(row, p)
  tell_session(row, p)
  return report.told
end
