-- SPDX-License-Identifier: MIT
return {
  about = "free flight of each object for a step",
  uses = { "dynamics/motion.clh" },
  params = {
    common.DIMS,
    { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: in double" },
    common.ORIGIN, common.ORIENTED, common.TURN, common.GYRO, common.GRAVITY, common.DRAG, common.FORCES,
    { "BOUNDARY", values = { 0, 1, 2 }, default = 0, about = "1: walls, 2: periodic" },
    { "ORDER", values = { 1, 2, 4 }, default = 1, about = "of the integrator" },
    common.ROUNDED,
    { "WG", values = { 1, 64, 128, 256 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256, 1024 }, default = common.by_batch(1),
      about = "objects a work-item" },
  },
  args = {
    integrate_free_flight = [[
      real4 *centres
      int4 *cells                if ORIGIN > 0
      real4 *velocities
      real4 *rotations           if ANGULAR_VELOCITY == 1 or BOUNDARY == 1 and ROTATED == 1
      real4 *angular_velocities  if ANGULAR_VELOCITY == 1
      const float4 *inertias     if GYRO == 1 or FORCES == 1 and ANGULAR_VELOCITY == 1
      const float4 *forces       if FORCES == 1
      real4 gravity              if GRAVITY > 0
      real4 drags                if DRAG == 1
      real4 lower                if BOUNDARY > 0
      real4 upper                if BOUNDARY > 0
      const float4 *halves       if BOUNDARY == 1
      real4 times
      uint substeps
      uint n
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.DOUBLE == 1 and p.ORIGIN > 0 then return false, "origin cells are for a state in float" end
    if p.ANGULAR_VELOCITY == 1 and p.ROTATED == 0 then return false, "what turns is rotated" end
    if p.GYRO == 1 and p.ANGULAR_VELOCITY == 0 then return false, "GYRO without ANGULAR_VELOCITY" end
    return true
  end,
}
