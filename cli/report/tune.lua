-- SPDX-License-Identifier: MIT
-- `duet tune` tells this at its end, of the object that --json prints.
local report = ...
local text, number, list, cut, count = report.text, report.number, report.list, report.cut, report.count
local line, wrapped, columns, command = report.line, report.wrapped, report.columns, report.command

-- A tuning that gave up has no time.
local function gave_up(row) return number(row, "step_ms") == 0 end

local function is_shared(row) return not gave_up(row) and row.share > 0 and row.share < 1 end

local function step_ms(row) return gave_up(row) and "-" or ("%.3f"):format(row.step_ms) end

local function signed(part) return ("%+.1f"):format(100 * part) end

local function tell_shares(rows)
  local row = columns("llrrrrlr", "workload", "plan", "ms", "gain %", "from", "to", "verdict", "seconds")
  for _, one in ipairs(rows) do
    row(cut(one.workload, 22), gave_up(one) and "the default" or report.plan_words(one.share), step_ms(one))
    if is_shared(one) then
      row(signed(one.gain), signed(one.gain_low), signed(one.gain_high), one.verdict)
    else
      row("-", "", "", gave_up(one) and one.verdict or "-")
    end
    row(("%.1f"):format(one.seconds))
  end
  line("plan: A's part of the work; B does the rest. ms: a step by this plan.\n"
    .. "gain: by how much it is faster than the better device alone; it lies between\n"
    .. "'from' and 'to' with 99 %% confidence.")
end

-- One device has no share, and nothing to gain over: its kernels were chosen.
local function tell_choices(rows)
  local row = columns("llrr", "workload", "kernels", "ms", "seconds")
  for _, one in ipairs(rows) do
    row(cut(one.workload, 22), cut(one.variant_b, 40), step_ms(one), ("%.1f"):format(one.seconds))
  end
  line("kernels: the usual ones of the device, or others that are faster with 99 %% confidence.\nms: a step with them.")
end

-- Why a plan is not loaded, and what would change that.
local function tell_use(row)
  if row.unused == "" then return end
  wrapped("  not used by applications: %s", row.unused)
  if gave_up(row) then
    wrapped("  the same command goes on from here; --wait SECONDS waits longer, --wait 0 measures beside them")
  elseif row.verdict == "ambiguous" then
    line("  the same command tunes again; a larger --budget allows more rounds")
  else
    line("  to make them use it:")
    command(row.use_command)
  end
end

local function tell_search(k)
  line("  kernels of %s: %.0f of %.0f sets of parameters tried in %.0f launches:", k.device, k.tried, k.configs,
    k.launches)
  if k.verdict == "faster" then
    line("    %.1f %% faster (%.1f to %.1f) by '%s'", 100 * k.gain, 100 * k.gain_low, 100 * k.gain_high, k.variant)
  else
    line("    %s; '%s' stays", k.verdict == "ambiguous" and "none was surely faster" or "no faster set was found",
      k.variant)
  end
end

local function subject(row)
  local items = row.items and count(row.items)
  return row.query and items .. " " .. row.query or row.task and items .. " items of kernel " .. row.task
    or row.steps and ("runs of %.0f steps"):format(row.steps) or "level " .. row.level
end

-- A store keeps no energy of a device alone.
local function tell_energy(row)
  local alone = row.single_joules > 0 and (", %.6g J by the better device alone"):format(row.single_joules) or ""
  line("  energy: %.6g J a launch%s; the gain is of energy", row.joules, alone)
end

local function tell_plan(row)
  if text(row, "command") ~= "" then command(row.command) end
  if not is_shared(row) and not row.one_device then line("  %s", report.gain(row)) end
  if number(row, "whole_ms") > 0 then line("  %s", report.whole(row.whole, row.whole, row)) end
  if not row.query and row.level ~= "certified" then line("  %s", report.wrong_words(row)) end
end

local function tell_searches(row)
  if row.known then line("  known: the same was measured before; --fresh measures it again") end
  for _, k in ipairs(list(row, "kernels")) do tell_search(k) end
  if row.joules then tell_energy(row) end
  if row.plans then line("  kernels and share together: %.0f of %.0f plans tried", row.plans_tried, row.plans) end
end

-- Tells figures that the table has no column for.
local function tell_details(row)
  line("\n%s, %s, %.0f launches", row.workload, subject(row), row.launches)
  if row.disturbed >= 0.005 * math.max(row.watched, 1) then
    line("  %.0f %% of the launches waited for a core", 100 * row.disturbed / row.watched)
  end
  if not gave_up(row) then tell_plan(row) end
  tell_use(row)
  if not gave_up(row) then tell_searches(row) end
end

return function(o)
  if #o.workloads == 0 then return report.told end
  (o.workloads[1].one_device and tell_choices or tell_shares)(o.workloads)
  for _, row in ipairs(o.workloads) do tell_details(row) end
  return report.told
end
