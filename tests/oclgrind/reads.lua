-- SPDX-License-Identifier: MIT
-- What a motion is asked, and the contacts of a still world, on a B of the caller's choice:
-- prints all numbers, bit for bit.
local duet = require "duet"
local dims, device = math.tointeger(arg[1]), arg[2]
local pair <close> = assert(duet.device_pair("pocl:0," .. device))

local function tell(rows)
  for _, n in ipairs { rows:get(0) } do io.write(("%a "):format(n)) end
  print(#rows)
end

local up = dims == 3 and { 0, 0, 1 } or { 0, 1, 0 }
local poses = duet.poses(40)
for i = 0, 39 do
  local high = i * 0.9
  poses:set(i, up[1] * high, up[2] * high, up[3] * high, 0.5, 0.5, 0.5, 0, 0, 0.1 * (i % 5), 1)
end
local motion <close> = assert(pair:motion(poses, nil, { dims = dims, wants = { "contact_response" }, plan = { share = 0 },
  gravity = { -10 * up[1], -10 * up[2], -10 * up[3] } }))
assert(motion:advance())
tell(assert(motion:read_of { 7, 3, 39 }))
assert(motion:moved())
assert(motion:advance())
local _, moved = assert(motion:moved())
tell(moved)

local query <close> = assert(pair:contact_query { dims = dims, share = 0 })
local pairs_of = duet.pairs(39)
for i = 0, 38 do pairs_of:set(i, i, i + 1) end
tell(assert(query:run(poses, pairs_of)))

local tree <close> = assert(pair:tree { dims = dims, share = 0 })
assert(tree:set_motion(motion))
local box_query <close> = assert(tree:box_query { level = "aabb" })
tell(assert(box_query:run(poses)))

-- A body that sleeps deep in others is pushed out, and within a skin only what commands altered is searched.
for i = 0, 39 do poses:set(i, up[1] * i * 0.9, up[2] * i * 0.9, up[3] * i * 0.9, 0.5, 0.5, 0.5, 0, 0, 0, 1) end
local row <close> = assert(pair:motion(poses, nil, { dims = dims, wants = { "contact_response", "sleep" }, plan = { share = 0 },
  skin = 0.3 }))
local all = {}
for i = 0, 39 do all[i + 1] = i end
assert(row:sleep_bodies(all))
for _ = 1, 3 do assert(row:advance()) end
assert(row:remove_bodies { 20 })
assert(row:advance())
tell(assert(row:read_of { 0, 19, 39 }))

-- A body that comes to sleepers wakes the first, and that the next.
local still, coming = { 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, false, false }, { 6, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, false, false }
local bodies = {}
for i = 0, 39 do
  poses:set(i, i < 3 and 1.01 * i or 1.5 * i, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1)
  bodies[i + 1] = still
end
poses:set(39, -1.3, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1)
bodies[40] = coming
local sleepers <close> = assert(pair:motion(poses, duet.bodies(bodies), { dims = dims,
  wants = { "contact_response", "sleep" }, plan = { share = 0 } }))
table.remove(all)
assert(sleepers:sleep_bodies(all))
for _ = 1, 6 do assert(sleepers:advance()) end
tell(assert(sleepers:read_of { 0, 1, 39 }))
