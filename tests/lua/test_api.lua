-- SPDX-License-Identifier: MIT
-- The list of all names, the module, the C headers and the editors'
-- definitions say the same.
local duet = require "duet"
local facts = require "facts"

local api = dofile(facts.root .. "/lua/api.lua")

-- The names that a header declares with DUET_API.
local function add_c_names(path, names)
  local text = facts.read_file(path):gsub("//[^\n]*", "")
  for declaration in text:gmatch "\nDUET_API([^;]*);" do
    names[declaration:match "([%w_]+)%s*%("] = path
  end
end

local function c_names()
  local names = {}
  local headers <close> = assert(io.popen("cd '" .. facts.root .. "' && ls " ..
    "runtime/duet.h */duet_*.h"))
  for header in headers:lines() do add_c_names(facts.root .. "/" .. header, names) end
  return names
end

local function partners()
  local names = {}
  for _, row in ipairs(api.names) do
    for _, c in ipairs(type(row.c) == "table" and row.c or { row.c }) do names[c] = row[1] end
  end
  for by, list in pairs(api.others) do
    for _, c in ipairs(list) do names[c] = by end
  end
  return names
end

facts.holds("every name of the C API has a partner in Lua", function()
  local known = partners()
  for name, path in pairs(c_names()) do
    assert(known[name], path .. ": " .. name .. " has no row with it in lua/api.lua")
  end
end)

facts.holds("the list names nothing that C lacks", function()
  local known = c_names()
  for name, by in pairs(partners()) do
    assert(known[name], by .. " stands for " .. name .. ", which no header declares")
  end
end)

local function in_list(name)
  for _, row in ipairs(api.names) do
    if row[1] == name then return row end
  end
  error(name .. " is not in lua/api.lua", 2)
end

facts.holds("what the module has is in the list", function()
  for name in pairs(duet) do in_list("duet." .. name) end
end)

-- "duet.DevicePair" -> the methods of "duet.device_pair"
local function methods_of(class)
  local name = class:gsub("^duet%.", ""):gsub("(%l)(%u)", "%1_%2"):lower()
  local metatable = debug.getregistry()["duet." .. name]
  if not metatable then return nil end
  local _, methods = debug.getupvalue(metatable.__index, 2)
  return methods
end

facts.holds("what an object can do is in the list", function()
  for _, class in ipairs(api.classes) do
    for name in pairs(methods_of(class[1]) or {}) do in_list(class[1] .. ":" .. name) end
  end
end)

facts.holds("every function of the list is there", function()
  for _, row in ipairs(api.names) do
    local class, method = row[1]:match "^(duet%.%u%w*):([%w_]+)$"
    local name = row[1]:match "^duet%.(%l[%w_]*)$"
    if class then assert(methods_of(class)[method], row[1]) end
    if name then assert(duet[name] ~= nil, row[1]) end
  end
end)

local function check_fields(class, object)
  for _, row in ipairs(api.names) do
    local field = row[1]:match("^duet%." .. class .. "%.([%w_]+)$")
    if field then assert(object[field] ~= nil, row[1] .. " is nil") end
  end
  if type(object) == "table" then
    for field in pairs(object) do in_list("duet." .. class .. "." .. field) end
  end
end

