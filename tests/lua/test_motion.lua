-- SPDX-License-Identifier: MIT
-- Objects that move, as a script has them.
local duet = require "duet"
local facts = require "facts"

local equal, holds, raises, refused = facts.equal, facts.holds, facts.raises, facts.refused
local pair <close> = assert(duet.device_pair())

-- One unit cube that falls, and a floor that does not move.
local poses = duet.poses {
  { 0, 0, 2, 0.5, 0.5, 0.5, 0, 0, 0, 1 },
  { 0, 0, -1, 5, 5, 1, 0, 0, 0, 1 },
}
local mask <const> = 0xffffffff
local bodies = duet.bodies {
  { 0, 0, 0, 0, 0, 0, 1, 0, 0.5, 1, mask, 0, false, false },
  { 0, 0, 0, 0, 0, 0, 0, 0, 0.5, 1, mask, 0, false, false },
}
local falling <const> = { gravity = { 0, 0, -10 }, wants = { "contact_response", "events" }, hit_speed = 1 }

holds("what is not said about a body is its default", function()
  local body = { duet.bodies(1):get(0) }
  equal(#body, 19)
  equal(body[7], 1) -- mass
  equal(body[11], mask)
  equal(body[12], 0) -- radius
  equal(body[13], false)
  equal(body[14], false)
  for i = 15, 19 do equal(body[i], 0) end -- rolling resistance, surface velocity, material
end)

holds("a row of a body may end behind sensor", function()
  local set = duet.bodies(1)
  set:set(0, 1, 0, 0, 0, 0, 0, 2, 0, 0.5, 1, mask, 0, false, false)
  local body = { set:get(0) }
  equal(body[7], 2)
  for i = 15, 19 do equal(body[i], 0) end
  raises("13 numbers, and a row has 19", set.set, set, 0, 1, 0, 0, 0, 0, 0, 2, 0, 0.5, 1, mask, 0, false)
end)

-- The call that makes a motion of a cube on a ground.
local function on_ground(shape, ground)
  local cube <const> = { { 0, 0, 0.75, 0.5, 0.5, 0.5, 0, 0, 0, 1 } }
  local smooth <const> = { { 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, mask, 0, false, false } }
  local def <const> = { gravity = { 0, 0, -10 }, wants = { "contact_response" }, [shape] = ground }
  return pair.motion, pair, cube, smooth, def
end

-- The ground leans by 0.1 along x.
local function slides_on(shape, ground)
  local make <const>, self, poses, bodies, def = on_ground(shape, ground)
  local motion <close> = assert(make(self, poses, bodies, def))
  for _ = 1, 60 do assert(motion:advance()) end
  local x, _, z = assert(motion:read()):get(0)
  local slope <const> = 0.1 / (1 + 0.1 ^ 2) -- sine times cosine
  equal(math.abs(x - 10 / 2 * slope) < 0.05, true)
  equal(math.abs(z - (0.5 * math.sqrt(1.01) - 0.1 * x)) < 0.01, true)
end

holds("a def has a ground of heights", function()
  local function with(heights) return on_ground("heights", heights) end
  slides_on("heights", { nx = 2, ny = 2, spacing = 40, origin = { -20, -20, 0 }, values = { 2, -2, 2, -2 } })
  raises("heights is 3; expected a table of nx, ny", with(3))
  raises("heights has no field 'value'; its fields are nx, ny", with { nx = 2, ny = 2, value = {} })
  raises("heights: values must be nx times ny numbers", with { nx = 2, ny = 2, values = { 1, 2, 3 } })
  raises("heights: values must be finite", with { nx = 2, ny = 2, values = { 1, 2, 3, 0 / 0 } })
  raises("heights: values must be finite", with { nx = 2, ny = 2, values = { 1, 2, 3, "4" } })
  raises("heights: material is 16; expected", with { nx = 2, ny = 2, values = { 1, 2, 3, 4 }, material = 16 })
end)

holds("a def has a mesh", function()
  local function with(mesh) return on_ground("mesh", mesh) end
  slides_on("mesh", { vertices = { -20, -20, 2, 20, -20, -2, -20, 20, 2, 20, 20, -2 }, triangles = { 0, 1, 3, 0, 3, 2 } })
  raises("mesh is 3; expected a table of file, scale", with(3))
  raises("mesh has no field 'vertex'; its fields are", with { vertex = {} })
  raises("mesh: vertices is a list of 2; expected a list", with { vertices = { 1, 2 }, triangles = { 0, 1, 2 } })
  raises("mesh: none.stl: ", with { file = "none.stl" })
end)

-- Both slide at 4 m/s on a floor of material 1: mu g t is 0.1 (a pair) and 0.2 (min) of it.
holds("bodies name materials of a table", function()
  local function slider(material) return { 4, 0, 0, 0, 0, 0, 1, 0, 9, 1, mask, 0, false, false, 0, 0, 0, 0, material } end
  local def = {
    gravity = { 0, 0, -10 }, dt = 0.01,
    materials = { { friction = 0.5 }, { friction = 0.2, friction_rule = "min" }, { friction = 0.9 } },
    material_pairs = { { 3, 1, friction = 0.1 } },
  }
  local floor = { 0, 0, 0, 0, 0, 0, 0, 0, 9, 1, mask, 0, false, false, 0, 0, 0, 0, 1 }
  local boxes = { { 0, 3, 0.5, 0.5, 0.5, 0.5, 0, 0, 0, 1 }, { 0, -3, 0.5, 0.5, 0.5, 0.5, 0, 0, 0, 1 }, { 0, 0, -1, 50, 50, 1, 0, 0, 0, 1 } }
  local motion <close> = assert(pair:motion(boxes, { slider(2), slider(3), floor }, def))
  for _ = 1, 100 do assert(motion:advance()) end
  local states = assert(motion:read())
  for i, friction in ipairs { 0.2, 0.1 } do
    local speed = select(8, states:get(i - 1))
    equal(math.abs(speed - (4 - 10 * friction)) < 0.02, true)
  end
  local function with(field, value) return pair.motion, pair, boxes, nil, { [field] = value } end
  raises("materials, row 1: friction_rule is 'mean'; expected one of average, geometric_mean, min, product, max",
    with("materials", { { friction_rule = "mean" } }))
  raises("material_pairs, row 1: expected two of the 0 materials by their numbers",
    with("material_pairs", { { 1, 1 } }))
  raises("materials is 3; expected a list of at most 15 materials", with("materials", 3))
end)

holds("a script acts between steps", function()
  local seen = {}
  local function lift(step, motion)
    seen[#seen + 1] = step
    if step == 3 then assert(motion:apply_impulses(0, { 0, 0, 5, 0, 0, 0 })) end
  end
  local motion <close> = assert(pair:motion(poses, bodies, {
    gravity = { 0, 0, -10 }, wants = { "contact_response" }, script = lift,
  }))
  for _ = 1, 4 do assert(motion:advance()) end
  equal(motion:step(), 4)
  equal(table.concat(seen, " "), "1 2 3 4")
  local states = assert(motion:read())
  equal(select(10, states:get(0)) > 4, true) -- velocity z
  raises("expected a function of the step and the motion", pair.motion, pair, poses, bodies, { script = 3 })
  local again <close> = assert(pair:motion(poses, bodies, { script = function(_, m) m:advance() end }))
  raises("its script is running", again.advance, again)
  local broken <close> = assert(pair:motion(poses, bodies, { script = function() error "no more" end }))
  raises("no more", broken.advance, broken)
  equal(broken:step(), 0)
end)

holds("a step has two halves, and nothing goes between them", function()
  local calls = 0
  local def <const> = { gravity = { 0, 0, -10 }, wants = { "contact_response" } }
  local motion <close> = assert(pair:motion(poses, bodies, {
    gravity = def.gravity, wants = def.wants, script = function() calls = calls + 1 end,
  }))
  local whole <close> = assert(pair:motion(poses, bodies, def))
  local before = assert(motion:advance())
  assert(motion:advance_begin())
  equal(calls, 2)
  local function busy(call, ...) refused("BAD_ARGUMENT", "a step of the motion is under way", call, motion, ...) end
  busy(motion.advance)
  busy(motion.hash)
  busy(motion.apply_impulses, 0, { 0, 0, 5, 0, 0, 0 })
  raises("the motion went on", function() return before.step end)
  equal(motion:plan(), nil)
  equal(motion:step(), 1)
  equal(assert(motion:advance_end()).step, 2)
  refused("BAD_ARGUMENT", "no step is under way", motion.advance_end, motion)
  for _ = 1, 2 do assert(whole:advance()) end
  equal(motion:hash(), whole:hash())
end)

holds("recorded commands give the same hash", function()
  local path <const> = os.tmpname()
  local motion <close> = assert(pair:motion(poses, bodies, falling))
  local again <close> = assert(pair:motion(poses, bodies, falling))
  assert(motion:record())
  assert(motion:apply_impulses(0, { 1, 0, 0, 0, 0, 0 }))
  for _ = 1, 5 do assert(motion:advance()) end
  assert(motion:save_recording(path))
  local replay <close> = assert(duet.replay(path))
  equal(replay:info().steps, 5)
  equal(replay:info().commands, 1)
  for k = 1, 5 do equal(assert(replay:advance(again)).step, k) end
  equal(replay:info().steps_done, 5)
  equal(again:hash(), motion:hash())
  local done, message = replay:advance(again)
  equal(done, nil)
  assert(message:find("steps are done", 1, true), message)
  os.remove(path)
end)

holds("a cube falls, and comes to rest on the floor", function()
  local motion <close> = assert(pair:motion(poses, bodies, falling))
  equal(#motion, 2)
  equal(motion:plan().share, pair:plan().share)
  local begun, hits, stays = {}, 0, 0
  for _ = 1, 90 do
    local result = assert(motion:advance())
    for a, b, x, y, z, nx, ny, nz, speed, impulse in result:hits() do
      assert(a == 0 and b == 1 and nz == -1 and speed > 4 and impulse > 0 and math.abs(z) < 0.1)
      hits = hits + 1
    end
    for a, b in result:stays() do stays = stays + a + b end
    assert(result.n_hits <= 1 and result.n_stays <= 1)
    for a, b, begins in result:events() do
      if begins then begun[a .. " " .. b] = true end
    end
  end
  assert(begun["0 1"] and hits == 1 and stays > 10)
  local _, _, z = assert(motion:read()):get(0)
  assert(math.abs(z - 0.5) < 0.02, z)
  local a, b, _, _, normal_z, n = assert(motion:contacts()):get(0)
  assert(a == 0 and b == 1 and normal_z == -1 and n == 4)
  assert(motion:energy().kinetic < 1e-3)
end)

holds("states are read and written in place", function()
  local motion <close> = assert(pair:motion(poses, bodies, falling))
  local rows = assert(motion:map_states("centres", "read", 1))
  equal(#rows, 1)
  equal(select(3, rows:get(0)), -1.0)
  raises("cannot be changed", rows.set, rows, 0, 0, 0, 0, 0)
  refused("BAD_ARGUMENT", "are mapped; expected duet_motion_unmap_states", motion.advance, motion)
  assert(motion:unmap_states "centres")
  raises("given back", rows.get, rows, 0)
  local velocities = assert(motion:map_states("velocities", "write"))
  velocities:set(0, 3, 0, 0, 0)
  assert(motion:unmap_states "velocities")
  assert(motion:advance())
  local x = assert(motion:read()):get(0)
  assert(math.abs(x - 0.05) < 1e-4, x)
  refused("BAD_ARGUMENT", "are not mapped", motion.unmap_states, motion, "velocities")
  raises("invalid option", motion.map_states, motion, "colours", "read")
end)

holds("states are read of some bodies, of those that moved, and between two steps", function()
  local motion <close> = assert(pair:motion(poses, bodies, falling))
  local ids, states = assert(motion:moved())
  assert(#ids == 2 and #states == 2)
  local before = assert(motion:read())
  assert(motion:advance())
  ids, states = assert(motion:moved())
  assert(#ids == 1 and ids:get(0) == 0)
  local after = assert(motion:read())
  equal(table.concat({ states:get(0) }, " "), table.concat({ after:get(0) }, " "))
  equal(table.concat({ assert(motion:read_of { 1, 0 }):get(1) }, " "), table.concat({ after:get(0) }, " "))
  local _, _, z = duet.states_between(before, after, 0.5):get(0)
  local _, _, from = before:get(0)
  local _, _, to = after:get(0)
  assert(math.abs(z - (from + to) / 2) < 1e-12)
  local none, why = motion:read_of { 7 }
  assert(not none and why == "place 7, in row 0; expected one below 2", why)
end)

holds("a delta says which pairs began, ended and stay", function()
  local delta <close> = assert(duet.pair_delta())
  local begun, ended, stays = delta:update { { 3, 4 }, { 0, 2 } }
  assert(#begun == 2 and #ended == 0 and #stays == 0)
  begun, ended, stays = delta:update { { 4, 3 }, { 1, 2 } }
  assert(#begun == 1 and #ended == 1 and #stays == 1)
  assert(begun:get(0) == 1 and ended:get(0) == 0 and stays:get(0) == 3)
end)

holds("a motion that was saved goes on bit for bit", function()
  local path = os.tmpname()
  local motion <close> = assert(pair:motion(poses, bodies, falling))
  for _ = 1, 10 do assert(motion:advance()) end
  assert(motion:save(path))
  for _ = 1, 10 do assert(motion:advance()) end
  local again <close> = assert(pair:motion(poses, bodies, falling))
  assert(again:load(path))
  for _ = 1, 10 do assert(again:advance()) end
  equal(motion:hash(), again:hash())
  os.remove(path)
end)

holds("only the effects run that the objects or the def call for", function()
  local still <close> = assert(pair:motion(poses))
  local moving <close> = assert(pair:motion(poses, bodies, falling))
  local function has(motion, name)
    return (" " .. table.concat(motion:effects(), " ") .. " "):find(" " .. name .. " ", 1, true) ~= nil
  end
  equal(has(still, "gravity"), false)
  equal(has(moving, "gravity"), true)
  local lines = moving:explain()
  equal(#lines, #duet.effects() + 1)
  equal(lines[#lines].name, "origin")
  equal(lines[#lines].active, false)
end)

holds("a scene that says how its objects move can be moved", function()
  local scene <close> = assert(duet.scene(facts.root .. "/lua/scenes/falling.lua", { n = 20 }))
  equal(#scene:bodies(), #scene)
  local motion <close> = assert(pair:motion(scene, { substeps = 2 }))
  equal(#motion, #scene)
  assert(motion:advance())
  local bounds <close> = assert(duet.scene(duet.bounds(1), 3))
  raises("bounds do not move", pair.motion, pair, bounds)
end)

holds("states can be read into an array that is there", function()
  local motion <close> = assert(pair:motion(poses, bodies, falling))
  local states = duet.states(2)
  equal(motion:read(states), states)
  equal(select(3, states:get(0)), 2)
  raises("an array of #motion states", motion.read, motion, duet.states(3))
end)

holds("a motion refuses what makes no sense", function()
  raises("a motion has no field 'gravitation'", pair.motion, pair, poses, nil, { gravitation = 1 })
  raises("wants has 'magic', which is no effect; docs/effects.md and duet.effects() list them", pair.motion, pair, poses, nil, { wants = { "magic" } })
  raises("'sphere'; expected one of none, walls, periodic", pair.motion, pair, poses, nil, { boundary = "sphere" })
  raises("as many bodies as poses", pair.motion, pair, poses, duet.bodies(1))
  raises("column 13: 1, not true or false", duet.bodies, { { 0, 0, 0, 0, 0, 0, 1, 0, 0.5, 1, mask, 0, 1, false } })
  raises("column 14: 1, not true or false", duet.bodies, { { 0, 0, 0, 0, 0, 0, 1, 0, 0.5, 1, mask, 0, true, 1 } })
  raises("column 10: -1, not a whole number", duet.bodies, { { 0, 0, 0, 0, 0, 0, 1, 0, 0.5, -1, mask, 0, false, false } })
  refused("BAD_ARGUMENT", "substeps is 1001", pair.motion, pair, poses, nil, { substeps = 1001 })
  refused("BAD_OBJECT", "", pair.motion, pair, { 0, 0, 0, -1, 1, 1, 0, 0, 0, 1 })
end)

holds("what is closed is refused", function()
  local motion = assert(pair:motion(poses, bodies, falling))
  local first = assert(motion:advance())
  local second = assert(motion:advance())
  raises("the motion went on", function() return first.time end)
  motion:close()
  motion:close()
  raises("the motion went on", second.events, second)
  raises("the motion is closed", motion.advance, motion)
end)

facts.finish()

holds("bodies come and go, and commands are the same words", function()
  local motion <close> = assert(pair:motion(poses, bodies,
    { gravity = { 0, 0, -10 }, wants = { "contact_response", "sleep", "forces" } }))
  for _ = 1, 3 do assert(motion:advance()) end
  local ids = assert(motion:add_bodies { { 3, 0, 4, 0.5, 0.5, 0.5, 0, 0, 0, 1 }, { -3, 0, 4, 0.5, 0.5, 0.5, 0, 0, 0, 1 } })
  equal(#ids, 2)
  equal(ids:get(1), 3)
  assert(motion:set_user_data(ids, { 7, 8 }))
  equal(assert(motion:user_data(3)):get(0), 8)
  assert(motion:set_user_data(3, { math.mininteger | 5 })) -- all 64 bits
  equal(assert(motion:user_data(3)):get(0), math.mininteger | 5)
  assert(motion:set_user_data(3, { 8 }))
  local still = duet.bodies(2)
  still:set(0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 1, false)
  assert(motion:set_bodies(ids, { "velocity" }, still))
  equal(select(8, assert(motion:read()):get(2)), 1)
  assert(motion:apply_forces({ first = 2, n = 2 }, { { 0, 0, 10, 0, 0, 0 }, { 0, 0, 10, 0, 0, 0 } }))
  assert(motion:apply_impulses(2, { -1, 0, 0, 0, 0, 0 }))
  assert(motion:advance())
  local _, _, z, _, _, _, _, vx = assert(motion:read()):get(2)
  assert(math.abs(z - 4) < 1e-5 and vx == 0)
  assert(motion:set_targets(1, { 0, 0, -0.9, 0, 0, 0, 1 }))
  assert(motion:set_poses(0, { { 0, 0, 5, 0.5, 0.5, 0.5, 0, 0, 0, 1 } }))
  assert(motion:advance())
  assert(motion:set_def { gravity = { 0, 0, 10 } })
  equal(motion:def().gravity[3], 10)
  assert(motion:disable_bodies(0))
  assert(motion:enable_bodies(0))
  assert(motion:sleep_bodies { 0, 2 })
  equal(#assert(motion:asleep()), #motion)
  assert(motion:wake_bodies { 0, 2 })
  assert(motion:remove_bodies(ids))
  equal(motion:has_body(3), false)
  equal(assert(motion:ids()):get(3), duet.NO_BODY)
  refused("BAD_ARGUMENT", "id 3 was removed", motion.wake_bodies, motion, 3)
  raises("no field that can be set", function() motion:set_bodies(0, "colour", duet.bodies(1)) end)
  raises("as many rows as bodies", function() motion:set_poses({ 0, 1 }, duet.poses(1)) end)
  assert(motion:advance())
end)
