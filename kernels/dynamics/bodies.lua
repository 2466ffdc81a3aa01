-- SPDX-License-Identifier: MIT
return {
  about = "bodies while a step is solved: gathered, accelerated, written back",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/float_vector.clh",
    "dynamics/listed.clh", "dynamics/accelerate.clh", "dynamics/body_lines.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.ORIGIN, common.TURNS, common.GRAVITY, common.DRAG, common.FORCES, common.SLEEP,
    common.ROUNDED, common.GROUP(64), common.ROWS_AN_ITEM,
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
    ]] .. common.AWAKE .. [[
      uint n
      float4 *bodies
    ]],
    integrate_velocities = [[
      float4 *bodies
      uint n
    ]] .. common.AWAKE .. [[
      float4 gravity        if GRAVITY > 0
      const real4 *centres  if GRAVITY == 2
      float drag            if DRAG == 1
      const float4 *forces  if FORCES == 1
      float h
    ]],
    finalize_bodies = [[
      uint hopes
      const uint *flags
      const float4 *bodies
      uint n
      real4 *centres
      int4 *cells                if ORIGIN > 0
      real4 *rotations           if ANGULAR_VELOCITY > 0
      real4 *angular_velocities  if ANGULAR_VELOCITY > 0
    ]] .. common.AWAKE .. [[
      const uint *asleep         if SLEEP == 1
      float *rests               if SLEEP == 1
      const float4 *halves       if SLEEP == 1
      float dt                   if SLEEP == 1
      float sleep_speed          if SLEEP == 1
      float sleep_after          if SLEEP == 1
      real4 *velocities
    ]],
  },
  valid = common.can_double,
}
