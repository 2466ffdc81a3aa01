-- SPDX-License-Identifier: MIT
-- `duet scenes` tells this, of the object that --json prints.
local report = ...

return function(o)
  local row = report.columns("ll")
  for _, scene in ipairs(o.scenes) do row(scene.name, scene.about) end
  return report.told
end
