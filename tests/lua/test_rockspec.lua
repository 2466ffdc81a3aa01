-- SPDX-License-Identifier: MIT
-- The rockspec says what LuaRocks needs, of the version that this is; and
-- where luarocks is installed, its own check agrees.
local duet = require "duet"
local facts = require "facts"

local path = facts.root .. "/duet-" .. duet.version .. "-1.rockspec"

facts.holds("the rockspec has this version, and builds files that the build makes", function()
  local spec = {}
  assert(loadfile(path, "t", spec))()
  facts.equal(spec.package, "duet")
  facts.equal(spec.version, duet.version .. "-1")
  facts.equal(spec.build.type, "cmake")
  facts.equal(spec.build.install.lib.duet, "build.luarocks/lua/duet.so")
  for _, field in ipairs { "rockspec_format", "source", "description", "dependencies" } do
    assert(spec[field], field)
  end
end)

facts.holds("luarocks takes it, where there is one", function()
  if not os.execute "command -v luarocks >/dev/null" then return end
  assert(os.execute("env -u LUA_PATH -u LUA_CPATH luarocks lint '" .. path .. "' >/dev/null"))
end)

facts.finish()
