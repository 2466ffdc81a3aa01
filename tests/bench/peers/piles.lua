-- SPDX-License-Identifier: MIT
-- Piles in Duet and in other engines, one after the other:
--
--     duet lua --trust tests/bench/peers/piles.lua DIR N STEPS ROUNDS [ENGINE]
--
-- DIR holds pile_box3d and its like (CMakeLists.txt beside this file); engines that were not built are left out.
-- ENGINE is duet, box3d, jolt or bullet, and all by default. Prints for each engine the processor time of a step
-- in ms, the median of ROUNDS; how many boxes are awake after the last; and then, in m, how deep the deepest two
-- boxes are in each other, and a box in the floor. One judge of all: the separation of two boxes along the best
-- of 15 axes, in double.
local duet = require "duet"

local dir, n, steps, rounds, only = arg[1], arg[2] or 5000, arg[3] or 600, arg[4] or 3, arg[5] or "all"
if not dir then error("give the folder of the engines' programs", 0) end
n, steps, rounds = tonumber(n) // 1 | 0, tonumber(steps) // 1 | 0, tonumber(rounds) // 1 | 0

local dt, substeps, gravity = 1 / 60, 4, -9.81
local scene = assert(duet.scene("falling", { n = n, restitution = 0, sleep_speed = 0.05 })) -- m/s, as in Box3D
local device = assert(duet.device_pair { a = "cpu", b = "cpu" })
local lower, upper = scene.lower, scene.upper
local engines = dofile(arg[0]:match "^(.-)[^/]*$" .. "engines.lua")
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

-- ms a step, boxes awake, poses
local function run_duet()
  local motion <close> = assert(device:motion(scene, { dt = dt, substeps = substeps }))
  local begun = os.clock()
  for _ = 1, steps do assert(motion:advance()) end
  local ms, awake, poses = (os.clock() - begun) * 1e3 / steps, 0, duet.poses(n)
  local at, sizes = assert(motion:read()), scene:poses()
  for i = 0, n - 1 do
    local x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz = at:get(i)
    local _, _, _, hx, hy, hz = sizes:get(i)
    poses:set(i, x, y, z, hx, hy, hz, qx, qy, qz, qw)
    if vx ~= 0 or vy ~= 0 or vz ~= 0 or wx ~= 0 or wy ~= 0 or wz ~= 0 then awake = awake + 1 end
  end
  return ms, awake, poses
end

local function run_other(program)
  local name, ms, _, awake, frames = engines.run(program, pile, n, steps, steps)
  if not name then error(program .. " told no time", 0) end
  local poses = duet.poses(n)
  for i, row in ipairs(frames[#frames]) do poses:set(i - 1, table.unpack(row, 1, 10)) end
  return ms, awake, poses, name
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

write_pile()
do -- kernels are built before the clock runs
  local motion <close> = assert(device:motion(scene, { dt = dt, substeps = substeps }))
  assert(motion:advance())
end
local runs = engines.list(dir, only, { name = "Duet " .. duet.version, run = run_duet },
  function(program) return { run = function() return run_other(program) end } end)
for _ = 1, rounds do
  for _, engine in ipairs(runs) do
    local ms, awake, poses, name = engine.run()
    engine.times = engine.times or {}
    table.insert(engine.times, ms)
    engine.name, engine.awake, engine.poses = name or engine.name, awake, poses
  end
end
print(("%d boxes, %d steps, median of %d rounds"):format(n, steps, rounds))
print(("%-14s %10s %8s %9s %9s"):format("", "ms a step", "awake", "deepest", "in floor"))
for _, engine in ipairs(runs) do
  table.sort(engine.times)
  print(("%-14s %10.2f %8d %9.4f %9.4f"):format(engine.name, engine.times[(rounds + 1) // 2], engine.awake,
    deepest(engine.poses)))
end
os.remove(pile)
