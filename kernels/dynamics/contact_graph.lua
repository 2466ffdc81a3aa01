-- SPDX-License-Identifier: MIT
-- What rows are made from: pairs, walls, and the ground.
local sources = [[
  const uint2 *pairs
  uint n_pairs
  const float *boxes
  const real4 *velocities
  const uint2 *filters  if FILTER == 1
  const float *sensors  if SENSORS == 1
  real4 lower  if BOUNDARY == 1
  real4 upper  if BOUNDARY == 1
  real4 ground_origin  only if GROUND > 0
  const float *ground_values  only if GROUND == 1
  real4 ground_spacing  only if GROUND == 1
  int4 ground_size  only if GROUND == 1
  const uint *mesh_nodes  only if GROUND == 2
  const real4 *centres  only if CARRIED == 1
  const real4 *rotations  only if CARRIED == 1
  const real4 *angular_velocities  only if CARRIED == 1
  uint carrier  only if CARRIED == 1
  float dt  only if CARRIED == 1
  real contact_margin  only if GROUND > 0
]]

return {
  about = "the contact graph: which bodies each body may touch",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/mesh_rows.h",
    "dynamics/mesh_tree.clh", "dynamics/team.clh" },
  params = {
    common.DIMS, common.DOUBLE,
    { "BOUNDARY", values = { 0, 1 }, default = 0, about = "1: walls" },
    common.MAY_RESPOND,
    { "FILTER", values = { 0, 1 }, default = 0, about = "1: groups and masks" },
    common.SENSORS,
    common.GROUND, common.CARRIED,
    { "TEAM", values = { 0, 1 }, default = 0, silent = true, about = "1: a launch's groups make rows together" },
    common.GROUP(64), common.ROWS_AN_ITEM,
  },
  args = {
    contact_graph_rows = sources .. [[
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
      volatile uint *starts
      uint *others
      uint n
      const real4 *velocities
      uint fill
      uint2 *links
      uint *touches
      uint *colours           if CONTACT_RESPONSE == 1
      volatile uint *return_starts
      uint *returns
    ]],
    make_rows = sources .. [[
      uint n
      volatile uint *team
      uint stage
      uint *row_counts
      uint *entry_rows
      uint *entry_values
      volatile uint *starts
      uint *others
    ]],
    make_returns = [[
      volatile uint *starts
      uint *others
      uint n
      const real4 *velocities
      volatile uint *team
      uint stage
      uint *row_counts
      uint *entry_rows
      uint *entry_values
      uint2 *links
      uint *touches
      uint *colours           if CONTACT_RESPONSE == 1
      volatile uint *return_starts
      uint *returns
    ]],
  },
  valid = function(p, limits)
    if p.CARRIED == 1 and p.GROUND ~= 2 then return false, "a mesh is carried" end
    return common.can_double(p, limits)
  end,
}
