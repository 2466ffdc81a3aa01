-- SPDX-License-Identifier: MIT
return {
  about = "counting sort: each id to its place",
  params = {
    { "STRETCH", min = 0, max = 1, default = 0, silent = true, about = "1: objects from n_hashed on" },
    { "SLAB", min = 0, max = 1, default = 0, silent = true,
      about = "1: many objects have no place, for they are another device's" },
    common.WG(256), common.PER_ITEM,
  },
  args = {
    scatter = [[
      const uint *keys
      const uint *ranks
      uint n
      uint n_hashed  if STRETCH == 1
      const uint *starts
      uint *ids
    ]],
  },
}
