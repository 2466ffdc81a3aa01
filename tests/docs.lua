-- SPDX-License-Identifier: MIT
-- Runs the commands of the documents, each block of them in a fresh folder and
-- on few objects:
--
--   duet lua --trust docs.lua PROGRAM ROOT FOLDER FILE...
--
-- Text indented below a block that ends in `cat` of a file, or in a program that
-- it built, `./hello`, is what that prints.
-- A block that cannot be run in a test has a comment above it that says why:
-- <!-- not run: it needs a GPU -->
-- Blocks with 'duet cluster' or mpirun are passed over where Duet was built without MPI, and
-- those with --simulate where it was built without SimGrid, and those that search a share where the
-- device pair is one device.
-- The blocks of a tutorial build on each other. It begins with a comment,
-- <!-- all blocks in one folder -->, and a block of C, Lua or CMake in it whose first line is
-- a comment with a file's name, `// game.c`, becomes that file.

local program, root, folder = table.unpack(arg, 1, 3)
local few = "400"
local trials = "80" -- few more than the fewest from which a tuning has a verdict

-- Files that the documents speak of.
local examples = {
  ["boxes.csv"] = "0,0,0,1,1,1\n0.5,0.5,0.5,2,2,2\n5,5,5,6,6,6\n",
  ["pairs.csv"] = "0,0,0,1,1,1,0,0,0,1,1,0,0,1,1,1,0,0,0,1\n",
  ["script.lua"] = "print(#arg)\n",
  ["scene.lua"] = 'local p = parameters { n = 10 }\nfor i = 1, p.n do add(i / 2, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1) end\nreturn { dims = 3 }\n',
}

local has_cluster = io.open(program .. "-cluster") ~= nil
local has_simulate = io.open(program .. "-simulate") ~= nil
local pair <close> = assert(duet.device_pair())
local is_one = pair:device("A").selector == pair:device("B").selector

