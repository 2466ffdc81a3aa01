-- SPDX-License-Identifier: MIT
return {
  about = "contacts of ghosts that a domain solves as well as their homes",
  uses = { "dynamics/records.h", "dynamics/border.h", "dynamics/place_kind.clh", "dynamics/colour_choice.clh" },
  params = { common.GROUP(64), common.ROWS_AN_ITEM },
  args = {
    begin_ghosts = [[
      uint n
      uint4 *ghosts
      uint *kept
    ]],
    note_kept = [[
      const uint2 *places
      const uint4 *ghosts
      uint n_border
      uint4 *border
      volatile uint *kept
      volatile uint *closing
    ]],
    note_lacks = [[
      const uint2 *places
      const uint4 *ghosts
      const uint *kept
      uint n
      uint closing_colour
      uint *closing
    ]],
    take_needed = [[
      const uint2 *places
      uint4 *ghosts
      uint n_border
      uint4 *border
      uint every
      uint closing_colour
      uint *closing
    ]],
    take_own = [[
      const uint2 *places
      uint4 *ghosts
      uint n_border
      uint4 *border
      uint closing_colour
    ]],
    end_contacts = [[
      const uint2 *places
      uint4 *ghosts
      uint n_border
      const uint4 *border
      uint *colours
      volatile uint *closing
    ]],
    end_ghosts = [[
      const uint2 *places
      uint4 *ghosts
      const uint *kept
      uint n
      uint every
      const uint *closing
    ]],
  },
}
