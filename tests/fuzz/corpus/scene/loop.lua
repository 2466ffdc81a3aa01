while true do add(0, 0, 1, 1) end