-- Every block of shell commands and every file in a document, with its line.
local function blocks(path)
  local found, block, skipped = {}, nil, false
  local one_folder = false
  local cats -- the last block, while what it prints is read
  local number = 0
  for line in assert(io.lines(path)) do
    number = number + 1
    if cats and line:match("^    ") then
      cats.prints = (cats.prints or "") .. line:sub(5) .. "\n"
    elseif line ~= "" then
      cats = nil
    end
    if block and line:match("^```") then
      block.name = block.is_text and block.commands[1]:match("^[/#-][/-]? ([%w_.]+%.%a+)$")
      block.one_folder = one_folder
      local commands = table.concat(block.commands, "\n")
      local uses_mpi = commands:find("duet cluster", 1, true) or commands:find("duet_cluster", 1, true) or commands:find("mpirun", 1, true)
      local simulates = commands:find("--simulate", 1, true)
      if simulates then uses_mpi = false end
      local shares = commands:find("duet tune", 1, true) and (commands:find("--strategy", 1, true) or commands:find("--query", 1, true))
      block.skipped = block.skipped or uses_mpi and not has_cluster or simulates and not has_simulate or shares and is_one
      if block.name and one_folder or not block.is_text then found[#found + 1] = block end
      for _, command in ipairs(block.is_text and {} or block.commands) do
        cats = cats or (command:match("^cat ") or command:match("%./%w+$")) and block
      end
      block = nil
    elseif block then
      block.commands[#block.commands + 1] = line
    elseif line:match("^```sh") or line == "```c" or line == "```lua" or line == "```cmake" then
      block = { line = number, commands = {}, skipped = skipped, is_text = line ~= "```sh" }
    end
    one_folder = one_folder or line == "<!-- all blocks in one folder -->"
    skipped = line:match("^<!%-%- not run: ") ~= nil
  end
  return found
end

-- The scenes that come with Duet, by name.
local shipped = {}
for name in assert(io.popen(("'%s' scenes"):format(program))):lines() do shipped[name:match("^%w+")] = true end

-- The same command, done in a moment.
local function small(line)
  line = line:gsub("(%-n )[%w,.]+", "%1" .. few)
  line = line:gsub("(%-%-items )%w+", "%1" .. few)
  line = line:gsub("(%-%-sizes )[%d,]+", "%1" .. few)
  line = line:gsub("%-%-pair [^ ]+", "")
  line = line:gsub("^duet bench", "duet bench --quick --repeat 2" .. (line:match("%-%-scene ") and "" or " --scene planes"))
  if not line:match("%-%-trials ") and not line:match("%-%-config ") and not line:match("%-%-replay ") then line = line:gsub("^duet tune", "%0 --trials " .. trials) end
  local command, scene = line:match("^(duet %a+) (%S+)")
  if scene == "why" then command, scene = line:match("^(duet profiles why) (%S+)") end
  local is_scene = scene and (scene:match("%.lua$") or shipped[scene]) and not command:match("lua$") and command ~= "duet scenes"
  local is_bound = line:match("%-n ") or line:match("%-%-replay ")
  if is_scene and not is_bound then line = line:gsub("^" .. command, command .. " -n " .. few) end
  return line
end

local function write_file(name, text)
  local file <close> = assert(io.open(folder .. "/" .. name, "w"))
  file:write(text)
end

local function make_folder()
  os.execute(("rm -rf '%s' && mkdir -p '%s' && ln -s '%s/lua' '%s/examples' '%s/tests' '%s'"):format(
    folder, folder, root, root, root, folder))
  for name, text in pairs(examples) do write_file(name, text) end
end

-- Settings that find the library that was built, installed beside the folder.
local library
local function find_library()
  if library then return library end
  local installed = folder .. ".installed"
  assert(os.execute(("cmake --install '%s' --prefix '%s' >'%s/installed'"):format(
    program:match("^(.*)/"), installed, folder)))
  local find <close> = assert(io.popen(("find '%s' -name duet.pc"):format(installed)))
  local packages = find:read("l"):match("^(.*)/")
  library = ("PKG_CONFIG_PATH='%s' LD_LIBRARY_PATH='%s/..' CMAKE_PREFIX_PATH='%s'"):format(packages, packages, installed)
  return library
end

local function run(block, is_first)
  if is_first or not block.one_folder then make_folder() end
  local text = table.concat(block.commands, "\n") .. "\n"
  if block.is_text then
    write_file(block.name, text)
    return true
  end
  local script = { "set -euo pipefail\n" }
  for _, line in ipairs(block.commands) do script[#script + 1] = small(line) .. "\n" end
  write_file("block.sh", table.concat(script))
  return os.execute(("cd '%s' && PATH=\"%s:$PATH\" DUET_PROFILE='%s/profiles.db' %s bash block.sh >out 2>err </dev/null")
    :format(folder, program:match("^(.*)/"), folder, (library or text:find("pkg-config", 1, true) or text:find("cmake -B", 1, true)) and find_library() or ""))
end

local function prints_what_it_should(block)
  if not block.prints then return true end
  local out <close> = assert(io.open(folder .. "/out"))
  if out:read("a"):find(block.prints, 1, true) then return true end
  local err <close> = assert(io.open(folder .. "/err", "w"))
  err:write("it does not print\n" .. block.prints)
  return false
end

local failed, n = 0, 0
for i = 4, #arg do
  local is_first = true
  for _, block in ipairs(blocks(arg[i])) do
    if not block.skipped then
      n = n + 1
      local ran = run(block, is_first)
      is_first = false
      if not ran or not prints_what_it_should(block) then
        failed = failed + 1
        local file <close> = assert(io.open(folder .. "/err"))
        io.stderr:write(("%s:%d: %s\n"):format(arg[i], block.line, file:read("a")))
      end
    end
  end
end
print(n .. " blocks, " .. failed .. " failed")
if failed > 0 or n == 0 then os.exit(1) end
