-- SPDX-License-Identifier: MIT
-- Rows in named columns: printed for people, written as CSV and JSON.
--
--   local f = frame.new { "objects", "ms" }
--   f:add { objects = 1000, ms = 1.5 }
--   f:print()
--   f:write "out/times" -- times.csv and times.json

local frame = {}
frame.__index = frame

-- Columns are names, in order.
function frame.new(columns)
  local known = {}
  for _, name in ipairs(columns) do known[name] = true end
  return setmetatable({ columns = columns, known = known, rows = {} }, frame)
end

-- A value may be missing; a name that is no column is an error.
function frame:add(row)
  for name in pairs(row) do
    if not self.known[name] then error("no column '" .. name .. "'", 2) end
  end
  self.rows[#self.rows + 1] = row
end

-- Each byte that belongs to no UTF-8 character as replace gives it.
local function mend(text, replace)
  local parts, at = {}, 1
  while true do
    local _, bad = utf8.len(text, at)
    parts[#parts + 1] = text:sub(at, (bad or 0) - 1)
    if not bad then return table.concat(parts) end
    parts[#parts + 1] = replace(text:sub(bad, bad))
    at = bad + 1
  end
end

local function hex(c) return ("\\x%02x"):format(c:byte()) end

local function spaced(digits)
  return (digits:reverse():gsub("(%d%d%d)", "%1 "):reverse():gsub("^ ", ""))
end

local function shown(value)
  if value == nil then return "" end
  if math.type(value) == "integer" then return spaced(tostring(value)) end
  if value == 0 then return "0" end
  if type(value) == "number" then
    return ("%." .. (math.abs(value) >= 100 and 0 or math.abs(value) >= 1 and 2 or 4) .. "f"):format(value)
  end
  return (mend(tostring(value):gsub("%c", hex), hex))
end

function frame:print()
  local widths = {}
  for i, name in ipairs(self.columns) do
    widths[i] = utf8.len(name)
    for _, row in ipairs(self.rows) do widths[i] = math.max(widths[i], utf8.len(shown(row[name]))) end
  end
  local function line(value_of, is_number)
    local cells = {}
    for i, name in ipairs(self.columns) do
      local text = value_of(name)
      local space = (" "):rep(widths[i] - utf8.len(text))
      cells[i] = is_number(name) and space .. text or text .. space
    end
    print((table.concat(cells, "  "):gsub("%s+$", "")))
  end
  local function of_numbers(name)
    for _, row in ipairs(self.rows) do
      if row[name] ~= nil then return type(row[name]) == "number" end
    end
    return false
  end
  line(function(name) return name end, of_numbers)
  for _, row in ipairs(self.rows) do
    line(function(name) return shown(row[name]) end, of_numbers)
  end
end

-- ------------------------------------------------------------------ files

local function number_text(value)
  if math.type(value) == "integer" then return tostring(value) end
  return ("%.9g"):format(value)
end

local function csv_value(value)
  if value == nil then return "" end
  if type(value) == "number" then return number_text(value) end
  local text = tostring(value)
  if not text:find '[",\n]' then return text end
  return '"' .. text:gsub('"', '""') .. '"'
end

local escapes = { ['"'] = '\\"', ["\\"] = "\\\\", ["\n"] = "\\n", ["\t"] = "\\t", ["\r"] = "\\r" }

-- A number that JSON cannot say, as a quotient by 0, is null.
local function json_value(value)
  if value == nil or value ~= value or value == math.huge or value == -math.huge then return "null" end
  if type(value) == "number" then return number_text(value) end
  if type(value) == "boolean" then return tostring(value) end
  local text = mend(tostring(value), function() return utf8.char(0xfffd) end)
  return '"' .. text:gsub('[%c"\\]', function(c)
    return escapes[c] or ("\\u%04x"):format(c:byte())
  end) .. '"'
end

function frame:csv()
  local lines = { table.concat(self.columns, ",") }
  for _, row in ipairs(self.rows) do
    local cells = {}
    for i, name in ipairs(self.columns) do cells[i] = csv_value(row[name]) end
    lines[#lines + 1] = table.concat(cells, ",")
  end
  return table.concat(lines, "\n") .. "\n"
end

function frame:json()
  local rows = {}
  for i, row in ipairs(self.rows) do
    local cells = {}
    for k, name in ipairs(self.columns) do cells[k] = json_value(name) .. ": " .. json_value(row[name]) end
    rows[i] = "  {" .. table.concat(cells, ", ") .. "}"
  end
  return "[\n" .. table.concat(rows, ",\n") .. "\n]\n"
end

local function write_file(path, text)
  local file <close>, message = io.open(path, "w")
  if not file then return nil, message end
  return file:write(text)
end

-- PATH.csv and PATH.json; nil and a message where one cannot be written.
function frame:write(path)
  local ok, message = write_file(path .. ".csv", self:csv())
  if not ok then return nil, message end
  ok, message = write_file(path .. ".json", self:json())
  return ok and true, message
end

return frame
