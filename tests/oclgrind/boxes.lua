-- SPDX-License-Identifier: MIT
-- A few boxes for motion.cmake: they fall on each other and on a floor, or fly.

local p = parameters {
  dims = 3,
  falling = true, -- onto a floor, with friction, rather than in free flight
  turned = true,
  sleep = false,
  continuous = false,
  events = false,
  shocks = false,
  hills = false,
  mesh = false,
  skin = 0.0,
  boundary = "walls", -- "periodic", "none"
  attraction = 0.0,
  integrator = "euler",
  doubles = false,
  origin = false,
  filtered = false,
}

local up = p.dims

local function vector(along, height)
  local v = { along }
  for k = 2, p.dims do v[k] = k == up and height or 0 end
  return v
end

local function box(centre, half_extents, parts)
  parts.centre, parts.half_extents = centre, half_extents
  if p.turned and p.dims == 2 then parts.angle = 0.2 * centre[1] end
  if p.turned and p.dims == 3 then parts.euler = { 0.1, 0, 0.2 * centre[1] } end
  add(parts)
end

local function cube(edge)
  local half_extents = {}
  for k = 1, p.dims do half_extents[k] = edge / 2 end
  return half_extents
end

for i = 0, 4 do
  local apart = p.falling and 0.98 or 2
  box(vector(0.2 * i, 0.49 + apart * i), cube(1), {
    velocity = vector(p.falling and 0.1 or 1, p.continuous and -60 or 0),
    restitution = p.falling and 0.2 or nil,
    friction = p.falling and 0.5 or nil,
    group = p.filtered and 1 + i % 2 or nil,
    mask = p.filtered and 3 or nil,
  })
end
if p.falling then
  local floor = cube(1)
  floor[1] = 6
  add { centre = vector(0, -0.5), half_extents = floor, mass = 0, friction = 0.5 }
end

local heights = { nx = 4, ny = 4, spacing = 2, origin = { -3, -3, 0 }, values = {} }
for k = 1, 16 do heights.values[k] = k % 3 * 0.2 end

-- The same places as triangles.
local mesh = { vertices = {}, triangles = {}, origin = heights.origin }
for k = 0, 15 do
  local x, y = k % 4, k // 4
  for _, value in ipairs { 2 * x, 2 * y, heights.values[k + 1] } do mesh.vertices[#mesh.vertices + 1] = value end
  if x < 3 and y < 3 then
    for _, vertex in ipairs { k, k + 1, k + 5, k, k + 5, k + 4 } do mesh.triangles[#mesh.triangles + 1] = vertex end
  end
end

local wants = {}
for _, name in ipairs { "sleep", "continuous", "events", "shocks" } do
  if p[name] then wants[#wants + 1] = name end
end
if p.falling then wants[#wants + 1] = "contact_response" end

local lower, upper = {}, {}
for k = 1, p.dims do lower[k], upper[k] = -8, 12 end

return {
  dims = p.dims,
  heights = p.hills and heights or nil,
  mesh = p.mesh and mesh or nil,
  boundary = p.boundary ~= "none" and p.boundary or nil,
  world = { lower = lower, upper = upper },
  gravity = p.attraction == 0 and vector(0, -9.81) or nil,
  attraction = p.attraction ~= 0 and { strength = p.attraction, centre = vector(0, -3) } or nil,
  wants = wants,
  hit_speed = p.events and 0.1 or nil,
  skin = p.skin > 0 and p.skin or nil,
  sleep_speed = p.sleep and 100 or nil,
  sleep_after = p.sleep and 0.03 or nil,
  drag = 0.1,
  integrator = p.integrator,
  doubles = p.doubles,
  origin = p.origin and "cell" or nil,
  origin_edge = p.origin and 16 or nil,
}
