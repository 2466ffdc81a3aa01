-- SPDX-License-Identifier: MIT
return {
  about = "the contact graph: which bodies each body may touch",
  uses = { "dynamics/motion.clh", "dynamics/records.h" },
  params = {
    common.DIMS,
    { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: the state is in double" },
    { "BOUNDARY", values = { 0, 1 }, default = 0, about = "1: walls" },
    { "CONTACT_RESPONSE", values = { 0, 1 }, default = 0, about = "1: contacts push back" },
    { "FILTER", values = { 0, 1 }, default = 0, about = "1: groups and masks" },
    { "SENSORS", values = { 0, 1 }, default = 0, about = "1: some bodies are sensors" },
    { "HEIGHTS", values = { 0, 1 }, default = 0, silent = true, about = "1: a ground of heights" },
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256, 1024 }, default = function(limits) return limits.cpu and limits.batch or 1 end,
      about = "objects, pairs or contacts a work-item" },
  },
  args = {
    contact_graph_pairs = [[
      const uint2 *pairs
      uint n_pairs
      const real4 *velocities
      const uint2 *filters  if FILTER == 1
      const float *sensors  if SENSORS == 1
      uint fill
      volatile uint *starts
      uint *others
    ]],
    contact_graph_walls = [[
      const float *boxes
      const real4 *velocities
      const float *sensors  if SENSORS == 1
      real4 lower           if BOUNDARY == 1
      real4 upper           if BOUNDARY == 1
      uint n
      uint fill
      volatile uint *starts
      uint *others
    ]],
    contact_graph_ground = [[
      const float *boxes
      const real4 *velocities
      const float *sensors    if SENSORS == 1
      const float *heights    if HEIGHTS == 1
      real4 ground_origin     if HEIGHTS == 1
      real4 ground_spacing    if HEIGHTS == 1
      int4 ground_size        if HEIGHTS == 1
      real contact_margin     if HEIGHTS == 1
      uint n
      uint fill
      volatile uint *starts
      uint *others
    ]],
    contact_graph_sort = [[
      const uint *row_starts
      uint n
      uint *row_values
    ]],
    contact_graph_reverse = [[
      const uint *starts
      const uint *others
      uint n
      const real4 *velocities
      uint fill
      uint2 *links
      uint *touches
      uint *colours           if CONTACT_RESPONSE == 1
      volatile uint *return_starts
      uint *returns
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    return true
  end,
}
