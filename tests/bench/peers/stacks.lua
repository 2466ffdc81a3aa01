-- SPDX-License-Identifier: MIT
-- Stacks that should stand and seams that nothing should trip over, in Duet and in other engines:
--
--     duet lua --trust tests/bench/peers/stacks.lua DIR [ENGINE]
--
-- DIR holds pile_box3d and its like (CMakeLists.txt beside this file); engines that were not built are left out.
-- ENGINE is duet, box3d, jolt or bullet, and all by default. Each engine uses the substeps that it would by
-- default. Prints for each scene and engine ms of processor time a step; then for a stack how many bodies fell
-- (by 0.9 of their height or more) and when the first did, and for a seam the part of its speed that the body
-- keeps and how high it hops in mm.
local duet = require "duet"
io.stdout:setvbuf "line" -- rows of a run that is stopped are not lost

local dir, only = arg[1], arg[2] or "all"
if not dir then error("give the folder of the engines' programs", 0) end
local engines = dofile(arg[0]:match "^(.-)[^/]*$" .. "engines.lua")
local device = assert(duet.device_pair { a = "cpu", b = "cpu" })
local dt, every, gravity = 1 / 60, 3, -9.81
local pile = os.tmpname()

local function floor_below(thickness)
  return { centre = { 0, 0, -thickness / 2 }, half_extents = { 30, 30, thickness / 2 }, mass = 0 }
end

local function stack(n, edge)
  local bodies = { floor_below(2) }
  for i = 0, n - 1 do
    bodies[#bodies + 1] = { centre = { 0, 0, (i + 0.5) * edge }, half_extents = { edge / 2, edge / 2, edge / 2 },
      mass = 1000 * edge ^ 3 }
  end
  return bodies
end

-- 18 levels of three blocks, `scale` times 75 x 25 x 15 mm; `out` names blocks by "level,place".
local function jenga(scale, out)
  local bodies, x, y, z = { floor_below(2) }, 0.0375 * scale, 0.0125 * scale, 0.0075 * scale
  for level = 0, 17 do
    for place = 0, 2 do
      local off, turned = (place - 1) * 2.004 * y, level % 2 == 1
      if not out[level .. "," .. place] then
        bodies[#bodies + 1] = {
          centre = turned and { off, 0, z * (2 * level + 1) } or { 0, off, z * (2 * level + 1) },
          half_extents = turned and { y, x, z } or { x, y, z },
          mass = 0.02 * scale ^ 3,
        }
      end
    end
  end
  return bodies
end

local function twelve_out()
  local out = {}
  for level = 1, 15, 2 do out[level .. "," .. (level % 4 < 2 and 0 or 2)] = true end
  for level = 2, 14, 4 do out[level .. ",1"] = true end
  return out
end

