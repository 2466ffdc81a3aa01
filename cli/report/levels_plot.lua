-- SPDX-License-Identifier: MIT
-- `duet accuracy --plot` of a still scene: for each device a row a level, its time to the left and what it gets wrong
-- to the right, by powers of ten from one pair on.
local report = ...
local box, write, ink, grey = report.box, report.write, report.ink, report.grey

local time_fill <const>, beaten_fill <const> = { 0.36, 0.53, 0.74 }, { 0.74, 0.80, 0.87 }
local wrong_fill <const> = { 0.80, 0.30, 0.20 }
local row_px <const>, head <const>, device_head <const>, foot <const> = 30, 96, 44, 46
local names_x <const>, times_x <const>, wrongs_x <const>, bar_px <const>, words_px <const> = 24, 120, 560, 260, 14

local function wrong(row) return row.missed + row["false"] end
local function digits_of_wrong(row) return math.log(1 + wrong(row), 10) end
local function step_ms(row) return row.step_ms end

local function draw_bar(x, y, length, fill, words)
  box(x, y - 15, length, 20, fill)
  write(x + length + 8, y, words_px, ink, "%s", words)
end

local function draw_row(rows, row, y)
  local most_wrong = report.greatest(rows, digits_of_wrong)
  write(names_x, y, words_px, ink, "%s", row.level)
  draw_bar(times_x, y, bar_px * row.step_ms / report.greatest(rows, step_ms), row.front and time_fill or beaten_fill,
    ("%.3g ms, %.2f x"):format(row.step_ms, row.relative))
  draw_bar(wrongs_x, y, most_wrong > 0 and bar_px * digits_of_wrong(row) / most_wrong or 0, wrong_fill,
    wrong(row) > 0 and report.count(wrong(row)) or "none")
end

return function(o)
  local letters, y = o.a == o.b and { "B" } or { "A", "B" }, head
  report.plot.width, report.plot.height = 960, head + #letters * device_head + row_px * #o.levels + foot
  write(names_x, 34, 20, ink, "What accuracy costs: %s, %s", report.cut(o.scene, 80),
    report.things(o.objects, "box", "boxes"))
  write(times_x, 66, words_px, ink, "time a step, and against sat15")
  write(wrongs_x, 66, words_px, ink, "wrong pairs, by powers of ten")
  for _, letter in ipairs(letters) do
    write(names_x, y, words_px, grey, "%s", report.device_alone(o, letter))
    y = y + row_px
    for _, row in ipairs(o.levels) do
      if row.device == letter then
        draw_row(o.levels, row, y)
        y = y + row_px
      end
    end
    y = y + device_head - row_px
  end
  write(names_x, y, words_px, grey, "Pale: another level on that device is at least as fast and as right.")
  return report.plot
end
