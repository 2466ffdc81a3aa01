-- SPDX-License-Identifier: MIT
-- `duet-cluster` tells this, of the object that --json prints; efficiency is there in a forecast alone.
local report = ...
local line, count = report.line, report.count

local function tell_ranks(ranks)
  local row = report.columns("rllrrrrr", "rank", "host", "devices", "objects", "ghosts", "pairs", "busy ms", "wait ms")
  for _, r in ipairs(ranks) do
    row(("%.0f"):format(r.rank), r.host, r.pair, count(r.objects), count(r.ghosts), count(r.pairs),
      ("%.3f"):format(r.busy_ms), ("%.3f"):format(r.wait_ms))
  end
end

return function(o)
  line("%s\n%s\n", report.scene_words(o), report.things(#o.ranks, "rank", "ranks"))
  tell_ranks(o.ranks)
  line("")
  local row = report.columns("lrl")
  if o.pairs then row("pairs", count(o.pairs), ("collide, at level %s; hash %s"):format(o.level, o.hash)) end
  row(o.platform and "simulated time" or "time", ("%.3f ms"):format(o.total_ms),
    ("median of %.0f, %.3f to %.3f; %s boxes a second"):format(o["repeat"], o.least_ms, o.most_ms,
      report.rate(o.total_ms > 0 and o.objects / o.total_ms * 1e3 or 0)))
  if o.efficiency then
    row("efficiency", ("%.3f"):format(o.efficiency), "what devices take for their own objects, by that")
  end
  for _, e in ipairs(o.exchanges or {}) do
    row(e.colours_between == o.colours_between and "exchanges" or "", ("%.3f"):format(e.efficiency),
      ("with one after %s"):format(report.things(e.colours_between, "colour", "colours")))
  end
  if o.check then report.tell_check(o.check) end
  return report.told
end
