-- SPDX-License-Identifier: MIT
-- Prints values so that a person can read them: tables in order, on one line
-- where they fit, a list of records as columns, an object as its fields, one
-- below the other. Gets class_names of lua/class.h and gives back the function
-- that prints, and is_name; it needs no more of Lua than an untrusted script has.

local names_of_object <const> = ...

local WIDTH <const> = 100
local DEEPEST <const> = 6
local ROWS <const> = 8

local kinds = { number = 1, string = 2, boolean = 3 }

local function comes_before(a, b)
  local kind_a, kind_b = kinds[type(a)] or 4, kinds[type(b)] or 4
  if kind_a ~= kind_b then return kind_a < kind_b end
  if kind_a <= 2 then return a < b end
  return tostring(a) < tostring(b)
end

local function keys_of(t)
  local keys = {}
  for key in pairs(t) do keys[#keys + 1] = key end
  table.sort(keys, comes_before)
  return keys
end

-- Each control character of a text as \x0a.
local function visible(text)
  local parts = {}
  for i = 1, #text do
    local c = text:byte(i)
    parts[i] = (c < 32 or c == 127) and ("\\x%02x"):format(c) or text:sub(i, i)
  end
  return table.concat(parts)
end

local function trim_end(text)
  local last = #text
  while text:byte(last) == 32 do last = last - 1 end
  return text:sub(1, last)
end

local NAME <const> = "abcdefghijklmnopqrstuvwxyz_0123456789"

local function is_name(text)
  for i = 1, #text do
    local place = NAME:find(text:sub(i, i):lower(), 1, true)
    if not place or i == 1 and place > 27 then return false end
  end
  return #text > 0
end

local function replace(text, what, with)
  local parts, at, from = {}, 1, text:find(what, 1, true)
  while from do
    parts[#parts + 1] = text:sub(at, from - 1)
    at = from + #what
    from = text:find(what, at, true)
  end
  return table.concat(parts, with) .. (#parts > 0 and with or "") .. text:sub(at)
end

local function scalar(value)
  if type(value) == "string" then return replace(("%q"):format(value), "\\\n", "\\n") end
  if math.type(value) == "float" then return ("%.6g"):format(value) end
  return tostring(value)
end

-- "name = " or "[7] = "; nothing for a sequence's own places.
local function label(key, n)
  if math.type(key) == "integer" and key >= 1 and key <= n then return "" end
  if type(key) == "string" and is_name(key) then return key .. " = " end
  return "[" .. scalar(key) .. "] = "
end

local describe

local function describe_table(t, indent, above)
  if above[t] then return "{ ... }" end -- itself, further up
  if #above >= DEEPEST then return "{ more }" end
  above[t] = true
  above[#above + 1] = t
  local parts, length, n = {}, 4, #t
  for _, key in ipairs(keys_of(t)) do
    local part = label(key, n) .. describe(t[key], indent .. "  ", above)
    parts[#parts + 1] = part
    length = length + #part + 2
    if part:find "\n" then length = WIDTH + 1 end
  end
  above[#above] = nil
  above[t] = nil
  if #parts == 0 then return "{}" end
  if length + #indent <= WIDTH then return "{ " .. table.concat(parts, ", ") .. " }" end
  return "{\n  " .. indent .. table.concat(parts, ",\n  " .. indent) .. "\n" .. indent .. "}"
end

function describe(value, indent, above)
  if type(value) == "table" then return describe_table(value, indent, above) end
  return scalar(value)
end

-- ---------------------------------------------------------------- records

-- The columns of a list of records; nil for all else. The name leads, and what is a
-- table is only counted.
local function columns_of(list)
  local seen, names = {}, {}
  if #list < 2 or #keys_of(list) ~= #list then return nil end
  for _, record in ipairs(list) do
    if type(record) ~= "table" then return nil end
    for _, key in ipairs(keys_of(record)) do
      if type(key) ~= "string" then return nil end
      if not seen[key] then names[#names + 1] = key end
      seen[key] = true
    end
  end
  for i, name in ipairs(names) do
    if name == "name" then table.insert(names, 1, table.remove(names, i)) end
  end
  return #names > 0 and names or nil
end

local function cell(value)
  if value == nil then return "" end
  if type(value) == "table" then return ("{ %d }"):format(#keys_of(value)) end
  if type(value) ~= "string" then return scalar(value) end
  return visible(value)
end

local function describe_records(list, names)
  local widths, lines, total = {}, {}, 0
  for i, name in ipairs(names) do
    widths[i] = utf8.len(name)
    for _, record in ipairs(list) do
      widths[i] = math.max(widths[i], utf8.len(cell(record[name])) or 0)
    end
    total = total + widths[i] + 2
  end
  if total > 2 * WIDTH then return nil end
  local function line(value_of)
    local cells = {}
    for i, name in ipairs(names) do
      local value = value_of(name)
      local text = cell(value)
      local space = (" "):rep(widths[i] - (utf8.len(text) or 0))
      cells[i] = type(value) == "number" and space .. text or text .. space
    end
    lines[#lines + 1] = trim_end(table.concat(cells, "  "))
  end
  line(function(name) return name end)
  for _, record in ipairs(list) do
    line(function(name) return record[name] end)
  end
  return table.concat(lines, "\n")
end

-- The first rows of an array, each after its place.
local function show_rows(array)
  local rows, widths, lines = {}, {}, { tostring(array) }
  for i = 1, math.min(#array, ROWS) do
    rows[i] = { i - 1, array:get(i - 1) }
    for k, value in ipairs(rows[i]) do
      rows[i][k] = scalar(value)
      widths[k] = math.max(widths[k] or 0, #rows[i][k])
    end
  end
  for i, row in ipairs(rows) do
    for k, text in ipairs(row) do row[k] = (" "):rep(widths[k] - #text) .. text end
    lines[i + 1] = "  " .. table.concat(row, "  ")
  end
  if #array > ROWS then lines[#lines + 1] = "  ..." end
  return table.concat(lines, "\n")
end

local function show_object(value, fields)
  local text = tostring(value)
  local lines, width = { text:sub(1, (text:find(" ", 1, true) or 0) - 1) }, 0
  if text:sub(-5) == " rows" then return show_rows(value) end
  if #fields == 0 or text:sub(-8) == "(closed)" then return text end
  for _, name in ipairs(fields) do width = math.max(width, #name) end
  for _, name in ipairs(fields) do
    lines[#lines + 1] = ("  %s%s  %s"):format(name, (" "):rep(width - #name), describe(value[name], "", {}))
  end
  return table.concat(lines, "\n")
end

local function show(value)
  if type(value) == "string" then return value end
  local class, fields = names_of_object(value)
  if class then return show_object(value, fields) end
  if type(value) ~= "table" then return scalar(value) end
  local names = columns_of(value)
  return names and describe_records(value, names) or describe(value, "", {})
end

return function(...)
  local texts = {}
  for i = 1, select("#", ...) do texts[i] = show((select(i, ...))) end
  print(table.concat(texts, "\t"))
end, is_name
