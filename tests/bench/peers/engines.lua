-- SPDX-License-Identifier: MIT
-- Shared by piles.lua and stacks.lua: bodies written for the programs beside this file, and the programs run.
-- A body is { centre, half_extents, rotation, radius, mass, velocity }; pile.h has the format.
local engines = {}

local function row(...) return ("%.9g "):rep(select("#", ...)):format(...) .. "\n" end

-- `def` holds dt, substeps, gravity, friction, sleep, and lower and upper if there are walls.
function engines.write(path, bodies, def)
  local file = assert(io.open(path, "w"))
  local lower, upper = def.lower or { 0, 0, 0 }, def.upper or { 0, 0, 0 }
  file:write(("%d %d %.9g %.9g %.9g %d %d "):format(#bodies, def.substeps, def.dt, def.gravity, def.friction,
    def.sleep and 1 or 0, def.lower and 1 or 0), row(lower[1], lower[2], lower[3], upper[1], upper[2], upper[3]))
  for _, b in ipairs(bodies) do
    local c, h, q, v = b.centre, b.half_extents, b.rotation or { 0, 0, 0, 1 }, b.velocity or { 0, 0, 0 }
    file:write(row(c[1], c[2], c[3], h[1], h[2], h[3], q[1], q[2], q[3], q[4], b.radius or 0, b.mass,
      v[1], v[2], v[3]))
  end
  assert(file:close())
end

-- The engines that were built: those whose program is in `dir`.
function engines.built(dir)
  local found = {}
  for _, name in ipairs { "box3d", "jolt", "bullet" } do
    local path = ("%s/pile_%s"):format(dir, name)
    local file = io.open(path)
    if file then
      file:close()
      found[#found + 1] = path
    end
  end
  return found
end

-- Returns the engine's name, ms of processor time a step, bodies awake at the end, and for every `every`
-- steps, and the last, an array of rows: centre, half extents and quaternion of each body.
function engines.run(program, pile, n, steps, every)
  local states = os.tmpname()
  local out <close> = assert(io.popen(("%s %s %s %d %d"):format(program, pile, states, steps, every)))
  local name, ms, awake = (out:read "l" or ""):match "^(.*)\t(.*)\t(.*)$"
  if not name then error(program .. " told no time", 0) end
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
  return name, tonumber(ms), tonumber(awake), frames
end

return engines
