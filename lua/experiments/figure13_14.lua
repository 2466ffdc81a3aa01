-- SPDX-License-Identifier: MIT
-- Figures 13 and 14 of the paper: the time of a step by configuration and
-- size: each device alone, and the pair at the tuned share.
local lab = require "duet.lab"

local options = lab.options("Times by configuration and size (figures 13 and 14).", {
  sizes = { 250000, 500000, 1000000, 2000000 },
  world = 200.0,
  variant = "", -- kernels of both; without one, each device's default
  mode = "own",
  strategy = "balance",
})

local rows = lab.frame.new { "devices", "objects", "configuration", "share", "ms", "low", "high" }

local function size_name(n)
  return ("%.3g M"):format(n / 1e6)
end

for pair, devices in lab.each_pair(options) do
  local plan = lab.plan(pair, options.mode, options.variant)
  local series = { { name = "A alone", points = {} }, { name = "B alone", points = {} }, { name = "A and B", points = {} } }
  for _, n in ipairs(options.sizes) do
    local scene <close> = lab.paper_scene(options, n)
    for i, r in ipairs(lab.compare(pair, scene, plan, options)) do
      rows:add {
        devices = devices, objects = n, configuration = series[i].name,
        share = r.plan.share, ms = r.ms, low = r.low, high = r.high,
      }
      table.insert(series[i].points, { size_name(n), r.ms, r.low, r.high })
    end
  end
  lab.finish(options, "figure13_14." .. devices:gsub("[^%w]+", "_"):gsub("_$", ""), rows, {
    title = "Time of a step: A " .. devices:gsub("%+", ", B "),
    x = "objects", y = "ms", kind = "bars", series = series,
  })
  rows = lab.frame.new(rows.columns)
end
