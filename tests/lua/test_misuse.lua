-- SPDX-License-Identifier: MIT
-- No call with any arguments ends the process, whatever is closed and whatever
-- is passed for what: each gives values, or nil with one line, or an error.
local duet = require "duet"
local facts = require "facts"

local seed = tonumber(os.getenv "DUET_TEST_SEED" or 1)
print("DUET_TEST_SEED=" .. seed)
math.randomseed(seed)

local paper = facts.root .. "/lua/scenes/paper.lua"

local function make_objects()
  local pair = assert(duet.device_pair())
  local scene = assert(duet.scene(paper, { n = 40, world = 5 }))
  local world = assert(pair:world(scene))
  local motion = assert(pair:motion(scene:poses()))
  return {
    pair, scene, world, motion, scene:poses(), scene:reference(), assert(world:step()), assert(motion:advance()),
    assert(world:map_poses(2)), assert(duet.search()), assert(world:online { keep = false }), duet.poses(2),
    duet.bounds(2), duet.pairs(2), duet.bodies(2), duet.states(40), assert(motion:contacts()),
  }
end

local plain <const> = {
  -1, 0, 1, 2, 3.5, 0 / 0, 1 / 0, 1e308, 2 ^ 53, math.mininteger, math.maxinteger, "", "x", "A", "own", "hash",
  ("long"):rep(200), "\0\1\2", true, false, {}, { 1, 2 }, { {} }, { { 1 } }, { a = 1 }, { share = 0.5 },
  { plan = { share = 2 } }, { plan = {} }, { dims = 2 }, { dims = 9 }, { strategy = "fig12" }, { launches = 2 ^ 32 },
  { n = 3 }, { wants = { "gravity" } }, { gravity = { 1 } }, { substeps = 2 ^ 31 }, { variants = { "x" } },
  { keep = false, variants = { "none" } }, setmetatable({}, { __index = function() error "no" end }), print,
  coroutine.create(print), io.stdout, paper,
}

-- These write files, or take long with good arguments.
local left_out <const> = { save = true, tune = true }

local function methods_of(object)
  local metatable = debug.getmetatable(object)
  local _, methods = debug.getupvalue(metatable.__index, 2)
  local names = {}
  for name in pairs(methods) do
    if not left_out[name] then names[#names + 1] = name end
  end
  table.sort(names)
  return names, methods
end

local function any(objects)
  if math.random() < 0.3 then return objects[math.random(#objects)] end
  return plain[math.random(#plain)]
end

local function any_arguments(objects)
  local arguments = {}
  for i = 1, math.random(0, 4) do arguments[i] = any(objects) end
  return table.unpack(arguments, 1, 4)
end

local function check(ok, value, message, status)
  if not ok then
    assert(type(value) == "string" or type(value) == "table", "an error of type " .. type(value))
  elseif value == nil and message ~= nil then
    assert(type(message) == "string" and not message:find "\n", message)
    assert(type(status) == "string" and status ~= "OK" and status ~= "UNKNOWN", status)
  end
end

facts.holds("functions take any arguments", function()
  local names = {}
  for name, value in pairs(duet) do
    if type(value) == "function" then names[#names + 1] = name end
  end
  table.sort(names)
  local objects = make_objects()
  for _ = 1, 600 do check(pcall(duet[names[math.random(#names)]], any_arguments(objects))) end
end)

facts.holds("methods take any arguments, on any object, open or closed", function()
  for _ = 1, 6 do
    local objects = make_objects()
    for _ = 1, 500 do
      local names, methods = methods_of(objects[math.random(#objects)])
      local name = names[math.random(#names)]
      if name ~= "close" or math.random() < 0.2 then
        local self = math.random() < 0.8 and objects[math.random(#objects)] or any(objects)
        check(pcall(methods[name], self, any_arguments(objects)))
      end
      if math.random() < 0.02 then collectgarbage() end
    end
  end
end)

-- A metatable could close what was checked a moment before.
facts.holds("no metatable of a table is asked", function()
  local asked = {}
  local function trap(t)
    return setmetatable(t, { __index = function(_, key) asked[#asked + 1] = key end })
  end
  local pair <close> = assert(duet.device_pair())
  local scene <close> = assert(duet.scene(paper, trap { n = 40 }))
  local world <close> = assert(pair:world(scene, trap {}))
  local motion <close> = assert(pair:motion(scene, trap {}))
  assert(pair:motion(scene:poses(), nil, trap {})):close()
  assert(world:online(trap { keep = false })):close()
  assert(motion:set_def(trap {}))
  assert(motion:user_data(trap { 0, 1 }))
  assert(pair:tune(scene, trap { keep = false, budget_trials = 80, modes = { "own" }, variants = { "simd" },
    level = "certified" }))
  facts.equal(table.concat(asked, " "), "")
end)

facts.holds("a string with a NUL is refused and not cut", function()
  local pair <close> = assert(duet.device_pair())
  facts.raises("a string without NUL", duet.scene, paper .. "\0x")
  facts.raises("n is 40\\x00x; expected a number", duet.scene, paper, { n = "40\0x" })
  facts.raises("n is a table; expected a number", duet.scene, paper, { n = {} })
  facts.raises("names with values", duet.scene, paper, { ["n\0"] = 1 })
  facts.raises("a string without NUL", duet.device_pair, "pocl:0\0x")
  facts.raises("level is 'sat6\\x00'; expected one of", pair.world, pair, { level = "sat6\0" })
end)

facts.holds("fields and operators of any object are values or errors", function()
  local objects = make_objects()
  for _ = 1, 2 do
    for _, object in ipairs(objects) do
      for _, key in ipairs(plain) do
        check(pcall(function() return object[key] end))
        check(pcall(function() object[key] = 1 end))
      end
      check(pcall(function() return #object end))
      check(pcall(tostring, object))
      check(pcall(function() return object .. object end))
      check(pcall(object.close, object))
    end
  end
end)

facts.finish()
