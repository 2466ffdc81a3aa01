-- SPDX-License-Identifier: MIT
-- The rows of `duet accuracy --csv`, with the names of their columns.
local report = ...

local columns <const> = {
  levels = { "device", "level", "step_ms", "relative", "same", "pairs", "missed", "false", "deepest_missed",
    "widest_false", "undecided_share", "front" },
  timesteps = { "dt", "substeps", "integrator", "own", "ms_a_second", "noise_ms", "error", "energy", "gain", "depth",
    "finite", "front" },
}

local flags <const> = { own = true, same = true, finite = true, front = true }

-- Noise that is not known has no bound, and what is lost is no number.
local function cell(o, row, name)
  local value = row[name]
  if name == "device" then return o[value:lower()] end
  if flags[name] then return value and "1" or "0" end
  if not value then return value == nil and "inf" or "nan" end
  return type(value) == "number" and (value % 1 == 0 and "%.0f" or "%.9g"):format(value) or value
end

return function(o)
  local kind = o.levels and "levels" or "timesteps"
  local lines = { table.concat(columns[kind], ",") }
  for _, row in ipairs(o[kind]) do
    local cells = {}
    for i, name in ipairs(columns[kind]) do cells[i] = cell(o, row, name) end
    lines[#lines + 1] = table.concat(cells, ",")
  end
  return table.concat(lines, "\n") .. "\n"
end
