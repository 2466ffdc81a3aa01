-- SPDX-License-Identifier: MIT
return {
  about = "one pass of a stable radix sort",
  params = {
    { "BITS", values = { 2, 4, 8 }, default = function(limits) return limits.cpu and 8 or 4 end,
      about = "bits a pass" },
    { "WG", values = { 1, 32, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 4, 8, 16, 16384 }, default = function(limits) return limits.cpu and 16384 or 16 end,
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
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
