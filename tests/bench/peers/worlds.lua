-- SPDX-License-Identifier: MIT
-- Worlds beside piles and stacks, in Duet and in other engines:
--
--     duet lua --trust tests/bench/peers/worlds.lua DIR [SCALE [ENGINE [SECONDS [SCENES]]]]
--
-- DIR holds pile_box3d and its like (CMakeLists.txt beside this file); engines that were not built are left out.
-- SCALE below 1 makes fewer bodies. ENGINE is duet, box3d, jolt or bullet, and all by default; no scene of
-- another engine takes more than SECONDS. SCENES are the numbers of those that run, as 1,2,5; all by default.
-- Prints for each scene and engine ms of processor time and of the clock a step, and what the scene is there for.
-- If bodies sleep, the first 60 steps do not count. The others use one thread. Duet's commands before a step count
-- by their processor time. All have the same substeps.
local duet = require "duet"
io.stdout:setvbuf "line" -- rows of a run that is stopped are not lost

local dir, scale, only, limit = arg[1], tonumber(arg[2] or 1), arg[3] or "all", tonumber(arg[4] or 600)
local asked = "," .. (arg[5] or "1,2,3,4,5,6,7,8") .. ","
if not dir then error("give the folder of the engines' programs", 0) end
local engines = dofile(arg[0]:match "^(.-)[^/]*$" .. "engines.lua")
local device = assert(duet.device_pair { a = "cpu", b = "cpu" })
local dt, substeps, gravity = 1 / 60, 4, -9.81
local pile = os.tmpname()

local function floor(width) return { centre = { 0, 0, -1 }, half_extents = { width, width, 1 }, mass = 0 } end

local function cube(x, y, z) return { centre = { x, y, z }, half_extents = { 0.5, 0.5, 0.5 }, mass = 1 } end

local function ball(x, y, z, vx, vy)
  return { centre = { x, y, z }, half_extents = { 0, 0, 0 }, radius = 0.5, mass = 1, velocity = { vx, vy, 0 } }
end

