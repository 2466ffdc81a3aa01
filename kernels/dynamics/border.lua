-- SPDX-License-Identifier: MIT
return {
  about = "contacts near the borders of a domain that is one of many",
  uses = { "dynamics/records.h", "dynamics/border.h", "dynamics/place_kind.clh", "dynamics/colour_choice.clh",
    "dynamics/body_row.clh" },
  params = { common.SLEEP, common.GROUP(64), common.ROWS_AN_ITEM },
  args = {
    mark_border = [[
      const uint2 *links
      const uint *touches
      uint n_contacts
      const uint2 *places
      const uint *asleep  if SLEEP == 1
      uint every
      uint *colours
      volatile uint *choices
      volatile uint *flags
    ]],
    choose_inner = [[
      const uint2 *links
      const uint *colours
      const uint2 *places
      const uint *starts
      const uint *return_starts
      const uint *returns
      uint n
      uint *used
      volatile uint *choices
    ]],
    count_border = [[
      const uint2 *links
      uint n_contacts
      const uint2 *places
      const uint *colours
      const uint *touches
      uint listed
      uint *border_starts
    ]],
    list_border = [[
      const uint2 *links
      uint n_contacts
      const uint *colours
      const uint *border_starts
      uint4 *border
    ]],
    border_key = [[
      const uint2 *links
      uint n_contacts
      const uint2 *places
      const uint *colours
      const uint *touches
      uint *list
      uint *keys
    ]],
    used_colours = [[
      const uint *row_ids
      uint first_id
      uint n_ids
      const uint *starts
      const uint *return_starts
      const uint *returns
      const uint *colours
      uint *gathered
    ]],
  },
}
