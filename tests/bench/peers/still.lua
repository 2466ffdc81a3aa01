-- SPDX-License-Identifier: MIT
-- A million boxes that stand still, in Duet and in other programs:
--
--     duet lua --trust tests/bench/peers/still.lua DIR N RUNS DEVICE PLATFORM
--
-- DIR holds still_bullet and still_embree (CMakeLists.txt beside this file); one that was not built is left out.
-- DEVICE is Duet's selector, PLATFORM a part of the name of its OpenCL platform; they are cpu and Portable. Times
-- are the least of RUNS, in ms: processor time on a CPU, which noise of other programs reaches least, and wall clock
-- on a GPU, for the objects lie on it then.
local duet = require "duet"
io.stdout:setvbuf "line" -- rows of a run that is stopped are not lost

local dir, n, runs, selector, platform = arg[1], arg[2] or 1000000, arg[3] or 5, arg[4] or "cpu", arg[5] or "Portable"
if not dir then error("give the folder of the other programs", 0) end
do
  local out <close> = assert(io.popen("realpath " .. dir))
  dir = out:read "l"
end
n, runs = tonumber(n) // 1 | 0, tonumber(runs) // 1 | 0
local on_cpu = selector:find "cpu" ~= nil

local side = 200 * (n / 1e6) ^ (1 / 3) -- crowded as a million in 200 x 200 x 200
local scene = assert(duet.scene("paper", { n = n, world = side }))
local device = assert(duet.device_pair { a = selector, b = selector })
local folder = os.tmpname()
os.remove(folder)
assert(os.execute("mkdir " .. folder))
local boxes_file, rays_file = folder .. "/boxes", folder .. "/rays"

local function write(path, rows)
  local file = assert(io.open(path, "wb"))
  file:write(rows:bytes())
  assert(file:close())
end

local function make_rays() -- each from somewhere in the world to somewhere else
  math.randomseed(1)
  local function at() return math.random() * side end
  local rays = duet.rays(n)
  for i = 0, n - 1 do
    local x, y, z = at(), at(), at()
    rays:set(i, x, y, z, at() - x, at() - y, at() - z, 1)
  end
  return rays
end

local function is_built(name)
  local file = io.open(dir .. "/" .. name)
  return file and file:close()
end

-- Numbers of the one line that a program prints last.
local function run(command)
  local out <close>, last = assert(io.popen(("cd %s && %s 2>&1"):format(folder, command))), nil
  for line in out:lines() do last = line end
  local numbers = {}
  for word in (last or ""):gmatch "%S+" do numbers[#numbers + 1] = tonumber(word) end
  if #numbers < 5 then error(command .. ": " .. tostring(last), 0) end
  return table.unpack(numbers)
end

local function least(work)
  local best, result = math.huge, work() -- kernels are built in the first
  for _ = 1, runs do
    local begun = os.clock()
    result = work()
    best = math.min(best, on_cpu and (os.clock() - begun) * 1e3 or result.total_ms)
  end
  return best, result
end

local rays = make_rays()
write(boxes_file, scene:poses())
write(rays_file, rays)

local function row(name, ms, what) print(("%-14s %9.2f  %s"):format(name, ms, what)) end

print(("%d boxes, %s, least of %d"):format(n, on_cpu and "ms of processor time" or "ms of wall clock", runs))
do
  local world <close> = assert(device:world(scene))
  local ms, result = least(function() return assert(world:step()) end)
  row("Duet " .. duet.version, ms, ("%d pairs that collide of %d candidates"):format(#result, result.candidates))
end
if is_built "still_bullet" then
  local wall, processor, sat_wall, sat_processor, candidates, pairs =
    run(("%s/still_bullet boxes %.9g %s %d"):format(dir, 3 ^ 0.5, platform, runs))
  row("Bullet3 OpenCL", on_cpu and processor or wall, ("grid: %d candidates"):format(candidates))
  row("", on_cpu and sat_processor or sat_wall, ("separating axes: %d pairs that collide"):format(pairs))
end
do
  local tree <close> = assert(device:tree())
  local tree_ms = least(function() return assert(tree:set_objects(scene:poses())) and { total_ms = 0 } end)
  local query <close> = assert(tree:ray_query { wants = "closest" })
  local hits
  local ms = least(function()
    local found, result = query:run(rays)
    hits = assert(found, result)
    return result
  end)
  local met = 0
  for _, _, id in hits:each() do met = met + (id ~= 0xffffffff and 1 or 0) end
  if on_cpu then row("Duet " .. duet.version, tree_ms, "tree") end
  row(on_cpu and "" or "Duet " .. duet.version, ms, ("%d rays, closest box: %d meet one"):format(n, met))
end
if on_cpu and is_built "still_embree" then
  local tree, candidates_ms, rays_ms, candidates, hits =
    run(("%s/still_embree boxes rays %d"):format(dir, runs))
  row("Embree 3", tree, "tree")
  row("", rays_ms, ("%d rays, closest box: %d meet one"):format(n, hits))
  row("", candidates_ms, ("%d candidates"):format(candidates))
end
os.execute("rm -r " .. folder)
