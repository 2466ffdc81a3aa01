-- SPDX-License-Identifier: MIT
return {
  about = "all of a step's solving: by a team of a CPU's groups, a GPU's that meet, or of few bodies and contacts by one",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/records.h", "dynamics/materials.h",
    "dynamics/contact.clh", "dynamics/constraint.clh", "dynamics/float_vector.clh", "dynamics/turn.clh",
    "dynamics/listed.clh", "dynamics/accelerate.clh", "dynamics/move_bodies.clh", "dynamics/team.clh",
    "dynamics/colour_parts.clh", "dynamics/meet.clh", "dynamics/sweep_parts.clh", "dynamics/prepare_constraint.clh",
    "dynamics/solve_constraint.clh", "dynamics/restitution.clh", "dynamics/restore_speeds.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.TURNS, common.GYRO, common.GRAVITY, common.DRAG, common.FORCES, common.SLEEP,
    common.FRICTION, common.CONTACT_RESPONSE, common.CONVEYS, common.ROLLING, common.MATERIALS, common.GROUND_MATERIAL,
    common.CARRIED,
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "contacts and bodies side by side in a work-item" },
    common.BLOCK, common.ROUNDED, common.TEAM,
    common.MEET,
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items of the group" },
    { "PER_ITEM", values = { 1, 64 }, default = function(limits) return limits.cpu and 64 or 1 end,
      about = "contacts a work-item" },
  },
  args = {
    solve_substeps = [[
      const uint4 *spans
      uint to_colour
      uint from_pass
      uint to_pass
      uint substeps
      uint hopes
      const uint *flags
      float *blocks
      volatile uint *team     if TEAM == 1 or MEET == 1
      uint stage              if TEAM == 1
      float4 *bodies
      const uint2 *links
      const uint *touches
      const uint *list
      float *contacts
    ]] .. common.SURFACES .. [[
      uint carrier            only if CARRIED == 1
      uint n
    ]] .. common.AWAKE .. [[
      float4 gravity          if GRAVITY > 0
      const real4 *centres    if GRAVITY == 2
      float drag              if DRAG == 1
      const float4 *forces    if FORCES == 1
      const real4 *rotations  if GYRO == 1 or CONVEYS == 1
      const float4 *inertias  if GYRO == 1
      uint soft
      float h
      float per_h
      float4 spring
      float4 hard_spring
      float load_speed
      float4 fall
      float least_speed
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.GYRO == 1 and p.ANGULAR_VELOCITY == 0 then return false, "GYRO without ANGULAR_VELOCITY" end
    if p.MEET == 1 and p.WG == 1 then return false, "groups that meet have several work-items" end
    if p.WG > 1 and p.LANES == 8 then return false, "lanes are for a work-item a group" end
    if p.GROUND_MATERIAL == 1 and p.MATERIALS == 0 then return false, "a material is one of a table" end
    return common.can_solve(p)
  end,
}
