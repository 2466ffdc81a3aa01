for i, name in ipairs { "a", "b" } do
  local x = #name:rep(i) + tonumber(("%d"):format(i))
  add { lower = { x, 0, 0 }, upper = { x + 1, 1, 1 } }
end
return { attraction = { strength = 2, centre = { 0, 0, 0 } }, doubles = true }
