local p = parameters { n = 10, edge = { 1, about = "of a cube" } }
local draw = random(7)
for i = 1, p.n do
  add(draw.uniform(0, 5), draw.normal(), draw.integer(1, 3), 0.5, 0.5, 0.5, draw.quaternion())
end
return { name = "rows", dims = 3, cell = 2, cell_fixed = true, level = "sat15" }
