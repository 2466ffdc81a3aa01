-- SPDX-License-Identifier: MIT
-- Parameters that many cards have: in a card's params, common.NAME stands for a table; in its args for text.

-- A default: one for a CPU, another for other devices.
local function by_device(cpu, other)
  return function(limits) return limits.cpu and cpu or other end
end

-- The same of objects, pairs or contacts a work-item: fewer on a CPU of many units (limits.batch).
local function by_batch(other)
  return function(limits) return limits.cpu and limits.batch or other end
end

common = {
  by_device = by_device,
  by_batch = by_batch,
  DIMS = { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
  SHAPE = { "SHAPE", values = { 0, 1 }, min = 0, max = 3, default = 0,
    about = "0 poses, 1 bounds, 2 rounded boxes, 3 spheres" },
  ROTATED = { "ROTATED", values = { 0, 1 }, default = 1, about = "0: every rotation is the identity" },
  ORIGIN = { "ORIGIN", min = 0, max = 254, default = 0,
    about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
  TREE_SHAPE = { "SHAPE", values = { 0, 1 }, min = 0, max = 3, default = 0,
    about = "0 poses, 1 bounds, 2 rounded boxes" },
  TREE_ORIGIN = { "ORIGIN", min = 0, max = 254, default = 0, silent = true,
    about = "large-world positions: the exponent bits of the origin cells' edge; 0: none" },
  APART = { "APART", values = { 0, 1, 2 }, default = 0,
    about = "1: poses are transforms, and their sizes apart; 2: compact ones" },
  ACCURACY = { "ACCURACY", values = { 0, 1, 2, 3, 4, 5 }, default = 0,
    about = "0 certified, 1 bounds, 2 spheres, 3 faces' axes, 4 all axes in float, 5 in double" },
  GRID = { "GRID", values = { 0, 1 }, default = 0, about = "0 dense, 1 hashed" },
  LEVELS = { "LEVELS", values = { 0, 1 }, default = 0, about = "1: cells of several sizes" },
  CELLS_X = { "CELLS_X", min = 0, max = 65536, default = 0, about = "cells along x that are compiled in; 0: read" },
  CELLS_Y = { "CELLS_Y", min = 0, max = 65536, default = 0, about = "along y" },
  CELLS_Z = { "CELLS_Z", min = 0, max = 65536, default = 0, about = "along z" },
  STRETCH = { "STRETCH", min = 0, max = 1, default = 0, silent = true,
    about = "1: objects from n_hashed on, to their places" },
  FILTERED = { "FILTERED", min = 0, max = 1, default = 0, silent = true,
    about = "1: only objects that the items' filter can touch" },
  WG = function(other)
    return { "WG", values = { 1, 64, 128, 256 }, default = by_device(1, other), about = "work-items a group" }
  end,
  PER_ITEM = { "PER_ITEM", values = { 1, 1024 }, default = by_device(1024, 1), about = "objects a work-item" },
  CONTACT_RESPONSE = { "CONTACT_RESPONSE", values = { 1 }, default = 1, about = "contacts push" },
  FRICTION = { "FRICTION", values = { 0, 1 }, default = 0, about = "1: contacts have friction" },
  CONVEYS = { "CONVEYS", values = { 0, 1 }, default = 0, silent = true, about = "1: surfaces move" },
  ROLLING = { "ROLLING", values = { 0, 1 }, default = 0, silent = true, about = "1: contacts resist to roll" },
  MATERIALS = { "MATERIALS", min = 0, max = 1, default = 0, silent = true, about = "1: bodies name materials" },
  GROUND_MATERIAL = { "GROUND_MATERIAL", min = 0, max = 1, default = 0, silent = true,
    about = "1: the ground has a material" },
  ROUNDED = { "ROUNDED", values = { 0, 1 }, default = 0, silent = true, about = "1: boxes have radii" },
  BLOCK = { "BLOCK", values = { 8, 32 }, default = by_device(8, 32),
    about = "contacts that are neighbours in memory" },
  TEAM = { "TEAM", values = { 0, 1 }, default = 0, silent = true, about = "1: a launch's groups take all colours together" },
  MEET = { "MEET", values = { 0, 1 }, default = 0, silent = true, about = "1: groups that all run at once meet" },
  TURNS = { "ANGULAR_VELOCITY", values = { 0, 1, 2 }, default = 0, about = "1: objects turn; 2: far in a step" },
  DOUBLE = { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: the state is in double" },
  TURN = { "ANGULAR_VELOCITY", values = { 0, 1 }, default = 0, about = "1: objects turn" },
  SLEEP = { "SLEEP", values = { 0, 1 }, default = 0, about = "1: bodies at rest are left out" },
  GRAVITY = { "GRAVITY", values = { 0, 1, 2 }, default = 0, about = "1: uniform, 2: towards a point" },
  ORIENTED = { "ROTATED", values = { 0, 1 }, default = 0, about = "1: orientation matters" },
  MAY_RESPOND = { "CONTACT_RESPONSE", values = { 0, 1 }, default = 0, about = "1: contacts push back" },
  ONE_LANE = { "LANES", values = { 1 }, default = 1, about = "objects side by side in a work-item" },
  DRAG = { "DRAG", values = { 0, 1 }, default = 0, about = "1: velocities decay" },
  FORCES = { "FORCES", values = { 0, 1 }, default = 0, about = "1: commands push" },
  GROUND = { "GROUND", values = { 0, 1, 2 }, default = 0, silent = true, about = "1: a ground of heights; 2: of a mesh" },
  CARRIED = { "CARRIED", min = 0, max = 1, default = 0, silent = true, about = "1: a body carries the ground" },
  SENSORS = { "SENSORS", values = { 0, 1 }, default = 0, about = "1: some bodies are sensors" },
  GYRO = { "GYRO", values = { 0, 1 }, default = 0, about = "1: some have no isotropic inertia" },
  ALL_ROTATED = { "ROTATED", values = { 1 }, default = 1, about = "every box has its rotation" },
  CONTACT_LANES = { "LANES", values = { 1, 8 }, default = by_device(8, 1),
    about = "contacts side by side in a work-item" },
  CONTACTS_AN_ITEM = { "PER_ITEM", values = { 1, 64, 256 },
    default = function(limits) return limits.cpu and limits.batch // 4 or 1 end, about = "contacts a work-item" },
  ROWS_AN_ITEM = { "PER_ITEM", values = { 1, 256, 1024 },
    default = by_batch(1), about = "objects, pairs or contacts a work-item" },
  GROUP = function(other)
    return { "WG", values = { 1, 64, 128 }, default = by_device(1, other), about = "work-items a group" }
  end,
  -- Arguments. The bodies, and the contacts, that a step may change.
  AWAKE = [[
    const uint *awake     if SLEEP == 1
    const uint *n_listed  if SLEEP == 1
    uint all_awake        if SLEEP == 1
]],
  AWAKE_CONTACTS = [[
    const uint *awake_contacts  if SLEEP == 1
    const uint *n_listed        if SLEEP == 1
    uint all_awake              if SLEEP == 1
]],
  -- Contacts of some colours, in blocks; and what a launch's groups meet by, if they take all colours together.
  COLOURS = [[
    const uint4 *spans
    int4 span
    uint from_colour
    uint to_colour
    uint each
    float *blocks
]],
  TEAMS = [[
    volatile uint *team  if TEAM == 1
    uint stage           if TEAM == 1
]],
  -- What a tree is asked, in the order of `order`, and the tree.
  QUERY_ITEMS = [[
    const float *items
    uint n
    uint first_item
    const uint *order
    uint in_order
    const uint2 *filters  if FILTERED == 1
    uint group            if FILTERED == 1
    uint mask             if FILTERED == 1
]],
  TREE_NODES = [[
    const float *boxes
    const float *nodes
    const uint *levels
    uint n_levels
]],
  -- What of bodies and of the ground a contact's surface comes from.
  SURFACES = [[
    const float *restitutions
    const float *frictions  if FRICTION == 1
    const uint *materials   if MATERIALS == 1
    const float *material_rules  if MATERIALS == 1
    float4 ground_surface   only if GROUND_MATERIAL == 1
    const float *rolling_resistances  if ROLLING == 1
    const float4 *halves    if ROLLING == 1
    const float4 *surface_velocities  if CONVEYS == 1
]],
  -- Whether the device, and positions as they are kept, allow a state in double.
  can_double = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.DOUBLE == 1 and p.ORIGIN and p.ORIGIN > 0 then return false, "origin cells are for a state in float" end
    return true
  end,
  -- Whether a tree has this config.
  can_query = function(p)
    if p.SHAPE == 3 then return false, "spheres come as rounded boxes" end
    if p.ORIGIN > 0 and p.SHAPE > 0 then return false, "origin cells are for poses" end
    return true
  end,
  -- Whether a kernel that solves contacts has this config.
  can_solve = function(p)
    if p.CONVEYS == 1 and p.FRICTION == 0 then return false, "what conveys has friction" end
    if p.ROLLING == 1 and p.ANGULAR_VELOCITY == 0 then return false, "what rolls turns" end
    if p.LANES == 8 and p.BLOCK ~= 8 then return false, "lanes are blocks" end
    if p.PER_ITEM % p.LANES ~= 0 then return false, "PER_ITEM is not a multiple of LANES" end
    return true
  end,
}
