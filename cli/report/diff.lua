-- SPDX-License-Identifier: MIT
-- `duet profiles diff` tells this of two profiles, of the object that --json prints.
local report = ...
local line, number = report.line, report.number

local fields <const> = { "uid", "live", "dead_reason", "scene", "objects", "a", "b", "level", "objective", "share", "mode",
  "variant_a", "variant_b", "ms", "low_ms", "high_ms", "gain", "gain_low", "gain_high", "verdict", "rounds", "single_ms",
  "whole_ms", "whole_gain", "missed_rate", "false_rate", "origin", "strategy", "options", "kernels", "created" }

local function shown(value)
  if type(value) == "number" then return ("%.6g"):format(value) end
  return type(value) == "string" and value or "-"
end

local function cell(p, name)
  if name == "a" or name == "b" then return report.device_words(p[name]) .. ", " .. p[name].platform_version end
  if name == "options" then return p.options and report.members(p.options) or "-" end
  if name == "live" then return p.live and "true" or "false" end
  return shown(p[name])
end

local function tell_fields(one, other)
  local row = report.columns("lllr")
  for _, name in ipairs(fields) do
    if one[name] ~= nil or other[name] ~= nil then
      local a, b = cell(one, name), cell(other, name)
      local differ = a ~= b or type(one[name]) == "number" and one[name] ~= other[name]
      row(name, a, b, differ and "*" or "")
    end
  end
end

return function(o)
  local one, other = o.first, o.second
  tell_fields(one, other)
  if one.family ~= other.family or one.objects ~= other.objects then
    line("\nTheir workloads differ, so their times say nothing of each other.")
    return report.told
  end
  local slow, quick = other, one
  if one.ms > other.ms then slow, quick = one, other end
  line("\nA step of %s takes %.1f %% longer than one of %s%s.", report.cut(slow.uid, 8), 100 * (slow.ms / quick.ms - 1),
    report.cut(quick.uid, 8), number(slow, "low_ms") > number(quick, "high_ms") and ""
    or ", which is within the intervals of both")
  return report.told
end
