-- SPDX-License-Identifier: MIT
-- Writes the man pages and the completion for bash from what the program's
-- --help says, so that they cannot tell anything else:
--
--   duet lua --trust manual.lua PROGRAM VERSION DATE EXAMPLES FOLDER
--
-- EXAMPLES is examples.md beside this file: a heading for each subcommand, then
-- sentences, each before a block of commands.

local duet = require "duet"
local program, version, date, examples_path, folder = table.unpack(arg)

-- The lines that a program prints; none where it fails.
local function lines_of(command)
  local pipe <close> = assert(io.popen(("'%s' %s 2>&1"):format(program, command)))
  local lines = {}
  for line in pipe:lines() do lines[#lines + 1] = line end
  return assert(pipe:close(), command) and lines
end

local function write(name, text)
  local file <close> = assert(io.open(folder .. "/" .. name, "w"))
  assert(file:write(text))
end

-- ---------------------------------------------------------------- reading

-- "  -n, --objects N  text" -> { flags = { "-n", "--objects" }, value = "N", text = ... }
local function read_option(line)
  local flags, rest = line:match "^  (%-%a, %-%-[%w-]+) (.*)"
  if not flags then flags, rest = line:match "^  (%-%-[%w-]+) (.*)" end
  if not flags then return nil end
  local names = {}
  for name in flags:gmatch "[^ ,]+" do names[#names + 1] = name end
  local value, text = rest:match "^(%u%S*) +(.*)"
  return { flags = names, value = value, text = (text or rest):match "^ *(.*)" }
end

-- "  list     what it does" -> { name = "list", text = ... }
local function read_verb(line)
  local name, text = line:match "^  (%l+)  +(.*)"
  return name and { name = name, text = text }
end

-- "DUET_CACHE  a folder" -> { name = "DUET_CACHE", text = ... }
local function read_variable(line)
  local name, text = line:match "^(%u[%u_]+)  +(.*)"
  return name and { name = name, text = text }
end

local function read_page(command)
  local page = { command = command, name = "duet" .. (command == "" and "" or "-" .. command:gsub(" ", "-")),
    about = {}, options = {}, verbs = {}, variables = {} }
  for _, line in ipairs(lines_of(command .. " --help")) do
    local option, verb, variable = read_option(line), read_verb(line), read_variable(line)
    if option then
      table.insert(page.options, option)
    elseif verb then
      table.insert(page.verbs, verb)
    elseif variable then
      table.insert(page.variables, variable)
    elseif not page.usage and line:match "^duet " and not line:match "^duet %d" then
      page.usage = line
    elseif line ~= "" and not line:match "^duet %d" and not line:match "^exit status:" then
      table.insert(page.about, line) -- the exit status has a section of its own
    end
  end
  return page
end

-- By subcommand: a list of text, commands.
local function read_examples(path)
  local by_name, list, text, commands = {}, nil, {}, nil
  for line in assert(io.lines(path)) do
    local heading = line:match "^## duet *(.*)"
    if heading then
      list = {}
      by_name[heading] = list
    elseif line == "```sh" then
      commands = {}
    elseif line == "```" then
      list[#list + 1] = { text = table.concat(text, " "), commands = commands }
      text, commands = {}, nil
    elseif commands then
      commands[#commands + 1] = line
    elseif list and line ~= "" and not line:match "^<!%-%-" then
      text[#text + 1] = line
    end
  end
  return by_name
end

-- ---------------------------------------------------------------- man pages

local specials = { ["\\"] = "\\e", ["-"] = "\\-", ["'"] = "\\(aq", ["`"] = "\\(ga", ["^"] = "\\(ha", ["~"] = "\\(ti" }
local function roff(text)
  return (text:gsub("[\\%-'`^~]", specials):gsub("^%.", "\\&."))
end

local function bold(text) return "\\fB" .. roff(text) .. "\\fR" end
local function italic(text) return "\\fI" .. roff(text) .. "\\fR" end

-- A sentence a line, and none of them long.
local function paragraph(text)
  local lines, line = {}, ""
  for word in text:gmatch "%S+" do
    word = roff(word)
    if line ~= "" and #line + 1 + #word > 79 or line:match "[.;:]$" then
      lines[#lines + 1] = line
      line = ""
    end
    line = line == "" and word or line .. " " .. word
  end
  lines[#lines + 1] = line
  return table.concat(lines, "\n") .. "\n"
end

local function entry(head, text) return (".TP\n%s\n%s"):format(head, paragraph(text)) end

-- "duet run SCENE|FILE [options]": the subcommand bold, what stands for something italic.
local function synopsis(page)
  local words = ("duet " .. page.command):gsub(" +$", "")
  local rest = page.usage:sub(#words + 2):gsub("[%w.]+", function(word) return italic(word) end)
  return bold(words) .. " " .. rest .. "\n"
end

local function option_entry(option)
  local flags = {}
  for i, flag in ipairs(option.flags) do flags[i] = bold(flag) end
  local head = table.concat(flags, ", ")
  return entry(option.value and head .. " " .. italic(option.value) or head, option.text)
end

local store <const> = { "$XDG_DATA_HOME/duet/profiles.db, ~/.local/share/duet/profiles.db",
  "The profile store, where DUET_PROFILE names no other." }
local cache <const> = { "$XDG_CACHE_HOME/duet, ~/.cache/duet", "Built kernels, where DUET_CACHE names no other folder." }
local folders <const> = { "/usr/share/duet, /usr/share/doc/duet",
  "Scenes and experiments to begin with, and documents, where Duet was installed from packages." }
local files <const> = {
  duet = { store, cache, folders },
  ["duet-lua"] = { { "$XDG_STATE_HOME/duet/lua_history, ~/.local/state/duet/lua_history",
    "What was typed at the prompt. Where it cannot be written, nothing is kept." }, store, cache, folders },
}

-- The store of those that name it or take a plan from it, and the cache of those that use devices.
local function files_of(page)
  local options, found = {}, {}
  for _, option in ipairs(page.options) do options[option.flags[1]] = true end
  if options["--profile"] or options["--share"] then found[#found + 1] = store end
  if options["--pair"] or options["--device"] then found[#found + 1] = cache end
  return found
end

-- The pages that a page names, as 'duet tune', and those above and below it.
local function related(page, pages)
  local names, known = {}, { [page.name] = true }
  local function add(name)
    if pages[name] and not known[name] then
      known[name] = true
      names[#names + 1] = name
    end
  end
  add "duet"
  add((page.name:match "^(.*)%-"))
  for _, verb in ipairs(page.verbs) do add(page.name .. "-" .. verb.name) end
  local text = table.concat(page.about, " ")
  for _, option in ipairs(page.options) do text = text .. " " .. option.text end
  for name in text:gmatch "'(duet [%l ]+)" do
    add(name:gsub(" ", "-"))
    add((name:match "^duet %l+"):gsub(" ", "-"))
  end
  return names
end

local function man_page(page, pages, main, examples)
  local out = {}
  local function add(text) out[#out + 1] = text end
  local function section(title) add(".SH " .. title .. "\n") end
  add((".TH %s 1 \"%s\" \"Duet %s\" \"User Commands\"\n"):format(roff(page.name:upper()), date, version))
  section "NAME"
  add(("%s \\- %s\n"):format(roff(page.name), roff(page.summary)))
  section "SYNOPSIS"
  add(synopsis(page))
  section "DESCRIPTION"
  add(paragraph(table.concat(page.about, " ")))
  if #page.verbs > 0 then section "COMMANDS" end
  for _, verb in ipairs(page.verbs) do add(entry(bold(verb.name), verb.text)) end
  if #page.options > 0 then section "OPTIONS" end
  for _, option in ipairs(page.options) do add(option_entry(option)) end
  section "EXAMPLES"
  for i, example in ipairs(examples) do
    if i > 1 then add ".PP\n" end
    add(paragraph(example.text))
    add ".PP\n.EX\n"
    for _, command in ipairs(example.commands) do add("    " .. bold(command) .. "\n") end
    add ".EE\n"
  end
  section "ENVIRONMENT"
  for _, variable in ipairs(main.variables) do add(entry(bold(variable.name), variable.text)) end
  local own_files = files[page.name] or files_of(page)
  if #own_files > 0 then section "FILES" end
  for _, file in ipairs(own_files) do add(entry(italic(file[1]), file[2])) end
  section "EXIT STATUS"
  add(entry(bold "0", "It did what was asked."))
  add(entry(bold "1", "It failed, and one line on stderr says what, where and why; or duet bench --against found something slower."))
  add(entry(bold "2", "The command line is wrong."))
  add(entry(bold "130", "Ctrl-C stopped it; what was measured until then is kept. The program ends by the signal, so that SIGTERM shows as 143 and SIGHUP as 129."))
  section "SEE ALSO"
  local names = related(page, pages)
  for i, name in ipairs(names) do
    add((".BR %s (1)%s\n"):format(roff(name), i < #names and "," or ""))
  end
  write(page.name .. ".1", table.concat(out))
end

-- ---------------------------------------------------------------- completion

-- "how grids are built: shared, own or slab" -> { "shared", "own", "slab" }
local function choices(text)
  local list = (text:match ": (.*)$" or ""):gsub("%b()", ""):gsub(" or ", ", ")
  local words = {}
  for item in list:gmatch "[^,]+" do
    local word = item:match "^ *(%l[%w_]*) *$"
    if not word then return {} end
    words[#words + 1] = word
  end
  return #words > 1 and words or {}
end

local function names_of(list)
  local names = {}
  for i, one in ipairs(list) do names[i] = one.name end
  return names
end

-- The first words of the lines that begin with one.
local function first_words(lines)
  local words = {}
  for _, line in ipairs(lines) do words[#words + 1] = line:match "^(%l[%w_]*)  " end
  return words
end

-- Values of an option of this name, if --help does not list them.
local function find_values(pages)
  local values = {}
  for _, page in pairs(pages) do
    for _, option in ipairs(page.options) do
      local found = choices(option.text)
      if #found > 0 and not option.value:match "^FILE" then values[option.flags[#option.flags]] = found end
    end
  end
  values["--level"], values["--mode"] = names_of(duet.levels()), duet.modes()
  for _, name in ipairs { "--variants", "--variant-a", "--variant-b" } do values[name] = values["--variant"] end
  return values
end

local completion <const> = [=[
# Completion of duet's command line for bash. Written from duet --help.

# Words that begin as the word being typed does; after a comma or "=", as what follows it.
_duet_words() {
  local before=
  [[ $word == *[,=]* ]] && before=${word%"${word##*[,=]}"}
  mapfile -t COMPREPLY < <(compgen -P "$before" -W "$1" -- "${word#"$before"}")
}

_duet_devices() {
  duet devices 2>/dev/null | sed -n 's/^\([a-z]*:[0-9]*\)  .*/\1/p; s/^without --pair: //p' | tr , '\n' | sort -u
}
_duet_profiles() { duet profiles list "$@" 2>/dev/null | sed -n 's/^\([0-9a-f]\{4,\}\)  .*/\1/p'; }

# What may follow this option.
_duet_value() {
  case $1 in
@VALUES    --pair | --other-pair) _duet_words "$(_duet_devices) cpu gpu halves" ;;
    --device) _duet_words "$(_duet_devices) cpu gpu" ;;
    *) COMPREPLY=() ;; # a file
  esac
}

# What may stand in place of a scene, a kernel, a profile.
_duet_operand() {
  case $1 in
@OPERANDS    *) COMPREPLY=() ;;
  esac
}

_duet() {
  local line=${COMP_LINE:0:COMP_POINT} word typed words command last
  word=${line##*[[:space:]]}
  read -ra typed <<< "${line%"$word"}"
  last=${typed[-1]}
  COMPREPLY=()
  case "${typed[1]:-} ${typed[2]:-} " in
@CASES    *) return ;;
  esac
  if [[ $word == --*=* ]]; then
    _duet_value "${word%%=*}"
  elif [[ " @VALUED " == *" $last "* ]]; then
    _duet_value "$last"
  elif [[ $word == -* || $words != -* ]]; then
    _duet_words "$words"
  else
    _duet_operand "$command"
  fi
  # Bash cuts words at colons and "=": what lies before is not typed again.
  local cut=${word%"${word##*[${COMP_WORDBREAKS:-:=}]}"} i
  for i in "${!COMPREPLY[@]}"; do COMPREPLY[i]=${COMPREPLY[i]#"$cut"}; done
}
complete -o default -F _duet duet
]=]

-- Words that may stand at a place of the command line, by those before it.
local function case(pattern, page)
  local words = {}
  for _, option in ipairs(page.options) do table.move(option.flags, 1, #option.flags, #words + 1, words) end
  for _, verb in ipairs(page.verbs) do words[#words + 1] = verb.name end
  if #page.options == 0 then table.move({ "--help", page.command == "" and "--version" or nil }, 1, 2, #words + 1, words) end
  return ("    %s) command='%s' words='%s' ;;\n"):format(pattern, page.command, table.concat(words, " "))
end

local function write_completion(ordered, pages, main)
  local parts = { VALUES = {}, OPERANDS = {}, CASES = { case("' '*", main) }, VALUED = {} }
  local function add(part, format, ...) table.insert(parts[part], format:format(...)) end
  local scenes = pages["duet-scenes"] and table.concat(first_words(lines_of "scenes"), " ") or ""
  local valued = {}
  for _, page in ipairs(ordered) do
    if page ~= main then
      add("CASES", "%s", case(("'%s '%s"):format(page.command, #page.verbs > 0 and "' '" or "*"), page))
    end
    if (page.usage:match "SCENE" or page.command == "scenes") and scenes ~= "" then
      add("OPERANDS", "    '%s') _duet_words '%s' ;;\n", page.command, scenes)
    end
    for _, option in ipairs(page.options) do
      for _, flag in ipairs(option.value and option.flags or {}) do
        if not valued[flag] then parts.VALUED[#parts.VALUED + 1] = flag .. " " end
        valued[flag] = true
      end
    end
  end
  add("OPERANDS", "    'source') _duet_words '%s' ;;\n", table.concat(first_words(lines_of "source --list"), " "))
  add("OPERANDS", "    'profiles show') _duet_words \"$(_duet_profiles)\" ;;\n")
  local values = find_values(pages)
  for name, words in pairs(values) do add("VALUES", "    %s) _duet_words '%s' ;;\n", name, table.concat(words, " ")) end
  table.sort(parts.VALUES)
  write("duet.bash", (completion:gsub("@(%u+)", function(name) return table.concat(parts[name]) end)))
end

-- ---------------------------------------------------------------- all of it

local main = read_page ""
main.summary = lines_of("--help")[1]:match ": (.*)"
table.insert(main.about, 1, "Duet finds all collisions among millions of boxes, in 2D and 3D. It divides the work between "
  .. "two OpenCL devices: a CPU and a GPU, two GPUs, or two halves of one CPU.")
local ordered, pages = { main }, { duet = main }

local function add_pages(page)
  for _, verb in ipairs(page.verbs) do
    local below = read_page((page.command .. " " .. verb.name):match "^ *(.*)")
    below.summary = verb.text
    ordered[#ordered + 1], pages[below.name] = below, below
    add_pages(below)
  end
end
add_pages(main)

local examples = read_examples(examples_path)
for _, page in ipairs(ordered) do
  man_page(page, pages, main, assert(examples[page.command], page.name .. ": examples.md has no example of it"))
end
write_completion(ordered, pages, main)
