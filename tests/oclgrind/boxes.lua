-- SPDX-License-Identifier: MIT
-- A few boxes for motion.cmake, more for tests/bench/effects.lua: they fall on each other and on a floor, or fly.

local p = parameters {
  dims = 3,
  n = 5, -- in columns of five
  falling = true, -- onto a floor, with friction, rather than in free flight
  turned = true,
  sleep = false,
  continuous = false,
  events = false,
  shocks = false,
  hills = false,
  mesh = false,
  carried = false, -- the mesh, by a body that turns and rises
  rounded = false, -- every second one is a ball, every fourth a capsule
  rolling = false, -- resistance
  belt = false, -- the floor's surface moves
  materials = false,
  sensors = false,
  deep = false, -- 15 mm in each other, and pushed apart
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

local function round(i, half_extents)
  if not p.rounded or i % 2 == 0 then return nil end
  local radius <const> = half_extents[1]
  for k = 1, p.dims do half_extents[k] = k == 1 and i % 4 == 1 and 0.3 or 0 end
  return radius
end

local apart <const> = not p.falling and 2 or p.deep and 0.965 or 0.98
local side <const> = math.ceil((p.n / 5) ^ (1 / (p.dims - 1)))
for i = 0, p.n - 1 do
  local level, column, half_extents = i % 5, i // 5, cube(1)
  local centre = vector(0.2 * level + 1.6 * (column // 2 * (column % 2 == 0 and 1 or -1)), 0.49 + apart * level)
  if p.dims == 3 then
    centre[1] = 0.2 * level + 1.6 * (column % side - (side - 1) // 2)
    centre[2] = 1.6 * (column // side - (side - 1) // 2)
  end
  local radius <const> = round(i, half_extents)
  box(centre, half_extents, {
    radius = radius,
    velocity = vector(p.falling and 0.1 or 1, p.continuous and -60 or p.shocks and -3 or 0),
    restitution = p.falling and (p.shocks and 0.8 or 0.2) or nil,
    friction = p.falling and 0.5 or nil,
    rolling_resistance = p.rolling and 0.05 or nil,
    material = p.materials and i % 4 or nil,
    sensor = p.sensors and i % 5 == 4 or nil,
    group = p.filtered and 1 + i % 2 or nil,
    mask = p.filtered and 3 or nil,
  })
end
if p.falling then
  local floor = cube(1)
  for k = 1, p.n > 5 and p.dims - 1 or 1 do floor[k] = 6 end
  add {
    centre = vector(0, -0.5),
    half_extents = floor,
    mass = 0,
    friction = 0.5,
    surface_velocity = p.belt and vector(0.7, 0) or nil,
    material = p.materials and 3 or nil,
  }
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

if p.carried then
  add {
    centre = { 0, 0, 0.1 },
    half_extents = { 0, 0, 0 },
    mass = 0,
    velocity = { 0, 0, 0.2 },
    angular_velocity = { 0.1, 0.05, 0.5 },
    group = 0,
    mask = 0,
  }
  mesh.carrier = p.n + 1
end

local wants = { p.deep and "depenetration" or nil }
for _, name in ipairs { "sleep", "continuous", "events", "shocks" } do
  if p[name] then wants[#wants + 1] = name end
end
if p.falling then wants[#wants + 1] = "contact_response" end

local lower, upper = {}, {}
for k = 1, p.dims do lower[k], upper[k] = -8, 12 end

return {
  dims = p.dims,
  heights = p.hills and heights or nil,
  mesh = (p.mesh or p.carried) and mesh or nil,
  materials = p.materials and {
    { friction = 0.05, restitution = 0.1, friction_rule = "min" },
    { friction = 0.9, restitution = 0.6 },
    { friction = 0.4, restitution = 0.3, restitution_rule = "product" },
  } or nil,
  material_pairs = p.materials and { { 2, 3, friction = 1.1, restitution = 0.2 } } or nil,
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
