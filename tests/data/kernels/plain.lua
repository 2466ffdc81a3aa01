return {
  about = "a scaled and shifted copy",
  uses = { "twice.clh" },
  params = {
    { "FACTOR", values = { 1, 2, 3 }, about = "what is multiplied by" },
    { "SHIFT", min = -8, max = 8, default = -1, about = "what is added" },
    { "WG", values = { 1, 64, 256 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 4 }, default = 4, about = "values a work-item" },
  },
  valid = function(p, limits)
    if p.FACTOR == 3 and p.PER_ITEM == 4 then return false, "3 is done one by one" end
    return limits.local_bytes >= 4 * p.WG, "too little local memory"
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