-- Eight planks over an edge: each juts out by `part` of what statics allows.
local function overhang(part)
  local bodies, x = { { centre = { -0.5, 0, 0.5 }, half_extents = { 0.5, 0.5, 0.5 }, mass = 0 } }, 0
  for i = 1, 8 do
    x = x + part / (2 * (9 - i))
    bodies[#bodies + 1] = { centre = { x - 0.5, 0, 1.1 + 0.2 * (i - 1) }, half_extents = { 0.5, 0.5, 0.1 }, mass = 1 }
  end
  return bodies
end

-- Unit cubes in rows, each half on two of the row below.
local function pyramid(rows)
  local bodies = { floor_below(2) }
  for row = 0, rows - 1 do
    for i = 1, rows - row do
      bodies[#bodies + 1] = { centre = { i - (rows - row + 1) / 2, 0, row + 0.5 }, half_extents = { 0.5, 0.5, 0.5 }, mass = 1 }
    end
  end
  return bodies
end

-- A cube on one of the same size, `ratio` times as heavy.
local function heavy_on_light(ratio)
  local bodies = stack(2, 1)
  bodies[2].mass, bodies[3].mass = 1, ratio
  return bodies
end

local function tiles(speed, body)
  local bodies = {}
  for x = 0, 59 do
    for y = -1, 1 do
      bodies[#bodies + 1] = { centre = { x, y, -0.5 }, half_extents = { 0.5, 0.5, 0.5 }, mass = 0 }
    end
  end
  body.centre, body.radius, body.mass, body.velocity = { 0, 0.1, 0.25 }, 0.25, 1, { speed, 0, 0 }
  bodies[#bodies + 1] = body
  return bodies
end

local scenes = {
  { name = "stack of 50", bodies = stack(50, 1), seconds = 20 },
  { name = "20 cubes of 1 cm", bodies = stack(20, 0.01), seconds = 10 },
  { name = "Jenga", bodies = jenga(1, {}), seconds = 10 },
  { name = "Jenga, 10 times, 12 out", bodies = jenga(10, twelve_out()), seconds = 10 },
  { name = "planks at 90 %", bodies = overhang(0.9), seconds = 10 },
  { name = "pyramid of 20 rows", bodies = pyramid(20), seconds = 20 },
  { name = "1 : 100, heavy on light", bodies = heavy_on_light(100), seconds = 5 },
}
for _, speed in ipairs { 1, 2, 5, 10 } do
  scenes[#scenes + 1] = { name = ("ball over tiles, %d m/s"):format(speed), seam = speed, friction = 0,
    bodies = tiles(speed, { half_extents = { 0, 0, 0 } }), seconds = 55 / speed }
end
scenes[#scenes + 1] = { name = "capsule over tiles, 5 m/s", seam = 5, friction = 0,
  bodies = tiles(5, { half_extents = { 0, 0.3, 0 } }), seconds = 11 }

local function run_duet(def)
  local scene = engines.scene(def.bodies, { gravity = gravity, friction = def.friction or 0.5 })
  local motion <close> = assert(device:motion(scene, { dt = dt }))
  local steps, frames, seconds = def.steps, {}, 0
  for step = 1, steps do
    local begun = os.clock()
    assert(motion:advance())
    seconds = seconds + os.clock() - begun
    if step % every == 0 or step == steps then
      local frame, at = {}, assert(motion:read())
      for i = 1, #def.bodies do
        local x, y, z = at:get(i - 1)
        frame[i] = { x, y, z }
      end
      frames[#frames + 1] = frame
    end
  end
  return "Duet " .. duet.version, seconds * 1e3 / steps, 0, 0, frames
end

local function fallen(def, frames)
  local first, count = nil, 0
  for i, b in ipairs(def.bodies) do
    for k, frame in ipairs(frames) do
      if b.mass > 0 and b.centre[3] - frame[i][3] > 1.8 * b.half_extents[3] then
        count, first = count + 1, math.min(first or k, k)
        break
      end
    end
  end
  if count == 0 then return "stands" end
  return ("%d of %d fall, the first after %.1f s"):format(count, #def.bodies - 1, first * every * dt)
end

local function tripped(def, frames)
  local i, height, last = #def.bodies, 0, nil
  for k = 2, #frames do
    local a, b = frames[k - 1][i], frames[k][i]
    if b[1] > 58 then break end
    height = math.max(height, b[3] - def.bodies[i].centre[3])
    last = (b[1] - a[1]) / (every * dt)
  end
  return ("keeps %.3f, hops %.1f mm"):format(last / def.seam, height * 1e3)
end

local runs = engines.list(dir, only, run_duet, function(program)
  return function(def) return engines.run(program, pile, #def.bodies, def.steps, every) end
end)
for _, def in ipairs(scenes) do
  print(def.name)
  def.steps = math.ceil(def.seconds / dt / every) * every
  engines.write(pile, def.bodies, { dt = dt, substeps = 4, gravity = gravity, friction = def.friction or 0.5 })
  for _, run in ipairs(runs) do
    local name, ms, _, _, frames = run(def)
    if not name then error("an engine failed", 0) end
    print(("  %-14s %8.3f ms  %s"):format(name, ms, def.seam and tripped(def, frames) or fallen(def, frames)))
  end
end
os.remove(pile)
