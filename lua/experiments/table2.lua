-- SPDX-License-Identifier: MIT
-- Table 2 of the paper: where the time of one device goes, as a percentage.
--
-- Device B does all the work, first with the paper's kernels and then with the
-- fast ones. The paper's own rows follow ours.
local lab = require "duet.lab"

local options = lab.options("Stage percentages of one device alone (table 2).", {
  sizes = { 250000, 500000, 1000000, 2000000 },
  world = 200.0,
  variants = "paper,fast", -- fast: what B's default is
})

-- The paper's columns, and which stages of ours count to each. Bounds go with
-- the hash, since the paper's hash kernel computes them; moving the objects
-- into cell order has no column of the paper's, nor has a kernel that tests
-- candidates where it finds them.
local columns = {
  { "hash", { "hash", "bounds", "clear" } },
  { "sort", { "sort" } },
  { "cell start", { "cell start", "scan" } },
  { "reorder", { "reorder" } },
  { "overlapping pairs", { "candidates" } },
  { "SAT", { "narrow", "decide" } },
  { "pairs with SAT", { "search" } },
  { "transfer", { "fetch pairs" } },
  { "upload", { "pack", "send objects", "send grid", "receive grid" } },
  { "other", {} },
}

local printed = { -- the paper, system 1, an RX 570
  { 250000, { 1.4, 0.5, 4.7, nil, 89.3, 1.9, nil, 2.2 } },
  { 500000, { 4.1, 0.4, 4.8, nil, 88.5, 1.1, nil, 1.0 } },
  { 1000000, { 1.3, 0.2, 1.5, nil, 95.7, 0.7, nil, 0.6 } },
  { 2000000, { 2.0, 0.1, 0.8, nil, 96.4, 0.3, nil, 0.3 } },
}

local column_of = {}
for i, column in ipairs(columns) do
  for _, stage in ipairs(column[2]) do column_of[stage] = i end
end

-- A step by B alone.
local function step_of(pair, scene, variant)
  if variant == "fast" then variant = pair:plan().variant_b end
  local world <close> = assert(pair:world(scene, {
    stage_times = true,
    plan = { share = 0, mode = "shared", variant_a = variant, variant_b = variant },
  }))
  return lab.median_step(world, scene, options["repeat"])
end

local function percentages(stages)
  local sums, total = {}, 0
  for i in ipairs(columns) do sums[i] = 0 end
  for _, stage in ipairs(stages) do
    if stage.device == "B" then
      local i = column_of[stage.name] or #columns
      sums[i] = sums[i] + stage.ms
      total = total + stage.ms
    end
  end
  for i, sum in ipairs(sums) do sums[i] = 100 * sum / total end
  return sums
end

local names = { "devices", "kernels", "objects", "ms" }
for i, column in ipairs(columns) do names[4 + i] = column[1] .. " %" end
local rows = lab.frame.new(names)
local series = {}
for i, column in ipairs(columns) do series[i] = { name = column[1], points = {} } end

local function add_row(devices, kernels, n, ms, parts)
  local row = { devices = devices, kernels = kernels, objects = n, ms = ms }
  for i in ipairs(columns) do
    row[names[4 + i]] = parts[i]
    table.insert(series[i].points, { ("%s\n%.3g M"):format(kernels, n / 1e6), parts[i] or 0 })
  end
  rows:add(row)
end

for pair, devices in lab.each_pair(options) do
  local b = devices:match "%+(.*)"
  for variant in options.variants:gmatch "[^,]+" do
    for _, n in ipairs(options.sizes) do
      local scene <close> = lab.paper_scene(options, n)
      local found = step_of(pair, scene, variant)
      add_row(b, variant, n, found.ms, percentages(found.stages))
    end
  end
end
for _, row in ipairs(printed) do add_row("RX 570", "as printed", row[1], nil, row[2]) end

lab.finish(options, "table2", rows, {
  title = "Where the time of one device goes",
  x = "kernels and objects", y = "% of the device's time",
  kind = "stack", yrange = { 0, 100 }, series = series,
})
