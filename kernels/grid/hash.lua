-- SPDX-License-Identifier: MIT
return {
  about = "cell of each object, and its rank in the cell",
  uses = { "counters.h", "lanes.clh", "narrowphase/object.clh", "grid/places.h", "grid/grid.clh" },
  params = {
    common.DIMS, common.SHAPE, common.ROTATED, common.ORIGIN, common.APART, common.GRID, common.LEVELS,
    { "RANK", values = { 0, 1 }, default = 1, about = "count objects a cell, for the counting sort" },
    { "PACKED", values = { 0, 1 }, default = 0, about = "1: objects of one slab, with their ids" },
    { "STRAYS", min = 0, max = 65536, default = 0, silent = true,
      about = "objects in each block that is marked where the other device wants any of it" },
    { "OWN", min = 0, max = 1, default = 0, silent = true,
      about = "1: objects are in about the order of cells, of which each work-item has its own" },
    { "LANES", values = { 1, 8 }, default = common.by_device(8, 1), about = "objects side by side in a work-item" },
    { "BATCH", values = { 1, 8, 64 }, default = common.by_device(64, 1),
      about = "objects whose cells are known before the first is counted" },
    common.CELLS_X, common.CELLS_Y, common.CELLS_Z, common.WG(256), common.PER_ITEM,
  },
  args = {
    hash = [[
      const float *objects
      const float *sizes     if APART > 0
      uint n
      uint n_hashed
      const uint *names      if PACKED == 1
      constant grid_level *levels
      uint n_levels
      uint n_cells
      uint key_from
      uint key_home_to
      uint key_to
      uint *keys
      volatile uint *counts  if RANK == 1
      uint *ranks            if RANK == 1
      const uint *edges      if OWN == 1
      uint *others           if OWN == 1
      uint marked_from       if STRAYS > 0
      uint marked_to         if STRAYS > 0
      uint stamp             if STRAYS > 0
      volatile uint *marks   if STRAYS > 0
      volatile uint *counters
    ]],
    own_cells = [[
      const float *objects
      const float *sizes     if APART > 0
      uint n
      constant grid_level *levels
      uint n_levels
      uint n_cells
      uint key_from
      uint *edges
    ]],
    count_others = [[
      volatile uint *counters
      const uint *others
      const uint *keys
      volatile uint *counts
      uint *ranks
    ]],
  },
  valid = function(p, limits)
    if p.BATCH % p.LANES ~= 0 then return false, "BATCH is not a multiple of LANES" end
    if p.OWN == 1 and p.RANK == 0 then return false, "OWN is for counting cells alone" end
    if p.BATCH > p.LANES and not limits.cpu then return false, "BATCH above LANES is for CPUs" end
    if p.SHAPE == 1 and p.ROTATED == 1 then return false, "bounds have no rotation" end
    if p.SHAPE == 3 and p.ROTATED == 1 then return false, "spheres have no rotation" end
    if p.SHAPE >= 2 and p.ORIGIN > 0 then return false, "what has a radius is not in origin cells" end
    if p.APART > 0 and (p.SHAPE >= 1 or p.ORIGIN > 0) then return false, "only poses from 0 have their sizes apart" end
    if p.APART > 0 and p.PACKED == 1 then return false, "what is packed is whole poses" end
    if (p.CELLS_X == 0) ~= (p.CELLS_Y == 0) or (p.CELLS_X == 0) ~= (p.CELLS_Z == 0) then return false, "CELLS_X, CELLS_Y and CELLS_Z go together" end
    if p.CELLS_X > 0 and (p.GRID == 1 or p.LEVELS == 1) then return false, "CELLS_X is for dense grids of one size" end
  end,
}
