-- SPDX-License-Identifier: MIT
-- The options of a subcommand, as --help lists them.
local report = ...

return function(o)
  local row = report.columns("ll")
  for _, option in ipairs(o) do row(option.flags, option.help) end
  return report.told
end
