-- SPDX-License-Identifier: MIT
-- Both devices count their part of the bytes, and the host adds the counts.
local p = parameters { n = 1000000, seed = 1 }

-- What is right. Lua takes too long for many bytes: there another kernel finds it.
local function reference(v)
  for i = 0, v.items - 1 do
    local byte = v.bytes[i]
    v.counts[byte] = v.counts[byte] + 1
  end
end

return {
  kernel = "histogram",
  args = {
    bytes = { "uchar", p.n, init = "random", max = 255, access = "slice" },
    counts = { "uint", 256, access = "sum" },
  },
  items = p.n,
  reference = p.n > 4e6 and "histogram_plain" or reference,
  key = { n = p.n },
}
