return { kernel = "k", items = 4, reference = "plain", tolerance = "exact",
  args = { y = { "float", 4, access = "out slice" } } }
