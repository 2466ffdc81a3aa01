-- SPDX-License-Identifier: MIT
-- `duet source --list` tells this, of the object that --json prints.
local report = ...
local line = report.line

-- "1 64 [128] 256", the default in brackets; "0 .. 31 [0]" for a range.
local function values_of(p)
  if p.min then return ("%.0f .. %.0f [%.0f]"):format(p.min, p.max, p.default) end
  local words = {}
  for i, v in ipairs(p.values) do words[i] = (v == p.default and "[%.0f]" or "%.0f"):format(v) end
  return table.concat(words, " ")
end

return function(o)
  for _, k in ipairs(o.kernels) do
    line("%s  %s", k.name, k.about)
    local row = report.columns("llll")
    for _, p in ipairs(k.params) do row(" ", p.name, values_of(p), p.about) end
    line("  %.0f valid config%s\n", k.configs, k.configs == 1 and "" or "s")
  end
  return report.told
end
