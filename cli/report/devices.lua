-- SPDX-License-Identifier: MIT
-- `duet devices` tells this, of the object that --json prints.
local report = ...
local line, bytes = report.line, report.bytes

local function tell_device(d)
  line("%s  %s", d.selector, d.name)
  local row = report.columns("lll", " ", "platform", d.platform, " ", "", d.platform_version, " ", "driver", d.driver,
    " ", "version", d.cl_version)
  row(" ", "kind", ("%s, %.0f units at %.0f MHz, %sdouble precision"):format(d.kind, d.units, d.clock_mhz,
    d.fp64 and "" or "no "))
  row(" ", "memory", ("%s%s, a buffer at most %s, local %s"):format(bytes(d.global_bytes),
    d.host_memory and " of the host" or "", bytes(d.max_buffer_bytes), bytes(d.local_bytes)))
  row(" ", "group", ("at most %.0f work-items"):format(d.max_group))
  row(" ", "parts", d.can_cut and ("%s[first-last], units 0 to %.0f"):format(d.selector, d.units - 1)
    or "none, it cannot be cut")
  for i, quirk in ipairs(d.quirks) do row(" ", i == 1 and "quirks" or "", quirk) end
  line("")
end

return function(o)
  for _, d in ipairs(o.devices) do tell_device(d) end
  for _, why in ipairs(o.absent) do line("%s\n", why) end
  local a, b = o.default_pair, nil
  local comma = a:find(",", 1, true)
  a, b = a:sub(1, comma - 1), a:sub(comma + 1)
  line("without --pair: %s", a == b and a or a .. "," .. b)
  return report.told
end
