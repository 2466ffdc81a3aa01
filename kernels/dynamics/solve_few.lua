-- SPDX-License-Identifier: MIT
return {
  about = "all substeps of few bodies and contacts, by one work-group",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/constraint.clh",
    "dynamics/float_vector.clh", "dynamics/turn.clh", "dynamics/listed.clh", "dynamics/accelerate.clh",
    "dynamics/move_bodies.clh", "dynamics/colour_parts.clh", "dynamics/solve_constraint.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: the state is in double" },
    { "ANGULAR_VELOCITY", values = { 0, 1, 2 }, default = 0, about = "1: objects turn; 2: far in a step" },
    { "GYRO", values = { 0, 1 }, default = 0, about = "1: some have no isotropic inertia" },
    { "GRAVITY", values = { 0, 1, 2 }, default = 0, about = "1: uniform, 2: towards a point" },
    { "DRAG", values = { 0, 1 }, default = 0, about = "1: velocities decay" },
    { "FORCES", values = { 0, 1 }, default = 0, about = "1: commands push" },
    { "SLEEP", values = { 0, 1 }, default = 0, about = "1: bodies at rest are left out" },
    { "FRICTION", values = { 0, 1 }, default = 0, about = "1: contacts have friction" },
    { "CONTACT_RESPONSE", values = { 1 }, default = 1, about = "contacts push" },
    { "CONVEYS", values = { 0, 1 }, default = 0, silent = true, about = "1: surfaces move" },
    { "ROLLING", values = { 0, 1 }, default = 0, silent = true, about = "1: contacts resist to roll" },
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "contacts and bodies side by side in a work-item" },
    { "BLOCK", values = { 8, 32 }, default = function(limits) return limits.cpu and 8 or 32 end,
      about = "contacts that are neighbours in memory" },
    { "ROUNDED", values = { 0, 1 }, default = 0, silent = true, about = "1: boxes have radii" },
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items of the group" },
    { "PER_ITEM", values = { 1, 64 }, default = function(limits) return limits.cpu and 64 or 1 end,
      about = "contacts a work-item" },
  },
  args = {
    solve_few = [[
      const uint4 *spans
      uint to_colour
      uint substeps
      float *blocks
      float4 *bodies
      uint n
      const uint *awake       if SLEEP == 1
      const uint *n_listed    if SLEEP == 1
      uint all_awake          if SLEEP == 1
      float4 gravity          if GRAVITY > 0
      const real4 *centres    if GRAVITY == 2
      float drag              if DRAG == 1
      const float4 *forces    if FORCES == 1
      const real4 *rotations  if GYRO == 1
      const float4 *inertias  if GYRO == 1
      uint soft
      float h
      float per_h
      float4 spring
      float4 hard_spring
      float load_speed
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.GYRO == 1 and p.ANGULAR_VELOCITY == 0 then return false, "GYRO without ANGULAR_VELOCITY" end
    if p.CONVEYS == 1 and p.FRICTION == 0 then return false, "what conveys has friction" end
    if p.ROLLING == 1 and p.ANGULAR_VELOCITY == 0 then return false, "what rolls turns" end
    if p.LANES == 8 and p.BLOCK ~= 8 then return false, "lanes are blocks" end
    if p.PER_ITEM % p.LANES ~= 0 then return false, "PER_ITEM is not a multiple of LANES" end
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
