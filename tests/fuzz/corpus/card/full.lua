return {
  about = "what a card can have",
  uses = { "lanes.clh" },
  emit = { "stencil" },
  params = {
    { "WG", values = { 1, 64 }, default = function(limits) return limits.cpu and 1 or 64 end, about = "a group" },
    { "ORIGIN", min = 0, max = 254, default = 0 },
    { "LANES", values = { 1, 2, 4 }, default = 1 },
  },
  valid = function(p, limits)
    if p.WG * p.LANES * 8 > limits.local_bytes then return false, "too large" end
    if p.LANES == 4 and not limits.fp64 then return false end
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.LANES } end,
}
