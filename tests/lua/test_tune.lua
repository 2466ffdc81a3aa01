-- SPDX-License-Identifier: MIT
-- Searches for the share and whole tunings, from Lua.
local duet = require "duet"
local facts = require "facts"

local equal, holds, raises, refused = facts.equal, facts.holds, facts.raises, facts.refused
local pair <close> = assert(duet.device_pair())
local scene <close> = assert(duet.scene(facts.root .. "/lua/scenes/paper.lua", { n = 300, world = 11 }))

-- A quick tuning: one variant, one mode, one launch a trial.
local function quick(more)
  local def = { keep = false, repeats = 1, variants = { "auto" }, modes = { "own" } }
  for name, value in pairs(more or {}) do def[name] = value end
  return def
end

-- A is `ratio` times slower than B.
local function search_on(ratio, def)
  local search <close> = assert(duet.search(def))
  local path = {}
  for share in search.ask, search do
    local a, b = ratio * share, 1 - share
    assert(search:tell(share, math.max(a, b), a, b))
    path[#path + 1] = share
  end
  return search:pick(), path
end

holds("the paper's search goes the printed way", function()
  local pick, path = search_on(10, { strategy = "fig12", launches = 6 })
  equal(table.concat(path, " "), "1.0 0.0 0.5 0.25 0.125 0.0625")
  equal(pick, 0.0625)
end)

holds("a script of the experiments searches as a strategy does", function()
  local file <close> = assert(io.open(facts.root .. "/lua/experiments/bisect.lua"))
  local pick, path = search_on(3, { strategy = "lua", strategy_lua = file:read "a" })
  equal(table.concat(path, " "), "0.0 0.5 0.25")
  equal(pick, 0.25)
  refused("BAD_INPUT", "", duet.search, { strategy = "lua", strategy_lua = "return 1" })
end)

holds("balance finds the best share of any ratio", function()
  for _, ratio in ipairs { 0.1, 1, 3, 10, 40 } do
    local pick = search_on(ratio)
    local best = 1 / (1 + ratio)
    assert(math.abs(math.max(ratio * pick, 1 - pick) / (ratio * best) - 1) < 0.01, ratio)
  end
end)

holds("a search refuses what makes no sense", function()
  refused("BAD_ARGUMENT", "balance", duet.search, { strategy = "none" })
  raises("a search has no field 'name'", duet.search, { name = "fig12" })
  local search = assert(duet.search())
  raises("a part from 0 to 1", search.tell, search, 2, 1, 1, 1)
  raises("milliseconds from 0", search.tell, search, 0, -1, 1, 1)
  raises("milliseconds from 0", search.tell, search, 0, 0 / 0, 1, 1)
  search:close()
  raises("the search is closed", search.ask, search)
end)

holds("a tuning gives a plan that finds the reference's pairs", function()
  local stages = {}
  local found = assert(pair:tune(scene, quick { watch = function(progress)
    stages[#stages + 1] = progress.stage
    assert(progress.plan.mode == "own" and progress.launches >= 1)
  end }))
  assert(#stages > 0)
  equal(found.objects, 300)
  assert(found.gain_low <= found.gain and found.gain <= found.gain_high)
  local world <close> = assert(pair:world(scene, { plan = found.plan }))
  equal(assert(world:step()):hash(), scene:reference():hash())
end)

holds("a watcher can stop a tuning, and its error comes through", function()
  refused("INTERRUPTED", "", pair.tune, pair, scene, quick { watch = function() return false end })
  raises("enough of it", pair.tune, pair, scene, quick { watch = function() error "enough of it" end })
end)

holds("a strategy can be a Lua function, as text", function()
  local found = assert(pair:tune(scene, quick { strategy = "lua",
    strategy_lua = "return function(history) if #history < 3 then return #history / 2 end end" }))
  equal(found.verdict ~= "", true)
  refused("BAD_INPUT", "", pair.tune, pair, scene, quick { strategy = "lua", strategy_lua = "return 1" })
end)

holds("kernels are searched where it is asked for", function()
  local without = assert(pair:tune(scene, quick()))
  equal(without.kernels[1].configs + without.kernels[2].configs, 0)
  local found = assert(pair:tune(scene, quick { search = "clear", variants = { "simd" }, budget_trials = 80 }))
  for _, kernels in ipairs(found.kernels) do
    assert(kernels.tried <= kernels.configs and kernels.gain_low <= kernels.gain_high)
  end
  refused("BAD_ARGUMENT", "search 'abacus'", pair.tune, pair, scene, quick { search = "abacus" })
end)

holds("a tuning that is kept is known the next time, and a world takes its plan", function()
  local store = os.tmpname()
  os.remove(store)
  local first = assert(pair:tune(scene, quick { keep = true, store = store }))
  local second = assert(pair:tune(scene, quick { keep = true, store = store }))
  equal(first.known, false)
  assert(#first.uid == 32 and first.unused == "" and first.rounds >= 0)
  local grid = assert(pair:tune(scene, { store = store, repeats = 1, variants = { "auto" }, modes = { "own" },
    strategy = "lua", strategy_lua = "return function(history) if #history < 3 then return #history / 2 end end" }))
  assert(grid.known == false and grid.unused:find "without %-%-keep")
  equal(second.known, true)
  local world <close> = assert(pair:world(scene))
  equal(assert(world:load_profile(store)).plan.share, first.plan.share)
  for _, ending in ipairs { "", "-wal", "-shm" } do os.remove(store .. ending) end
end)

holds("queries are tuned by their kind, and a tree takes what is known of them", function()
  local store = os.tmpname()
  os.remove(store)
  local tree <close> = assert(pair:tree())
  assert(tree:set_objects(scene:poses()))
  for _, query in ipairs { "rays any", "boxes itself" } do
    local def = { store = store, query = query, items = 200, repeats = 1, budget_trials = 60 }
    local tuned = assert(pair:tune(scene, def))
    local items = query == "boxes itself" and 300 or 200
    equal(tuned.known, false)
    equal(assert(pair:tune(scene, def)).known, true)
    assert(tuned.true_pairs > 0)
    local profile = assert(tree:load_profile(query, items, store))
    equal(profile.grade, tuned.unused == "" and "exact" or "default")
    if tuned.unused == "" then equal(profile.plan.share, tuned.plan.share) end
    local kept = assert(duet.profiles(store, true))
    local found = false
    for _, one in ipairs(kept) do found = found or (one.query == query and one.items == items and one.objects == 300) end
    assert(found, query)
  end
  equal(assert(tree:load_profile("rays closest", 200, store)).grade, "default")
  local balls <close> = assert(duet.scene(duet.spheres { 0, 0, 0, 1, 2, 0, 0, 1, 4, 4, 4, 2, 1, 5, 2, 1 }))
  for query, hits in pairs { ["points nearest 3"] = 3 * 60, ["rays any"] = 60 } do
    local def = { keep = false, query = query, items = 60, repeats = 1, budget_trials = 43 }
    equal(assert(pair:tune(balls, def)).true_pairs, hits)
  end
  local path <const> = os.tmpname() .. ".csv"
  local file <close> = assert(io.open(path, "w"))
  for i = 1, 20 do file:write(("%.2f,5,%d,0.5,0.5,0.5,0,0,0,1\n"):format(1e8 + i * 0.25, -2e8)) end
  file:close()
  local far <close> = assert(duet.scene(path, { origin = "cell" }))
  os.remove(path)
  for query, hits in pairs { ["points nearest 3"] = 3 * 60, ["boxes itself"] = 19 + 18 + 17 + 16 } do
    local def = { keep = false, query = query, items = 60, repeats = 1, budget_trials = 43 }
    equal(assert(pair:tune(far, def)).true_pairs, hits)
  end
  for _, ending in ipairs { "", "-wal", "-shm" } do os.remove(store .. ending) end
  refused("BAD_ARGUMENT", "query 'rays both'", tree.load_profile, tree, "rays both", 1)
  refused("BAD_ARGUMENT", "a query has no variants; expected none", pair.tune, pair, scene, quick { query = "boxes" })
end)

holds("a motion is tuned by runs, goes on where it was stopped, and then has the same bits", function()
  local store = os.tmpname()
  os.remove(store)
  local falling <close> = assert(duet.scene(facts.root .. "/lua/scenes/falling.lua", { n = 30 }))
  local def = { store = store, steps = 3, search = "bodies", variants = { "auto" }, modes = { "own" },
    repeats = 1, budget_trials = 60 }
  local trials = 0
  def.watch = function() trials = trials + 1; return trials < 5 end
  refused("INTERRUPTED", "goes on from there", pair.tune, pair, falling, def)
  def.watch = function(progress) assert(progress.trials > 5 or progress.remembered) end
  local tuned = assert(pair:tune(falling, def))
  assert(tuned.resumed and not tuned.known and tuned.step_ms > 0)
  equal(assert(pair:tune(falling, def)).known, true)
  local function hash_with(choose)
    local motion <close> = assert(pair:motion(falling))
    choose(motion)
    for _ = 1, 10 do assert(motion:advance()) end
    return assert(motion:hash())
  end
  local plain = hash_with(function() end)
  equal(hash_with(function(motion)
    local profile = assert(motion:load_profile(store))
    equal(profile.grade, tuned.unused == "" and "exact" or "default")
    if tuned.unused == "" then
      equal(profile.plan.variant_b, tuned.plan.variant_b)
      equal(motion:plan().share, tuned.plan.share)
    end
  end), plain)
  equal(hash_with(function(motion)
    local settings = "auto bodies.WG=128 bodies.PER_ITEM=1"
    assert(motion:set_plan { variant_b = settings, share = 0 })
    equal(motion:plan().variant_b, settings)
    refused("BAD_ARGUMENT", "WG=5", motion.set_plan, motion, { variant_b = "auto bodies.WG=5" })
    equal(motion:plan().variant_b, settings)
  end), plain)
  for _, ending in ipairs { "", "-wal", "-shm" } do os.remove(store .. ending) end
  refused("BAD_ARGUMENT", "expected 2 or more", pair.tune, pair, falling, { keep = false, steps = 1 })
  refused("BAD_ARGUMENT", "steps of a motion have no query", pair.tune, pair, falling,
    { keep = false, steps = 5, query = "boxes" })
  refused("BAD_ARGUMENT", "has no profile", pair.tune, pair, scene, { keep = false, steps = 5 })
end)

holds("an online plan gives the same pairs, and outlives no world", function()
  local world <close> = assert(pair:world(scene, { plan = { share = 0.5 } }))
  local online <close> = assert(world:online { keep = false })
  for _ = 1, 5 do
    assert(world:set_scene(scene))
    equal(assert(online:step()):hash(), scene:reference():hash())
  end
  equal(math.type(online:tunings()), "integer")
  refused("BAD_ARGUMENT", "variant 'no'", world.online, world, { variants = { "no such" } })
  raises("modes is 'both'; expected one of shared, own, slab", world.online, world, { modes = { "both" } })
  raises("an online plan steps the world", world.close, world)
  equal(online:close(), true)
  equal(online:close(), true)
  raises("the online plan is closed", online.step, online)
end)

holds("an online plan follows a motion, and its script runs", function()
  local bodies, steps = assert(duet.scene("falling", { n = 200 })), 0
  local plain <close> = assert(pair:motion(bodies, {}))
  local motion <close> = assert(pair:motion(bodies, { script = function() steps = steps + 1 end }))
  local online <close> = assert(motion:online { most_extra = 0.2 })
  for _ = 1, 40 do
    assert(plain:advance())
    equal(assert(online:advance()).step, motion:step())
  end
  equal(steps, 40)
  equal(motion:hash(), plain:hash())
  raises("it follows a motion", online.step, online)
  raises("keep", motion.online, motion, { keep = true })
  motion:close()
  raises("closed", online.advance, online)
  equal(online:close(), true)
end)

holds("a tuning refuses what makes no sense", function()
  refused("BAD_ARGUMENT", "42 trials ends before a verdict; expected at least 43", pair.tune, pair, scene,
    quick { budget_trials = 42 })
  raises("keep is 1; expected true or false", pair.tune, pair, scene, { keep = 1 })
  raises("a tuning has no field 'budget'", pair.tune, pair, scene, { budget = 1 })
  raises("modes is 'fast'; expected one of shared, own, slab", pair.tune, pair, scene, { modes = { "fast" } })
  raises("modes is 'default'; expected one of shared, own, slab", pair.tune, pair, scene, { modes = { "own", "default" } })
  raises("level is 'sat7'; expected one of certified, aabb", pair.tune, pair, scene, { level = "sat7" })
  raises("level is 'sat7'; expected one of certified, aabb", pair.tune, pair, scene, { level = { "sat6", "sat7" } })
  raises("a list of 1 to 32 names", pair.tune, pair, scene, { variants = {} })
  raises("a list of names", pair.tune, pair, scene, { variants = { 1 } })
  refused("BAD_ARGUMENT", "wait_seconds is nan", pair.tune, pair, scene, quick { wait_seconds = 0 / 0 })
  refused("BAD_ARGUMENT", "budget_seconds is nan", pair.tune, pair, scene, quick { budget_seconds = 0 / 0 })
  raises("watch is 1; expected a function", pair.tune, pair, scene, { watch = 1 })
  refused("BAD_ARGUMENT", "", pair.tune, pair, scene, quick { strategy = "none" })
  raises("duet.scene expected", pair.tune, pair, {})
end)

facts.finish()
