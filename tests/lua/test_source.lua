-- SPDX-License-Identifier: MIT
-- Kernel text from Lua.
local duet = require "duet"
local facts = require "facts"

local function sum(list, field)
  local total = 0
  for _, item in ipairs(list) do total = total + item[field] end
  return total
end

facts.holds("every kernel has a text, and a setting changes it", function()
  for _, kernel in ipairs(assert(duet.kernels())) do
    local source = assert(duet.source(kernel.name))
    facts.equal(#source.sha256, 64)
    assert(source.text:find("kernel", 1, true), kernel.name)
    for _, param in ipairs(kernel.params) do
      assert(#param.name > 0 and #param.about > 0 and math.type(param.default) == "integer")
    end
  end
  local small, large = assert(duet.source("hash", { WG = 64 })), assert(duet.source("hash", { WG = 128 }))
  facts.equal(small.group, 64)
  assert(small.sha256 ~= large.sha256)
end)

facts.holds("a small device has fewer configs", function()
  local large = sum(assert(duet.kernels { max_group = 1024 }), "configs")
  local small = sum(assert(duet.kernels { max_group = 64, local_bytes = 4096 }), "configs")
  assert(small < large)
end)

facts.holds("what no card allows is refused", function()
  facts.refused("BAD_ARGUMENT", "WG", duet.source, "hash", { WG = 3 })
  facts.refused("BAD_ARGUMENT", "NONE", duet.source, "hash", { NONE = 3 })
  facts.refused("BAD_ARGUMENT", "none", duet.source, "none")
  facts.raises("names with whole numbers", duet.source, "hash", { WG = "x" })
  facts.raises("a device's limits has no field 'group'", duet.kernels, { group = 3 })
end)

facts.finish()
