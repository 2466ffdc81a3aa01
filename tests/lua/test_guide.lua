-- SPDX-License-Identifier: MIT
-- docs/lua.md and docs/queries.md tell the truth: their Lua blocks print what stands under
-- them, and figures are those that the experiments find.
local facts = require "facts"

local guide = facts.read_file(facts.root .. "/docs/lua.md")
local queries = facts.read_file(facts.root .. "/docs/queries.md")
local lua = os.getenv "DUET_LUA" or "lua5.4"

local function run(command)
  local program <close> = assert(io.popen("cd '" .. facts.root .. "' && { " .. command .. " ; } 2>&1"))
  local printed = program:read "a"
  return printed, program:close()
end

local function write_file(path, text)
  local file <close> = assert(io.open(path, "w"))
  file:write(text)
end

local function check_blocks(text)
  local path, n = os.tmpname(), 0
  for block, says in text:gmatch "```lua\n(.-)```\n\n```text\n(.-)```" do
    write_file(path, block)
    local printed = run(lua .. " " .. path)
    facts.equal(printed, says)
    n = n + 1
  end
  os.remove(path)
  local _, blocks = text:gsub("```lua\n", "")
  facts.equal(n, blocks)
end

facts.holds("every Lua block prints what stands under it", function()
  check_blocks(guide)
  check_blocks(queries)
end)

facts.holds("what figure 12 is said to find is what it finds", function()
  local ms, off = guide:gsub("%s+", " "):match "after (%d+) ms of tuning, and `balance` at ([%d.]+) %%"
  local out = os.tmpname()
  os.remove(out)
  assert(os.execute("mkdir " .. out))
  run(("%s lua/experiments/figure12.lua --ratios 10 --sizes 100 --points 2 --out %s"):format(lua, out))
  local csv = facts.read_file(out .. "/figure12.times10.csv")
  local tuning = csv:match "fig12,.-,([%d.]+)\n"
  local balance_off = csv:match "balance,[^\n]*,([%d.]+),[%d.]+\n"
  facts.equal(("%.0f"):format(tuning), ms)
  facts.equal(("%.1f"):format(balance_off), off)
  os.execute("rm -r " .. out)
end)

facts.finish()
