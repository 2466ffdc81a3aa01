-- SPDX-License-Identifier: MIT
return {
  about = "where bodies are, as poses for a tree",
  uses = { "dynamics/motion.clh" },
  params = {
    common.DOUBLE, common.ORIENTED, common.ROUNDED, common.GROUP(64),
    { "PER_ITEM", values = { 1, 256, 1024 }, default = common.by_batch(1),
      about = "bodies a work-item" },
  },
  args = {
    write_poses = [[
      const real4 *centres
      const real4 *rotations   if ROTATED == 1
      const float4 *halves
      uint n
      uint row_words           if ROUNDED == 1
      float *poses
    ]],
  },
  valid = common.can_double,
}
