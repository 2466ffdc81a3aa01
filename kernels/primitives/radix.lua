-- SPDX-License-Identifier: MIT
return {
  about = "one pass of a stable radix sort",
  params = {
    { "BITS", values = { 2, 4, 8 }, default = common.by_device(8, 4), about = "bits a pass" },
    { "WG", values = { 1, 32, 64, 128, 256 }, default = common.by_device(1, 128), about = "work-items a group" },
    { "PER_ITEM", values = { 4, 8, 16, 16384 }, default = common.by_device(16384, 16),
      about = "consecutive elements a work-item" },
  },
  args = {
    radix_count = [[
      const uint *keys_in
      uint n
      uint shift
      uint *tiles
    ]],
    radix_move = [[
      const uint *keys_in
      const uint *ids_in
      uint n
      uint shift
      uint first_pass
      const uint *tiles
      uint *keys_out
      uint *ids_out
    ]],
  },
  valid = function(p, limits)
    if (1 << p.BITS) * p.WG * 4 > limits.local_bytes then return false, "counts above the device's local memory" end
  end,
}
