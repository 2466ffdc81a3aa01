-- SPDX-License-Identifier: MIT
-- Figures 10 and 11 of the paper: the time lines of a step by B alone, and of one that both devices
-- share at the tuned share, measured rather than sketched. First with the paper's kernels and one
-- grid that B builds, then with the fast kernels and a grid of each device's own.
local lab = require "duet.lab"

local options = lab.options("The time lines of a step (figures 10 and 11).", {
  sizes = { 1000000 },
  world = 200.0,
  strategy = "balance",
})

local ways = { -- name, mode, variant; without one, each device's default
  { "paper", "shared", "paper" },
  { "fast", "own", "" },
}

local rows = lab.frame.new { "figure", "devices", "kernels", "objects", "share", "ms", "A ms", "B ms" }

local function add(figure, pair, devices, way, n, plan, step)
  rows:add {
    figure = figure, devices = devices, kernels = way[1], objects = n, share = plan.share, ms = step.ms,
    ["A ms"] = step.device_ms[1], ["B ms"] = step.device_ms[2],
  }
  lab.timeline(options, ("figure%d.%s.%s.%d"):format(figure, way[1], devices:gsub("[^%w]+", "_"):gsub("_$", ""), n), {
    title = ("%s: %d boxes, the %s kernels"):format(plan.share == 0 and "B alone" or "A and B", n, way[1]),
    about = {
      ("%.3f ms; share of A %.4g, grids: %s"):format(step.ms, plan.share, plan.mode),
      "A: " .. pair:device("A").name, "B: " .. pair:device("B").name,
    },
    total_ms = step.ms, stages = step.stages,
    devices = { A = pair:device("A").selector, B = pair:device("B").selector },
  })
end

for pair, devices in lab.each_pair(options) do
  for _, n in ipairs(options.sizes) do
    local scene <close> = lab.paper_scene(options, n)
    for _, way in ipairs(ways) do
      local plan = lab.plan(pair, way[2], way[3])
      local world <close> = assert(pair:world(scene, { plan = plan, stage_times = true }))
      local share = lab.search({ strategy = options.strategy }, lab.launcher(world, scene, plan))
      for figure, part in pairs { [10] = 0, [11] = share } do
        local at = lab.with_share(plan, part)
        assert(world:set_plan(at))
        add(figure, pair, devices, way, n, at, lab.median_step(world, scene, options["repeat"]))
      end
    end
  end
end

lab.finish(options, "figure10_11", rows)
