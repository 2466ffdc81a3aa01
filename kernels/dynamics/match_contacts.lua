-- SPDX-License-Identifier: MIT
return {
  about = "matches the last step's contacts with the new ones, and moves their impulses over",
  uses = { "dynamics/records.h", "dynamics/border.h", "dynamics/contact.clh" },
  params = {
    common.DIMS, common.TURN, common.MAY_RESPOND, common.FRICTION, common.SLEEP, common.GROUP(64),
    common.ROWS_AN_ITEM,
  },
  args = {
    match_contacts = [[
      const uint2 *old_links
      const uint *old_touches
      const float *old_contacts
      uint n_old
      const uint *old_colours  if CONTACT_RESPONSE == 1
      uint *colours            if CONTACT_RESPONSE == 1
      const uint *asleep       if SLEEP == 1
      uint n                   if SLEEP == 1
      float *rests             if SLEEP == 1
      const uint *starts
      const uint *others
      uint *touches
      float *contacts
    ]],
  },
  valid = function(p)
    if p.FRICTION == 1 and p.CONTACT_RESPONSE == 0 then return false, "FRICTION without CONTACT_RESPONSE" end
    if p.SLEEP == 1 and p.CONTACT_RESPONSE == 0 then return false, "SLEEP without CONTACT_RESPONSE" end
    return true
  end,
}
