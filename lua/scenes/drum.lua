-- SPDX-License-Identifier: MIT
-- Grains in a drum of triangles that turns and lifts them with its bars. It moves.

local p = parameters {
  n = 400, -- the carrier and grains
  speed = 1.5, -- radians a second
  radius = 0.05, -- of a grain
  friction = 0.6,
  seed = 1,
}

local quarter <const>, bar <const> = 6, 0.8 -- sides of a quarter turn; where a bar ends, in radii
local gap <const> = 2.3 * p.radius
local radius = gap * math.ceil((16 * p.n) ^ (1 / 3) / 2.3)
local half = radius / 2 -- along y, its length

-- Along a circle by quotients alone, so that the drum is the same on every machine.
local vertices, triangles = {}, {}
local function put(x, y, z)
  table.move({ x, y, z }, 1, 3, #vertices + 1, vertices)
  return #vertices // 3 - 1
end
local function face(...) table.move({ ... }, 1, 3, #triangles + 1, triangles) end

local front <const>, back <const> = put(0, -half, 0), put(0, half, 0)
local sides <const> = 4 * quarter
for i = 0, sides - 1 do
  local t = i % quarter / quarter
  local x, z = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
  for _ = 1, i // quarter do x, z = -z, x end
  local far = i % quarter == 0 and bar * radius or radius
  put(far * x, -half, far * z)
  put(far * x, half, far * z)
end
for i = 0, sides - 1 do -- turned inward
  local a, b = 2 + 2 * i, 2 + 2 * ((i + 1) % sides)
  face(a, b, b + 1)
  face(a, b + 1, a + 1)
  face(front, b, a)
  face(back, a + 1, b + 1)
end

add { -- carries the drum, and touches nothing itself
  centre = { 0, 0, 0 },
  half_extents = { 0, 0, 0 },
  mass = 0,
  angular_velocity = { 0, p.speed, 0 },
  group = 0,
  mask = 0,
}

local source = random(p.seed)
local across, along = math.floor(1.1 * radius / gap), math.floor(2 * half / gap) - 1
for i = 0, p.n - 2 do
  local function place(k, count) return (k - (count - 1) / 2) * gap + source.uniform(-0.1, 0.1) * p.radius end
  add {
    centre = { place(i % across, across), place(i // across % along, along), place(i // (across * along), across) },
    half_extents = { 0, 0, 0 },
    radius = p.radius,
    friction = p.friction,
    rolling_resistance = 0.05,
  }
end

return {
  dims = 3,
  gravity = { 0, 0, -9.81 },
  mesh = { vertices = vertices, triangles = triangles, carrier = 0 },
  wants = { "contact_response", "continuous" },
}
