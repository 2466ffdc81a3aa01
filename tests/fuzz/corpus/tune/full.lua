return {
  workloads = {
    { scene = "boxes.csv" },
    { scene = "paper.lua", n = { 1000, 2000 }, set = { rotated = false, world = 9 } },
  },
  pair = "pocl:0,pocl:1",
  strategy = "balance",
  variants = { "auto", "simd" },
  modes = { "own", "slab" },
  level = { "sat15" },
  budget = { seconds = 5, trials = 9 },
  repeats = 5,
  seed = 3,
}
