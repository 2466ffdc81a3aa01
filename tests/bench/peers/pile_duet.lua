-- SPDX-License-Identifier: MIT
-- The pile of piles.lua in Duet, as the programs beside this file run it in another engine:
--
--     duet lua --trust tests/bench/peers/pile_duet.lua N STATES STEPS EVERY [THREADS]
--
-- N boxes of the scene `falling`. The whole CPU works; THREADS only says how many units it must have, which
-- POCL_CPU_MAX_CU_COUNT sets. STATES and the line that is printed are those of pile.h.
local duet = require "duet"

local n, path, steps, every, threads = table.unpack(arg)
if not every then error("give N STATES STEPS EVERY [THREADS]", 0) end
n, steps, every, threads = tonumber(n), tonumber(steps), tonumber(every), tonumber(threads)

local def = { dt = 1 / 60, substeps = 4 }
-- Bodies below 0.05 m/s may sleep, as in Box3D.
local function pile_of(count)
  return assert(duet.scene("falling", { n = count, restitution = 0, sleep_speed = 0.05 }))
end
local scene = pile_of(n)
local device = assert(duet.device_pair { a = "cpu", b = "cpu" })
if threads and device:device("A").units ~= threads then
  error(("the CPU has %d units, not %d"):format(device:device("A").units, threads), 0)
end

local function write_states(file, motion)
  local at, sizes, awake = assert(motion:read()), scene:poses(), 0
  for i = 0, n - 1 do
    local x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz = at:get(i)
    local _, _, _, hx, hy, hz = sizes:get(i)
    file:write(("%.9g "):rep(16):format(x, y, z, hx, hy, hz, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz), "\n")
    if vx ~= 0 or vy ~= 0 or vz ~= 0 or wx ~= 0 or wy ~= 0 or wz ~= 0 then awake = awake + 1 end
  end
  return awake
end

local function warm(small_or_large, count)
  local motion <close> = assert(device:motion(small_or_large, def))
  for _ = 1, count do assert(motion:advance()) end
end

warm(pile_of(100), 300) -- kernels are built before the clock runs: a pile that comes to rest needs all of them,
warm(scene, 1) -- and those that search pairs depend on the number of boxes
local motion <close> = assert(device:motion(scene, def))
local file = assert(io.open(path, "w"))
local spent, passed, awake = 0, 0, 0
for step = 1, steps do
  local begun = os.clock()
  local result = assert(motion:advance())
  spent, passed = spent + os.clock() - begun, passed + result.total_ms
  if step % every == 0 or step == steps then awake = write_states(file, motion) end
end
assert(file:close())
print(("Duet %s\t%.4f\t%.4f\t%d"):format(duet.version, spent * 1e3 / steps, passed / steps, awake))
