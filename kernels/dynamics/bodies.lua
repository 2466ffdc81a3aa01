-- SPDX-License-Identifier: MIT
return {
  about = "bodies while a step is solved: gathered, accelerated, written back",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/float_vector.clh",
    "dynamics/listed.clh", "dynamics/accelerate.clh" },
  params = {
    common.DIMS,
    { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: the state is in double" },
    { "ORIGIN", min = 0, max = 254, default = 0,
      about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
    common.TURNS,
    { "GRAVITY", values = { 0, 1, 2 }, default = 0, about = "1: uniform, 2: towards a point" },
    { "DRAG", values = { 0, 1 }, default = 0, about = "1: velocities decay" },
    { "FORCES", values = { 0, 1 }, default = 0, about = "1: commands push" },
    { "SLEEP", values = { 0, 1 }, default = 0, about = "1: bodies at rest are left out" },
    common.ROUNDED,
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256, 1024 }, default = function(limits) return limits.cpu and limits.batch or 1 end,
      about = "objects, pairs or contacts a work-item" },
  },
  args = {
    prepare_bodies = [[
      const real4 *velocities
      const real4 *rotations           if ANGULAR_VELOCITY > 0
      const real4 *angular_velocities  if ANGULAR_VELOCITY > 0
      const float4 *inertias           if ANGULAR_VELOCITY > 0
      const float4 *halves             if ANGULAR_VELOCITY > 0 and ROUNDED == 1
      const uint *asleep               if SLEEP == 1
      uint woken                       if SLEEP == 1
      const uint *flags                if SLEEP == 1
      const uint *awake                if SLEEP == 1
      const uint *n_listed             if SLEEP == 1
      uint all_awake                   if SLEEP == 1
      uint n
      float4 *bodies
    ]],
    integrate_velocities = [[
      float4 *bodies
      uint n
      const uint *awake     if SLEEP == 1
      const uint *n_listed  if SLEEP == 1
      uint all_awake        if SLEEP == 1
      float4 gravity        if GRAVITY > 0
      const real4 *centres  if GRAVITY == 2
      float drag            if DRAG == 1
      const float4 *forces  if FORCES == 1
      float h
    ]],
    finalize_bodies = [[
      const float4 *bodies
      uint n
      real4 *centres
      int4 *cells                if ORIGIN > 0
      real4 *rotations           if ANGULAR_VELOCITY > 0
      real4 *angular_velocities  if ANGULAR_VELOCITY > 0
      const uint *awake          if SLEEP == 1
      const uint *n_listed       if SLEEP == 1
      uint all_awake             if SLEEP == 1
      const uint *asleep         if SLEEP == 1
      float *rests               if SLEEP == 1
      const float4 *halves       if SLEEP == 1
      float dt                   if SLEEP == 1
      float sleep_speed          if SLEEP == 1
      float sleep_after          if SLEEP == 1
      real4 *velocities
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.DOUBLE == 1 and p.ORIGIN > 0 then return false, "origin cells are for a state in float" end
    return true
  end,
}
