-- SPDX-License-Identifier: MIT
-- Clusters as a script has them: every rank of an MPI job runs this, and each compares what all
-- of them find with the plain C reference.
local duet = require "duet"
local facts = require "facts"

local n <const> = 200
local seed = tonumber(os.getenv "DUET_TEST_SEED") or 20261122
math.randomseed(seed)

-- An object's place at a step is known by its number alone; now and then it goes far.
local starts = {}
for i = 1, n do
  starts[i] = { math.random() * 6, math.random() * 6, math.random() * 6,
    0.1 + math.random() / 2, 0.1 + math.random() / 2, 0.1 + math.random() / 2 }
end
local function pose(i, step)
  local s, far = starts[i], (i + step) % 17 == 0 and 9 or 0
  local turn = i * 0.7 + step * 0.1
  return s[1] + 0.3 * math.sin(step + i) + far, s[2] + 0.2 * math.cos(step * i), s[3],
    s[4], s[5], s[6], 0, 0, math.sin(turn), math.cos(turn)
end

local function expected(step)
  local rows = {}
  for i = 1, n do rows[i] = { pose(i, step) } end
  local scene <close> = assert(duet.scene(duet.poses(rows)))
  return assert(scene:reference())
end

-- Hands each rank every other object, or third ...: none is where it belongs.
local function fill(cluster, first_id)
  local ids, rows = {}, {}
  for i = 1 + cluster.rank, n, cluster.rank_count do
    ids[#ids + 1], rows[#rows + 1] = first_id + i - 1, { pose(i, 0) }
  end
  return assert(cluster:set_objects(duet.ids(ids), #rows > 0 and rows or duet.poses(0)))
end

facts.holds("objects that the script moves have the reference's pairs at each step", function()
  local cluster <close> = assert(duet.cluster { plain = true })
  fill(cluster, 0)
  for step = 0, 49 do
    local owned, ids = assert(cluster:map_owned())
    for place, id in ids:each() do owned:set(place, pose(id + 1, step)) end
    local result, pairs <close> = assert(cluster:step()), expected(step)
    assert(#pairs > 20)
    facts.equal(result.objects, n)
    facts.equal(result.pairs, #pairs)
    facts.equal(result.hash, pairs:hash())
  end
end)

facts.holds("clusters come one after the other, and ids have 64 bits", function()
  local cluster <close> = assert(duet.cluster { plain = true, parts = 2 })
  fill(cluster, 1 << 40)
  assert(cluster:step())
  local known, found = {}, 0
  local pairs <close> = expected(0)
  for _, a, b in pairs:each() do known[a << 32 | b] = true end
  for _, a, b in assert(cluster:own_pairs()):each() do
    found = found + 1
    assert(known[(a - (1 << 40)) << 32 | (b - (1 << 40))])
  end
  local ranks, all = assert(cluster:ranks()), 0
  facts.equal(#ranks, cluster.rank_count)
  facts.equal(found, ranks[cluster.rank + 1].pairs)
  for _, rank in ipairs(ranks) do all = all + rank.pairs end
  facts.equal(all, #pairs)
end)

-- A sphere for each box, which is written anew at each step.
facts.holds("spheres that the script moves have the reference's pairs at each step", function()
  local cluster <close> = assert(duet.cluster { plain = true, shape = "spheres" })
  local function sphere(i, step)
    local x, y, z, radius = pose(i, step)
    return x, y, z, radius
  end
  local ids, rows = {}, {}
  for i = 1 + cluster.rank, n, cluster.rank_count do ids[#ids + 1], rows[#rows + 1] = i - 1, { sphere(i, 0) } end
  assert(cluster:set_objects(ids, #rows > 0 and rows or duet.spheres(0)))
  for step = 0, 9 do
    local owned, own = assert(cluster:map_owned())
    for place, id in own:each() do owned:set(place, sphere(id + 1, step)) end
    local all = {}
    for i = 1, n do all[i] = { sphere(i, step) } end
    local scene <close> = assert(duet.scene(duet.spheres(all)))
    local pairs <close> = assert(scene:reference())
    assert(#pairs > 20)
    facts.equal(assert(cluster:step()).hash, pairs:hash())
  end
  facts.raises("duet.spheres expected", cluster.set_objects, cluster, ids, duet.poses(#ids))
end)

facts.holds("owned objects are rows of the kind that the scene has", function()
  local cluster <close> = assert(duet.cluster { plain = true })
  local path = "cluster_lua_" .. cluster.rank_count .. ".lua"
  if cluster.rank == 0 then
    local file <close> = assert(io.open(path, "w"))
    file:write("for i = 1, 9 do add(1e9 + i, 0, 0, 1, 1, 1, 0, 0, 0, 1) end return { dims = 3, origin = 'cell' }")
  end
  for _, of in ipairs { { "rounded", 44 }, { "spheres", 16 }, { "grains", 40 }, { path, 56 } } do
    assert(cluster:load_scene(of[1], of[1] ~= path and { n = 9 } or nil))
    local result = assert(cluster:step())
    local owned, ids = assert(cluster:map_owned())
    local rows, names = owned:bytes(), ids:bytes()
    facts.equal(#rows, of[2] * #ids)
    facts.equal(result.objects, 9)
    assert(cluster:set_objects(names, rows))
    facts.equal(assert(cluster:step()).hash, result.hash)
  end
  if cluster.rank == 0 then os.remove(path) end
end)

facts.holds("devices of a cluster and of the script find the same pairs", function()
  local settings = { n = 300, world = 12 }
  local cluster <close> = assert(duet.cluster())
  facts.equal(cluster:scene(), nil)
  facts.equal(assert(cluster:load_scene("paper", settings)).n, 300)
  assert(cluster:load_profile(os.tmpname() .. ".none"))
  assert(cluster:set_plan { share = 0.5 })
  assert(cluster:set_level "double")
  local pair <close> = assert(duet.device_pair())
  local scene <close> = assert(duet.scene("paper", settings))
  local world <close> = assert(pair:world(scene))
  local one = assert(world:step())
  assert(#one > 50)
  facts.equal(assert(cluster:step()).hash, one:hash())
end)

facts.holds("bodies move as those of one motion, and a script that begins again knows its step", function()
  local name = "cluster_lua_motion_" .. os.getenv "OMPI_COMM_WORLD_SIZE"
  local path, saved, n_ranks = name .. ".lua", name .. ".motion", 0
  local file = assert(io.open(path, "w"))
  file:write [[
    for i = 0, 19 do add { centre = { i % 5, i // 5, 1 + i % 3 }, half_extents = { 0.45, 0.45, 0.4 } } end
    return { dims = 3, gravity = { 0, 0, -9.81 }, boundary = "walls", hit_speed = 0.5,
      world = { lower = { -1, -1, 0 }, upper = { 6, 5, 20 } }, wants = { "contact_response", "events" } } ]]
  file:close()
  local events, hits = 0, 0
  local cluster <close> = assert(duet.cluster())
  n_ranks = cluster.rank_count
  assert(cluster:begin_motion(path))
  facts.equal(cluster:motion_step(), 0)
  for step = 1, 40 do
    local result = assert(cluster:advance())
    events, hits = events + #result.events, hits + #result.hits
    for _, e in ipairs(result.events) do assert(e.a < e.b and (e.begins == true or e.begins == false)) end
    for _, h in ipairs(result.hits) do assert(h.speed > 0.5 and #h.point == 3 and #h.normal == 3) end
    assert(n_ranks > 1 or step < 30 or result.stays[1].a < result.stays[1].b)
  end
  assert(cluster:save_motion(saved))
  assert(cluster:begin_motion(path, nil, saved))
  facts.equal(cluster:motion_step(), 40)
  local last = assert(cluster:advance())
  local pair <close> = assert(duet.device_pair())
  local scene <close> = assert(duet.scene(path))
  local motion <close> = assert(pair:motion(scene))
  local all_events, all_hits, result = 0, 0, nil
  for step = 1, 41 do
    result = assert(motion:advance())
    if step <= 40 then all_events, all_hits = all_events + result.n_events, all_hits + result.n_hits end
  end
  facts.equal(assert(cluster:state_hash()), motion:hash())
  assert(all_events > 10 and all_hits > 10)
  assert(events <= all_events and hits <= all_hits and last.step == 41)
  if n_ranks == 1 then
    facts.equal(events, all_events)
    facts.equal(hits, all_hits)
  end
  if cluster.rank == 0 then os.remove(path); os.remove(saved) end
end)

facts.holds("commands to bodies over ranks are one motion's", function()
  local path <const>, n <const> = "commanded.lua", 40
  local file = assert(io.open(path, "w"))
  file:write [[
    for i = 0, 39 do
      add { centre = { i % 8, i // 8, 0.5 }, half_extents = { 0.45, 0.45, 0.45 }, mass = i == 20 and 0 or 1 }
    end
    return { dims = 3, gravity = { 0, 0, -9.81 }, body = { friction = 0.5 }, boundary = "walls",
             world = { lower = { -2, -2, 0 }, upper = { 10, 10, 9 } },
             wants = { "contact_response", "forces", "sleep" } }
  ]]
  file:close()
  local function command(world)
    local ids = assert(world:add_bodies({ { 3.5, 2, 2, 0.4, 0.4, 0.4, 0, 0, 0, 1 } }))
    facts.equal(#ids, 1)
    assert(world:remove_bodies { first = 3, n = 2 })
    assert(world:set_poses(7, { { 0, 4, 3, 0.4, 0.4, 0.4, 0, 0, 0, 1 } }))
    assert(world:set_bodies(9, "velocity", { { 2, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0, false, false } }))
    assert(world:apply_impulses(11, { { 0, 0, 4, 0.1, 0, 0 } }))
    assert(world:apply_forces(12, { { 0, 30, 0, 0, 0, 1 } }))
    assert(world:set_targets(20, { { 4, 2.3, 1, 0, 0, 0, 1 } }))
    assert(world:disable_bodies(30))
    assert(world:sleep_bodies(31))
    assert(world:wake_bodies(31))
    assert(world:set_def { gravity = { 1, 0, -9.81 } })
    assert(world:set_user_data({ 5, 6 }, { 55, 66 }))
    facts.equal(assert(world:user_data { 6, 5 }):get(0), 66)
    facts.refused("BAD_ARGUMENT", "body 0 of 1: the body with id 3 was removed", world.wake_bodies, world, 3)
    facts.refused("BAD_ARGUMENT", "there is no body 90", world.remove_bodies, world, 90)
    facts.raises("'masss' is no field", world.set_bodies, world, 9, "masss", { { 1 } })
    for _ = 1, 20 do assert(world:advance()) end
    assert(world:enable_bodies(30))
    assert(world:advance())
  end
  local cluster <close> = assert(duet.cluster())
  facts.refused("BAD_ARGUMENT", "expected duet_cluster_begin_motion first", cluster.wake_bodies, cluster, 3)
  assert(cluster:begin_motion(path))
  command(cluster)
  local pair <close> = assert(duet.device_pair())
  local scene <close> = assert(duet.scene(path))
  local motion <close> = assert(pair:motion(scene))
  command(motion)
  facts.equal(assert(cluster:state_hash()), motion:hash())
  facts.equal(#motion:ids(), n + 1)
  if cluster.rank == 0 then os.remove(path) end
end)

facts.holds("the file of pairs is that of the reference", function()
  local cluster <close> = assert(duet.cluster { plain = true })
  fill(cluster, 0)
  local path = "cluster_lua_" .. cluster.rank_count .. ".npy"
  assert(cluster:step())
  assert(cluster:save_pairs(path, true))
  local pairs <close> = expected(0)
  local rows = {}
  for _, a, b in pairs:each() do rows[#rows + 1] = { a, b } end
  table.sort(rows, function(p, q) return p[1] < q[1] or p[1] == q[1] and p[2] < q[2] end)
  facts.equal(facts.read_file(path):sub(129), duet.pairs64(rows):bytes())
  assert(cluster:step()) -- on all, before the file goes
  if cluster.rank == 0 then os.remove(path) end
end)

facts.holds("views hold until the next call, and nothing is taken that is none", function()
  local cluster <close> = assert(duet.cluster { plain = true })
  fill(cluster, 0)
  local owned, ids = assert(cluster:map_owned())
  facts.raises("cannot be changed", ids.set, ids, 0, 7)
  facts.refused("BAD_ARGUMENT", "no pairs were found", cluster.own_pairs, cluster)
  assert(cluster:step())
  facts.raises("its owner has given back", owned.get, owned, 0)
  local first = assert(cluster:own_pairs())
  assert(cluster:step())
  facts.raises("its owner has given back", first.bytes, first)
  local last = assert(cluster:own_pairs())
  fill(cluster, 0)
  facts.raises("its owner has given back", last.bytes, last)
  facts.raises("has no field 'plane'", duet.cluster, { plane = true })
  facts.raises("pair is a table; expected a string", duet.cluster, { pair = {} })
  facts.raises("as many objects as there are ids", cluster.set_objects, cluster, { 1 }, duet.poses(2))
  facts.refused("BAD_ARGUMENT", "parts is 0", duet.cluster, { plain = true, parts = 0 })
  facts.refused("BAD_ARGUMENT", "papr: no such file or scene", cluster.load_scene, cluster, "papr")
  local closed = assert(duet.cluster { plain = true })
  closed:close()
  closed:close()
  facts.raises("the cluster is closed", closed.step, closed)
end)

facts.holds("a rank that fails alone ends the others' calls, and none waits for it", function()
  local ok, message = pcall(function()
    local cluster <close> = assert(duet.cluster { plain = true })
    fill(cluster, 0)
    if cluster.rank == cluster.rank_count - 1 then error "of its own" end
    while true do assert(cluster:step()) end
  end)
  assert(not ok)
  assert(message:find "of its own" or message:find "another rank makes another call", message)
end)

facts.holds("what is there is what lua/api.lua lists", function()
  local cluster <close> = assert(duet.cluster { plain = true })
  assert(cluster:load_scene("paper", { n = 20 }))
  local moving <close> = assert(duet.cluster())
  assert(moving:begin_motion("falling", { n = 20 }))
  local objects = {
    Cluster = cluster, ClusterResult = assert(cluster:step()), ClusterRank = assert(cluster:ranks())[1],
    ClusterMotionResult = assert(moving:advance()),
  }
  local names = {}
  for _, row in ipairs(dofile(facts.root .. "/lua/api.lua").names) do
    local class, field = row[1]:match "^duet%.(%u%w*)%.([%w_]+)$"
    names[(class or "") .. "." .. (field or "")] = true
    if objects[class] then assert(objects[class][field] ~= nil, row[1]) end
  end
  for class, object in pairs(objects) do
    for field in pairs(class == "Cluster" and {} or object) do assert(names[class .. "." .. field], field) end
  end
end)

facts.finish()
