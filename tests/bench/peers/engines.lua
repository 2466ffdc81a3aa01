-- SPDX-License-Identifier: MIT
-- Shared by piles.lua, stacks.lua and worlds.lua: bodies written for the programs beside this file, and as a
-- scene of Duet's, and both run. A body is { centre, half_extents, rotation, radius, mass, velocity,
-- angular_velocity }; pile.h has the format.
local duet = require "duet"
local engines = {}

local function row(...) return ("%.9g "):rep(select("#", ...)):format(...) .. "\n" end
local none = { 0, 0, 0 }

-- A body's centre, half extents, rotation, velocity and angular velocity.
local function parts_of(b)
  return b.centre, b.half_extents, b.rotation or { 0, 0, 0, 1 }, b.velocity or none, b.angular_velocity or none
end

-- `def` holds dt, substeps, gravity, friction; and restitution, sleep, continuous, settled, churn, and lower and
-- upper if there are walls.
function engines.write(path, bodies, def)
  local file = assert(io.open(path, "w"))
  local lower, upper = def.lower or none, def.upper or none
  file:write(("%d %d %.9g %.9g %.9g %.9g %d %d %d %d %d "):format(#bodies, def.substeps, def.dt, def.gravity,
    def.friction, def.restitution or 0, def.sleep and 1 or 0, def.lower and 1 or 0, def.continuous and 1 or 0,
    def.settled or 0, def.churn or 0), row(lower[1], lower[2], lower[3], upper[1], upper[2], upper[3]))
  for _, b in ipairs(bodies) do
    local c, h, q, v, w = parts_of(b)
    file:write(row(c[1], c[2], c[3], h[1], h[2], h[3], q[1], q[2], q[3], q[4], b.radius or 0, b.mass,
      v[1], v[2], v[3], w[1], w[2], w[3]))
  end
  assert(file:close())
end

-- The same bodies as a scene; def.wants names effects besides.
function engines.scene(bodies, def)
  local path = os.tmpname() .. ".lua"
  local file = assert(io.open(path, "w"))
  for _, b in ipairs(bodies) do
    local c, h, q, v, w = parts_of(b)
    file:write(("add { centre = { %.17g, %.17g, %.17g }, half_extents = { %.17g, %.17g, %.17g }, "
      .. "rotation = { %.17g, %.17g, %.17g, %.17g }, %smass = %.17g, friction = %.17g, "
      .. "restitution = %.17g, velocity = { %.17g, %.17g, %.17g }, angular_velocity = { %.17g, %.17g, %.17g } }\n")
      :format(c[1], c[2], c[3], h[1], h[2], h[3], q[1], q[2], q[3], q[4],
        b.radius and ("radius = %.17g, "):format(b.radius) or "", b.mass, def.friction,
        def.restitution or 0, v[1], v[2], v[3], w[1], w[2], w[3]))
  end
  local wants = { '"contact_response"' }
  for _, name in ipairs(def.wants or {}) do wants[#wants + 1] = ('"%s"'):format(name) end
  if def.sleep then wants[#wants + 1] = '"sleep"' end
  if def.continuous then wants[#wants + 1] = '"continuous"' end
  file:write(("return { dims = 3, gravity = { 0, 0, %.17g }, wants = { %s }, %s }\n"):format(def.gravity,
    table.concat(wants, ", "), def.sleep and "skin = 0.05, sleep_speed = 0.05" or ""))
  assert(file:close())
  local scene = assert(duet.scene(path))
  os.remove(path)
  return scene
end

-- Whether the engine is one of those that are asked for (names with commas between), or all are.
local function is_asked(name, only) return only == "all" or ("," .. only .. ","):find("," .. name .. ",", 1, true) end

-- Returns a list of what runs the engines that are asked for: Duet's, and others' made by `make_other` of the
-- path of a program, for those that were built, in `dir`.
function engines.list(dir, only, duets, make_other)
  local found = {}
  if is_asked("duet", only) then found[1] = duets end
  for _, name in ipairs { "box3d", "jolt", "bullet" } do
    local path = ("%s/pile_%s"):format(dir, name)
    local file = is_asked(name, only) and io.open(path)
    if file then
      file:close()
      found[#found + 1] = make_other(path)
    end
  end
  return found
end

-- Returns the engine's name, ms of processor time and of the clock a step, bodies awake at the end, and for
-- every `every` steps, and the last, an array of rows: centre, half extents, quaternion, velocity and angular
-- velocity of each body. Without a name the engine failed, as one that lacks a shape does, or took more than
-- `seconds`, if these are given. It has one thread if `threads` is nil.
function engines.run(program, pile, n, steps, every, seconds, threads)
  local states = os.tmpname()
  local limit = seconds and ("timeout %d "):format(seconds) or ""
  local out <close> = assert(io.popen(("%s%s %s %s %d %d %s"):format(limit, program, pile, states, steps, every,
    threads or "")))
  local name, ms, wall, awake = (out:read "l" or ""):match "^(.*)\t(.*)\t(.*)\t(.*)$"
  local frames = {}
  for line in io.lines(states) do
    local frame = frames[#frames]
    if not frame or #frame == n then
      frame = {}
      frames[#frames + 1] = frame
    end
    local numbers = {}
    for word in line:gmatch "%S+" do numbers[#numbers + 1] = tonumber(word) end
    frame[#frame + 1] = numbers
  end
  os.remove(states)
  return name, tonumber(ms), tonumber(wall), tonumber(awake), frames
end

-- Returns the command that runs the Lua script in another process, with as many units of PoCL's CPU as `threads`,
-- or all if it is nil.
function engines.duet_command(script, threads)
  local out <close> = assert(io.popen "readlink /proc/$PPID/exe")
  local program = out:read "l"
  if not program:match "/lua[^/]*$" then program = program .. " lua --trust" end
  local units = threads and ("env POCL_CPU_MAX_CU_COUNT=%d POCL_MAX_PTHREAD_COUNT=%d "):format(threads, threads) or ""
  return ("%s%s %s"):format(units, program, script) -- PoCL 3 knows the second name
end

return engines
