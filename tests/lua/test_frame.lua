-- SPDX-License-Identifier: MIT
-- Tables as CSV and JSON, and the statistics of lab.
local facts = require "facts"
local frame = require "duet.frame"
local lab = require "duet.lab"
local plot = require "duet.plot"

facts.holds("CSV and JSON keep what a row holds", function()
  local f = frame.new { "name", "n", "ms" }
  f:add { name = 'a "b", c\n', n = 3, ms = 0.1 }
  f:add { n = -1, ms = 0 / 0 }
  facts.equal(f:csv():sub(1, 34), 'name,n,ms\n"a ""b"", c\n",3,0.1\n,-1,')
  facts.equal(f:json():match "^(.-)\n  {\"name\": null", '[\n  {"name": "a \\"b\\", c\\n", "n": 3, "ms": 0.1},')
  assert(f:json():find('"ms": null', 1, true))
  facts.raises("no column 'x'", f.add, f, { x = 1 })
end)

facts.holds("names that are no text of people do no harm", function()
  local f = frame.new { "name" }
  f:add { name = "\27[2J\xff\xc3\xa9\xe2\x82" }
  f:add { name = "\xed\xa0\x80" }
  assert(utf8.len(f:json()) and not f:json():find "\27")
  assert(f:json():find('"\\u001b[2J\u{fffd}\u{e9}\u{fffd}\u{fffd}"', 1, true), f:json())
  local printed, before = {}, print
  print = function(line) printed[#printed + 1] = line end
  f:print()
  print = before
  facts.equal(printed[2], "\\x1b[2J\\xff\u{e9}\\xe2\\x82")
  facts.equal(printed[3], "\\xed\\xa0\\x80")
end)

facts.holds("the median's interval holds it as often as it says", function()
  facts.equal(lab.median { 3, 1, 2 }, 2)
  facts.equal(lab.median { 4, 1, 2, 3 }, 2.5)
  -- 9 values: ranks 2 and 8 hold the median with 1 - 2 (1 + 9) / 512 = 96.1 %
  local low, high = lab.median_interval { 9, 8, 7, 6, 5, 4, 3, 2, 1 }
  facts.equal(low .. " " .. high, "2 8")
  low, high = lab.median_interval { 1, 2, 3 } -- too few: all of them
  facts.equal(low .. " " .. high, "1 3")
end)

facts.holds("a gain is by round", function()
  local a, b = { samples = { 10, 20, 30 } }, { samples = { 8, 16, 24 } }
  facts.equal(lab.gain(a, b), 0.25)
end)

facts.holds("a picture that cannot be drawn is a line that says why", function()
  local chart = { title = "t", x = "x", y = "y", kind = "lines", series = { { name = "s", points = { { 1, 2 } } } } }
  local ok, why = plot.draw("/nowhere/picture", chart)
  assert(not ok and not why:find "\n" and why:find "gnuplot", why)
  chart.series[1].points = {}
  ok, why = plot.draw("picture", chart)
  assert(not ok and why:find "no points")
  for _, series in ipairs { {}, false } do
    ok, why = plot.draw("picture", { title = "t", x = "x", y = "y", kind = "bars", series = series or nil })
    assert(not ok and why == "picture: there are no series")
  end
end)

facts.holds("a title may have any characters", function()
  local base = os.tmpname()
  local chart = { title = [[a "b" \c $d `e` 'f' g_h & <i>]], x = "x", y = "y", kind = "bars",
    series = { { name = "s\"s", points = { { "n\"n", 2 } } } } }
  assert(plot.draw(base, chart))
  local svg <close> = assert(io.open(base .. ".svg"))
  local text = svg:read "a"
  assert(text:find([[<title>a "b" \c $d `e` 'f' g_h &amp; &lt;i&gt;</title>]], 1, true), "gnuplot's own title")
  assert(text:find([[g_h &amp; &lt;i></text>]], 1, true), "an underscore made an index")
  assert(text:find("prefers-color-scheme:dark", 1, true), "not for dark pages")
  local drawn = text:gsub("<style>.-</style>", "")
  for _, ink in ipairs { '"black"', '"rgb(51,51,51)"', '"#ffffff"', "rgb(221, 221, 221)" } do
    assert(drawn:find(ink, 1, true), "gnuplot draws with other inks: no " .. ink)
  end
  for _, ending in ipairs { "", ".svg", ".png" } do os.remove(base .. ending) end
end)

facts.holds("bars begin at 0, also those that go down", function()
  local function ticks_of(values)
    local base, ticks = os.tmpname(), {}
    local points = {}
    for i, value in ipairs(values) do points[i] = { "bar" .. i, value } end
    local chart = { title = "t", x = "x", y = "y", kind = "bars", series = { { name = "s", points = points } } }
    assert(plot.draw(base, chart))
    local svg <close> = assert(io.open(base .. ".svg"))
    for tick in svg:read("a"):gmatch "<text> *([-%d.]+)</text>" do ticks[tonumber(tick)] = true end
    for _, ending in ipairs { "", ".svg", ".png" } do os.remove(base .. ending) end
    return ticks
  end
  assert(ticks_of { 7.9, 2.3 }[0])
  assert(ticks_of { -39, -41 }[0])
end)

facts.holds("a logarithmic axis of few powers has ticks to read", function()
  local function script_of(most)
    return plot.script("x", { title = "t", x = "x", y = "y", kind = "lines", log = "y",
      series = { { name = "s", points = { { 0, 3 }, { 1, most, 4, most } } } } })
  end
  assert(script_of(40):find("set ytics ('1' 1, '2' 2, '5' 5, '10' 10, '20' 20, '50' 50", 1, true))
  assert(not script_of(400):find "set ytics")
end)

facts.finish()