facts.holds("every field of the list is there, and no other", function()
  local pair <close> = assert(duet.device_pair())
  local scene <close> = assert(duet.scene(facts.root .. "/lua/scenes/paper.lua", { n = 50, world = 9 }))
  local world <close> = assert(pair:world(scene))
  local result = assert(world:step())
  check_fields("Device", duet.devices()[1])
  check_fields("Plan", pair:plan())
  check_fields("Profile", assert(world:load_profile("no/such/profiles.db")))
  check_fields("Scene", scene)
  check_fields("Result", result)
  check_fields("Stage", result:stages()[1])
  check_fields("Profile", assert(world:load_profile(os.tmpname() .. ".none")))
  local motion <close> = assert(pair:motion(scene:poses(), nil, { gravity = { 0, 0, -9.81 } }))
  check_fields("MotionResult", assert(motion:advance()))
  check_fields("Energy", assert(motion:energy()))
  check_fields("Effect", motion:explain()[1])
  check_fields("Kernel", assert(duet.kernels())[1])
  check_fields("Source", assert(duet.source "hash"))
  check_fields("Level", duet.levels()[1])
  check_fields("Strategy", duet.strategies()[1])
  local query <close> = assert(pair:query())
  local _, tested = assert(query:run(scene:poses()))
  check_fields("PairQueryResult", tested)
  local tree <close> = assert(assert(pair:tree { share = 0 }):set_objects(scene:poses()))
  local casting <close> = assert(tree:ray_query { normals = true })
  local _, cast = assert(casting:run { { 0, 0, 0, 1, 0, 0, 1 } })
  check_fields("RayQueryResult", cast)
  assert(tree:set_motion(motion))
  assert(tree:set_share(0.5))
  facts.raises("a share from 0 to 1", tree.set_share, tree, 2)
  facts.raises("duet.motion expected", tree.set_motion, tree, tree)
  facts.raises("table expected", tree.set_mesh, tree, "drum.stl")
  facts.raises("mesh: none.stl: ", tree.set_mesh, tree, { file = "none.stl" })
  local touching <close> = assert(pair:contact_query())
  local _, touched = assert(touching:run(scene:poses(), result:copy()))
  check_fields("ContactQueryResult", touched)
  local testing <close> = assert(tree:box_query())
  local _, joined = assert(testing:run(scene:poses()))
  check_fields("BoxQueryResult", joined)
  local none = assert(testing:run_itself(duet.filters(#scene:poses())))
  facts.equal(#none, 0)
  facts.refused("BAD_ARGUMENT", "1 filters; expected one for each of the tree's", testing.run_itself, testing, { { 1, 1 } })
  local asking <close> = assert(tree:point_query { nearest = 2 })
  local _, asked = assert(asking:run { { 0, 0, 0 } })
  check_fields("PointQueryResult", asked)
  local moving <close> = assert(tree:sweep_query { wants = "every" })
  local _, moved = assert(moving:run { { 0, 0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 0, 0, 1 } })
  check_fields("SweepQueryResult", moved)
  local path = os.tmpname()
  os.remove(path)
  assert(pair:tune(scene, { store = path, repeats = 1, variants = { "auto" }, modes = { "own" } }))
  local stored = assert(duet.profiles(path))[1]
  check_fields("StoredProfile", stored)
  check_fields("StoredDevice", stored.a)
  check_fields("StoredTrial", assert(duet.profile_trials(stored.uid, path))[1])
  os.remove(path)
  check_fields("Tuning", assert(pair:tune(scene, { keep = false, repeats = 1, variants = { "auto" }, modes = { "own" } })))
end)

local widths <const> = { f = "f", d = "d", i = "i4", I = "I4", h = "h", Q = "I8", C = "B", B = "B" }

facts.holds("an array's row has the columns of the list, and they fill the C struct", function()
  for _, class in ipairs(api.classes) do
    if class.columns then
      local made <close> = duet[class[1]:match "^duet%.(%w+)$":gsub("(%l)(%u)", "%1_%2"):lower()](1)
      facts.equal(#{ made:get(0) }, #class.columns)
      local unused = #made:bytes() - ("!8" .. class.columns:gsub(".", widths)):packsize()
      assert(unused >= 0 and unused < 8, class[1]) -- a large pose ends with a word that is kept free
    end
  end
end)

facts.holds("a class that the list names is in it", function()
  local known = {}
  for _, class in ipairs(api.classes) do known[class[1]] = true end
  for _, row in ipairs(api.names) do
    local types = type(row[2]) == "table" and table.concat(row[2], " ") .. " " .. (row[3] or "") or row[2]
    for class in types:gmatch "duet%.%u%w*" do assert(known[class], row[1] .. ": " .. class) end
  end
end)

facts.holds("the editors' definitions are Lua, and name every function", function()
  local made <close> = assert(io.popen(("lua5.4 '%s/lua/define.lua' '%s/lua/api.lua'"):format(facts.root, facts.root)))
  local text = made:read "a"
  assert(load(text, "definitions"))
  for name, value in pairs(duet) do
    assert(type(value) ~= "function" or text:find("\nfunction duet." .. name .. "(", 1, true), name)
  end
end)

facts.finish()
