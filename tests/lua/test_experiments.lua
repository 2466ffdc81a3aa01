-- SPDX-License-Identifier: MIT
-- Each experiment runs on a tiny scene and leaves a table, CSV, JSON and
-- pictures; and the figures that do not depend on the machine are right.
local facts = require "facts"

local out = os.tmpname()
os.remove(out) -- the first experiment makes the folder

local lua = os.getenv "DUET_LUA" or "lua5.4"

-- The lines that the experiment prints.
local function run(name, options)
  local program <close> = assert(io.popen(("%s '%s/lua/experiments/%s.lua' --out %s %s 2>&1"):format(lua, facts.root, name, out, options)))
  local printed = program:read "a"
  local ok, _, code = program:close()
  assert(ok, ("%s: exit %s: %s"):format(name, code, printed))
  return printed
end

-- { { column = text, ... }, ... }; no cell of ours has a comma in it.
local function read_csv(name)
  local rows, columns = {}, nil
  for line in io.lines(out .. "/" .. name .. ".csv") do
    local cells = {}
    for cell in (line .. ","):gmatch "([^,]*)," do cells[#cells + 1] = cell end
    if columns then
      local row = {}
      for i, column in ipairs(columns) do row[column] = cells[i] end
      rows[#rows + 1] = row
    end
    columns = columns or cells
  end
  return rows
end

-- The rows, after all that an experiment leaves was found to have data.
local function check_files(name)
  local json = facts.read_file(out .. "/" .. name .. ".json")
  assert(json:find "^%[\n  {" and json:find "}\n%]\n$" and not json:find "[:,]%s*,", json)
  local svg = facts.read_file(out .. "/" .. name .. ".svg")
  assert(svg:find "^<%?xml" and svg:find "</svg>%s*$", name .. ".svg is no SVG")
  local png = facts.read_file(out .. "/" .. name .. ".png")
  assert(png:find "^\x89PNG" and #png > 5000, name .. ".png is no picture")
  return read_csv(name)
end

local function find_file(pattern)
  local list <close> = assert(io.popen("ls " .. out))
  for file in list:lines() do
    local name = file:match("^" .. pattern .. "$")
    if name then return name end
  end
  error("no file " .. pattern)
end

local function name_of(pattern) return find_file("(" .. pattern .. ")%.csv") end
local function name_of_svg(pattern) return find_file("(" .. pattern .. ".*%.svg)") end

local tiny <const> = "--sizes 500,1000 --world 20 --repeat 2"

facts.holds("the paper in one command leaves one page with all that the paper printed beside ours", function()
  run("paper", tiny)
  local page = facts.read_file(out .. "/index.html")
  for _, part in ipairs { "table2", "figure10_11", "figure12", "figure13_14", "figure15" } do
    assert(page:find('<h2 id="' .. part .. '">', 1, true), part)
  end
  assert(page:find('<td class="r">96.4</td>', 1, true), "the paper's 2 M row of table 2 is missing")
  assert(page:find("<td>about 18, the peak</td>", 1, true), "the paper's peak gain is missing")
  for name in page:gmatch '<img src="([^"]+)"' do
    assert(facts.read_file(out .. "/" .. name):find "</svg>%s*$", name)
  end
  local _, pictures = page:gsub("<img ", "")
  facts.equal(pictures, 1 + 4 + 2 * 5 + 1 + 1) -- table 2, time lines, searches with their paths, figures 13 to 15
end)

facts.holds("the time lines of a step have B alone and both, whose bars lie within the step", function()
  local rows = read_csv "figure10_11"
  facts.equal(#rows, 4)
  local bars = 0
  for _, row in ipairs(rows) do
    assert(row.figure == "11" or tonumber(row.share) == 0)
    local svg = facts.read_file(out .. "/" .. name_of_svg("figure" .. row.figure .. "%." .. row.kernels))
    for ms, from, to in svg:gmatch "<title>[%w ]+: ([%d.]+) ms, from ([%d.]+) to ([%d.]+)</title>" do
      bars = bars + 1
      assert(tonumber(to) - tonumber(from) >= tonumber(ms) - 0.002, "a stage took longer than from its begin to its end")
      assert(tonumber(from) >= 0 and tonumber(to) <= tonumber(row.ms) + 0.05, to)
    end
  end
  assert(bars >= 4 * 4, bars)
end)

facts.holds("table 2 adds up to 100 % in every row of ours", function()
  local rows = check_files "table2"
  facts.equal(#rows, 4 + 4)
  for i = 5, 8 do facts.equal(rows[i].kernels, "as printed") end
  for _, row in ipairs(table.move(rows, 1, 4, 1, {})) do
    local sum = 0
    for column, cell in pairs(row) do
      if column:find "%%$" then sum = sum + tonumber(cell) end
    end
    assert(math.abs(sum - 100) < 1e-4, sum)
    facts.equal(tonumber(row["other %"]), 0) -- every stage has its column
  end
end)

facts.holds("figures 13 and 14 have each device alone and the pair", function()
  local rows = check_files(name_of "figure13_14.*")
  facts.equal(#rows, 6)
  for i, row in ipairs(rows) do
    facts.equal(row.configuration, ({ "A alone", "B alone", "A and B" })[(i - 1) % 3 + 1])
    assert(tonumber(row.low) <= tonumber(row.ms) and tonumber(row.ms) <= tonumber(row.high))
  end
end)

facts.holds("figure 15 has a gain for each size at which both devices work", function()
  local rows = check_files "figure15"
  facts.equal(#rows, 2)
  for _, row in ipairs(rows) do
    local share = tonumber(row.share)
    facts.equal(row.plan, share == 0 and "B alone" or share == 1 and "A alone" or "A and B")
    for _, gain in ipairs { "gain over B %", "low", "high", "gain over the better %" } do
      facts.equal(row[gain] ~= "", row.plan == "A and B")
    end
  end
end)

facts.holds("figure 15 names the device that does it all, without a gain", function()
  local strategy = out .. "/alone.lua"
  local file <close> = assert(io.open(strategy, "w"))
  file:write "return function(history) if #history == 0 then return 1 end end"
  file:close()
  run("figure15", tiny .. " --strategy " .. strategy)
  for _, row in ipairs(read_csv "figure15") do
    facts.equal(row.plan, "A alone")
    facts.equal(row["gain over B %"] .. row["gain over the better %"], "")
  end
end)

facts.holds("the paper's search loses the best share of a tenfold slower device, and balance does not", function()
  check_files "figure12.times10"
  check_files "figure12.times5"
  local fig12, balance = table.unpack(read_csv "figure12.times10")
  facts.equal(fig12.share, "0.0625")
  assert(tonumber(fig12["off %"]) > 2.5)
  assert(tonumber(balance["off %"]) < 1)
  assert(tonumber(balance["tuning ms"]) < tonumber(fig12["tuning ms"]))
end)

facts.holds("cells of the cube's edge miss 4.5 % of the pairs, and Duet refuses them", function()
  local printed = run("cell_flaw", "--sizes 8000 --euler 1")
  assert(printed:find("CELL_TOO_SMALL: the cell edge 1 is below the extent", 1, true), printed)
  local rows = check_files "cell_flaw"
  local missed = tonumber(rows[1]["missed %"])
  assert(missed > 3.5 and missed < 5.5, missed)
  facts.equal(tonumber(rows[#rows]["candidates missed"]), 0) -- cells of the widest cube's edge
end)

facts.holds("the slow kernel and the fast one are shared alike", function()
  run("slow_kernel", tiny)
  facts.equal(#check_files "slow_kernel", 6)
end)

facts.holds("a heavy box rests on a light one where substeps are enough for their ratio", function()
  run("phase", "--seconds 1.4 --most 4 --finest 30")
  local rows = check_files "phase"
  facts.equal(#rows, 22) -- two dt's and eleven ratios
  for _, row in ipairs(rows) do
    facts.equal(row.holds, tonumber(row.substeps) > 0 and "yes" or "no")
    local ratio = tonumber(row["mass ratio"])
    if ratio == 1 then facts.equal(row.holds, "yes") end
    if ratio >= 30000 then facts.equal(row.holds, "no") end
  end
end)

facts.holds("a wrong option is refused with one line and exit 2", function()
  for options, says in pairs {
    ["--size 3"] = "there is no option '--size'",
    ["--sizes 1,x"] = "--sizes '1,x': give whole numbers",
    ["--sizes"] = "--sizes needs a value",
    ["--repeat 0"] = "--repeat '0': give a whole number from 1",
    ["--pair x"] = "no device 'x'",
    [tiny .. " --variant x"] = "variant 'x': expected",
    [tiny .. " --mode x"] = "mode is 'x'; expected one of",
    [tiny .. " --strategy x"] = "strategy 'x': there is none",
  } do
    facts.raises("exit 2: " .. says, run, "figure15", options)
  end
end)

facts.holds("without --out each run has a new folder, whose name it prints", function()
  os.execute("mkdir " .. out .. "/here")
  for i = 1, 2 do
    local program <close> = assert(io.popen(("cd '%s/here' && %s '%s/lua/experiments/cell_flaw.lua' --sizes 10"):format(out, lua, facts.root)))
    local printed = program:read "a"
    local folder = printed:match "%-> (%S+): cell_flaw.csv"
    facts.equal(folder, "results/cell_flaw-" .. i)
    facts.read_file(("%s/here/%s/cell_flaw.csv"):format(out, folder))
  end
  local list <close> = assert(io.popen("ls " .. out .. "/here"))
  facts.equal(list:read "a", "results\n")
end)

-- A's time rises with the share and B's falls, by random steps between 32 shares.
local function random_times()
  local rows, a, b = 33, { 0 }, { [33] = 0 }
  for i = 2, rows do a[i] = a[i - 1] + 1e-3 + math.exp(4 * math.random()) * math.random() end
  for i = rows - 1, 1, -1 do b[i] = b[i + 1] + 1e-3 + math.exp(4 * math.random()) * math.random() end
  return function(share)
    local at = share * (rows - 1)
    local i = math.min(math.floor(at), rows - 2)
    local function between(t) return t[i + 1] + (at - i) * (t[i + 2] - t[i + 1]) end
    return between(a), between(b)
  end
end

-- The share at which both take the same time.
local function best_share(times)
  local low, high = 0, 1
  for _ = 1, 60 do
    local middle = (low + high) / 2
    local a, b = times(middle)
    if a <= b then low = middle else high = middle end
  end
  return low
end

facts.holds("bisection's bracket holds the best share at every step", function()
  local bisect = assert(loadfile(facts.root .. "/lua/experiments/bisect.lua"))()
  for _ = 1, 200 do
    local times, history = random_times(), {}
    local best = best_share(times)
    for share in bisect.strategy, history do
      local a, b = times(share)
      history[#history + 1] = { share = share, total = math.max(a, b), a = a, b = b }
      local low, high = bisect.bracket(history)
      assert(low <= best and best <= high, best)
    end
    facts.equal(#history, 13)
  end
end)

os.execute("rm -r " .. out)
facts.finish()
