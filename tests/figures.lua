-- SPDX-License-Identifier: MIT
-- Runs the commands that the documents' tables come from and compares what is
-- not a time, to as many digits as are printed:
--
--   duet lua --trust figures.lua PROGRAM DOCS SCENES FOLDER

local program, docs, scenes, folder = table.unpack(arg, 1, 4)

-- "997 484", "+40 %", "2.8e-6": the number, and half of what its last digit is worth.
local function printed(cell)
  local text = cell:gsub("%s*%%$", ""):gsub("(%d) %f[%d]", "%1"):gsub("^%+", "")
  local value = tonumber(text)
  if not value then return nil end
  local digits, power = text:match("^%-?([%d%.]+)e?(.*)$")
  local decimals = #(digits:match("%.(%d+)$") or "")
  return value, 0.5001 * 10.0 ^ ((tonumber(power) or 0) - decimals)
end

-- The cells of a document's rows, from the line of the table's heads on.
local function table_of(name, head)
  local rows, inside = {}, false
  for line in assert(io.lines(docs .. "/" .. name)) do
    if line:find(head, 1, true) == 1 then
      inside = true
    elseif inside and line:sub(1, 1) ~= "|" then
      break
    elseif inside and not line:find("|---", 1, true) then
      local row = {}
      for cell in line:gmatch("|%s*([^|]-)%s*%f[|]") do row[#row + 1] = cell end
      rows[#rows + 1] = row
    end
  end
  assert(#rows > 0, name .. " has no table '" .. head .. "'")
  return rows
end

-- Gives what `duet accuracy` finds, as rows by the names of their columns.
local function accuracy(arguments)
  local csv = folder .. "/figures.csv"
  assert(os.execute(("'%s' accuracy %s --csv '%s' >'%s/figures.out'"):format(program, arguments, csv, folder)))
  local rows, names = {}, nil
  for line in assert(io.lines(csv)) do
    local row, cells = {}, {}
    for cell in line:gmatch("[^,]+") do cells[#cells + 1] = cell end
    for i, name in ipairs(names or {}) do row[name] = tonumber(cells[i]) or cells[i] end
    if names then rows[#rows + 1] = row end
    names = names or cells
  end
  return rows
end

local failed, compared = 0, 0
local function compare(where, cell, value)
  local is, tolerance = printed(cell)
  compared = compared + 1
  if not is or math.abs(is - value) > tolerance then
    failed = failed + 1
    io.stderr:write(("%s: '%s' is printed, and it is %.6g\n"):format(where, cell, value))
  end
end

local function find(rows, wanted)
  for _, row in ipairs(rows) do
    local same = true
    for name, value in pairs(wanted) do
      same = same and (row[name] == value or type(value) == "number" and math.abs(row[name] / value - 1) < 1e-6)
    end
    if same then return row end
  end
  error("the command gives no such row: " .. next(wanted))
end

-- Levels: | level | ms | against sat15 | missed | false | widest false separation | undecided |
local function check_levels()
  local found = accuracy(("'%s/paper.lua' -n 1000000 --repeat 1"):format(scenes))
  for _, row in ipairs(table_of("accuracy.md", "| level | ms a step |")) do
    local name = row[1]:match("`(.*)`")
    local level = find(found, { level = name })
    compare(name .. ", missed", row[4], level.missed)
    compare(name .. ", false", row[5], level["false"])
    if level["false"] > 0 then compare(name .. ", widest", row[6], level.widest_false) end
    if level.undecided_share > 0 then compare(name .. ", undecided", row[7], 100 * level.undecided_share) end
  end
  local file <close> = assert(io.open(docs .. "/accuracy.md"))
  local pairs_said, candidates = file:read("a"):match("cubes, ([%d ]+) of ([%d ]+) candidates collide")
  compare("pairs", pairs_said, find(found, { level = "certified" }).pairs)
  compare("candidates", candidates, find(found, { level = "aabb" }).pairs)
end

-- Time steps: | dt | substeps | ms a second | error | energy | gain | deepest | |
local function check_timesteps()
  local found = accuracy(("'%s/falling.lua' -n 500 --limit 3600"):format(scenes))
  for _, row in ipairs(table_of("accuracy.md", "| dt | substeps |")) do
    local rate = tonumber(row[1]:match("^1/(%d+)"))
    if rate then
      local row_found = find(found, { dt = tonumber(("%.9g"):format(1 / rate)), substeps = tonumber(row[2]) })
      local where = row[1] .. " by " .. row[2]
      compare(where .. ", error", row[4], row_found.error)
      compare(where .. ", energy", row[5], 100 * row_found.energy)
      compare(where .. ", gain", row[6], 100 * row_found.gain)
      compare(where .. ", deepest", row[7], row_found.depth)
    end
  end
end

-- Orbits: what yoshida gets at 1/30, and that verlet gets no nearer.
local function check_orbits()
  local found = accuracy(("'%s/orbit2d.lua' -n 500 --limit 3600"):format(scenes))
  local file <close> = assert(io.open(docs .. "/accuracy.md"))
  local said = file:read("a"):gsub("%s+", " "):match("by `yoshida` comes within ([%d%.e%-]+) of the reference")
  compare("yoshida at 1/30", said, find(found, { integrator = "yoshida", dt = tonumber(("%.9g"):format(1 / 30)) }).error)
end

check_levels()
check_timesteps()
check_orbits()
print(compared .. " figures, " .. failed .. " wrong")
if failed > 0 then os.exit(1) end
