-- SPDX-License-Identifier: MIT
return {
  about = "moves and turns bodies by a substep",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/constraint.clh", "dynamics/turn.clh",
    "dynamics/listed.clh", "dynamics/move_bodies.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.TURNS, common.GYRO, common.SLEEP, common.FRICTION, common.CONTACT_RESPONSE,
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "objects side by side in a work-item" },
    common.BLOCK, common.GROUP(64),
    { "PER_ITEM", values = { 1, 256, 1024 }, default = common.by_batch(1),
      about = "objects a work-item" },
  },
  args = {
    integrate_positions = [[
      float4 *bodies
      uint n
    ]] .. common.AWAKE .. [[
      const real4 *rotations  if GYRO == 1
      const float4 *inertias  if GYRO == 1
      float h
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.GYRO == 1 and p.ANGULAR_VELOCITY == 0 then return false, "GYRO without ANGULAR_VELOCITY" end
    if p.PER_ITEM % p.LANES ~= 0 then return false, "PER_ITEM is not a multiple of LANES" end
    return true
  end,
}
