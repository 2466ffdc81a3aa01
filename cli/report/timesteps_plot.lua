-- SPDX-License-Identifier: MIT
-- `duet accuracy --plot` of a moving scene: the error of each run over its time, both by powers of ten, and the front
-- as a line. Runs with contacts have a colour a dt and their substeps as a number, free flight a colour an integrator
-- and the substep.
local report = ...
local stroke, dot, write, ink, grey = report.stroke, report.dot, report.write, report.ink, report.grey

local left <const>, right <const>, top <const>, bottom <const>, words_px <const> = 84, 640, 70, 484, 13
local letter <const> = 0.65 * words_px -- the width of one, rather too much than too little
local pale <const>, paper <const> = { 0.87, 0.88, 0.90 }, { 1, 1, 1 }
-- Okabe and Ito's, which most colour-blind people can tell apart.
local hues <const> = { { 0.00, 0.45, 0.70 }, { 0.90, 0.62, 0.00 }, { 0.00, 0.62, 0.45 }, { 0.80, 0.40, 0.00 } }

local integrators <const> = { euler = 1, verlet = 2, yoshida = 3 }

local function flies(o) return o.reference.integrator == "yoshida" end

-- The place of a run's colour: the reference's dt is 16, 8, 4 and 2 times shorter than those that are compared.
local function group_of(o, row)
  return flies(o) and integrators[row.integrator] or 5 - math.floor(math.log(row.dt / o.reference.dt, 2) + 0.5)
end

-- From the least to the most of a field, in powers of ten, and the places of both.
local function axis_of(rows, field, from, to)
  local least, most = math.huge, -math.huge
  for _, row in ipairs(rows) do
    local value = row.finite and row[field] or 0
    if value > 0 and value < math.huge then
      least, most = math.min(least, math.log(value, 10) - 0.15), math.max(most, math.log(value, 10) + 0.15)
    end
  end
  if not (least < most) then least, most = -1, 1 end
  local function place(value)
    local part = value > 0 and (math.log(value, 10) - least) / (most - least) or 0
    return from + math.min(1, math.max(0, part)) * (to - from)
  end
  return { least = least, most = most, place = place }
end

-- A line and its value at 1, 2 and 5 of each power of ten; of many powers at 1.
local function draw_ticks(axis, draw)
  local power = math.floor(axis.least)
  while power <= axis.most do
    for _, times in ipairs(axis.most - axis.least > 2.5 and { 1 } or { 1, 2, 5 }) do
      local value = times * 10.0 ^ power
      local digits = math.log(value, 10)
      if digits >= axis.least and digits <= axis.most then draw(axis.place(value), ("%.4g"):format(value)) end
    end
    power = power + 1
  end
end

local function draw_frame(o, x, y)
  write(24, 32, 19, ink, "What accuracy costs: %s, %s, %.3g s", report.cut(o.scene, 60),
    report.things(o.objects, "box", "boxes"), o.time)
  write(24, 56, words_px, ink, "distance from the reference at the end (root mean square), in the scene's unit")
  draw_ticks(x, function(at, value)
    stroke(at, top, at, bottom, pale, 1)
    write(at - 10, bottom + 20, words_px, grey, "%s", value)
  end)
  draw_ticks(y, function(at, value)
    stroke(left, at, right, at, pale, 1)
    write(left - 56, at + 4, words_px, grey, "%s", value)
  end)
  stroke(left, top, left, bottom, grey, 1)
  stroke(left, bottom, right, bottom, grey, 1)
  write(left + 180, bottom + 46, words_px, ink, "ms that a second of the scene takes")
end

-- A run's place in the plot, and its dot's radius.
local function points_of(o, x, y)
  local points = {}
  for i, row in ipairs(o.timesteps) do
    points[i] = { x = x.place(row.ms_a_second), y = row.finite and y.place(row.error) or top, row = row,
      radius = row.own and 11 or row.front and 7 or 5 }
  end
  return points
end

-- Covers the front's line with boxes { left, top, right, bottom }, too.
local function draw_front(points, taken)
  local front = {}
  for _, p in ipairs(points) do
    if p.row.front then front[#front + 1] = p end
  end
  table.sort(front, function(a, b) return a.x < b.x end)
  for i = 2, #front do
    local from, to = front[i - 1], front[i]
    stroke(from.x, from.y, to.x, to.y, grey, 1.5)
    for part = 0, 1, 1 / 64 do
      local at_x, at_y = from.x + part * (to.x - from.x), from.y + part * (to.y - from.y)
      taken[#taken + 1] = { at_x - 1, at_y - 1, at_x + 1, at_y + 1 }
    end
  end
end

local function draw_dot(o, p, taken)
  if p.row.own then
    dot(p.x, p.y, 11, ink)
    dot(p.x, p.y, 9, paper)
  end
  dot(p.x, p.y, p.row.front and 7 or 5, hues[group_of(o, p.row)])
  taken[#taken + 1] = { p.x - p.radius, p.y - p.radius, p.x + p.radius, p.y + p.radius }
end

local function count_covered(box, taken)
  local n = 0
  for _, other in ipairs(taken) do
    if box[1] < other[3] and other[1] < box[3] and box[2] < other[4] and other[2] < box[4] then n = n + 1 end
  end
  return n
end

-- Words that wide may stand beside, above or below the point, or further off.
local function places_of(p, width)
  local places = {}
  for _, off in ipairs { p.radius + 4, p.radius + 14 } do
    for _, at in ipairs { { p.x + off, p.y + 5 }, { p.x - width / 2, p.y - off },
      { p.x - width / 2, p.y + off + words_px }, { p.x - off - width, p.y + 5 } } do
      places[#places + 1] = { at[1] - 4, at[2] - words_px, at[1] + width + 4, at[2] }
    end
  end
  return places
end

-- At the first place that covers least.
local function draw_words(o, p, taken)
  local words = flies(o) and ("1/%.4g"):format(p.row.substeps / p.row.dt)
    or ("%.0f%s"):format(p.row.substeps, p.row.finite and "" or " lost")
  local best, fewest = nil, math.huge
  for _, box in ipairs(places_of(p, #words * letter)) do
    local n = count_covered(box, taken)
    if n < fewest then best, fewest = box, n end
  end
  write(best[1] + 4, best[4], words_px, ink, "%s", words)
  taken[#taken + 1] = best
end

local function draw_key(o)
  local drawn, y = {}, top + 10
  for _, row in ipairs(o.timesteps) do
    local group = group_of(o, row)
    if not drawn[group] then
      drawn[group] = true
      dot(right + 30, y - 4, 6, hues[group])
      write(right + 44, y, words_px, ink, "%s", flies(o) and row.integrator or ("dt 1/%.4g s"):format(1 / row.dt))
      y = y + 24
    end
  end
  for i, note in ipairs { flies(o) and "at a point: the substep" or "at a point: substeps", "ring: the scene's own",
    "line: nothing is both", "faster and nearer" } do
    write(right + 24, y + 20 * i - 12, words_px, grey, note)
  end
end

return function(o)
  local x, y = axis_of(o.timesteps, "ms_a_second", left, right), axis_of(o.timesteps, "error", bottom, top)
  report.plot.width, report.plot.height = 860, 560
  draw_frame(o, x, y)
  local points, taken = points_of(o, x, y), {}
  draw_front(points, taken)
  for _, p in ipairs(points) do draw_dot(o, p, taken) end
  for _, p in ipairs(points) do draw_words(o, p, taken) end
  draw_key(o)
  return report.plot
end
