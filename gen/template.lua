-- SPDX-License-Identifier: MIT
-- Makes a kernel template into Lua. A line that begins with //@ is Lua; in
-- every other line @{expr} stands for the value of expr. The rest is plain OpenCL
-- C, so a template without //@ lines comes out as it went in.
--
-- Line n of the template is line n of the Lua, so that Lua's messages name the
-- template's own lines, and #line does the same for the compiler's.

local template = { modules = {} } -- modules: of gen/emit, by name

local library = { "assert", "error", "ipairs", "math", "pairs", "select", "string", "table",
                  "tonumber", "tostring", "type" }

-- The rows of a text one after the other, each with its end. Most hold nothing of interest, so
-- that it counts how little is done for each.
local function each_row(text)
  local at = 1
  return function()
    if at > #text then return nil end
    local from, to = at, text:find("\n", at, true) or #text
    at = to + 1
    return text:sub(from, to)
  end
end

local function end_row(text)
  return text:sub(-1) == "\n" and text or text .. "\n"
end

-- Behind the //@ of a line of Lua, or nil. Only blanks stand before it.
local function lua_in(row)
  local mark = row:find("//@", 1, true)
  return mark and row:sub(1, mark - 1) == (" "):rep(mark - 1) and row:sub(mark + 3, -2) or nil
end

-- The place of the } that belongs to the { at a place; nil: there is none.
local function closing_brace(row, open)
  local depth = 0
  for at = open, #row do
    local c = row:byte(at)
    depth = depth + (c == 123 and 1 or c == 125 and -1 or 0)
    if depth == 0 then return at end
  end
end

-- 'a @{b} c'  ->  '"a ", (b), " c", "\n"'
local function row_to_args(row, where)
  local args, at, from = {}, 1, row:find("@{", 1, true)
  while from do
    local last = closing_brace(row, from + 1)
    if not last then error(where .. ": '@{' has no '}' on its line", 0) end
    args[#args + 1] = ("%q"):format(row:sub(at, from - 1))
    args[#args + 1] = "(" .. row:sub(from + 2, last - 1) .. ")"
    at, from = last + 1, row:find("@{", last + 1, true)
  end
  args[#args + 1] = ("%q"):format(row:sub(at))
  args[#args + 1] = '"\\n"'
  return table.concat(args, ", ")
end

-- text: the template; path: what Lua's messages call it; line_name: what the
-- compiler's do. Returns a chunk that wants what template.expand gives it.
function template.translate(text, path, line_name)
  local chunk, moved = {}, true
  for row in each_row(end_row(text)) do
    local n = #chunk + 1
    local lua = lua_in(row)
    if lua then
      chunk[n], moved = lua, true
    else
      local sync = moved and ("_put('#line %d %q\\n') "):format(n, line_name) or ""
      chunk[n], moved = sync .. "_put(" .. row_to_args(row:sub(1, -2), path .. ":" .. n) .. ")", false
    end
  end
  return "local _put, _ENV = ... " .. table.concat(chunk, "\n")
end

-- Gives the beginning of the row of a place, at `least` or behind it.
local function row_at(text, place, least)
  while place > least and text:byte(place - 1) ~= 10 do place = place - 1 end
  return place
end

-- Pieces of a text: rows in which neither mark stands, many in one, and each row in which one does.
-- There are few of these, so that most of the text is not looked at row by row.
local function each_piece(text, one, other)
  local at, next_one, next_other = 1, 0, 0
  local function find(mark, last)
    return last >= at and last or text:find(mark, at, true) or math.huge
  end
  return function()
    if at > #text then return nil end
    next_one, next_other = find(one, next_one), find(other, next_other)
    local from, mark = at, math.min(next_one, next_other)
    local row = mark < math.huge and row_at(text, mark, at) or #text + 1
    at = row > from and row or text:find("\n", mark, true) + 1
    return text:sub(from, at - 1)
  end
end

-- The same for headers and plain kernels, one after the other: lines of Lua only choose
-- among the others, which stay as they are and get no #line of their own. A file of which
-- nothing stays leaves no #line 1 either.
function template.translate_choices(text)
  local chunk = { "local _put, _ENV = ... local _head = '' " }
  for piece in each_piece(end_row(text), "//@", "#line 1 ") do
    local lua = lua_in(piece)
    if lua then
      chunk[#chunk + 1] = " " .. lua .. "\n"
    elseif piece:sub(1, 8) == "#line 1 " then
      chunk[#chunk + 1] = (" _head = %q "):format(piece)
    else
      chunk[#chunk + 1] = ("_put(_head, %q) _head = ''"):format(piece)
    end
  end
  return table.concat(chunk)
end

-- Runs a translated template, which finds the names in scope, the modules and
-- the library as its globals.
function template.expand(run, scope)
  local out = {}
  local function put(...)
    for i = 1, select("#", ...) do
      local value = select(i, ...)
      local kind = type(value)
      if kind ~= "string" and kind ~= "number" then
        error("an expression in @{} gives a " .. kind .. ", not a text or a number", 2)
      end
      out[#out + 1] = value
    end
  end
  for name, module in pairs(template.modules) do scope[name] = module end
  for _, name in ipairs(library) do scope[name] = _ENV[name] end
  run(put, scope)
  return table.concat(out)
end

return template
