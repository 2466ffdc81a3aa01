-- SPDX-License-Identifier: MIT
return {
  about = "contact manifolds: the points where a pair touches",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/float_vector.clh",
    "dynamics/box_contact.clh", "dynamics/rounded_contact.clh", "dynamics/box_lanes.clh", "dynamics/continuous.clh",
    "dynamics/body_pairs.clh", "dynamics/seam.clh", "dynamics/manifold_record.clh", "dynamics/listed.clh",
    "dynamics/mesh_rows.h", "dynamics/mesh_tree.clh", "dynamics/ground.clh", "dynamics/ground_heights.clh",
    "dynamics/ground_mesh.clh", "dynamics/triangle_contact.clh", "dynamics/ground_touch.clh", "dynamics/ground_contact.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.ORIGIN, common.ORIENTED, common.TURN,
    { "BOUNDARY", values = { 0, 1 }, default = 0, about = "1: walls" },
    common.MAY_RESPOND, common.FRICTION,
    { "CONTINUOUS", values = { 0, 1 }, default = 0, about = "1: fast bodies do not tunnel through thin ones" },
    common.SLEEP,
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "pairs side by side in a work-item, of turned boxes in float" },
    common.ROUNDED,
    { "SENSORS", values = { 0, 1 }, default = 0, silent = true, about = "1: some bodies are sensors" },
    common.GROUND, common.CARRIED,
    common.GROUP(128),
    { "PER_ITEM", values = { 1, 4, 8, 64, 256 }, default = function(limits) return limits.cpu and limits.batch // 4 or 4 end,
      about = "objects, pairs or contacts a work-item" },
  },
  args = {
    build_manifolds = [[
      const uint2 *links
      uint n_contacts
      uint n
      const real4 *centres
      const int4 *cells       if ORIGIN > 0
      const float4 *halves
      const real4 *rotations  if ROTATED == 1
      real4 lower             if BOUNDARY == 1
      real4 upper             if BOUNDARY == 1
      real4 ground_origin  only if GROUND > 0
      const float *ground_values  only if GROUND > 0
      real4 ground_spacing  only if GROUND == 1
      int4 ground_size  only if GROUND == 1
      const uint *mesh_triangles  only if GROUND == 2
      const uint *mesh_nodes  only if GROUND == 2
      uint carrier  only if CARRIED == 1
      const float4 *bodies    if CONTACT_RESPONSE == 1
      const uint *asleep      if SLEEP == 1
      uint woken              if SLEEP == 1
      float *rests            if SLEEP == 1
      const float *sensors    if SENSORS == 1 and ROUNDED == 1 and CONTACT_RESPONSE == 1
      float dt                if CONTINUOUS == 1
      volatile uint *flags    if SLEEP == 1
    ]] .. common.AWAKE_CONTACTS .. [[
      float margin
      uint *touches
      float *contacts
    ]],
  },
  valid = function(p, limits)
    if p.WG > 1 and p.LANES == 8 then return false, "lanes are for a work-item a group" end
    local lists = p.ROTATED == 1 and p.CONTINUOUS == 0 and p.ROUNDED == 0
    if p.WG > 1 and p.WG * p.PER_ITEM * (lists and 20 or 8) + 64 > limits.local_bytes then return false, "pairs above the device's local memory" end
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.DOUBLE == 1 and p.ORIGIN > 0 then return false, "origin cells are for a state in float" end
    if p.GROUND > 0 and (p.DIMS == 2 or p.ORIGIN > 0) then return false, "a ground is in 3D, without origin cells" end
    if p.CARRIED == 1 and (p.GROUND ~= 2 or p.ANGULAR_VELOCITY == 0) then return false, "a mesh is carried by what turns" end
    if p.ANGULAR_VELOCITY == 1 and p.ROTATED == 0 then return false, "what turns is rotated" end
    if p.FRICTION == 1 and p.CONTACT_RESPONSE == 0 then return false, "FRICTION without CONTACT_RESPONSE" end
    if p.CONTINUOUS == 1 and p.CONTACT_RESPONSE == 0 then return false, "CONTINUOUS without CONTACT_RESPONSE" end
    if p.SLEEP == 1 and p.CONTACT_RESPONSE == 0 then return false, "SLEEP without CONTACT_RESPONSE" end
    return true
  end,
}
