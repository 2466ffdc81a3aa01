-- SPDX-License-Identifier: MIT
-- Makes a kernel template into Lua. A line that begins with //@ is Lua; in
-- every other line @{expr} stands for the value of expr. What is left is plain
-- OpenCL C, so a template without //@ lines comes out as it went in.
--
-- Line n of the template is line n of the Lua, so that Lua's messages name the
-- template's own lines, and #line does the same for the compiler's.

local template = { modules = {} } -- modules: of gen/emit, by name

local library = { "assert", "error", "ipairs", "math", "pairs", "select", "string", "table",
                  "tonumber", "tostring", "type" }

-- 'a @{b} c'  ->  '"a ", (b), " c", "\n"'
local function row_to_args(row, where)
  local args, at = {}, 1
  for from, expr, to in row:gmatch("()@(%b{})()") do
    args[#args + 1] = ("%q"):format(row:sub(at, from - 1))
    args[#args + 1] = "(" .. expr:sub(2, -2) .. ")"
    at = to
  end
  if row:find("@{", at, true) then error(where .. ": '@{' has no '}' on its line", 0) end
  args[#args + 1] = ("%q"):format(row:sub(at))
  args[#args + 1] = '"\\n"'
  return table.concat(args, ", ")
end

-- text: the template; path: what Lua's messages call it; line_name: what the
-- compiler's do. Returns a chunk that wants what template.expand gives it.
function template.translate(text, path, line_name)
  local chunk, moved = {}, true
  for row in (text:gsub("\n?$", "\n", 1)):gmatch("(.-)\n") do
    local n = #chunk + 1
    local lua = row:match("^%s*//@(.*)$")
    if lua then
      chunk[n], moved = lua, true
    else
      local sync = moved and ("_put('#line %d %q\\n') "):format(n, line_name) or ""
      chunk[n], moved = sync .. "_put(" .. row_to_args(row, path .. ":" .. n) .. ")", false
    end
  end
  return "local _put, _ENV = ... " .. table.concat(chunk, "\n")
end

-- The same for headers and plain kernels, one after the other: lines of Lua only choose
-- among the others, which stay as they are and get no #line of their own. A file of which
-- nothing stays leaves no #line 1 either.
function template.translate_choices(text)
  local chunk, rows = { "local _head = '' " }, {}
  local function put_rows()
    if #rows == 0 then return end
    chunk[#chunk + 1] = ("_put(_head, %q) _head = ''"):format(table.concat(rows))
    rows = {}
  end
  for row in (text:gsub("\n?$", "\n", 1)):gmatch("(.-\n)") do
    local lua = row:match("^%s*//@(.*)\n$")
    if lua then
      put_rows()
      chunk[#chunk + 1] = " " .. lua .. "\n"
    elseif row:match("^#line 1 ") then
      put_rows()
      chunk[#chunk + 1] = (" _head = %q "):format(row)
    else
      rows[#rows + 1] = row
    end
  end
  put_rows()
  return "local _put, _ENV = ... " .. table.concat(chunk)
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
