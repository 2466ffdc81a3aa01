-- SPDX-License-Identifier: MIT
-- Figure 12 of the paper: the path of its search for the share, against
-- `balance` and the curve of what every share takes.
--
-- Invented devices come first: A is K times slower than B and both pay a
-- little for sharing. Then the devices at hand, where the curve is measured.
-- The paper's search cuts off the side that holds the best share when the
-- dearer end is K times the cheaper one; `balance` looks at which device
-- waited for the other.
local lab = require "duet.lab"

local options = lab.options("The path of the search for the share (figure 12).", {
  sizes = { 250000 },
  world = 200.0,
  variant = "", -- kernels of both; without one, each device's default
  mode = "own",
  launches = 10, -- launches of fig12, as in the paper
  points = 16, -- intervals of the measured curve
  ratios = "3,5,10,20",
})

local rows = lab.frame.new { "on", "strategy", "launches", "share", "ms", "best share", "best ms", "off %", "tuning ms" }

local function invented(ratio)
  return function(share)
    local a = share > 0 and ratio * share + 0.02 or 0
    local b = share < 1 and 1 - share + (share > 0 and 0.01 or 0) or 0
    return 10 * math.max(a, b), 10 * a, 10 * b
  end
end

-- The least of a curve of { share, ms } points.
local function least(curve)
  local best = curve[1]
  for _, p in ipairs(curve) do
    if p[2] < best[2] then best = p end
  end
  return best
end

local function curve_of(launch, points)
  local curve = {}
  for i = 0, points do
    local share = i / points
    curve[#curve + 1] = { share, (launch(share)) }
  end
  return curve
end

local function time_at(launch, path, share)
  for _, p in ipairs(path) do
    if p[1] == share then return p[2] end
  end
  return (launch(share))
end

-- A path as { launch, share }, for the second picture.
local function by_launch(path)
  local points = {}
  for i, p in ipairs(path) do points[i] = { i, p[1] } end
  return points
end

-- Both searches on one cost function, what they found, and two pictures: where
-- on the curve they measured, and which share they tried when.
local function draw(name, title, launch, curve, time_of)
  local best, most = least(curve), 0
  local places = { { name = "every share", style = "lines", colour = "#999999", points = curve } }
  local paths = {}
  for _, strategy in ipairs { "fig12", "balance" } do
    local def = { strategy = strategy, launches = strategy == "fig12" and options.launches or nil }
    local pick, path = lab.search(def, launch)
    local ms, cost = time_of(path, pick), 0
    for _, p in ipairs(path) do cost = cost + p[2] end
    rows:add {
      on = title, strategy = strategy, launches = #path, share = pick, ms = ms, ["best share"] = best[1],
      ["best ms"] = best[2], ["off %"] = 100 * (ms / best[2] - 1), ["tuning ms"] = cost,
    }
    most = math.max(most, #path)
    places[#places + 1] = { name = strategy, style = "points", points = path }
    paths[#paths + 1] = { name = strategy, points = by_launch(path) }
  end
  table.insert(paths, 1, { name = "best share", style = "lines", colour = "#999999", points = { { 1, best[1] }, { most, best[1] } } })
  lab.finish(options, name, rows, {
    title = title, x = "share of A", y = "ms", kind = "lines", log = "y", xrange = { -0.02, 1.02 },
    yrange = { 0.9 * best[2] }, series = places,
  }, {
    path = {
      title = title .. ": the share that each launch tried", x = "launch", y = "share of A", kind = "lines",
      xrange = { 0.5, most + 0.5 }, yrange = { -0.03, 1.03 }, series = paths,
    },
  })
  rows = lab.frame.new(rows.columns)
end

for ratio in options.ratios:gmatch "[^,]+" do
  local launch = invented(tonumber(ratio))
  draw("figure12.times" .. ratio, "A is " .. ratio .. " times slower than B", launch, curve_of(launch, 2000), function(_, share)
    return (launch(share))
  end)
end

for pair, devices in lab.each_pair(options) do
  for _, n in ipairs(options.sizes) do
    local scene <close> = lab.paper_scene(options, n)
    local plan = lab.plan(pair, options.mode, options.variant)
    local world <close> = lab.world(pair, scene, plan)
    local launch = lab.launcher(world, scene, plan)
    launch(0.5) -- builds what is not built
    draw(("figure12.%s.%d"):format(devices:gsub("[^%w]+", "_"), n), ("%s, %d objects"):format(devices, n), launch,
      curve_of(launch, options.points), function(path, share) return time_at(launch, path, share) end)
  end
end
