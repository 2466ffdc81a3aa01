-- SPDX-License-Identifier: MIT
return {
  about = "contacts into blocks of constraints, and their impulses back",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/float_vector.clh", "dynamics/records.h", "dynamics/materials.h",
    "dynamics/contact.clh", "dynamics/constraint.clh",
    "dynamics/team.clh", "dynamics/colour_parts.clh", "dynamics/prepare_constraint.clh" },
  params = {
    common.DIMS,
    { "DOUBLE", values = { 0, 1 }, default = 0, silent = true, about = "1: the state is in double" },
    { "ANGULAR_VELOCITY", values = { 0, 1 }, default = 0, about = "1: objects turn" },
    common.FRICTION,
    common.CONTACT_RESPONSE,
    common.CONVEYS,
    common.MATERIALS,
    common.GROUND_MATERIAL,
    common.CARRIED,
    common.ROLLING,
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "contacts side by side in a work-item" },
    common.BLOCK,
    common.TEAM,
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 64, 256 }, default = function(limits) return limits.cpu and limits.batch // 4 or 1 end,
      about = "contacts a work-item" },
  },
  args = {
    prepare_contacts = [[
      const uint2 *links
      const uint *touches
      const float *contacts
      const float *restitutions
      const float *frictions  if FRICTION == 1
      const uint *materials   if MATERIALS == 1
      const float *material_rules  if MATERIALS == 1
      float4 ground_surface  only if GROUND_MATERIAL == 1
      const float *rolling_resistances  if ROLLING == 1
      const float4 *halves    if ROLLING == 1
      const float4 *surface_velocities  if CONVEYS == 1
      const real4 *rotations  if CONVEYS == 1
      uint n
      uint carrier  only if CARRIED == 1
      const uint *list
      const uint4 *spans
      int4 span
      uint from_colour
      uint to_colour
      uint each
      float *blocks
      volatile uint *team  if TEAM == 1
      uint stage          if TEAM == 1
      float4 *bodies
    ]],
    store_impulses = [[
      const uint *list
      const uint4 *spans
      int4 span
      uint from_colour
      uint to_colour
      uint each
      float *blocks
      float *contacts
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.CONVEYS == 1 and p.FRICTION == 0 then return false, "what conveys has friction" end
    if p.ROLLING == 1 and p.ANGULAR_VELOCITY == 0 then return false, "what rolls turns" end
    if p.GROUND_MATERIAL == 1 and p.MATERIALS == 0 then return false, "a material is one of a table" end
    if p.LANES == 8 and p.BLOCK ~= 8 then return false, "lanes are blocks" end
    if p.PER_ITEM % p.LANES ~= 0 then return false, "PER_ITEM is not a multiple of LANES" end
    return true
  end,
}
