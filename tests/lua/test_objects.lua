-- SPDX-License-Identifier: MIT
-- Device pairs, scenes, worlds, results and arrays, as a script has them.
local duet = require "duet"
local facts = require "facts"

local equal, holds, raises, refused = facts.equal, facts.holds, facts.raises, facts.refused
local paper = facts.root .. "/lua/scenes/paper.lua"

local pair <close> = assert(duet.device_pair())
local scene <close> = assert(duet.scene(paper, { n = 2000, world = 20 }))
local expected = scene:reference():hash()

-- Two unit cubes that overlap and one that is far away.
local three = duet.poses {
  { 0, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1 },
  { 0.7, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1 },
  { 9, 9, 9, 0.5, 0.5, 0.5, 0, 0, 0, 1 },
}

holds("a string opens a pair as --pair does", function()
  local one <close> = assert(duet.device_pair "cpu")
  equal(one:device("A").selector, one:device("B").selector)
  equal(one:plan().share, 0)
  equal(one:check_cache(), true)
  refused("BAD_ARGUMENT", "expected two selectors", duet.device_pair, "cpu,")
end)

holds("any share and mode gives the reference's pairs", function()
  local world <close> = assert(pair:world(scene))
  for _, mode in ipairs(duet.modes()) do
    for _, share in ipairs { 0, 0.25, 1 } do
      assert(world:set_plan { share = share, mode = mode })
      equal(world:plan().share, share)
      equal(assert(world:step()):hash(), expected)
    end
  end
end)

