-- SPDX-License-Identifier: MIT
return {
  about = "fat AABBs of bodies, and whether all are still inside theirs",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/listed.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.ORIGIN, common.ORIENTED, common.TURN, common.GRAVITY,
    { "CONTINUOUS", values = { 0, 1 }, default = 0, about = "1: fast bodies do not tunnel through thin ones" },
    { "SKIN", values = { 0, 1 }, default = 0, about = "1: the contact graph lasts until a body leaves its fat AABB" },
    common.ROUNDED,
    { "ALTERED", values = { 0, 1 }, default = 0, silent = true, about = "1: of the bodies that commands altered" },
    common.SLEEP, common.GROUP(64), common.ROWS_AN_ITEM,
  },
  args = {
    compute_fat_aabbs = [[
      const real4 *centres
      const int4 *cells        if ORIGIN > 0
      int4 base                if ORIGIN > 0
      const real4 *rotations   if ROTATED == 1
      const real4 *velocities          if CONTINUOUS + SKIN > 0
      const real4 *angular_velocities  if CONTINUOUS + SKIN > 0 and ANGULAR_VELOCITY == 1
      real dt                          if CONTINUOUS + SKIN > 0
      real skin                        if SKIN == 1
      real horizon                     if SKIN == 1
      real skins                       if SKIN == 1
      real4 gravity                    if SKIN == 1 and GRAVITY == 1
      const uint *asleep               if SKIN == 1 and SLEEP == 1
      const float4 *halves
      real aabb_margin
      const uint *altered              if ALTERED == 1
      uint n_altered                   if ALTERED == 1
      uint n                           if ALTERED == 0
      float *boxes
    ]],
    check_fat_aabbs = [[
      const real4 *centres
      const int4 *cells        if ORIGIN > 0
      int4 base                if ORIGIN > 0
      const real4 *rotations   if ROTATED == 1
      const real4 *velocities          if CONTINUOUS == 1
      const real4 *angular_velocities  if CONTINUOUS == 1 and ANGULAR_VELOCITY == 1
      real dt                          if CONTINUOUS == 1
      const float4 *halves
      real contact_margin
      uint n
      uint of_all
      const uint *awake        if SLEEP == 1
      const uint *n_listed     if SLEEP == 1
      uint all_awake           if SLEEP == 1
      const float *boxes
      uint hopes
      volatile uint *flags
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.ALTERED == 1 and p.SKIN == 0 then return false, "without a skin all are computed" end
    if p.DOUBLE == 1 and p.ORIGIN > 0 then return false, "origin cells are for a state in float" end
    return true
  end,
}
