-- SPDX-License-Identifier: MIT
-- Figure 15 of the paper: how much faster the pair is at the tuned share than
-- B alone, which is the paper's measure, and than the better device alone.
-- If one device does it all, the plan says which, and there is no gain.
local lab = require "duet.lab"

local options = lab.options("Gain of sharing, by size (figure 15).", {
  sizes = { 250000, 500000, 1000000, 2000000 },
  world = 200.0,
  variant = "", -- kernels of both; without one, each device's default
  mode = "own",
  strategy = "balance",
})

local rows = lab.frame.new { "devices", "objects", "plan", "share", "gain over B %", "low", "high", "gain over the better %" }
local over_b = {}

for pair, devices in lab.each_pair(options) do
  local plan = lab.plan(pair, options.mode, options.variant)
  over_b[#over_b + 1] = { name = devices, points = {} }
  for _, n in ipairs(options.sizes) do
    local scene <close> = lab.paper_scene(options, n)
    local a, b, both = table.unpack(lab.compare(pair, scene, plan, options))
    local gain, low, high = lab.sharing_gain(b, both)
    rows:add {
      devices = devices, objects = n, plan = lab.plan_name(both.plan.share), share = both.plan.share,
      ["gain over B %"] = gain, low = low, high = high,
      ["gain over the better %"] = (lab.sharing_gain(a.ms < b.ms and a or b, both)),
    }
    table.insert(over_b[#over_b].points, { ("%.3g M"):format(n / 1e6), gain or 0, low, high })
  end
end

lab.finish(options, "figure15", rows, {
  title = "How much faster A and B are than B alone",
  x = "objects", y = "%", kind = "bars", series = over_b,
})
