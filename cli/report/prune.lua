-- SPDX-License-Identifier: MIT
-- `duet profiles prune` tells this, of the object that --json prints.
local report = ...

return function(o)
  report.line("%s launches and %s profiles forgotten, the file is %s smaller", report.count(o.samples),
    report.count(o.profiles), report.bytes(math.max(0, o.bytes)))
  return report.told
end
