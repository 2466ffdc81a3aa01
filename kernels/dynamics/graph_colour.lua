-- SPDX-License-Identifier: MIT
return {
  about = "graph colouring: contacts of one colour share no body that moves",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh",
    "dynamics/listed.clh", "dynamics/colour_choice.clh", "dynamics/body_row.clh",
    "dynamics/colouring.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.TURN, common.FRICTION, common.CONTACT_RESPONSE, common.SLEEP, common.SENSORS,
    common.GROUP(64), common.ROWS_AN_ITEM,
  },
  args = {
    graph_colour_mark = [[
      const uint2 *links
      const uint *touches
      uint n_contacts
      uint n
    ]] .. common.AWAKE_CONTACTS .. [[
      const float4 *bodies
      const float *sensors  if SENSORS == 1
      uint *colours
      volatile uint *choices
      uint hopes
      volatile uint *flags
    ]],
    graph_colour_choose = [[
      const uint2 *links
      uint *colours
      const uint *starts
      const uint *return_starts
      const uint *returns
      uint n
    ]] .. common.AWAKE .. [[
      uint *used
      volatile uint *choices
    ]],
    graph_colour_take = [[
      const uint2 *links
      uint n
    ]] .. common.AWAKE .. [[
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
    ]] .. common.AWAKE_CONTACTS .. [[
      uint *list
      uint *keys
    ]],
  },
  valid = common.can_double,
}
