-- SPDX-License-Identifier: MIT
-- Makes definitions/duet.lua, from which an editor knows the API (LuaCATS). The build
-- does it: build/release/lua/definitions, share/duet/lua/definitions once installed.

local api = dofile(arg[1])

local function result_type(row)
  if not row.fails then return row[3] end
  return (row[3]:gsub("%?$", "")) .. "?"
end

local function define_function(row)
  local name, parameters, result, about = row[1], row[2], row[3], row[4]
  local lines, names = { "--- " .. about }, {}
  for _, parameter in ipairs(parameters) do
    local its_name, its_type = parameter:match "^(%S+): (.+)$"
    lines[#lines + 1] = "---@param " .. its_name .. " " .. its_type
    names[#names + 1] = (its_name:gsub("%?$", ""))
  end
  if result then lines[#lines + 1] = "---@return " .. result_type(row) end
  if row.fails then
    lines[#lines + 1] = "---@return string? message"
    lines[#lines + 1] = "---@return string? status"
  end
  local place = name:gsub("^duet%.(%u)", "%1")
  lines[#lines + 1] = ("function %s(%s) end\n"):format(place, table.concat(names, ", "))
  return table.concat(lines, "\n")
end

local function define_class(class)
  local name = class[1]
  local lines = { "--- " .. class[2], "---@class " .. name }
  for _, row in ipairs(api.names) do
    local field = row[1]:match("^" .. name:gsub("%.", "%%.") .. "%.([%w_]+)$")
    if field then
      lines[#lines + 1] = ("---@field %s %s%s"):format(field, row[2], row[3] ~= "" and " " .. row[3] or "")
    end
  end
  lines[#lines + 1] = ("local %s = {}\n"):format(name:match "%.(%w+)$")
  return table.concat(lines, "\n")
end

print "---@meta duet\n-- Made from api.lua by define.lua; do not edit.\n"
for _, class in ipairs(api.classes) do print(define_class(class)) end
print "--- Collisions among boxes, found by two OpenCL devices together.\n---@class duet"
for _, row in ipairs(api.names) do
  local field = row[1]:match "^duet%.(%l[%w_]*)$"
  if field and type(row[2]) == "string" then print(("---@field %s %s %s"):format(field, row[2], row[3])) end
end
print "local duet = {}\n"
for _, row in ipairs(api.names) do
  if type(row[2]) == "table" then print(define_function(row)) end
end
print "return duet"
