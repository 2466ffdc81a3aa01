-- SPDX-License-Identifier: MIT
return {
  about = "matches the last step's contacts with the new ones, and moves their impulses over",
  uses = { "dynamics/records.h", "dynamics/contact.clh" },
  params = {
    common.DIMS,
    { "ANGULAR_VELOCITY", values = { 0, 1 }, default = 0, about = "1: objects turn" },
    { "CONTACT_RESPONSE", values = { 0, 1 }, default = 0, about = "1: contacts push back" },
    common.FRICTION,
    { "SLEEP", values = { 0, 1 }, default = 0, about = "1: bodies at rest are left out" },
    { "WG", values = { 1, 64, 128 }, default = function(limits) return limits.cpu and 1 or 64 end,
      about = "work-items a group" },
    { "PER_ITEM", values = { 1, 256, 1024 }, default = function(limits) return limits.cpu and limits.batch or 1 end,
      about = "objects, pairs or contacts a work-item" },
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
