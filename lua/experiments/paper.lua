-- SPDX-License-Identifier: MIT
-- The paper in one command: table 2 and figures 10 to 15, each by its own experiment, and one page,
-- index.html, that puts what the paper printed beside them.
--
--   duet lua --trust lua/experiments/paper.lua --out paper
--
-- The paper's figures 13 to 15 are pictures; the page has the numbers that its text names.
local lab = require "duet.lab"

local options = lab.options("The paper's table 2 and figures 10 to 15, and one page.", {
  sizes = { 250000, 500000, 1000000, 2000000 },
  world = 200.0,
})
local folder = arg[0]:match "^(.*/)" or "./"

-- ------------------------------------------------------------------ what the paper says

local printed = {
  { "table2", "Table 2: where the time of one device goes",
    "The paper's rows, of an RX 570, stand below ours as printed. It finds 89 to 96 % of the time in the search of " ..
    "overlapping pairs, and therefore shares that." },
  { "figure10_11", "Figures 10 and 11: time lines of a step",
    "The paper sketches them: figure 10 has the GPU alone, with hash, sort and cell start (T GPU1), the search (T GPU2) " ..
    "and SAT (T GPU3); figure 11 sends the grid to the CPU (T BUS2), which then searches and tests its part (T CPU1, " ..
    "T CPU2) meanwhile. These are measured." },
  { "figure12", "Figure 12: the search for the share",
    "The paper's search halves from one end, at most ten times. It moves the slower end to the middle, and so loses the " ..
    "side with the best share where one device is several times slower." },
  { "figure13_14", "Figures 13 and 14: time of a step by configuration",
    "System 1 is a Core i5-9600K with UHD Graphics 630 and an RX 570, system 2 two Xeon E5-2620 and a Tesla K20. In the " ..
    "paper's pictures the GPU is the fastest single device at every size and the CPU the slowest; sharing is faster " ..
    "than the GPU alone in all configurations." },
  { "figure15", "Figure 15: gain of sharing over the GPU alone", "The paper's text names these:",
    { { "devices", "objects", "gain over the GPU %" },
      { "system 1, GPU + IGPU", "0.25 M", "about 8" }, { "system 1, GPU + CPU", "0.25 M", "about 15" },
      { "system 1, GPU + IGPU", "0.5 M", "about 18, the peak" },
      { "system 2, GPU + CPU", "0.25 to 2 M", "less, slowly growing with the size" } } },
}

-- ------------------------------------------------------------------ the experiments

local results = {} -- by experiment: tables with their pictures, in order
local running

local finish, timeline = lab.finish, lab.timeline

function lab.finish(own, name, rows, chart, more)
  finish(own, name, rows, chart, more)
  local pictures = chart and { name } or {}
  for key in pairs(more or {}) do pictures[#pictures + 1] = name .. "_" .. key end
  table.insert(results[running], { rows = rows, pictures = pictures })
end

function lab.timeline(own, name, def)
  timeline(own, name, def)
  table.insert(results[running], { pictures = { name } })
end

local function given(sizes)
  local texts = {}
  for i, n in ipairs(sizes) do texts[i] = tostring(n) end
  return { "--out", options.out, "--pair", options.pair, "--repeat", tostring(options["repeat"]), "--seed",
    tostring(options.seed), "--world", tostring(options.world), "--sizes", table.concat(texts, ",") }
end

-- The largest size alone for those that draw a step or a search.
for _, part in ipairs(printed) do
  running = part[1]
  results[running] = {}
  local all = running ~= "figure12" and running ~= "figure10_11"
  arg = given(all and options.sizes or { options.sizes[#options.sizes] })
  arg[0] = folder .. running .. ".lua"
  assert(loadfile(arg[0]))()
end

-- ------------------------------------------------------------------ the page

local page = {}
local function add(format, ...) page[#page + 1] = select("#", ...) > 0 and format:format(...) or format end

local entities = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;" }
local function words(text) return (tostring(text):gsub('[&<>"]', entities)) end

local function cell(value)
  if value == nil then return "<td></td>" end
  local number = type(value) == "number"
  local text = math.type(value) == "float" and ("%.4g"):format(value) or value
  return ("<td%s>%s</td>"):format(number and ' class="r"' or "", words(text))
end

local function add_table(columns, rows)
  local heads = {}
  for i, name in ipairs(columns) do heads[i] = "<th>" .. words(name) .. "</th>" end
  add("<table><tr>%s</tr>\n", table.concat(heads))
  for _, row in ipairs(rows) do
    local cells = {}
    for i, name in ipairs(columns) do cells[i] = cell(row[name]) end
    add("<tr>%s</tr>\n", table.concat(cells))
  end
  add "</table>\n"
end

-- A list of lists, the first of them the columns, as rows by name.
local function named_rows(list)
  local rows = {}
  for i = 2, #list do
    rows[i - 1] = {}
    for k, name in ipairs(list[1]) do rows[i - 1][name] = list[i][k] end
  end
  return rows
end

local function has_picture(name)
  local file <close> = io.open(options.out .. "/" .. name .. ".svg")
  return file ~= nil
end

add [[
<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>The paper, run again</title>
<style>
:root{color-scheme:light dark}body{font:15px/1.5 sans-serif;max-width:1100px;margin:2em auto;padding:0 1em}
table{border-collapse:collapse;margin:1em 0;display:block;overflow-x:auto}th,td{padding:.2em .7em;text-align:left;border-bottom:1px solid #8884}
.r{text-align:right;font-variant-numeric:tabular-nums}img{max-width:100%;height:auto}h2{margin-top:2em}.p{border-left:3px solid #0072B2;padding-left:1em}
</style>
<h1>The paper, run again</h1>
<p>Tayyub and Khan, <i>Heterogeneous Design and Efficient CPU-GPU Implementation of Collision Detection</i>: what it printed, beside what this machine does.</p>
]]
for _, part in ipairs(printed) do
  add("<h2 id=\"%s\">%s</h2>\n<div class=\"p\"><p>%s</p>\n", part[1], words(part[2]), words(part[3]))
  if part[4] then add_table(part[4][1], named_rows(part[4])) end
  add "</div>\n"
  for _, result in ipairs(results[part[1]]) do
    if result.rows then add_table(result.rows.columns, result.rows.rows) end
    for _, name in ipairs(result.pictures) do
      if has_picture(name) then add('<p><img src="%s.svg" alt="%s"></p>\n', words(name), words(name)) end
    end
  end
end
add "</html>\n"

local file <close> = assert(io.open(options.out .. "/index.html", "w"))
assert(file:write(table.concat(page)))
print(("-> %s/index.html"):format(options.out))
