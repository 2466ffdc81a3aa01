-- SPDX-License-Identifier: MIT
-- `duet profiles list` tells this: the profiles by device pair, those in use first.
local report = ...
local line, cut, count = report.line, report.cut, report.count

local function signed(part) return ("%+.1f"):format(100 * part) end

-- Certified is exact and the default, and is not mentioned.
local function workload(p)
  return report.workload_words(p) .. ((p.query or p.level == "certified") and "" or ", " .. p.level)
end

local function tell_profile(row, p)
  local shared = p.share > 0 and p.share < 1
  row(cut(p.uid, 8), workload(p), p.one_device and not shared and "one device" or report.plan_words(p.share),
    ("%.3f"):format(p.ms), shared and signed(p.gain) or "-", shared and p.verdict or "-", cut(p.created, 10),
    p.dead_reason or p.here and "here" or "elsewhere")
end

-- Below the table, because few rows have it.
local function tell_notes(notes)
  for _, note in ipairs(notes) do line("%s: %s", cut(note.uid, 8), note.says) end
end

local function add_notes(notes, p)
  local function add(says) notes[#notes + 1] = { uid = p.uid, says = says } end
  if p.objective ~= "time" then add("tuned for " .. p.objective) end
  if p.disturbed > 0 then add(report.waited(p)) end
  if p.whole_ms and p.whole_gain_high < 0 then add(report.whole(p.a.name, nil, p)) end
end

local function tell_pair(p)
  line("%s%s", p.one_device and "" or "A: ", report.device_words(p.a))
  if not p.one_device then line("B: %s", report.device_words(p.b)) end
  return report.columns("lllrrlll", "profile", "workload", "plan", "ms", "gain %", "verdict", "when", "where")
end

local function tell_none(o)
  if o.dead == 0 then return line("%s: no profiles yet; duet tune makes them", o.store) end
  line("%s: no profile is in use; --dead shows the %s that %s not", o.store, count(o.dead), o.dead == 1 and "is" or "are")
end

return function(o)
  local row, last, notes = nil, nil, {}
  if #o.profiles == 0 then tell_none(o) end
  for _, p in ipairs(o.profiles) do
    if not last or p.pair_id ~= last.pair_id or p.live ~= last.live then
      tell_notes(notes)
      notes = {}
      if last then line("") end
      if not p.live and (not last or last.live) then line("not used:") end
      row = tell_pair(p)
    end
    tell_profile(row, p)
    add_notes(notes, p)
    last = p
  end
  tell_notes(notes)
  if last then line("plan: A's part of the work; B does the rest. gain: over the better device alone.") end
  return report.told
end
