-- SPDX-License-Identifier: MIT
-- A kernel of the user's, run and tuned from Lua: what Lua computes itself comes out.
local duet = require "duet"
local facts = require "facts"

local folder = os.tmpname()
os.remove(folder)
assert(os.execute("mkdir " .. folder))

local function write(name, text)
  local file <close> = assert(io.open(folder .. "/" .. name, "w"))
  file:write(text)
end

write("blend.lua", [[
return {
  about = "test", params = { { "WG", values = { 1, 16 }, about = "group" } },
  args = { blend = "ulong first\nulong last\nfloat a\nint b\nconst float2 *x\nfloat2 *y\nuint *sum" },
  launch = function(p) return { group = p.WG, per_item = 1 } end,
}]])
write("blend.cl", [[
__kernel void blend(BLEND_ARGS)
{
    ulong i = first + get_global_id(0);
    if (i >= last)
        return;
    y[i] += a * x[i] + (float)b;
    atomic_add(&sum[i % 3], (uint)i);
}]])
write("blend.task.lua", [[
local p = parameters { n = 300 }
return {
  kernel = "blend", items = p.n, key = { n = p.n },
  args = {
    a = 2.0, b = 1, x = { "float2", p.n, access = "slice", init = "index" },
    y = { "float2", p.n, access = "in out slice" }, sum = { "uint", 3, access = "sum" },
  },
  reference = function(v)
    for i = 0, 2 * v.items - 1 do v.y[i] = v.y[i] + v.a * v.x[i] + v.b end
    for i = 0, v.items - 1 do v.sum[i % 3] = v.sum[i % 3] + i end
  end,
}]])
local path = folder .. "/blend.task.lua"

local pair <close> = assert(duet.device_pair())

facts.holds("numbers and arrays go in, and what the kernel wrote comes out", function()
  local task <close> = assert(pair:task(path, { n = 5 }))
  facts.equal(task:items(), 5)
  local x, y = {}, {}
  for i = 1, 10 do x[i], y[i] = i * i, 100 * i end
  for _, share in ipairs { 0, 0.375, 1 } do
    assert(assert(task:set("a", 3)):set("b", -7))
    assert(assert(task:set("x", x)):set("y", y))
    assert(task:set_plan { share = share })
    facts.equal(task:plan().share, share)
    for again = 1, 2 do
      local result = assert(task:run())
      assert(result.total_ms > 0 and #result.stages > 0 and #result.device_ms == 2)
      local found = assert(task:get "y")
      for i = 1, 10 do facts.equal(found[i], 100.0 * i + again * (3.0 * i * i - 7)) end
      local sum = assert(task:get "sum")
      facts.equal(table.concat(sum, " "), "3 5 2") -- 0 + 3, 1 + 4, 2
    end
  end
end)

facts.holds("arrays are also strings of bytes", function()
  local task <close> = assert(pair:task(path, { n = 2 }))
  local bytes = string.pack("ffff", 1, 2, 3, 4)
  assert(task:set("x", bytes))
  facts.equal(task:get("x", "bytes"), bytes)
  assert(task:run())
  facts.equal(task:get("y", "bytes"), string.pack("ffff", 3, 5, 7, 9))
end)

facts.holds("an online plan runs a task: the share moves, and what comes out stays right", function()
  local task <close> = assert(pair:task(path, { n = 4 }))
  local online <close> = assert(task:online { most_extra = 0.5 })
  assert(task:set("x", { 1, 2, 3, 4, 5, 6, 7, 8 }):set("y", { 0, 0, 0, 0, 0, 0, 0, 0 }))
  for run = 1, 60 do
    local result = assert(online:run())
    assert(result.total_ms > 0 and #result.stages > 0 and #result.device_ms == 2)
    local found = assert(task:get "y")
    for i = 1, 8 do facts.equal(found[i], run * (2.0 * i + 1)) end
  end
  facts.equal(math.type(online:tunings()), "integer")
  facts.raises("it follows a task: expected online:run()", online.step, online)
  facts.raises("it follows a task: expected online:run()", online.advance, online)
  facts.raises("keep", task.online, task, { keep = true })
  task:close()
  facts.raises("closed", online.run, online)
  facts.equal(online:close(), true)
  facts.raises("the online plan is closed", online.run, online)
end)

facts.holds("arguments are listed by name", function()
  local task <close> = assert(pair:task(path))
  local args = task:args()
  facts.equal(#args, 5)
  facts.equal(args[1].name, "a")
  facts.equal(args[1].elements, 0)
  facts.equal(args[5].name, "y")
  facts.equal(args[5].type, "float2")
  facts.equal(args[5].access, "in out slice")
  facts.equal(args[5].elements, 300)
  facts.equal(args[5].bytes, 8)
end)

facts.holds("a wrong argument is told", function()
  local task <close> = assert(pair:task(path, { n = 2 }))
  facts.raises("the task has no argument 'z'", task.set, task, "z", 1)
  facts.raises("3 numbers for elements of float2", task.set, task, "x", { 1, 2, 3 })
  facts.raises("number 2 is a table; expected one that float2 holds", task.set, task, "x", { 1, {}, 3, 4 })
  facts.raises("7 bytes for elements of 8", task.set, task, "x", "1234567")
  facts.refused("BAD_ARGUMENT", "x has 1 elements of float2; expected 2", task.set, task, "x", { 1, 2 })
  facts.refused("BAD_ARGUMENT", "b is 0.5; expected a number that int holds", task.set, task, "b", 0.5)
  facts.refused("BAD_ARGUMENT", "sum is only written", task.set, task, "sum", { 1, 2, 3 })
  facts.refused("BAD_ARGUMENT", "a is a number; expected an array", task.get, task, "a")
  facts.refused("BAD_ARGUMENT", "no parameter 'm'", pair.task, pair, path, { m = 2 })
  facts.refused("NOT_FOUND", "none.task.lua", pair.task, pair, folder .. "/none.task.lua")
  task:close()
  facts.raises("the task is closed", task.run, task)
end)

facts.holds("a task that was tuned runs by its plan", function()
  local store = folder .. "/profiles.db"
  local file <close> = assert(duet.task_file(path, { n = 300 }))
  local tuned = assert(pair:tune(file, { store = store, repeats = 1, budget_trials = 80 }))
  local task <close> = assert(pair:task(path, { n = 300 }))
  local before = task:plan()
  local profile = assert(task:load_profile(store))
  if tuned.unused == "" and tuned.uid ~= "" then
    facts.equal(profile.grade, "exact")
    facts.equal(task:plan().share, tuned.plan.share)
  else
    facts.equal(task:plan().share, before.share)
  end
  assert(task:run())
  local x, y = task:get "x", task:get "y"
  for i = 1, 600 do facts.equal(y[i], 2 * x[i] + 1) end
end)

os.execute("rm -r " .. folder)
facts.finish()
