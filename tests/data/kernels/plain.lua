return {
  about = "a scaled and shifted copy",
  uses = { "twice.clh" },
  params = {
    { "FACTOR", values = { 1, 2, 3 }, about = "what is multiplied by" },
    { "SHIFT", min = -8, max = 8, default = -1, about = "what is added" },
    { "WG", values = { 1, 64, 256 }, default = common.by_device(1, 64), about = "work-items a group" },
    { "PER_ITEM", values = { 1, 4 }, default = 4, about = "values a work-item" },
  },
  valid = function(p, limits)
    if p.FACTOR == 3 and p.PER_ITEM == 4 then return false, "3 is done one by one" end
    if limits.local_bytes < 4 * p.WG then return false, "too little local memory" end
  end,
}
