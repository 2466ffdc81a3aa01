-- SPDX-License-Identifier: MIT
-- The paper's cell edge is the cube's, 1, while a rotated cube is up to the
-- square root of 3 wide: what the 27 cells around an object then miss.
--
-- A pair is missed where its objects' centres are two cells apart or more. The
-- reference's pairs at each cell edge, and all pairs whose bounds overlap, are
-- counted so. Duet refuses such a cell, or widens it: that is shown first.
local duet = require "duet"
local lab = require "duet.lab"

local options = lab.options("What cells of the cube's edge miss.", {
  sizes = { 100000 },
  world = 0.0, -- 0: of the paper's density at one million
  euler = 0.0, -- 1: uniform Euler angles, as in the paper, not uniform rotations
})

local edges = { 1, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, math.sqrt(3) }

local rows = lab.frame.new { "objects", "cell edge", "pairs", "missed", "missed %", "candidates", "candidates missed", "candidates missed %" }

-- Half the width of a pose's bounds, on each axis.
local function half_widths(hx, hy, hz, x, y, z, w)
  local s = 2 / (x * x + y * y + z * z + w * w)
  local abs = math.abs
  return abs(1 - s * (y * y + z * z)) * hx + abs(s * (x * y - z * w)) * hy + abs(s * (x * z + y * w)) * hz,
    abs(s * (x * y + z * w)) * hx + abs(1 - s * (x * x + z * z)) * hy + abs(s * (y * z - x * w)) * hz,
    abs(s * (x * z - y * w)) * hx + abs(s * (y * z + x * w)) * hy + abs(1 - s * (x * x + y * y)) * hz
end

local function read_objects(scene)
  local objects = { centre = { {}, {}, {} }, half_extents = { {}, {}, {} } }
  for id, cx, cy, cz, hx, hy, hz, x, y, z, w in scene:poses():each() do
    local c, h = objects.centre, objects.half_extents
    c[1][id], c[2][id], c[3][id] = cx, cy, cz
    h[1][id], h[2][id], h[3][id] = half_widths(hx, hy, hz, x, y, z, w)
  end
  return objects
end

local function overlap(objects, a, b)
  for axis = 1, 3 do
    local c, h = objects.centre[axis], objects.half_extents[axis]
    if math.abs(c[a] - c[b]) > h[a] + h[b] then return false end
  end
  return true
end

-- All pairs whose bounds overlap, as a flat list of ids.
local function find_candidates(objects, n)
  local cells, found, wide <const> = {}, {}, 2048
  local x, y, z = objects.centre[1], objects.centre[2], objects.centre[3]
  local edge = math.sqrt(3) * 1.001
  for id = 0, n - 1 do
    local key = ((z[id] // edge) * wide + y[id] // edge) * wide + x[id] // edge
    for dz = -1, 1 do
      for dy = -1, 1 do
        for dx = -1, 1 do
          local cell = cells[key + (dz * wide + dy) * wide + dx]
          for _, other in ipairs(cell or {}) do
            if overlap(objects, id, other) then
              found[#found + 1] = other
              found[#found + 1] = id
            end
          end
        end
      end
    end
    cells[key] = cells[key] or {}
    table.insert(cells[key], id)
  end
  return found
end

-- Whether the 27 cells around a hold b.
local function is_missed(objects, a, b, edge)
  for axis = 1, 3 do
    local c = objects.centre[axis]
    if math.abs(c[a] // edge - c[b] // edge) > 1 then return true end
  end
  return false
end

local function count_missed(objects, ids, edge)
  local missed = 0
  for i = 1, #ids, 2 do
    if is_missed(objects, ids[i], ids[i + 1], edge) then missed = missed + 1 end
  end
  return missed
end

local function show_refusal(scene)
  local pair <close> = assert(duet.device_pair())
  local fixed <close> = assert(pair:world(scene, { cell = 1, cell_fixed = true }))
  local _, message, status = fixed:step()
  print("cell = 1, fixed:  " .. tostring(status) .. ": " .. tostring(message))
  local free <close> = assert(pair:world(scene, { cell = 1 }))
  local result = assert(free:step())
  print(("cell = 1, free:   widened to %.4f, and all %d pairs are found\n"):format(result.cell, #result))
end

local series = { { name = "collisions", points = {} }, { name = "pairs whose bounds overlap", points = {} } }
local density <const> = 1e6 / 200 ^ 3

for _, n in ipairs(options.sizes) do
  local world = options.world > 0 and options.world or (n / density) ^ (1 / 3)
  local scene <close> = lab.paper_scene({ seed = options.seed, world = world, euler = options.euler }, n)
  show_refusal(scene)
  local objects = read_objects(scene)
  local pairs_found, candidates = {}, find_candidates(objects, n)
  for _, a, b in assert(scene:reference()):each() do
    pairs_found[#pairs_found + 1] = a
    pairs_found[#pairs_found + 1] = b
  end
  for _, edge in ipairs(edges) do
    local missed, candidates_missed = count_missed(objects, pairs_found, edge), count_missed(objects, candidates, edge)
    local n_pairs, n_candidates = #pairs_found // 2, #candidates // 2
    rows:add {
      objects = n, ["cell edge"] = edge, pairs = n_pairs, missed = missed, ["missed %"] = 100 * missed / n_pairs,
      candidates = n_candidates, ["candidates missed"] = candidates_missed,
      ["candidates missed %"] = 100 * candidates_missed / n_candidates,
    }
    table.insert(series[1].points, { edge, 100 * missed / n_pairs })
    table.insert(series[2].points, { edge, 100 * candidates_missed / n_candidates })
  end
end

lab.finish(options, "cell_flaw", rows, {
  title = "What 27 cells miss, by their edge (rotated unit cubes)",
  x = "cell edge, in edges of a cube", y = "% missed", kind = "lines", yrange = { 0 }, series = series,
})
