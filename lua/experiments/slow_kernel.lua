-- SPDX-License-Identifier: MIT
-- How much of the paper's gain is owed to a slow kernel: the same sharing with
-- the paper's kernels and with the fast ones, on every device pair at hand.
--
-- A slow kernel makes the search of candidates all that counts, and that part
-- can be shared; what both devices do, and what travels, weighs nothing beside
-- it. The last rows let each device build its own grid as well.
local lab = require "duet.lab"

local options = lab.options("The gain of sharing with a slow and with a fast kernel.", {
  sizes = { 250000 },
  world = 200.0,
  strategy = "balance",
})

local ways = { -- name, mode, variant; without one, each device's default
  { "paper, shared grid", "shared", "paper" },
  { "auto, shared grid", "shared", "auto" },
  { "fast, own grids", "own", "" },
}

local rows = lab.frame.new {
  "devices", "objects", "kernels", "A alone ms", "B alone ms", "share", "A and B ms",
  "gain over the better %", "low", "high", "by paper's B alone",
}
local series = { { name = "A alone", points = {} }, { name = "B alone", points = {} }, { name = "A and B", points = {} } }

for pair, devices in lab.each_pair(options) do
  for _, n in ipairs(options.sizes) do
    local scene <close> = lab.paper_scene(options, n)
    local slow_ms
    for _, way in ipairs(ways) do
      local results = lab.compare(pair, scene, lab.plan(pair, way[2], way[3]), options)
      local a, b, both = table.unpack(results)
      local gain, low, high = lab.sharing_gain(a.ms < b.ms and a or b, both)
      slow_ms = slow_ms or b.ms
      rows:add {
        devices = devices, objects = n, kernels = way[1], ["A alone ms"] = a.ms, ["B alone ms"] = b.ms,
        share = both.plan.share, ["A and B ms"] = both.ms, ["gain over the better %"] = gain,
        low = low, high = high, ["by paper's B alone"] = both.ms / slow_ms,
      }
      for i, r in ipairs(results) do
        table.insert(series[i].points, { ("%s\n%.3g M"):format(way[1]:gsub(", ", "\n"), n / 1e6), r.ms, r.low, r.high })
      end
    end
  end
end

lab.finish(options, "slow_kernel", rows, {
  title = "The same sharing with a slow and with a fast kernel",
  x = "kernels and objects", y = "ms", kind = "bars", series = series,
})
