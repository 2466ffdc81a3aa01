-- SPDX-License-Identifier: MIT
-- Words of reports for people. A script adds lines and tables and returns `report.told`, which
-- layout.lua lays out: a string is a line; a list is a table, first a letter for each column, l or r, then cells.
local report = ...
local text, number, count = report.text, report.number, report.count
local told = {}
report.told = told

function report.line(format, ...) told[#told + 1] = format:format(...) end

-- A line that goes on below, further in, if it is wider than a terminal.
function report.wrapped(format, ...)
  local rest, at = format:format(...), 81
  while #rest > 80 and at > 4 do
    at = 81
    while at > 4 and rest:sub(at, at) ~= " " do at = at - 1 end
    if at > 4 then told[#told + 1], rest = rest:sub(1, at - 1), "    " .. rest:sub(at + 1) end
  end
  told[#told + 1] = rest
end

-- A table with these heads, if any. Returns the function that adds a row; a cell that is nil is left out.
function report.columns(align, ...)
  local rows = { align }
  local function row(...)
    for i = 1, select("#", ...) do
      local cell = select(i, ...)
      if cell ~= nil then rows[#rows + 1] = cell end
    end
  end
  told[#told + 1] = rows
  row(...)
  return row
end

-- The command's options, each with its value; words may be quoted.
local function options_of(whole)
  local options, from, quoted, i = {}, 1, false, 1
  while i <= #whole do
    local c = whole:sub(i, i)
    if c == "'" then quoted = not quoted end
    if c == "\\" and not quoted then i = i + 1 end
    if c == " " and not quoted and whole:sub(i + 1, i + 1) == "-" then
      options[#options + 1] = whole:sub(from, i - 1)
      from = i + 1
    end
    i = i + 1
  end
  options[#options + 1] = whole:sub(from)
  return options
end

-- A command to paste: a line that would be wider than a terminal goes on after a backslash.
function report.command(whole)
  local lines, column = "", 0
  for i, option in ipairs(options_of(whole)) do
    if i > 1 and column + 1 + #option > 78 then
      lines, column = lines .. " \\\n  ", 0
    end
    local gap = column > 0 and " " or "  "
    lines, column = lines .. gap .. option, column + #gap + #option
  end
  told[#told + 1] = lines
end

-- "1 box", "2 000 boxes"
function report.things(n, one, many) return count(n) .. " " .. (n == 1 and one or many) end

-- "98.3 million", "14 800": three digits
function report.rate(a_second)
  if a_second >= 999500 then return ("%.3g million"):format(a_second * 1e-6) end
  local unit = a_second < 1000 and 1 or 10 ^ (math.floor(math.log(a_second, 10)) - 2)
  return count(math.floor(a_second / unit + 0.5) * unit + 0.5)
end

-- "12.3 MB"
function report.bytes(n)
  local units, unit = { "B", "kB", "MB", "GB", "TB", "PB", "EB" }, 1
  while n >= 999.5 and unit < #units do n, unit = n / 1000, unit + 1 end
  return (unit > 1 and n < 99.5 and "%.1f %s" or "%.0f %s"):format(n, units[unit])
end

-- A bar of part (0 to 1) of the width in characters; in eighths of one if the terminal has UTF-8.
function report.bar(part, width)
  local left = math.floor(math.max(0, math.min(part, 1)) * width * 8 + 0.5)
  if not in_utf8 then return ("#"):rep((left + 4) // 8) end
  local rest = left % 8
  return ("█"):rep(left // 8) .. (rest > 0 and utf8.char(0x2590 - rest) or "")
end

local function percents(format, row, name, ...)
  return format:format(100 * row[name], 100 * row[name .. "_low"], 100 * row[name .. "_high"], ...)
end

-- Percent by which the other is quicker where one gains so much over it.
local function lead_of_other(gain) return 100 * (1 / (1 + gain) - 1) end

-- The gain of a plan; if one device does it all, which one, and what sharing would gain, which is why it does.
function report.gain(row)
  local alone = (row.share == 0 and "B" or "A") .. " alone; "
  if row.share > 0 and row.share < 1 then
    return percents("%+.1f %% (%+.1f to %+.1f) over the best single device: %s", row, "gain", row.verdict)
  elseif row.verdict == "slower" and (row.joules or row.objective == "energy") then
    return alone .. ("sharing would take %.1f %% more energy (%.1f to %.1f)"):format(lead_of_other(row.gain),
      lead_of_other(row.gain_high), lead_of_other(row.gain_low))
  elseif row.verdict == "slower" then
    return alone .. ("sharing would be %.1f %% slower (%.1f to %.1f)"):format(-100 * row.gain, -100 * row.gain_high,
      -100 * row.gain_low)
  elseif row.verdict == "ambiguous" then
    return alone .. "not certain what sharing gains"
  elseif number(row, "gain_low") < number(row, "gain_high") then
    return alone .. percents("sharing may gain nothing: %+.1f %% (%+.1f to %+.1f)", row, "gain")
  end
  return alone .. "no share promises more"
end

-- How one device by itself compares with a plan. selector: what --pair takes for it, or nil.
function report.whole(name, selector, row)
  name = report.cut(name, 40)
  if row.whole_gain_high < 0 then
    return ("%s by itself is %.1f %% faster (%.1f to %.1f): use --pair %s"):format(name, lead_of_other(row.whole_gain),
      lead_of_other(row.whole_gain_high), lead_of_other(row.whole_gain_low), selector or "with it alone")
  elseif row.whole_gain_low > 0 then
    return ("%.1f %% faster than %s by itself (%.1f to %.1f)"):format(100 * row.whole_gain, name,
      100 * row.whole_gain_low, 100 * row.whole_gain_high)
  end
  return ("about as fast as %s by itself: "):format(name) .. percents("%+.1f %% (%+.1f to %+.1f)", row, "whole_gain")
end

-- The members of an object, by name: "least 0.1, repeats 3".
function report.members(o)
  local words = {}
  for name, value in pairs(o) do
    words[#words + 1] = name .. " " .. (type(value) == "table" and "(" .. report.members(value) .. ")"
      or type(value) == "number" and ("%.14g"):format(value) or tostring(value))
  end
  return table.concat(words, ", ")
end

-- Pairs that a level gets wrong; certified needs no word.
function report.wrong_words(row)
  return ("of %s pairs that collide, level %s misses %.3g %% and adds %.3g %% that are false"):format(
    count(number(row, "true_pairs")), text(row, "level"), 100 * number(row, "missed_rate"),
    100 * number(row, "false_rate"))
end

-- How quiet the machine was when a profile was measured.
function report.waited(p) return ("%.0f of %.0f launches waited for a core"):format(p.disturbed, p.watched) end

-- "3 of 20 steps waited for a core; other programs had 40 % of the cores"; nil if none did, or for threads of their own.
function report.disturbed(row)
  if number(row, "disturbed") == 0 or number(row, "cpu_load") < 0.005 then return nil end
  return ("%.0f of %.0f steps waited for a core; other programs had %.0f %% of the cores"):format(row.disturbed,
    row.watched, 100 * row.cpu_load)
end

-- "A 40.00 %", "B alone"
function report.plan_words(share)
  return share > 0 and share < 1 and ("A %.2f %%"):format(100 * share) or share == 0 and "B alone" or "A alone"
end

-- The devices of a plan with their parts of the work. Both or one: A and B are one device that shares nothing.
function report.tell_devices(o)
  local row = report.columns("lllrl")
  local function tell(label, name, part)
    row(label, o[name], o[name .. "_name"], ("%.4g %%"):format(100 * part),
      ("of the work, kernels '%s'"):format(o["variant_" .. name]))
  end
  if report.is_alone(o) then return tell("on", "b", 1) end
  tell("A", "a", o.share)
  tell("B", "b", 1 - o.share)
end

function report.is_alone(o) return o.share == 0 and o.a == o.b end

-- "A alone: pocl:0[0], its name", without the letter if the device is the only one.
function report.device_alone(o, letter)
  local name = letter:lower()
  return ("%s%s, %s"):format(o.a == o.b and "" or letter .. " alone: ", report.cut(o[name], 60),
    report.cut(o[name .. "_name"], 120))
end

-- If both devices have a share.
function report.tell_grids(o)
  if o.share > 0 and o.share < 1 then report.line("grids: %s", o.mode) end
end

-- "paper: 2 000 rotated boxes, 3D"
function report.scene_words(o) return ("%s: %s %s, %.0fD"):format(o.scene, count(o.objects), o.kind, o.dims) end

function report.tell_check(check)
  local all = report.things(check.reference, "pair", "pairs")
  if check.right then return report.line("check: the same %s as the plain C reference", all) end
  report.line("check: WRONG: %s of the reference's %s missing, and %s too many", count(check.missing), all,
    count(check.extra))
end

return report
