-- SPDX-License-Identifier: MIT
-- Where a heavy box rests on a light one: how many substeps a step of dt needs
-- for a ratio of masses. Not from the paper.
--
-- All ratios stand side by side on one floor. A pair holds where the heavy box
-- neither sinks in by a tenth of an edge nor slides off, from a second on.
local duet = require "duet"
local lab = require "duet.lab"

local options = lab.options("How many substeps a ratio of masses needs, by dt.", {
  seconds = 4.0,
  most = 32, -- substeps: 1, 2, 4 ... up to it
  finest = 480, -- steps a second: 15, 30 ... up to it
})

local ratios = { 1, 3, 10, 30, 100, 300, 1000, 3000, 10000, 30000, 100000 }
local apart <const>, mask <const> = 3, 0xffffffff

local function body(mass)
  return { 0, 0, 0, 0, 0, 0, mass, 0, 0.6, mask, mask, 0, false, false }
end

-- The floor, then for each ratio a box of mass 1 and the heavy one on it.
local function make_objects()
  local wide = apart * #ratios
  local poses = { { wide / 2, 0, -0.5, wide, 5, 0.5, 0, 0, 0, 1 } }
  local bodies = { body(0) }
  for i, ratio in ipairs(ratios) do
    for layer, mass in ipairs { 1, ratio } do
      poses[#poses + 1] = { apart * i, 0, layer - 0.5, 0.5, 0.5, 0.5, 0, 0, 0, 1 }
      bodies[#bodies + 1] = body(mass)
    end
  end
  return duet.poses(poses), duet.bodies(bodies)
end

-- NaN holds nothing.
local function stands(states, i)
  local x, y, z = states:get(2 * i)
  return z > 1.4 and z < 1.6 and math.abs(x - apart * i) < 0.1 and math.abs(y) < 0.1
end

-- Says for each ratio whether it holds.
local function try(pair, poses, bodies, per_second, substeps)
  local def = { gravity = { 0, 0, -9.81 }, wants = { "contact_response" }, dt = 1 / per_second, substeps = substeps }
  local motion <close> = assert(pair:motion(poses, bodies, def))
  local holds = {}
  for step = 1, math.ceil(options.seconds * per_second) do
    assert(motion:advance())
    if step >= per_second and step % (per_second // 5) == 0 then
      local states = assert(motion:read())
      for i in ipairs(ratios) do holds[i] = holds[i] ~= false and stands(states, i) end
    end
  end
  return holds
end

-- Gives for each ratio the fewest substeps that hold; nothing where none does.
local function fewest_substeps(pair, poses, bodies, per_second)
  local fewest, substeps = {}, 1
  while substeps <= options.most do
    for i, holds in ipairs(try(pair, poses, bodies, per_second, substeps)) do
      if not holds then fewest[i] = nil end -- fewer ones held by chance
      if holds then fewest[i] = fewest[i] or substeps end
    end
    substeps = 2 * substeps
  end
  return fewest
end

local rows = lab.frame.new { "steps a second", "mass ratio", "substeps", "holds" }
local chart = {
  title = "Substeps that a heavy box on a light one needs",
  x = "dt, s", y = "ratio of masses", kind = "map", nothing = "falls",
  columns = {}, rows = {}, values = {}, log = "z",
}
for i, ratio in ipairs(ratios) do
  chart.rows[i] = ("%g"):format(ratio):gsub("e%+0*", "e")
  chart.values[i] = {}
end

for pair in lab.each_pair(options) do
  local poses, bodies = make_objects()
  local per_second = 15
  while per_second <= options.finest do
    local fewest = fewest_substeps(pair, poses, bodies, per_second)
    chart.columns[#chart.columns + 1] = "1/" .. per_second
    for i, ratio in ipairs(ratios) do
      rows:add { ["steps a second"] = per_second, ["mass ratio"] = ratio, substeps = fewest[i] or 0, holds = fewest[i] and "yes" or "no" }
      chart.values[i][#chart.columns] = fewest[i] or false
    end
    per_second = 2 * per_second
  end
  break -- the same bits on every pair
end

lab.finish(options, "phase", rows, chart)
