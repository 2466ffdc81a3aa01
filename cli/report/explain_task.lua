-- SPDX-License-Identifier: MIT
-- `duet explain --task` tells this, of the object that --json prints.
local report = ...
local line = report.line

local function tell_argument(row, arg)
  if not arg.type then return row(arg.name, "number", "", "", ("%.9g"):format(arg.value)) end
  row(arg.name, arg.type, ("%.0f"):format(arg.elements), arg.an_item > 0 and ("%.0f"):format(arg.an_item) or "all",
    arg.access .. (arg.halo > 0 and (", halo %.0f"):format(arg.halo) or "") .. (arg.once and ", sent once" or ""))
end

-- The values of a parameter, the default in brackets: "1 [16] 64".
local function values_of(parameter)
  local words = {}
  for i, value in ipairs(parameter.values) do
    words[i] = (value == parameter.default and "[%.0f]" or "%.0f"):format(value)
  end
  return table.concat(words, " ")
end

local function tell_kernel(o, k)
  local free = #k.parameters > 0 and ("%.0f valid sets of parameters"):format(k.configs)
    or "which leaves nothing to be chosen"
  line("\n%s  %s: kernel %s, %s", k.device, k.selector, o.kernel, free)
  for _, p in ipairs(k.parameters) do line("  %s  %s", p.name, values_of(p)) end
end

return function(o)
  line("%s: %s items of kernel %s\n", o.task, report.count(o.items), o.kernel)
  local row = report.columns("llrrl", "argument", "type", "elements", "an item", "access")
  for _, arg in ipairs(o.arguments) do tell_argument(row, arg) end
  for _, k in ipairs(o.kernels) do tell_kernel(o, k) end
  local own = o.reference == o.kernel
  line("\nright: as %s%s, %s%s", o.reference ~= "" and "kernel " .. o.reference or "the file's reference",
    own and " itself on B alone" or "", o.tolerance > 0 and ("within %g"):format(o.tolerance) or "exactly",
    own and ": only sharing is checked" or "")
  line("in the store: %s; n %.0f", o.key, o.n)
  return report.told
end
