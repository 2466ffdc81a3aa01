add { centre = { 0, 0, 0 }, half = { 1, 1, 1 }, euler = { 0.1, 0.2, 0.3 }, velocity = { 1, 0, 0 },
  angular_velocity = { 0, 0, 1 }, mass = 2, restitution = 0.5, friction = 0.3, group = 1, mask = 3 }
add { centre = { 3, 0, 0 }, half = { 1, 1, 1 }, rotation = { euler(1, 2, 3) } }
return {
  dims = 3,
  world = { lower = { 0, 0, 0 }, upper = { 9, 9, 9 } },
  body = { mass = 1, friction = 0.5 },
  gravity = { 0, 0, -9.81 },
  drag = 0.1,
  boundary = "walls",
  wants = { "contact_response", "friction", "sleep" },
  integrator = "euler", dt = 1 / 60, substeps = 4, skin = 0.1, slop = 0.01,
  accuracy = { missed = 0.01 },
}
