-- SPDX-License-Identifier: MIT
-- `duet accuracy` tells this of a still scene, of the object that --json prints.
local report = ...
local line, things, count = report.line, report.things, report.count

local function distance(n, value) return n == 0 and "-" or ("%.2g"):format(value) end

local function step_ms(row) return row.step_ms end

local function tell_row(add, row, slowest)
  add(row.front and "*" or " ", row.level, ("%.3f"):format(row.step_ms),
    ("%.2f%s"):format(row.relative, row.same and " ~" or "  "), report.bar(row.step_ms / slowest, 20),
    count(row.missed), count(row["false"]), distance(row.missed, row.deepest_missed),
    distance(row["false"], row.widest_false), ("%.2g %%"):format(100 * row.undecided_share))
end

local function tell_device(o, letter)
  local rows = {}
  for _, row in ipairs(o.levels) do
    if row.device == letter then rows[#rows + 1] = row end
  end
  line("\n%s", report.device_alone(o, letter))
  local add = report.columns("llrrlrrrrr", " ", "level", "ms a step", "/ sat15", " ", "missed", "false", "deepest",
    "widest", "undecided")
  for _, row in ipairs(rows) do tell_row(add, row, report.greatest(rows, step_ms)) end
end

return function(o)
  line("%s: %s, %s; median of %.0f steps", o.scene, things(o.objects, "object", "objects"),
    things(o.pairs, "pair collides", "pairs collide"), o.rounds)
  if o.a ~= o.b then tell_device(o, "A") end
  tell_device(o, "B")
  line("\n* nothing is both faster and more right. ~ the difference from sat15 is noise in these rounds.")
  if o.rounds < 6 then -- the least for an interval of 95 %
    line("Fewer than 6 rounds tell no difference from noise: give --repeat.")
  end
  if report.disturbed(o) then line("%s", report.disturbed(o)) end
  line("missed: pairs that collide; false: that do not.\n"
    .. "deepest: overlap of the worst missed; widest: separation of the worst false one, in the scene's unit.")
  return report.told
end
