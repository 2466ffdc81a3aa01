-- SPDX-License-Identifier: MIT
return {
  about = "where bodies are, as poses for a tree",
  uses = { "dynamics/motion.clh" },
  params = {
    { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: the state is in double" },
    { "ROTATED", values = { 0, 1 }, default = 0, about = "1: orientation matters" },
    common.ROUNDED,
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256, 1024 }, default = function(limits) return limits.cpu and limits.batch or 1 end,
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
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    return true
  end,
}
