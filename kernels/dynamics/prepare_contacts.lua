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
    common.CONTACT_LANES,
    common.BLOCK,
    common.TEAM,
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    common.CONTACTS_AN_ITEM,
  },
  args = {
    prepare_contacts = [[
      const uint2 *links
      const uint *touches
      const float *contacts
    ]] .. common.SURFACES .. [[
      const real4 *rotations  if CONVEYS == 1
      uint n
      uint carrier  only if CARRIED == 1
      const uint *list
    ]] .. common.COLOURS .. common.TEAMS .. [[
      float4 *bodies
    ]],
    store_impulses = [[
      const uint *list
    ]] .. common.COLOURS .. [[
      float *contacts
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.GROUND_MATERIAL == 1 and p.MATERIALS == 0 then return false, "a material is one of a table" end
    return common.can_solve(p)
  end,
}