holds("a level that misses none finds at least the reference's pairs", function()
  local world <close> = assert(pair:world(scene, { level = "aabb" }))
  local n = #scene:reference()
  local result = assert(world:step())
  equal(#result, result.candidates)
  assert(#result > n)
  for _, level in ipairs(duet.levels()) do
    assert(world:set_level(level.name))
    local found = #assert(world:step())
    assert(level.missed > 0 or found >= n, level.name)
    equal(found, #scene:reference(level.name))
  end
  raises("level is 'exact'; expected one of certified, aabb", world.set_level, world, "exact")
  raises("'exact'; expected one of certified, aabb", pair.world, pair, { level = "exact" })
end)

holds("all ways to read a result give the same pairs", function()
  local world <close> = assert(pair:world(scene, { plan = { share = 0.5 } }))
  local result = assert(world:step())
  local copy, n, bytes = result:copy(), 0, {}
  for a, b in result:pairs() do
    local pair_a, pair_b = result:pair(n)
    local copy_a, copy_b = copy:get(n)
    assert(a == pair_a and b == pair_b and a == copy_a and b == copy_b and a < b)
    n = n + 1
    bytes[n] = string.pack("<I4I4", a, b)
  end
  equal(n, #result)
  equal(n, #copy)
  equal(table.concat(bytes), copy:bytes())
  equal(copy:hash(), expected)
  equal(duet.pairs(copy:bytes()):hash(), expected)
end)

holds("iterating makes no garbage for a pair", function()
  local world <close> = assert(pair:world(scene))
  local result = assert(world:step())
  collectgarbage()
  collectgarbage "stop"
  local before, n = collectgarbage "count", 0
  for _ in result:pairs() do n = n + 1 end
  local after = collectgarbage "count"
  collectgarbage "restart"
  assert(n > 1000 and (after - before) * 1024 < 1000, after - before)
end)

holds("objects come as an array, as rows, as numbers, packed, or in the world's own memory", function()
  local world <close> = assert(pair:world { dims = 3 })
  local rows, numbers = {}, {}
  for place = 0, #three - 1 do
    rows[#rows + 1] = { three:get(place) }
    table.move(rows[#rows], 1, 10, #numbers + 1, numbers)
  end
  for _, given in ipairs { three, rows, numbers, three:bytes() } do
    assert(world:set_poses(given))
    local result = assert(world:step())
    equal(#result, 1)
    equal(table.concat({ result:pair(0) }, " "), "0 1")
  end
  local mapped = assert(world:map_poses(3))
  for place, row in ipairs(rows) do mapped:set(place - 1, table.unpack(row)) end
  equal(#assert(world:step()), 1)
end)

holds("a step has two halves, and nothing goes between them", function()
  local world <close> = assert(pair:world(scene))
  local expected = assert(world:step()):hash()
  assert(world:step_begin())
  equal(world:plan(), nil)
  local function busy(call, ...) refused("BAD_ARGUMENT", "a step of the world is under way", call, world, ...) end
  busy(world.step)
  busy(world.set_plan, { share = 0.5 })
  busy(world.set_poses, three)
  assert(tostring(world):find "a step is under way")
  equal(assert(world:step_end()):hash(), expected)
  refused("BAD_ARGUMENT", "no step is under way", world.step_end, world)
end)

holds("bounds and 2D work too", function()
  local world <close> = assert(pair:world { dims = 2, shape = "bounds" })
  assert(world:set_bounds { { 0, 0, 0, 1, 1, 0 }, { 1, 1, 0, 2, 2, 0 }, { 3, 3, 0, 4, 4, 0 } })
  local result = assert(world:step())
  equal(#result, 1) -- touching collides
  local mapped = assert(world:map_bounds(2))
  mapped:set(0, 0, 0, 0, 1, 1, 0)
  mapped:set(1, 5, 5, 0, 6, 6, 0)
  equal(#assert(world:step()), 0)
  local flat <close> = assert(duet.scene(duet.bounds { 0, 0, 0, 1, 1, 0 }, 2))
  equal(flat.dims, 2)
  equal(flat.shape, "bounds")
  equal(flat:poses(), nil)
  equal(flat:bounds():get(0), 0)
end)

holds("boxes in origin cells are asked about far away", function()
  local far <const> = 1000000000
  local tree <close> = assert(pair:tree { origin_edge = 0.5 })
  local boxes = duet.large_poses { { 0.25, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1, far, -far, 7 } }
  equal(select(11, boxes:get(0)), far)
  assert(tree:set_objects(boxes))
  local rays <close> = assert(tree:ray_query())
  local _, id, t = assert(rays:run { { 0, 0, 0, 1, 0, 0, 9, far - 4, -far, 7 } }):get(0)
  equal(id, 0)
  equal(t, 1.75)
  local points <close> = assert(tree:point_query { nearest = 1 })
  equal(select(3, assert(points:run { { 0, 0, 0, far, -far + 3, 7 } }):get(0)), 1)
  local sweeps <close> = assert(tree:sweep_query())
  equal(select(3, assert(sweeps:run { { 0, 0, 0, 0.25, 0.25, 0.25, 0, 0, 0, 1, far - 4, -far, 7, 1, 0, 0, 9 } }):get(0)), 1.5)
  local joined <close> = assert(tree:box_query())
  equal(#assert(joined:run { { 0, 0, 0, 1, 1, 1, 0, 0, 0, 1, far, -far, 8 }, { 0, 0, 0, 1, 1, 1, 0, 0, 0, 1, far, far, 8 } }), 1)
  assert(not pcall(rays.run, rays, duet.rays { { 0, 0, 0, 1, 0, 0, 9 } }))
  refused("BAD_ARGUMENT", "origin cells are for poses", pair.tree, pair, { shape = "spheres", origin_edge = 1 })
end)

holds("rounded boxes and spheres", function()
  local capsule = { 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.5 }
  local box = { 0, 2, 0, 1, 1, 1, 0, 0, 0, 1, 0.5 } -- touches it
  local rounded = duet.rounded_boxes { capsule, box }
  equal(rounded:collide(0, 1), true)
  equal(rounded:separation(0, 1), 0.0)
  equal(#rounded:bytes(), 2 * 44)
  local world <close> = assert(pair:world { shape = "rounded boxes" })
  assert(world:set_rounded_boxes(rounded))
  equal(#assert(world:step()), 1)
  local mapped = assert(world:map_rounded_boxes(2))
  mapped:set(0, table.unpack(capsule))
  box[11] = 0
  mapped:set(1, table.unpack(box))
  equal(#assert(world:step()), 0)
  local balls <close> = assert(pair:world { shape = "spheres" })
  assert(balls:set_spheres { { 0, 0, 0, 3 }, { 2, 3, 6, 4 }, { 9, 9, 9, 1 } })
  equal(#assert(balls:step()), 1) -- 7 from centre to centre
  equal(#assert(balls:map_spheres(1)), 1)
  refused("BAD_ARGUMENT", "made for spheres, not for poses", balls.map_poses, balls, 1)
  local tree <close> = assert(pair:tree { shape = "spheres" })
  assert(tree:set_objects { { 0, 0, 0, 1 }, { 5, 0, 0, 2 } })
  local rays <close> = assert(tree:ray_query())
  local _, id, t = assert(rays:run { { 5, 9, 0, 0, -1, 0, 100 } }):get(0)
  assert(id == 1 and t == 7)
  local normals <close> = assert(tree:ray_query { normals = true })
  local _, cast = assert(normals:run { { 5, 9, 0, 0, -1, 0, 100 }, { 9, 9, 9, 1, 0, 0, 1 } })
  equal(table.concat({ cast.normals:get(0) }, " "), "0.0 1.0 0.0")
  equal(table.concat({ cast.normals:get(1) }, " "), "0.0 0.0 0.0")
  refused("BAD_ARGUMENT", "normals with wants any", tree.ray_query, tree, { wants = "any", normals = true })
  local boxes <close> = assert(tree:box_query())
  equal(#assert(boxes:run { { 2, 0, 0, 1 }, { 0, 4, 0, 1 } }), 2)
  local sweeps <close> = assert(tree:sweep_query())
  local _, met, at = assert(sweeps:run { { 5, 9, 0, 1, 0, -2, 0, 100 } }):get(0)
  assert(met == 1 and at == 3)
  local cubes <close> = assert(pair:tree { shape = "rounded boxes" })
  assert(cubes:set_objects { { 5, 0, 0, 1, 1, 1, 0, 0, 0, 1, 0.5 } })
  local moved <close> = assert(cubes:sweep_query())
  local _, _, first = assert(moved:run { { 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.5, 1, 0, 0, math.huge } }):get(0)
  equal(first, 2)
  local contacts <close> = assert(pair:contact_query { shape = "spheres" })
  local _, _, x, _, _, points = assert(contacts:run({ { 0, 0, 0, 1 }, { 1.5, 0, 0, 1 } }, { { 0, 1 } })):get(0)
  assert(x == 1 and points == 1)
  local scene <close> = assert(duet.scene(duet.spheres { 0, 0, 0, 1, 2, 0, 0, 1 }))
  equal(scene.shape, "spheres")
  equal(scene:poses(), nil)
  equal(scene:bounds(), nil)
  equal(scene:rounded_boxes(), nil)
  equal(select(4, scene:spheres():get(1)), 1.0)
  equal(#scene:reference(), 1)
  local of_boxes <close> = assert(duet.scene(rounded))
  equal(of_boxes.shape, "rounded boxes")
  equal(select(11, of_boxes:rounded_boxes():get(0)), 0.5)
end)

holds("queries find what their filters can touch", function()
  local tree <close> = assert(pair:tree { share = 0 })
  assert(tree:set_objects { { 5, 0, 0, 1, 1, 1, 0, 0, 0, 1 }, { 9, 0, 0, 1, 1, 1, 0, 0, 0, 1 } })
  assert(tree:set_filters { { 1, 3 }, { 2, 1 } })
  local function found(kind, item, def)
    local query <close> = assert(tree[kind .. "_query"](tree, def))
    local hits <const> = assert(query:run { item })
    return #hits > 0 and select(2, hits:get(0)) or duet.NO_OBJECT
  end
  local items <const> = { ray = { 0, 0, 0, 1, 0, 0, 20 }, sweep = { 0, 0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 0, 0, 20 },
    box = { 7, 0, 0, 2, 1, 1, 0, 0, 0, 1 }, point = { 5, 0, 0 } }
  for kind, item in pairs(items) do
    local nearest <const> = kind == "point" and 1 or nil
    equal(found(kind, item, { filter = { 1, 1 }, nearest = nearest }), 0)
    equal(found(kind, item, { filter = { 1, 2 }, nearest = nearest }), 1)
    equal(found(kind, item, { filter = { 4, 3 }, nearest = nearest }), duet.NO_OBJECT)
  end
  raises("filter is a list of 1; expected { group, mask }", tree.ray_query, tree, { filter = { 1 } })
  raises("filter is -1; expected a whole number from 0", tree.ray_query, tree, { filter = { 1, -1 } })
  refused("BAD_ARGUMENT", "3 filters; expected one for each of the tree's 2 objects", tree.set_filters, tree,
    { { 1, 1 }, { 1, 1 }, { 1, 1 } })
end)

holds("a tree of a motion has its bodies, with radii or without", function()
  for _, radius in ipairs { 0, 0.25 } do
    local motion <close> = assert(pair:motion({ { 0, 0, 2, 0.5, 0.5, 0.5, 0, 0, 0, 1 } },
      { { 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1, radius, false, false } }))
    local tree <close> = assert(pair:tree(motion, { share = 0 }))
    local rays <close> = assert(tree:ray_query())
    equal(select(3, assert(rays:run { { 0, 0, 9, 0, 0, -1, 9 } }):get(0)), 6.5 - radius)
    refused("BAD_ARGUMENT", "the tree has 2", pair.tree, pair, motion, { dims = 2 })
  end
end)

holds("sizes apart from transforms have the same pairs", function()
  local world <close> = assert(pair:world { pose_form = "transforms" })
  local sizes = assert(world:map_sizes(#three))
  local transforms = assert(world:map_transforms(#three))
  for place, x, y, z, hx, hy, hz, qx, qy, qz, qw in three:each() do
    sizes:set(place, hx, hy, hz)
    transforms:set(place, x, y, z, qx, qy, qz, qw)
  end
  equal(table.concat({ assert(world:step()):pair(0) }, " "), "0 1")
  equal(select(7, duet.transforms(1):get(0)), 1.0)
  refused("BAD_ARGUMENT", "made for transforms, not for poses", world.map_poses, world, 1)
end)

holds("compact transforms have the pairs of their poses", function()
  local world <close> = assert(pair:world { pose_form = "compact" })
  local sizes = assert(world:map_sizes(#three))
  local transforms = assert(world:map_compact_transforms(#three))
  for place, x, y, z, hx, hy, hz in three:each() do
    sizes:set(place, hx, hy, hz)
    transforms:set(place, x, y, z, -32768, 0, 5, 32767)
  end
  equal(table.concat({ transforms:get(1) }, " ", 4), "-32768 0 5 32767")
  equal(#transforms:bytes(), 20 * #three)
  local ok, line = pcall(transforms.set, transforms, 0, 0, 0, 0, 0, 0, 0, 32768)
  equal(ok, false)
  assert(line:find("row 0, column 7: 32768, not a whole number from -32768 to 32767", 1, true), line)
  equal(table.concat({ assert(world:step()):pair(0) }, " "), "0 1")
  equal(select(7, duet.compact_transforms(1):get(0)), 1)
  assert(world:set_poses(three))
  equal(#assert(world:step()), 1)
end)

holds("objects in the order of their cells have the same pairs, by their new places", function()
  local world <close> = assert(pair:world { ordered = true, plan = { share = 0.5, mode = "slab" } })
  assert(world:set_poses { { three:get(2) }, { three:get(0) }, { three:get(1) } })
  equal(table.concat({ assert(world:step()):pair(0) }, " "), "1 2")
  local order = assert(world:order())
  equal(#order, 3)
  local sorted = duet.poses(3)
  for place, id in order:each() do sorted:set(place, three:get((id + 2) % 3)) end
  equal(order:get(2), 0) -- the object far away comes last
  assert(world:set_poses(sorted))
  equal(table.concat({ assert(world:step()):pair(0) }, " "), "0 1")
end)

holds("each gives every place once", function()
  local places = {}
  for place, x in three:each() do places[#places + 1] = place .. ":" .. x end
  equal(table.concat(places, " "), "0:0.0 1:" .. three:get(1) .. " 2:9.0")
end)

holds("the exact test of two boxes is there", function()
  equal(three:collide(0, 1), true)
  equal(three:collide(0, 2), false)
  assert(three:separation(0, 1) < 0 and three:separation(0, 2) > 7)
end)

-- ---------------------------------------------------------------- failures

holds("a failure is nil, one line and the status", function()
  refused("NOT_FOUND", "nowhere.lua", duet.scene, "nowhere.lua")
  refused("BAD_ARGUMENT", "nvidia:77", duet.device_pair, { a = "nvidia:77", b = "nvidia:77" })
  refused("BAD_ARGUMENT", "expected auto, simd, gpu or paper", pair.world, pair, { plan = { variant_a = "none" } })
  local bad = duet.poses { 0, 0, 0, 1, 1, 1, 0, 0, 0, 0 }
  refused("BAD_OBJECT", "object 0", duet.scene, bad, 3)
  local world <close> = assert(pair:world { dims = 3 })
  assert(world:set_poses(three))
  refused("BAD_ARGUMENT", "none", world.set_plan, world, { variant_b = "none" })
  equal(#assert(world:step()), 1)
end)

holds("a field that is not there is an error that lists those there are", function()
  raises("a device pair has no field 'A'; its fields are a, b, kernel_dir, cache_dir", duet.device_pair, { A = "x" })
  raises("a world has no field 'dim'", pair.world, pair, { dim = 3 })
  raises("a plan has no field 'ratio'", pair.world, pair, { plan = { ratio = 1 } })
  raises("duet.scene has no 'number'", function() return scene.number end)
end)

holds("a value of the wrong kind is an error that says what would be right", function()
  raises("share is 1.5; expected a part from 0 to 1", pair.world, pair, { plan = { share = 1.5 } })
  raises("share is -nan; expected", pair.world, pair, { plan = { share = 0 / 0 } })
  raises("'fast'; expected one of shared, own", pair.world, pair, { plan = { mode = "fast" } })
  raises("dims is -1; expected a whole number from 0", pair.world, pair, { dims = -1 })
  raises("rotated is 1; expected true or false", pair.world, pair, { rotated = 1 })
  raises("lower is 1; expected {", pair.world, pair, { lower = 1 })
  raises("both corners", pair.world, pair, { lower = { 0, 0, 0 } })
  raises("a is 1; expected a string", duet.device_pair, { a = 1 })
  raises("variant_a has 200 characters; expected at most 191", pair.world, pair, { plan = { variant_a = ("x"):rep(200) } })
  raises("duet.poses from 7 numbers: a row has 10", duet.poses, { 1, 2, 3, 4, 5, 6, 7 })
  raises("duet.poses from 3 bytes", duet.poses, "abc")
  raises("row 1: 2 numbers, and a row has 10", duet.poses, { { three:get(0) }, { 1, 2 } })
  raises("column 2: nil, not a number", function() three:set(0, 1, nil, 3, 4, 5, 6, 7, 8, 9, 10) end)
  raises("row 0, column 2: -2, not a whole number from 0", duet.pairs, { 1, -2 })
  raises("a count from 0", duet.poses, -1)
  raises("place 3 of 3 rows", three.get, three, 3)
  raises("place -1", three.get, three, -1)
  raises("cannot be changed", function() scene:poses():set(0, three:get(0)) end)
  raises("duet.poses expected", pair:world({ dims = 3 }).set_poses, pair:world { dims = 3 }, duet.bounds(1))
end)

holds("what is closed is refused, and closing again is nothing", function()
  local other = assert(duet.device_pair())
  local world = assert(other:world { dims = 3 })
  assert(world:set_poses(three))
  local result = assert(world:step())
  local mapped = assert(world:map_poses(1))
  other:close()
  other:close()
  raises("the device pair is closed", other.plan, other)
  equal(#assert(world:step()), 0) -- the devices stay while a world does
  raises("the world was stepped again", result.hash, result)
  result = assert(world:step())
  world:close()
  world:close()
  raises("the world is closed", world.step, world)
  raises("the result's world is closed", result.pair, result, 0)
  raises("the result's world is closed", function() return #result end)
  raises("given back", mapped.get, mapped, 0)
  local box = assert(duet.scene(three, 3))
  local view = box:poses()
  box:close()
  raises("the scene is closed", box.poses, box)
  raises("given back", view.get, view, 0)
  local array = duet.poses(2)
  array:close()
  raises("the array is closed", array.get, array, 0)
end)

holds("a loop over a result ends with an error where the world is stepped in it", function()
  local world <close> = assert(pair:world(scene))
  raises("the world was stepped again", function()
    for _ in assert(world:step()):pairs() do assert(world:step()) end
  end)
end)

holds("mapped memory is the script's until the next map, set or step", function()
  local world <close> = assert(pair:world { dims = 3 })
  local first = assert(world:map_poses(3))
  assert(world:map_poses(2))
  raises("given back", first.get, first, 0)
  local third = assert(world:map_poses(3))
  for place = 0, 2 do third:set(place, three:get(place)) end
  equal(#assert(world:step()), 1)
  raises("given back", third.set, third, 0, three:get(0)) -- it would not be sent
end)

holds("a method of one kind refuses an object of another", function()
  raises("duet.world expected", pair:world({ dims = 3 }).step, scene)
  raises("duet.device_pair expected", pair.world, scene)
  raises("duet.scene expected", scene.reference, pair)
  raises("duet.poses or another array expected", three.get, pair, 0)
end)

holds("children keep their parents, in any order of collection", function()
  for _ = 1, 3 do
    local result = (function()
      local own = assert(duet.device_pair())
      local world = assert(own:world { dims = 3 })
      assert(world:set_poses(three))
      return assert(world:step())
    end)()
    collectgarbage()
    collectgarbage()
    equal(#result, 1)
    result = nil -- luacheck: ignore
    collectgarbage()
  end
  local view = assert(duet.scene(three, 3)):poses()
  collectgarbage()
  equal(view:get(2), 9)
end)

holds("an object says what it is", function()
  local small = assert(duet.scene(paper, { n = 3, world = 5 }))
  assert(tostring(small):find("duet.scene { name = paper, dims = 3, ", 1, true))
  assert(tostring(small):find("upper = { 5.0, 5.0, 5.0 }", 1, true))
  small:close()
  equal(tostring(small), "duet.scene (closed)")
  equal(tostring(three), "duet.poses of 3 rows")
end)

facts.finish()
