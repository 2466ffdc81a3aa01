-- SPDX-License-Identifier: MIT
-- `duet accuracy` tells this of a moving scene, of the object that --json prints.
local report = ...
local line = report.line

-- By powers of ten: a character at the least error.
local function digits_part(error, least, most)
  return error > 0 and (math.log(error / least, 10) + 0.2) / (math.log(most / least, 10) + 0.2) or 0
end

local function least_and_most(rows)
  local least, most = math.huge, 0
  for _, row in ipairs(rows) do
    if row.finite and row.error > 0 then least, most = math.min(least, row.error), math.max(most, row.error) end
  end
  return least, most
end

local function tell_row(add, o, row, slowest, least, most)
  add(row.front and "*" or " ", ("1/%.4g"):format(1 / row.dt), ("%.0f%s"):format(row.substeps, row.own and " <" or "  "),
    row.integrator, ("%.1f"):format(row.ms_a_second), row.noise_ms and ("±%.1f"):format(row.noise_ms) or "?",
    report.bar(row.ms_a_second / slowest, 16))
  if not row.finite then return add("lost", report.bar(1, 16), "-", "-", "-") end
  add(("%.2g"):format(row.error), report.bar(digits_part(row.error, least, most), 16),
    ("%+.2g %%"):format(100 * row.energy), ("%.2g %%"):format(100 * row.gain),
    o.contact and ("%.2g"):format(row.depth) or "-")
end

return function(o)
  local reference, least, most = o.reference, least_and_most(o.timesteps)
  local slowest = report.greatest(o.timesteps, function(row) return row.ms_a_second end)
  line("%s: %s, %.3g s of the scene, on %s", o.scene, report.things(o.objects, "object", "objects"), o.time, o.b)
  line("reference: dt 1/%.4g, substeps %.0f, %s: %.1f ms a second, gain %.2g %%\n", 1 / reference.dt,
    reference.substeps, reference.integrator, reference.ms_a_second, 100 * reference.gain)
  local add = report.columns("lrrlrrlrlrrr", " ", "dt", "substeps", "", "ms a second", "noise", "", "error", "", "energy",
    "gain", "deepest")
  for _, row in ipairs(o.timesteps) do tell_row(add, o, row, slowest, least, most) end
  if #o.timesteps < o.asked then
    line("\n%.0f dearer ones were not begun: the limit, or Ctrl-C, came before.", o.asked - #o.timesteps)
  end
  line("\n* nothing that is as fast, but for noise, is nearer to the reference; < the scene's own.\n"
    .. "noise: two times that differ by less than both of theirs may be the same; ? where a run\n"
    .. "had too few steps to know it: a longer --time has more.\n"
    .. "error: root mean square distance of the centres from the reference's, by powers of ten;\n"
    .. "energy: less the reference's at the end, gain: greatest rise on the way, both in the greatest\n"
    .. "kinetic energy; deepest: overlap of the worst contact, in the scene's unit.")
  return report.told
end
