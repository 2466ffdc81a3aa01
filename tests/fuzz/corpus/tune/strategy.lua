return {
  workloads = { { scene = "a.csv" } },
  accuracy = { missed = 0.01, ["false"] = 0.1 },
  strategy = function(search) return { ask = function() return 0.5 end, tell = function() end } end,
}
