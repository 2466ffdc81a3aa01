return {
  about = "sums over a neighbourhood of any dimension",
  emit = { "stencil" },
  params = { { "DIMS", values = { 2, 3 }, about = "dimensions" } },
  launch = function() return { group = 1, per_item = 1 } end,
}
