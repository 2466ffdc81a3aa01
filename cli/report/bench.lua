-- SPDX-License-Identifier: MIT
-- `duet bench` tells this: the cases of a scene, or at the end the verdicts against earlier results.
--
--   results, before   as --output has them; before is nil if nothing is compared
--   scene             nil: the verdicts
--   confidence        of all intervals
local report = ...
local text, number, list, line = report.text, report.number, report.list, report.line

local function times(row, one, ...)
  for i, name in ipairs { ... } do
    row(one.failed and (i == 1 and "failed" or "-") or ("%.3f"):format(number(one, name)))
  end
end

local function tell_comparison(row, one)
  if text(one, "verdict") == "" then return row("-", "-", "-", "-", "new") end
  for _, name in ipairs { "against_ms", "ratio", "ratio_low", "ratio_high" } do row(("%.3f"):format(number(one, name))) end
  row(one.verdict)
end

local function tell_case(row, one, shared, compared)
  if shared then row(("%.2f"):format(one.share), one.mode) end
  row(one.variant_a .. (one.variant_a == one.variant_b and "" or " | " .. one.variant_b))
  times(row, one, "median_ms", "low_ms", "high_ms")
  if shared then times(row, one, "a_ms", "b_ms") end
  if compared then tell_comparison(row, one) end
end

-- shared: by two devices, so that there is a share and a time of each.
local function tell_scene(o)
  local devices, row = o.results.devices, nil
  local shared = not report.is_one_device(devices[1], devices[2])
  for _, one in ipairs(o.results.cases) do
    if one.scene == o.scene then
      if not row then
        if number(one, "dims") == 0 then
          line("task %s, %s", one.scene, report.things(one.objects, "item", "items"))
        else
          line("%s, %s, %.0fD", one.scene, report.things(one.objects, "object", "objects"), number(one, "dims"))
        end
        row = report.columns((shared and "rl" or "") .. "lrrr" .. (shared and "rr" or "") .. (o.before and "rrrrl" or ""))
        if shared then row("share", "mode") end
        row("kernels", "ms", "from", "to")
        if shared then row("A ms", "B ms") end
        if o.before then row("before", "before/now", "from", "to", "") end
      end
      tell_case(row, one, shared, o.before)
    end
  end
end

local function mean_load(results)
  local sum, n = 0, 0
  for _, one in ipairs(list(results, "cases")) do
    sum = sum + number(one, "cpu_load")
    n = n + (text(one, "failed") == "" and 1 or 0)
  end
  return n > 0 and 100 * sum / n or 0
end

local function tell_verdicts(o)
  local counts = {}
  for _, verdict in ipairs { "faster", "same", "slower", "ambiguous" } do
    local n = 0
    for _, one in ipairs(o.results.cases) do n = n + (text(one, "verdict") == verdict and 1 or 0) end
    counts[#counts + 1] = ("%d %s"):format(n, verdict)
  end
  line("against %s: %s", text(o.before, "time"), table.concat(counts, ", "))
  line("before/now: 1.10 is 10 %% faster now than before; it lies between 'from' and 'to' with\n%.0f %% confidence",
    100 * o.confidence)
  line("other programs used %.0f %% of the cores, and before %.0f %%; a difference that they can explain is ambiguous",
    mean_load(o.results), mean_load(o.before))
end

return function(o)
  (o.scene and tell_scene or tell_verdicts)(o)
  return report.told
end
