return {
  dims = 2,
  origin = { 1e6, 2e6 }, origin_edge = 64,
  objects = {
    { 0, 0, 1, 1, 0.5 },
    { centre = { 2, 2 }, half = { 1, 1 }, angle = 0.3 },
  },
}
