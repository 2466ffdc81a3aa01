-- SPDX-License-Identifier: MIT
-- What the prompt of `duet lua` knows: which names may follow what is typed, and help.
-- Gets is_name of show.lua, class_names of lua/class.h and the list of api.lua; gives back complete(word,
-- globals) and help(value). It needs no more of Lua than an untrusted script has.

local is_name <const>, names_of_object <const>, api <const> = ...

-- ---------------------------------------------------------------- completion

local keywords <const> = { "and", "break", "do", "else", "elseif", "end", "false", "for", "function", "goto", "if", "in",
  "local", "nil", "not", "or", "repeat", "return", "then", "true", "until", "while" }

local function names_in(value, methods_only)
  local class, fields, methods = names_of_object(value)
  if class then return methods_only and methods or fields end
  local names = {}
  for key, member in pairs(type(value) == "table" and value or {}) do
    if type(key) == "string" and (not methods_only or type(member) == "function") then names[#names + 1] = key end
  end
  return names
end

-- The place of the last . or : of a name, or nil.
local function last_separator(name)
  for i = #name, 1, -1 do
    local c = name:sub(i, i)
    if c == "." or c == ":" then return i end
  end
end

local function path_of(name) return name:sub(1, (last_separator(name) or 1) - 1) end

local function last_name(name) return name:sub((last_separator(name) or 0) + 1) end

-- The value of a path such as "duet.device_pair".
local function value_at(globals, path)
  if path == "" then return globals end
  return value_at(globals, path_of(path))[last_name(path)]
end

-- "duet.de", "pair:wo", "du" -> the whole words, in order, a line each.
local function complete(word, globals)
  local path, part, found = path_of(word), last_name(word), {}
  local before = word:sub(1, #word - #part)
  local value, names = value_at(globals, path), before == "" and keywords or {}
  for _, list in ipairs { names, names_in(value, before:sub(-1) == ":") } do
    for _, name in ipairs(list) do
      if name:sub(1, #part) == part and is_name(name) then found[#found + 1] = before .. name end
    end
  end
  table.sort(found)
  return table.concat(found, "\n")
end

-- ---------------------------------------------------------------- help

local overview <const> = [[
The value of an expression is printed; Tab completes names; Ctrl-C stops what runs, Ctrl-D ends.

  pair = duet.device_pair()              the default devices; or "cpu,gpu", or "halves" of the CPU
  scene = duet.scene("paper")            objects: a scene that comes with Duet, or a file
  world = pair:world(scene)              the objects on the devices
  result = world:step()                  all pairs that collide
  result:stages()                        where the time went

help(pair), help(duet.scene) and help "World" tell more. The names of the module:
]]

-- "duet.scene(from, settings?)"; for a value its name alone.
local function heading(row)
  if type(row[2]) == "string" then return row[1] end
  local names = {}
  for i, parameter in ipairs(row[2]) do names[i] = parameter:sub(1, parameter:find(":", 1, true) - 1) end
  return ("%s(%s)"):format(row[1], table.concat(names, ", "))
end

local function about(row) return type(row[2]) == "string" and row[3] or row[4] end

local function print_rows(rows)
  local width = 0
  for _, row in ipairs(rows) do width = math.max(width, #heading(row)) end
  for _, row in ipairs(rows) do
    print(("  %s%s  %s"):format(heading(row), (" "):rep(width - #heading(row)), about(row) or ""))
  end
end

local function rows_where(matches)
  local rows = {}
  for _, row in ipairs(api.names) do
    if matches(row[1]) then rows[#rows + 1] = row end
  end
  return rows
end

-- "duet.device_pair", "DevicePair" and "pair" alike.
local function plain(name)
  local letters = {}
  for i = name:sub(1, 5) == "duet." and 6 or 1, #name do
    local c = name:sub(i, i)
    letters[#letters + 1] = c ~= "_" and c:lower() or nil
  end
  return table.concat(letters)
end

local function name_of(value)
  if type(value) == "string" then return value end
  for name, member in pairs(duet) do
    if member == value then return "duet." .. name end
  end
  return (names_of_object(value))
end

-- Arrays are many, and made alike.
local function print_overview()
  local arrays, others = {}, {}
  for _, row in ipairs(rows_where(function(name) return path_of(name) == "duet" and last_name(name) >= "a" end)) do
    local is_array = (row[4] or ""):find("Made of a number of rows", 1, true)
    if is_array then arrays[#arrays + 1] = last_name(row[1]) else others[#others + 1] = row end
  end
  print(overview)
  print_rows(others)
  print "\nArrays of rows are made by duet.NAME(rows); help(duet.poses) says what its rows are. The names:\n"
  local line = " "
  for _, name in ipairs(arrays) do
    if #line + 1 + #name > 79 then
      print(line)
      line = " "
    end
    line = line .. " " .. name
  end
  print(line)
end

local function help(value)
  if value == nil then return print_overview() end
  local wanted = plain(name_of(value) or tostring(value))
  for _, class in ipairs(api.classes) do
    if plain(class[1]) == wanted then print(class[1] .. ": " .. class[2]) end
  end
  local rows = rows_where(function(name)
    return plain(name) == wanted or plain(path_of(name)) == wanted
  end)
  print_rows(rows)
  if #rows == 0 then print(("there is no help on '%s'; help() lists the names"):format(wanted)) end
end

return complete, help
