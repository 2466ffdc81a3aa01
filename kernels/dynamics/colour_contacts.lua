-- SPDX-License-Identifier: MIT
return {
  about = "all of graph colouring in one launch, by a team of a CPU's groups or a GPU's that meet",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/listed.clh",
    "dynamics/team.clh", "dynamics/meet.clh", "dynamics/colour_choice.clh", "dynamics/body_row.clh",
    "dynamics/colouring.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.TURN, common.FRICTION, common.CONTACT_RESPONSE, common.SLEEP, common.SENSORS,
    { "TEAM", values = { 0, 1 }, default = 0, silent = true, about = "1: a launch's groups colour together" },
    common.MEET,
    { "WG", values = { 1, 64, 128, 256, 512 },
      default = function(limits) return limits.cpu and 1 or math.min(512, limits.max_group) end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1 }, default = 1, about = "contacts a work-item at least" },
  },
  args = {
    colour_contacts = [[
      const uint2 *links
      const uint *touches
      uint n_contacts
      uint n
      const uint *awake     if SLEEP == 1
    ]] .. common.AWAKE_CONTACTS .. [[
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
      uint4 *spans
      uint block
      uint block_capacity
      uint hopes
      volatile uint *flags
      volatile uint *team
      uint stage
    ]],
  },
  valid = common.can_double,
}
