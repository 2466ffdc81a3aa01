-- SPDX-License-Identifier: MIT
return {
  about = "all rounds of graph colouring, by groups that all run at once",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh", "dynamics/listed.clh",
    "dynamics/colour_choice.clh", "dynamics/colouring.clh", "dynamics/meet.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.TURN, common.FRICTION, common.CONTACT_RESPONSE, common.SLEEP,
    { "WG", values = { 1, 64, 128, 256, 512 },
      default = function(limits) return limits.cpu and 1 or math.min(512, limits.max_group) end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1 }, default = 1, about = "bodies a work-item at least" },
  },
  args = {
    colour_rounds = [[
      const uint2 *links
      uint n
    ]] .. common.AWAKE .. [[
      const uint *starts
      const uint *return_starts
      const uint *returns
      const real4 *velocities
      uint *used
      volatile uint *choices
      uint *colours
      volatile uint *flags
      volatile uint *team
    ]],
  },
  valid = common.can_double,
}
