-- SPDX-License-Identifier: MIT
-- What experiments share: their options, and times that can be compared.
--
-- Plans that are compared are stepped in turn, round by round, so that a slow
-- minute falls on all of them alike; each step gets the objects anew.

local duet = require "duet"
local frame = require "duet.frame"
local plot = require "duet.plot"
local draw_timeline = require "duet.timeline"

local lab = {}

-- ------------------------------------------------------------------ options

local function fail(format, ...)
  io.stderr:write(format:format(...), "\n")
  os.exit(2, true)
end

-- "250000,1e6" -> { 250000, 1000000 }
local function read_sizes(text)
  local sizes = {}
  for item in text:gmatch "[^,]+" do
    local n = math.tointeger(tonumber(item))
    if not n or n < 1 then fail("--sizes '%s': give whole numbers with commas, as 1000,2000", text) end
    sizes[#sizes + 1] = n
  end
  return sizes
end

local function read_number(name, text)
  return tonumber(text) or fail("--%s '%s': give a number", name, text)
end

local function read_count(name, text)
  local n = math.tointeger(tonumber(text))
  return n and n >= 1 and n or fail("--%s '%s': give a whole number from 1", name, text)
end

local function read_value(name, default, text)
  if name == "sizes" then return read_sizes(text) end
  if math.type(default) == "integer" then return read_count(name, text) end
  if type(default) == "number" then return read_number(name, text) end
  return text
end

local function print_help(defaults, about)
  print(about .. "\n")
  local names = {}
  for name in pairs(defaults) do names[#names + 1] = name end
  table.sort(names)
  for _, name in ipairs(names) do
    local value = defaults[name]
    if type(value) == "table" then value = table.concat(value, ",") end
    print(("  --%-10s %s"):format(name, value == "" and "(none)" or value))
  end
  os.exit(0, true)
end

local function mkdir(options, path)
  return os.execute("mkdir " .. options .. " -- '" .. path:gsub("'", "'\\''") .. "' 2>/dev/null")
end

-- Before anything is measured, so that no hour's work ends without a place.
local function make_folder(path)
  if not mkdir("-p", path) then fail("--out '%s': cannot be made", path) end
  return path
end

local function exists(path)
  local file <close> = io.open(path)
  return file ~= nil
end

-- The first of NAME-1, NAME-2 ... that is not there.
local function make_new_folder(name)
  make_folder(name:match "^(.*)/")
  local i = 1
  while not mkdir("", name .. "-" .. i) do
    if not exists(name .. "-" .. i) then fail("'%s-%d': cannot be made; give --out FOLDER", name, i) end
    i = i + 1
  end
  return name .. "-" .. i
end

-- The results of a call. A name that was typed and that nothing has ends the script as a wrong
-- option does.
local function take(value, message, status)
  if status == "BAD_ARGUMENT" then fail("%s", message) end
  return assert(value, message)
end

-- Reads arg over the defaults: "--name value" or "--name=value". Options that
-- every experiment has are out (a folder for what it writes; else a new one in results),
-- repeat (rounds), seed, and pair ("A,B", and more of them after semicolons).
function lab.options(about, own)
  local results = "results/" .. arg[0]:match "([^/]*)$":gsub("%.lua$", "")
  local options = { out = results .. "-N", ["repeat"] = 9, seed = 1, pair = "" }
  for name, value in pairs(own) do options[name] = value end
  local i = 1
  while arg[i] do
    local name, value = arg[i]:match "^%-%-([%w_]+)=?(.*)$"
    if name == "help" then print_help(options, about) end
    if options[name or ""] == nil then fail("there is no option '%s'; --help lists those there are", arg[i]) end
    if not arg[i]:find("=", 1, true) then
      i = i + 1
      value = arg[i] or fail("--%s needs a value", name)
    end
    options[name] = read_value(name, options[name], value)
    i = i + 1
  end
  options.out = options.out == results .. "-N" and make_new_folder(results) or make_folder(options.out)
  return options
end

-- The pairs that were asked for, each opened when its turn comes.
function lab.each_pair(options)
  local defs = {}
  for both in options.pair:gmatch "[^;]+" do defs[#defs + 1] = { a = both } end
  if #defs == 0 then defs[1] = {} end
  local i, pair = 0, nil
  return function()
    if pair then pair:close() end
    i = i + 1
    if not defs[i] then return nil end
    pair = take(duet.device_pair(defs[i]))
    return pair, pair:device("A").selector .. "+" .. pair:device("B").selector
  end
end

-- The paper's scene: n rotated unit cubes in a world of edge options.world.
function lab.paper_scene(options, n)
  local scenes = os.getenv "DUET_SCENES" or (arg[0]:match "^(.*/)" or "./") .. "../scenes"
  return assert(duet.scene(scenes .. "/paper.lua",
    { n = n, seed = options.seed, world = options.world, euler = options.euler == 1 }))
end

-- ------------------------------------------------------------------ times

function lab.median(values)
  local sorted = table.move(values, 1, #values, 1, {})
  table.sort(sorted)
  local half = #sorted // 2
  return #sorted % 2 == 1 and sorted[half + 1] or (sorted[half] + sorted[half + 1]) / 2
end

-- The interval of the median between two order statistics that holds it with
-- at least this confidence, by the binomial distribution; all values where
-- they are too few.
function lab.median_interval(values, confidence)
  local sorted = table.move(values, 1, #values, 1, {})
  table.sort(sorted)
  local n, below, chance, rank = #sorted, 0, 0.5 ^ #sorted, 1
  for k = 0, n // 2 - 1 do
    below = below + chance -- that at most k values lie below the median
    if 1 - 2 * below < (confidence or 0.95) then break end
    rank = k + 1
    chance = chance * (n - k) / (k + 1)
  end
  return sorted[rank], sorted[n + 1 - rank]
end

-- One step, for which the objects are handed over anew, as an application does.
-- (world:set_scene would have the grid fitted again as well.)
function lab.step(world, scene)
  if scene.shape == "poses" then
    assert(world:set_poses(scene:poses()))
  else
    assert(world:set_bounds(scene:bounds()))
  end
  return assert(world:step())
end

-- A step by another plan than the last, which buffers have to settle to first.
local function step_with(world, scene, plan)
  assert(world:set_plan(plan))
  lab.step(world, scene)
  return lab.step(world, scene)
end

-- Steps each plan in turn, `rounds` times after one to warm up. Gives for each
-- plan: ms, low, high (the median's interval), and samples by round.
function lab.race(world, scene, plans, rounds)
  local results, hash = {}, nil
  for i, plan in ipairs(plans) do
    local found = step_with(world, scene, plan):hash()
    assert(found == (hash or found), "two plans found different pairs")
    hash, results[i] = found, { samples = {}, plan = plan }
  end
  for round = 1, rounds do
    for turn = 1, #plans do
      local i = (turn + round - 2) % #plans + 1
      results[i].samples[round] = step_with(world, scene, plans[i]).total_ms
    end
  end
  for _, r in ipairs(results) do
    r.ms = lab.median(r.samples)
    r.low, r.high = lab.median_interval(r.samples)
  end
  return results
end

-- How much faster b is than a, round by round: 0.25 is a quarter. With the
-- interval of that median.
function lab.gain(a, b)
  local gains = {}
  for round, ms in ipairs(a.samples) do gains[round] = ms / b.samples[round] - 1 end
  local low, high = lab.median_interval(gains)
  return lab.median(gains), low, high
end

-- The pair's default plan in a mode, with kernels where they are named.
function lab.plan(pair, mode, variant)
  local plan = pair:plan()
  plan.mode = mode
  if variant ~= "" then plan.variant_a, plan.variant_b = variant, variant end
  return plan
end

-- A world with the plan, whose names may have been typed.
function lab.world(pair, scene, plan)
  local ok, world, message, status = pcall(pair.world, pair, scene, { plan = plan })
  if not ok then fail("%s", world) end
  return take(world, message, status)
end

-- A plan with another share.
function lab.with_share(plan, share)
  return { share = share, mode = plan.mode, variant_a = plan.variant_a, variant_b = plan.variant_b }
end

-- Lets a strategy search, one of duet.strategies() or the script FILE.lua;
-- launch(share) gives total_ms, a_ms, b_ms. Returns its pick, and every launch as
-- { share, total_ms }.
function lab.search(def, launch)
  if def.strategy and def.strategy:find "%.lua$" then
    local file <close> = assert(io.open(def.strategy))
    def = { strategy = "lua", strategy_lua = file:read "a", launches = def.launches }
  end
  local search <close> = take(duet.search(def))
  local path = {}
  while true do
    local share, message = search:ask()
    if not share then return search:pick(), path, assert(not message, message) end
    local total, a, b = launch(share)
    path[#path + 1] = { share, total }
    assert(search:tell(share, total, share > 0 and a or 0, share < 1 and b or 0))
  end
end

-- A launch for lab.search on the world's devices.
function lab.launcher(world, scene, plan)
  return function(share)
    local result = step_with(world, scene, lab.with_share(plan, share))
    return result.total_ms, result.device_ms[1], result.device_ms[2]
  end
end

-- The step of median time of those of all rounds but the first, so that its stages belong together.
function lab.median_step(world, scene, rounds)
  local steps = {}
  for round = 0, rounds do
    local result = lab.step(world, scene)
    if round > 0 then steps[round] = { ms = result.total_ms, device_ms = result.device_ms, stages = result:stages() } end
  end
  table.sort(steps, function(a, b) return a.ms < b.ms end)
  return steps[(#steps + 1) // 2]
end

-- Who works at a share.
function lab.plan_name(share)
  return share == 0 and "B alone" or share == 1 and "A alone" or "A and B"
end

-- The gain of sharing over a single device, in percent, with its interval; nothing if the plan
-- has one device do it all.
function lab.sharing_gain(single, both)
  if lab.plan_name(both.plan.share) ~= "A and B" then return end
  local gain, low, high = lab.gain(single, both)
  return 100 * gain, 100 * low, 100 * high
end

-- Each device alone and both at the tuned share: three entries of lab.race,
-- the last with its share.
function lab.compare(pair, scene, plan, options)
  local world <close> = lab.world(pair, scene, plan)
  local share = lab.search({ strategy = options.strategy }, lab.launcher(world, scene, plan))
  local plans = {}
  for i, part in ipairs { 1, 0, share } do plans[i] = lab.with_share(plan, part) end
  return lab.race(world, scene, plans, options["repeat"])
end

-- ------------------------------------------------------------------ results

-- NAME.svg and NAME.png in the folder that was asked for, where there is gnuplot.
function lab.picture(options, name, chart)
  local ok, why = plot.draw(options.out .. "/" .. name, chart)
  if not ok then io.stderr:write(why, "\n") end
  return ok and (", %s.svg, %s.png"):format(name, name) or ""
end

-- NAME.svg with the time lines of a step (duet.timeline).
function lab.timeline(options, name, def)
  local file <close> = assert(io.open(options.out .. "/" .. name .. ".svg", "w"))
  assert(file:write(draw_timeline(def)))
end

-- Prints the rows, and writes NAME.csv, NAME.json, the picture and other ones, NAME_KEY for
-- each key of `more`.
function lab.finish(options, name, rows, chart, more)
  rows:print()
  assert(rows:write(options.out .. "/" .. name))
  local written = name .. ".csv, " .. name .. ".json"
  if chart then written = written .. lab.picture(options, name, chart) end
  for key, other in pairs(more or {}) do written = written .. lab.picture(options, name .. "_" .. key, other) end
  print(("-> %s: %s\n"):format(options.out, written))
end

lab.frame = frame

return lab
