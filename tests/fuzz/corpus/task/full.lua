local p = parameters { n = 40, seed = 1 }
return {
  kernel = "k",
  entry = "k",
  args = {
    a = 2.0,
    m = 3,
    x = { "float", p.n, init = "random", min = -1, max = 2, access = "slice", halo = 1, send = "once" },
    y = { "int4", 2 * p.n, access = "out slice" },
    z = { "double", p.n, init = function(i) return i / 2 end, access = "in out slice" },
    s = { "ulong", 16, access = "sum" },
    w = { "uchar", 7, init = "index" },
  },
  items = p.n,
  work = 2,
  reference = function(v)
    for i = 0, #v.y - 1 do v.y[i] = i * v.m end
    v.s[3] = v.w[2] + v.items
  end,
  tolerance = 1e-5,
  key = { n = p.n, bins = 64 },
}
