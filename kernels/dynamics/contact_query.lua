-- SPDX-License-Identifier: MIT
return {
  about = "where pairs of boxes touch that the caller brings",
  uses = { "lanes.clh", "narrowphase/object.clh", "dynamics/float_vector.clh", "dynamics/box_contact.clh", "dynamics/box_lanes.clh",
    "dynamics/rounded_contact.clh" },
  params = {
    common.DIMS,
    { "SHAPE", values = { 0 }, min = 0, max = 3, default = 0, about = "0 poses, 2 rounded boxes, 3 spheres" },
    common.ROUNDED,
    { "ROTATED", values = { 1 }, default = 1, about = "a pair's contact is its own, whatever the others are" },
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "pairs side by side in a work-item" },
    common.GROUP(64),
    { "PER_ITEM", values = { 1, 64, 256 }, default = function(limits) return limits.cpu and limits.batch // 4 or 1 end,
      about = "pairs a work-item" },
  },
  args = {
    contact_query = [[
      const float *objects
      const uint *pairs
      uint n
      float margin
      uint *contacts
    ]],
  },
  valid = function(p)
    if p.SHAPE == 1 then return false, "bounds have no contacts" end
    if p.ROUNDED ~= (p.SHAPE >= 2 and 1 or 0) then return false, "ROUNDED is that of SHAPE" end
    return true
  end,
}