-- Cubes in a square on a floor, `high` on each other.
local function field(n, high)
  local side = math.ceil((n / high) ^ 0.5)
  local bodies = { floor(2 * side + 60) }
  for i = 0, n - 1 do
    local column = i // high
    bodies[#bodies + 1] = cube(1.5 * (column % side - side / 2), 1.5 * (column // side - side / 2), 0.5 + i % high)
  end
  return bodies, 0.75 * side
end

-- Beside cubes that sleep, balls that roll.
local function few(n, rolling)
  local bodies, edge = field(n, 1)
  for i = 0, rolling - 1 do
    local b = ball(1.5 * (i % 100), -edge - 3 - 1.5 * (i // 100), 0.5, 0, -0.5)
    b.angular_velocity = { 1, 0, 0 }
    bodies[#bodies + 1] = b
  end
  return bodies
end

local function tumbling()
  return { { centre = { 0, 0, 0 }, half_extents = { 0.5, 0.3, 0.15 }, mass = 1, angular_velocity = { 0.01, 9, 0.01 } } }
end

-- Balls that fly at plates a tenth as thick as their way of a step.
local function bullets(n)
  local bodies = {}
  for i = 0, n - 1 do
    bodies[#bodies + 1] = { centre = { 0, 4 * i, 0 }, half_extents = { 0.1, 1, 1 }, mass = 0 }
  end
  for i = 0, n - 1 do
    bodies[#bodies + 1] = { centre = { -20 - 0.037 * i, 4 * i, 0 }, half_extents = { 0, 0, 0 }, radius = 0.1, mass = 1,
      velocity = { 120, 0, 0 } }
  end
  return bodies
end

local function row_of_balls()
  local bodies = {}
  for i = 0, 5 do bodies[#bodies + 1] = ball(i, 0, 0, 0, 0) end
  bodies[#bodies + 1] = ball(-2.5, 0, 0, 1, 0)
  return bodies
end

local function rounded(n)
  local side = math.ceil((n / 8) ^ (1 / 3) * 2)
  local bodies = { floor(4 * side) }
  for i = 0, n - 1 do
    local x, y, z = i % side, i // side % side, i // (side * side)
    bodies[#bodies + 1] = { centre = { 1.1 * (x - side / 2) + 0.3 * (z % 2), 1.1 * (y - side / 2), 0.6 + 1.1 * z },
      half_extents = { 0.4, 0.3, 0.2 }, radius = 0.1, mass = 1 }
  end
  return bodies
end

-- A frame's kinetic energy, of bodies that are boxes or balls.
local function energy(bodies, frame)
  local sum = 0
  for i, b in ipairs(bodies) do
    if b.mass > 0 then
      local f, r = frame[i], b.radius or 0
      local a, c, d = b.half_extents[1] + r, b.half_extents[2] + r, b.half_extents[3] + r
      local inertia = b.radius and { 0.4 * r * r, 0.4 * r * r, 0.4 * r * r }
        or { (c * c + d * d) / 3, (a * a + d * d) / 3, (a * a + c * c) / 3 }
      local x, y, z, w = f[7], f[8], f[9], f[10]
      local axes = { { 1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w) },
        { 2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w) },
        { 2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y) } }
      sum = sum + b.mass / 2 * (f[11] ^ 2 + f[12] ^ 2 + f[13] ^ 2)
      for k = 1, 3 do
        local turn = axes[k][1] * f[14] + axes[k][2] * f[15] + axes[k][3] * f[16]
        sum = sum + b.mass / 2 * inertia[k] * turn * turn
      end
    end
  end
  return sum
end

local function farthest(bodies, frame)
  local most = 0
  for i, b in ipairs(bodies) do
    if b.mass > 0 then
      most = math.max(most, ((frame[i][1] - b.centre[1]) ^ 2 + (frame[i][2] - b.centre[2]) ^ 2
        + (frame[i][3] - b.centre[3]) ^ 2) ^ 0.5)
    end
  end
  return most
end

-- Functions that say what a scene shows, by its bodies and its frames.
local function tell_awake(_, _, awake) return ("%d awake"):format(awake) end

local function tell_place(def, frames, awake)
  local way = farthest(def.bodies, frames[#frames])
  return ("%d awake, none further than %.1f mm from its place"):format(awake, way * 1e3)
end

local function tell_kept(def, frames)
  return ("keeps %.4f of its energy"):format(energy(def.bodies, frames[#frames]) / def.energy)
end

local function tell_behind(def, frames)
  local last, n, behind = frames[#frames], #def.bodies // 2, 0
  for i = n + 1, 2 * n do behind = behind + (last[i][1] > 0 and 1 or 0) end
  return ("%d of %d go through"):format(behind, n)
end

local function tell_rest(def, frames)
  return ("%.2g J of %d kg"):format(energy(def.bodies, frames[#frames]), #def.bodies - 1)
end

local function count(n) return math.ceil(n * scale) end

local scenes = {
  { name = "10 of 100 000 roll", make = function() return few(count(100000), 10) end, steps = 240, sleep = true,
    tell = tell_awake },
  { name = "1 000 of 100 000 roll", make = function() return few(count(100000), count(1000)) end, steps = 240,
    sleep = true, tell = tell_awake },
  { name = "1 000 of 100 000 go and come", make = function() return field(count(100000), 2) end, steps = 160,
    sleep = true, churn = count(1000), tell = tell_place },
  { name = "a box that tumbles, 60 s", make = tumbling, steps = 3600, gravity = 0, tell = tell_kept },
  { name = "bullets of 120 m/s", make = function() return bullets(100) end, steps = 60, gravity = 0, continuous = true,
    tell = tell_behind },
  { name = "1 000 cubes at rest, 10 s", make = function() return (field(1000, 10)) end, steps = 600, tell = tell_rest },
  { name = "a ball hits a row of six", make = row_of_balls, steps = 240, gravity = 0, friction = 0, restitution = 1,
    wants = { "shocks" }, tell = tell_kept },
  { name = "2 000 rounded boxes, 5 s", make = function() return rounded(count(2000)) end, steps = 300,
    tell = tell_rest },
}

-- Removes bodies before a step, and puts them where they began: as pile_renew of pile.h.
local function renew(motion, scene, ids, step, churn)
  local first = 1 + step % ((#scene:poses() - 1) // churn) * churn
  local gone, poses, bodies = duet.ids(churn), duet.poses(churn), duet.bodies(churn)
  for i = 0, churn - 1 do
    gone:set(i, ids:get(first + i))
    poses:set(i, scene:poses():get(first + i))
    bodies:set(i, scene:bodies():get(first + i))
  end
  local begun = os.clock()
  assert(motion:remove_bodies(gone))
  local fresh = assert(motion:add_bodies(poses, bodies))
  local spent = os.clock() - begun
  for i = 0, churn - 1 do ids:set(first + i, fresh:get(i)) end
  return spent
end

local function frame_of(def, motion, ids)
  local frame, states, place_of = {}, assert(motion:read()), {}
  local there = assert(motion:ids())
  for place = 0, #there - 1 do place_of[there:get(place)] = place end
  for i = 1, #def.bodies do
    local x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz = states:get(place_of[ids:get(i - 1)])
    local h = def.bodies[i].half_extents
    frame[i] = { x, y, z, h[1], h[2], h[3], qx, qy, qz, qw, vx, vy, vz, wx, wy, wz }
  end
  return frame
end

local function awake_in(def, frame)
  local awake = 0
  for i, f in ipairs(frame) do
    local moves = f[11] ~= 0 or f[12] ~= 0 or f[13] ~= 0 or f[14] ~= 0 or f[15] ~= 0 or f[16] ~= 0
    awake = awake + (moves and def.bodies[i].mass > 0 and 1 or 0)
  end
  return awake
end

-- Builds the kernels before the clock runs, those of small scenes by running them.
local function warm(def, scene)
  local motion <close> = assert(device:motion(scene, { dt = dt, substeps = substeps }))
  for step = 1, #def.bodies < 5000 and def.steps or 3 do
    if def.churn then renew(motion, scene, assert(motion:ids()), step, def.churn) end
    assert(motion:advance())
  end
end

local function run_duet(def)
  local scene = engines.scene(def.bodies, def)
  warm(def, scene)
  local motion <close> = assert(device:motion(scene, { dt = dt, substeps = substeps }))
  local ids, spent, passed = assert(motion:ids()), 0, 0
  for step = 1, def.steps do
    local renewed = def.churn and step > def.settled and renew(motion, scene, ids, step, def.churn) or 0
    local begun = os.clock()
    local result = assert(motion:advance())
    if step > def.settled then
      spent, passed = spent + os.clock() - begun + renewed, passed + result.total_ms / 1e3 + renewed
    end
  end
  local counted = def.steps - def.settled
  local frame = frame_of(def, motion, ids)
  return "Duet " .. duet.version, spent * 1e3 / counted, passed * 1e3 / counted, awake_in(def, frame), { frame }
end

local runs = engines.list(dir, only, run_duet, function(program)
  return function(def) return engines.run(program, pile, #def.bodies, def.steps, def.steps, limit) end
end)

local function run_all(def)
  for _, run in ipairs(runs) do
    local name, ms, wall, awake, frames = run(def)
    if name then
      print(("%-30s %-14s %9.3f %9.3f  %s"):format(def.name, name, ms, wall, def.tell(def, frames, awake)))
    end
  end
end

local function run_scene(def)
  def.bodies, def.dt, def.substeps, def.settled = def.make(), dt, substeps, def.sleep and 60 or 0
  def.gravity, def.friction = def.gravity or gravity, def.friction or 0.5
  local begun = {}
  for i, b in ipairs(def.bodies) do
    local v, w = b.velocity or { 0, 0, 0 }, b.angular_velocity or { 0, 0, 0 }
    begun[i] = { 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, v[1], v[2], v[3], w[1], w[2], w[3] }
  end
  def.energy = energy(def.bodies, begun)
  engines.write(pile, def.bodies, def)
  run_all(def)
  def.bodies = nil
end

for i, def in ipairs(scenes) do
  if asked:find("," .. i .. ",", 1, true) then run_scene(def) end
end
os.remove(pile)
