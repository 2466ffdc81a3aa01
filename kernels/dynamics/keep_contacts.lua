-- SPDX-License-Identifier: MIT
return {
  about = "contacts that stay in a domain while bodies come and go",
  uses = { "dynamics/border.h" },
  params = { common.GROUP(64), common.ROWS_AN_ITEM },
  args = {
    keep_contacts = [[
      const uint2 *places
      const uint *moved
      uint n_contacts
      uint2 *links
    ]],
  },
}
