-- SPDX-License-Identifier: MIT
-- `duet profiles show` tells this of a profile's trials, their kernels, and the plans that no other beats.
local report = ...
local line, columns = report.line, report.columns

local function ms(value) return value and ("%.3f"):format(value) or "-" end

-- Kernels are told once each, and numbered in the order in which they are met.
local function numbering()
  local names, numbers = {}, {}
  return names, function(name)
    if not numbers[name] then
      names[#names + 1] = name
      numbers[name] = tostring(#names)
    end
    return numbers[name]
  end
end

local function tell_front(front)
  line("\nplans that no other beats in both time and energy:")
  local row = columns("rrrll", "ms", "J", "share", "A's kernels", "B's kernels")
  for _, p in ipairs(front) do
    row(("%.4f"):format(p.ms), ("%.6g"):format(p.joules), ("%.4f"):format(p.share), p.variant_a, p.variant_b)
  end
end

return function(p)
  local names, number_of = numbering()
  line("")
  local row = columns("rrlrrrrrrrrl", "trial", "share", "mode", "A", "B", "runs", "ms", "low", "high", "A ms", "B ms",
    "outcome")
  for _, t in ipairs(p.trials) do
    row(("%.0f"):format(t.number), ("%.4f"):format(t.share), t.mode, number_of(t.variant_a), number_of(t.variant_b),
      ("%.0f"):format(t.samples), ms(t.ms), ms(t.low_ms), ms(t.high_ms), ms(t.a_ms), ms(t.b_ms),
      t.outcome .. (t.reason and ": " .. t.reason or ""))
  end
  line("")
  local kernel = columns("rl", "A, B", "kernels")
  for i, name in ipairs(names) do kernel(tostring(i), name) end
  if p.pareto then tell_front(p.pareto) end
  return report.told
end
