-- SPDX-License-Identifier: MIT
return {
  about = "lets impacts pass through rows of bodies that touch",
  uses = { "lanes.clh", "dynamics/vector.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/constraint.clh",
    "dynamics/restitution.clh",
    "dynamics/team.clh", "dynamics/colour_parts.clh" },
  params = {
    { "DIMS", values = { 2, 3 }, default = 3, about = "dimensions" },
    { "ANGULAR_VELOCITY", values = { 0, 1, 2 }, default = 0, about = "1: objects turn; 2: far in a step" },
    { "FRICTION", values = { 0, 1 }, default = 0, about = "1: contacts have friction" },
    { "CONTACT_RESPONSE", values = { 1 }, default = 1, about = "contacts push" },
    { "CONVEYS", values = { 0, 1 }, default = 0, silent = true, about = "1: surfaces move" },
    { "ROLLING", values = { 0, 1 }, default = 0, silent = true, about = "1: contacts resist to roll" },
    { "LANES", values = { 1, 8 }, default = function(limits) return limits.cpu and 8 or 1 end,
      about = "contacts side by side in a work-item" },
    { "BLOCK", values = { 8, 32 }, default = function(limits) return limits.cpu and 8 or 32 end,
      about = "contacts that are neighbours in memory" },
    { "ROUNDED", values = { 0, 1 }, default = 0, silent = true, about = "1: boxes have radii" },
    { "TEAM", values = { 0, 1 }, default = 0, silent = true, about = "1: a launch's groups take all colours together" },
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 128 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 64, 256 }, default = function(limits) return limits.cpu and limits.batch // 4 or 1 end,
      about = "contacts a work-item" },
  },
  args = {
    solve_shocks = [[
      const uint4 *spans
      int4 span
      uint from_colour
      uint to_colour
      uint each
      float *blocks
      volatile uint *team  if TEAM == 1
      uint stage          if TEAM == 1
      float4 *bodies
      float4 fall
      float least_speed
      float soon
      uint sweep
      uint first_sweep
      volatile uint *shocked
    ]],
  },
  valid = function(p)
    if p.CONVEYS == 1 and p.FRICTION == 0 then return false, "what conveys has friction" end
    if p.ROLLING == 1 and p.ANGULAR_VELOCITY == 0 then return false, "what rolls turns" end
    if p.LANES == 8 and p.BLOCK ~= 8 then return false, "lanes are blocks" end
    if p.PER_ITEM % p.LANES ~= 0 then return false, "PER_ITEM is not a multiple of LANES" end
    return true
  end,
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
