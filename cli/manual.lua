-- SPDX-License-Identifier: MIT
-- Writes the man pages and the completion for bash from what the program's
-- --help says, so that they cannot tell anything else:
--
--   duet lua --trust manual.lua PROGRAM VERSION FOLDER

local program, version, folder = table.unpack(arg)

local function help(command)
  local pipe = assert(io.popen(("'%s' %s --help"):format(program, command)))
  local lines = {}
  for line in pipe:lines() do lines[#lines + 1] = line end
  assert(pipe:close(), command)
  return lines
end

local function write(name, text)
  local file = assert(io.open(folder .. "/" .. name, "w"))
  assert(file:write(text))
  assert(file:close())
end

-- ---------------------------------------------------------------- reading

-- "  -n, --objects N  text" -> { flags = "-n, --objects", value = "N", text = ... }
local function read_option(line)
  local flags, rest = line:match("^  (%-%a, %-%-[%w-]+) (.*)")
  if not flags then flags, rest = line:match("^  (%-%-[%w-]+) (.*)") end
  if not flags then return nil end
  local value, text = rest:match("^(%u%S*) +(.*)")
  return { flags = flags, value = value, text = (text or rest):match("^ *(.*)") }
end

-- "  list     what it does", also the variables of the environment
local function read_entry(line)
  local name, text = line:match("^  ([%a_]+)  *(.*)")
  return name and { flags = name, text = text }
end

local function read_page(command)
  local lines = help(command)
  local page = { command = command, synopsis = lines[1], about = {}, rows = {} }
  for i = 2, #lines do
    local row = read_option(lines[i]) or read_entry(lines[i])
    if row then
      page.rows[#page.rows + 1] = row
    elseif lines[i] ~= "" then
      page.about[#page.about + 1] = lines[i]
    end
  end
  return page
end

-- ---------------------------------------------------------------- man pages

local function roff(text)
  text = text:gsub("\\", "\\e"):gsub("%-", "\\-")
  return (text:gsub("^[.']", "\\&%0"))
end

local function man_row(row)
  local head = "\\fB" .. roff(row.flags) .. "\\fR"
  if row.value then head = head .. " \\fI" .. roff(row.value) .. "\\fR" end
  return (".TP\n%s\n%s\n"):format(head, roff(row.text))
end

local function man_page(page, summary)
  local name = ("duet " .. page.command):gsub(" +$", ""):gsub(" ", "-")
  local out = {
    (".TH %s 1 \"\" \"Duet %s\" \"User commands\"\n"):format(roff(name:upper()), version),
    (".SH NAME\n%s \\- %s\n"):format(roff(name), roff(summary)),
    (".SH SYNOPSIS\n.B %s\n"):format(roff(page.synopsis)),
    ".SH DESCRIPTION\n",
  }
  for _, line in ipairs(page.about) do out[#out + 1] = roff(line) .. "\n" end
  out[#out + 1] = page.rows[1].flags:match("^%-") and ".SH OPTIONS\n" or ".SH COMMANDS\n"
  for _, row in ipairs(page.rows) do
    if row.flags == "DUET_PROFILE" then out[#out + 1] = ".SH ENVIRONMENT\n" end
    out[#out + 1] = man_row(row)
  end
  out[#out + 1] = ".SH EXIT STATUS\n0: done. 1: it failed; one line on stderr says why. "
    .. "2: the command line is wrong. 130, as a shell shows it: Ctrl\\-C ended it.\n"
  if name ~= "duet" then out[#out + 1] = ".SH SEE ALSO\n.BR duet (1)\n" end
  write(name .. ".1", table.concat(out))
end

-- ---------------------------------------------------------------- completion

local function words(page)
  local all = {}
  for _, row in ipairs(page.rows) do
    for flag in row.flags:gmatch("[^ ,]+") do all[#all + 1] = flag end
  end
  return table.concat(all, " ")
end

local completion = [=[
# Completion of duet's command line for bash. Written from duet --help.
_duet() {
  local current=${COMP_WORDS[COMP_CWORD]} words
  case "$COMP_CWORD:${COMP_WORDS[1]:-} ${COMP_WORDS[2]:-}" in
@CASES    *) return ;;
  esac
  if [[ $COMP_CWORD -eq 1 || $current == -* || $words != -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  fi
}
complete -o default -F _duet duet
]=]

-- What may stand at a place of the command line, by the words before it.
local function case(pattern, page)
  return ("    %s) words='%s' ;;\n"):format(pattern, words(page))
end

-- ---------------------------------------------------------------- all of it

local main = read_page("")
local cases = {}
man_page(main, "collisions among boxes, found by two OpenCL devices together")

local function subcommand(row, before)
  local command = before .. row.flags
  local page = read_page(command)
  man_page(page, row.text)
  local has_verbs = not page.rows[1].flags:match("^%-")
  if has_verbs then
    for _, verb in ipairs(page.rows) do subcommand(verb, command .. " ") end
    cases[#cases + 1] = case(("2:'%s '*"):format(command), page)
  elseif before == "" then
    cases[#cases + 1] = case(("*:'%s '*"):format(command), page)
  else
    cases[#cases + 1] = case(("[3-9]*:'%s'"):format(command), page)
  end
end

for _, row in ipairs(main.rows) do
  if row.flags:match("^%l") then subcommand(row, "") end
end
table.insert(cases, 1, case("1:*", { rows = main.rows }))
write("duet.bash", (completion:gsub("@CASES", (table.concat(cases):gsub("%%", "%%%%")))))
