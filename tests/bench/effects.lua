-- SPDX-License-Identifier: MIT
-- State hashes of every effect on several devices:
--
--     duet lua --trust tests/bench/effects.lua 'pocl:0 gpu pocl:0,gpu' [CASE ...]
--
-- The first argument has devices and pairs, divided by blanks; of a pair A searches 0.4 of a slab. No CASE is all.
-- Prints a row for each case: the hash of the state on the first, and for each of the others `same`, or its own hash.
-- Fails if one differs. Without arguments the names of the cases are printed.
local duet = require "duet"

local here <const> = arg[0]:match "^(.-)[^/]*$"
local boxes <const> = here .. "../oclgrind/boxes.lua"

local function falling(set)
  set.n = set.n or 200
  return { scene = boxes, set = set, steps = 60 }
end

local cases = {
  contacts = falling {},
  contacts_2d = falling { dims = 2, n = 40 },
  free_flight = falling { falling = false, boundary = "periodic" },
  orbits = falling { falling = false, attraction = 5.0, integrator = "yoshida" },
  doubles = falling { doubles = true },
  origin_cells = falling { origin = true, boundary = "none" },
  sleep = falling { sleep = true },
  skin = falling { skin = 0.3 },
  continuous = falling { continuous = true },
  events = falling { events = true, sleep = true },
  sensors = falling { events = true, sensors = true },
  filter = falling { filtered = true },
  shocks = falling { shocks = true },
  depenetration = falling { deep = true },
  materials = falling { materials = true },
  conveyor = falling { belt = true, rounded = true },
  rounded = falling { rounded = true },
  rounded_2d = falling { dims = 2, n = 40, rounded = true },
  rolling = falling { rounded = true, rolling = true },
  heights = falling { hills = true },
  heights_all = falling { hills = true, rounded = true, sleep = true, skin = 0.1, continuous = true, events = true },
  heights_doubles = falling { hills = true, rounded = true, doubles = true },
  mesh = falling { mesh = true },
  mesh_all = falling { mesh = true, rounded = true, sleep = true, skin = 0.1, continuous = true, events = true,
    materials = true, rolling = true, belt = true },
  mesh_doubles = falling { mesh = true, rounded = true, doubles = true },
  carrier = falling { carried = true },
  carrier_all = falling { carried = true, rounded = true, sleep = true, skin = 0.1, continuous = true, events = true,
    materials = true, rolling = true, belt = true, shocks = true },
  carrier_doubles = falling { carried = true, rounded = true, doubles = true },
  drum = { scene = "drum", set = { n = 400 }, steps = 120 },
  terrain = { scene = "terrain", set = { n = 400 }, steps = 120 },
  seam = { scene = "seam", set = {}, steps = 120 },
  pile = { scene = "falling", set = { n = 2000 }, steps = 60 },
  marbles = { scene = "marbles", set = { n = 1000 }, steps = 60 },
  bullets = { scene = "bullets", set = {}, steps = 40 },
}
local names = {}
for name in pairs(cases) do names[#names + 1] = name end
table.sort(names)

if not arg[1] then
  print(table.concat(names, "\n"))
  os.exit()
end

local function hash_on(selector, case)
  local a, b = selector:match "^([^,]+),(.+)$"
  local pair <close> = assert(duet.device_pair { a = a or selector, b = b or selector })
  local motion <close> = assert(pair:motion(assert(duet.scene(case.scene, case.set))))
  if a then assert(motion:set_plan { share = 0.4, mode = "slab" }) end
  for _ = 1, case.steps do assert(motion:advance()) end
  return assert(motion:hash())
end

local selectors, differs = {}, 0
for selector in arg[1]:gmatch "%S+" do selectors[#selectors + 1] = selector end
for _, name in ipairs(#arg > 1 and table.move(arg, 2, #arg, 1, {}) or names) do
  if not cases[name] then error(("no case '%s'; there are %s"):format(name, table.concat(names, ", ")), 0) end
  local row, right = { ("%-16s"):format(name) }, nil
  for _, selector in ipairs(selectors) do
    local hash <const> = hash_on(selector, cases[name])
    right = right or hash
    row[#row + 1] = ("%s: %s"):format(selector, #row > 1 and hash == right and "same" or hash)
    differs = differs + (hash == right and 0 or 1)
  end
  print(table.concat(row, "  "))
end
if differs > 0 then error(("%d differ"):format(differs), 0) end
