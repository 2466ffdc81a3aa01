-- SPDX-License-Identifier: MIT
-- A store of profiles, looked into from Lua.
local duet = require "duet"
local facts = require "facts"

local store = os.tmpname()
local rows = os.tmpname()
local other = os.tmpname()
os.remove(store)
os.remove(other)

local pair <close> = assert(duet.device_pair())
local scene <close> = assert(duet.scene(facts.root .. "/lua/scenes/paper.lua", { n = 200, world = 9 }))
local tuned = assert(pair:tune(scene, { store = store, repeats = 1, variants = { "auto" }, modes = { "own" } }))

facts.holds("what was tuned is listed, with its plan and its devices", function()
  local list = assert(duet.profiles(store))
  assert(#list == 1)
  local one = list[1]
  assert(one.objects == 200 and one.dims == 3 and one.scene == "paper" and one.replaced == "")
  assert(one.share == tuned.plan.share and one.mode == "own" and one.variant_a == "auto")
  assert(#one.a.name > 0 and #one.b.driver > 0)
end)

facts.holds("a profile's trials are found by its first digits", function()
  local uid = assert(duet.profiles(store))[1].uid
  local trials = assert(duet.profile_trials(uid:sub(1, 8), store))
  assert(#trials > 0)
  for _, trial in ipairs(trials) do
    assert(trial.outcome ~= "ok" or (trial.step_ms > 0 and trial.low_ms <= trial.high_ms))
  end
end)

facts.holds("what was not measured is nil", function()
  local two = pair:device("A").selector ~= pair:device("B").selector -- halves of one device
  for _, one in ipairs { tuned, duet.profiles(store)[1] } do
    assert(math.type(one.whole_ms) == (two and "float" or nil))
    for _, gain in ipairs { "whole_gain", "whole_gain_low", "whole_gain_high" } do
      assert((one[gain] == nil) == (one.whole_ms == nil))
    end
  end
end)

facts.holds("rows go out and come in once", function()
  assert(duet.export_profiles(rows, store))
  local added, known = assert(duet.import_profiles(rows, other))
  assert(added > 0 and known == 0)
  local again, all = assert(duet.import_profiles(rows, other))
  assert(again == 0 and all == added)
  assert(duet.profiles(other)[1].uid == duet.profiles(store)[1].uid)
end)

facts.holds("a profile is forgotten, and one is put to use", function()
  local uid = assert(duet.profiles(store))[1].uid
  facts.refused("BAD_ARGUMENT", "no profile begins with 'zz'", duet.use_profile, "zz", store)
  assert(duet.use_profile(uid:sub(1, 9), store))
  assert(#duet.profiles(store) == 1)
  assert(duet.forget_profile(uid, other))
  assert(#duet.profiles(other, true) == 0)
end)

facts.holds("a world is told on which grounds it gets its plan", function()
  local world <close> = assert(pair:world(scene))
  assert(assert(world:explain_profile(store)):find "exact")
  assert(world:load_profile(store).grade == "exact")
end)

facts.holds("what is not there is said in one line", function()
  local refused = facts.refused
  refused("NOT_FOUND", "no/such.db", duet.profiles, "no/such.db")
  refused("BAD_ARGUMENT", "no profile begins with 'zz'", duet.profile_trials, "zz", store)
  refused("NOT_FOUND", "no/rows", duet.import_profiles, "no/rows", store)
  refused("IO_FAILED", "no/folder", duet.export_profiles, "no/folder/rows", store)
  refused("BAD_INPUT", "README.md:1: ", duet.import_profiles, facts.root .. "/README.md", store)
end)

for _, path in ipairs { store, rows, other } do os.remove(path) end
facts.finish()
