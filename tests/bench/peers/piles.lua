-- SPDX-License-Identifier: MIT
-- Piles in Duet and in other engines, one after the other:
--
--     duet lua --trust tests/bench/peers/piles.lua DIR N STEPS ROUNDS [ENGINES [THREADS]]
--
-- DIR holds pile_box3d and its like (CMakeLists.txt beside this file); engines that were not built are left out.
-- ENGINES are some of duet, box3d, jolt and bullet with commas between, and all by default. THREADS are numbers with
-- commas between, such as 1,4,16: each engine runs with each of them, Duet on as many cores of PoCL's CPU. Without,
-- Duet has the whole CPU and the others one thread. Prints for each engine ms of the clock and of processor time a
-- step, the medians of ROUNDS, in each of which the engines take turns; how many boxes are awake after the last; and
-- then, in m, how deep the deepest two boxes are in each other, and a box in the floor. One judge of all: the
-- separation of two boxes along the best of 15 axes, in double.
local duet = require "duet"

local dir, n, steps, rounds, only = arg[1], arg[2] or 5000, arg[3] or 600, arg[4] or 3, arg[5] or "all"
local counts = {} -- of threads
for count in (arg[6] or "0"):gmatch "%d+" do counts[#counts + 1] = tonumber(count) end
if not dir then error("give the folder of the engines' programs", 0) end
n, steps, rounds = tonumber(n) // 1 | 0, tonumber(steps) // 1 | 0, tonumber(rounds) // 1 | 0

local dt, substeps, gravity = 1 / 60, 4, -9.81
local scene = assert(duet.scene("falling", { n = n, restitution = 0, sleep_speed = 0.05 })) -- m/s, as in Box3D
local device = assert(duet.device_pair { a = "cpu", b = "cpu" })
local lower, upper = scene.lower, scene.upper
local folder = arg[0]:match "^(.-)[^/]*$"
local engines = dofile(folder .. "engines.lua")
local pile = os.tmpname()

local function write_pile()
  local bodies, poses = {}, scene:poses()
  for i = 0, n - 1 do
    local x, y, z, hx, hy, hz, qx, qy, qz, qw = poses:get(i)
    bodies[i + 1] = { centre = { x, y, z }, half_extents = { hx, hy, hz }, rotation = { qx, qy, qz, qw }, mass = 1 }
  end
  engines.write(pile, bodies,
    { dt = dt, substeps = substeps, gravity = gravity, friction = 0.5, sleep = true, lower = lower, upper = upper })
end

-- A result of a run: the engine's name, ms of the clock and of processor time a step, boxes awake, poses.
local function run(command, input, threads)
  local name, ms, wall, awake, frames = engines.run(command, input, n, steps, steps, nil, threads)
  if not name then error(command .. " told no time", 0) end
  local poses = duet.poses(n)
  for i, row in ipairs(frames[#frames]) do poses:set(i - 1, table.unpack(row, 1, 10)) end
  return { name = name, wall = wall, ms = ms, awake = awake, poses = poses }
end

local function run_duet(threads)
  return run(engines.duet_command(folder .. "pile_duet.lua", threads), n, threads)
end

local function deepest(poses)
  local world <close> = assert(device:world(assert(duet.scene(poses, 3))))
  local between, floor = 0, 0
  for a, b in assert(world:step()):pairs() do between = math.max(between, -poses:separation(a, b)) end
  for i = 0, n - 1 do
    local _, _, z, hx, hy, hz, qx, qy, qz, qw = poses:get(i)
    local q = qx * qx + qy * qy + qz * qz + qw * qw
    local reach = (math.abs(2 * (qx * qz - qw * qy)) * hx + math.abs(2 * (qy * qz + qw * qx)) * hy
      + math.abs(q - 2 * (qx * qx + qy * qy)) * hz) / q
    floor = math.max(floor, lower[3] - (z - reach))
  end
  return between, floor
end

local function median(results, key)
  local values = {}
  for i, result in ipairs(results) do values[i] = result[key] end
  table.sort(values)
  return values[(#values + 1) // 2]
end

write_pile()
local rows = {} -- an engine with a number of threads
for _, count in ipairs(counts) do
  local threads = count > 0 and count or nil
  for _, run_engine in ipairs(engines.list(dir, only, run_duet, function(program)
    return function() return run(program, pile, threads) end
  end)) do
    rows[#rows + 1] = { threads = threads, run = run_engine, results = {} }
  end
end
for round = 1, rounds do
  for _, row in ipairs(rows) do row.results[round] = row.run(row.threads) end
end
print(("%d boxes, %d steps, median of %d rounds"):format(n, steps, rounds))
print(("%-14s %7s %10s %10s %8s %9s %9s"):format("", "threads", "ms a step", "processor", "awake", "deepest",
  "in floor"))
for _, row in ipairs(rows) do
  local last = row.results[rounds]
  print(("%-14s %7s %10.2f %10.2f %8d %9.4f %9.4f"):format(last.name, row.threads or "", median(row.results, "wall"),
    median(row.results, "ms"), last.awake, deepest(last.poses)))
end
os.remove(pile)
