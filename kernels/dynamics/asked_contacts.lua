-- SPDX-License-Identifier: MIT
return {
  about = "contacts that a domain asks their homes for",
  uses = { "dynamics/records.h", "dynamics/border.h", "dynamics/body_row.clh" },
  params = { common.GROUP(64), common.ROWS_AN_ITEM },
  args = {
    read_asked = [[
      const uint2 *places
      const uint2 *links
      const uint *touches
      const float *contacts
      uint row_words
      const uint *starts
      const uint *return_starts
      const uint *returns
      const uint *colours
      const uint2 *asked
      uint n_ids
      uint *gathered
    ]],
    take_asked = [[
      const uint2 *places
      const uint2 *links
      uint *touches
      float *contacts
      uint row_words
      const uint *starts
      const uint *return_starts
      const uint *returns
      uint *colours
      const uint2 *asked
      uint n_ids
      const uint *gathered
      volatile uint *closing
    ]],
  },
}
