-- SPDX-License-Identifier: MIT
return {
  about = "graph colouring: contacts of one colour share no body that moves",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh",
    "dynamics/listed.clh", "dynamics/team.clh" },
  params = {
    common.DIMS,
    { "DOUBLE", values = { 0, 1 }, default = 0, about = "1: the state is in double" },
    { "ANGULAR_VELOCITY", values = { 0, 1 }, default = 0, about = "1: objects turn" },
    common.FRICTION,
    common.CONTACT_RESPONSE,
    { "SLEEP", values = { 0, 1 }, default = 0, about = "1: bodies at rest are left out" },
    { "SENSORS", values = { 0, 1 }, default = 0, about = "1: some bodies are sensors" },
    { "TEAM", values = { 0, 1 }, default = 0, silent = true, about = "1: a launch's groups colour together" },
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256, 1024 }, default = function(limits) return limits.cpu and limits.batch or 1 end,
      about = "objects, pairs or contacts a work-item" },
  },
  args = {
    graph_colour_mark = [[
      const uint2 *links
      const uint *touches
      uint n_contacts
      uint n
      const uint *awake_contacts  if SLEEP == 1
      const uint *n_listed        if SLEEP == 1
      uint all_awake              if SLEEP == 1
      const float4 *bodies
      const float *sensors  if SENSORS == 1
      uint *colours
      volatile uint *choices
      volatile uint *flags
    ]],
    graph_colour_choose = [[
      const uint2 *links
      uint *colours
      const uint *starts
      const uint *return_starts
      const uint *returns
      uint n
      const uint *awake     if SLEEP == 1
      const uint *n_listed  if SLEEP == 1
      uint all_awake        if SLEEP == 1
      uint *used
      volatile uint *choices
    ]],
    graph_colour_take = [[
      const uint2 *links
      uint n
      const uint *awake     if SLEEP == 1
      const uint *n_listed  if SLEEP == 1
      uint all_awake        if SLEEP == 1
      const real4 *velocities
      uint *used
      volatile uint *choices
      uint round
      uint *colours
      volatile uint *flags
    ]],
    graph_colour_key = [[
      uint *colours
      const uint *touches
      uint n_contacts
      uint n_keys
      const uint *awake_contacts  if SLEEP == 1
      const uint *n_listed        if SLEEP == 1
      uint all_awake              if SLEEP == 1
      uint *list
      uint *keys
    ]],
    colour_contacts = [[
      const uint2 *links
      const uint *touches
      uint n_contacts
      uint n
      const uint *awake           if SLEEP == 1
      const uint *awake_contacts  if SLEEP == 1
      const uint *n_listed        if SLEEP == 1
      uint all_awake              if SLEEP == 1
      const float4 *bodies
      const float *sensors  if SENSORS == 1
      const uint *starts
      const uint *return_starts
      const uint *returns
      const real4 *velocities
      uint sorts
      uint *used
      volatile uint *choices
      uint *colours
      uint *keys
      uint *key_counts
      uint *key_starts
      uint *list
      volatile uint *flags
      volatile uint *team
      uint stage
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    return true
  end,
}
