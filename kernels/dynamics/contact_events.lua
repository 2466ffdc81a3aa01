-- SPDX-License-Identifier: MIT
return {
  about = "which contacts touch after a step, and which hit hard",
  uses = { "dynamics/motion.clh", "dynamics/records.h", "dynamics/contact.clh" },
  params = {
    common.DIMS, common.DOUBLE, common.ORIGIN, common.TURN, common.MAY_RESPOND, common.FRICTION,
    common.CARRIED,
    { "HITS", values = { 0, 1 }, default = 0, about = "1: reports impacts above a speed" },
    common.GROUP(64),
    { "PER_ITEM", values = { 1, 16 }, default = function(limits) return limits.cpu and 16 or 1 end,
      about = "words of 32 contacts a work-item" },
  },
  args = {
    contact_events = [[
      const uint *touches
      const float *contacts
      uint n_contacts
      uint *touching
      uint hopes
      volatile uint *flags
      const uint2 *links                if HITS == 1
      uint n                            if HITS == 1
      uint carrier  only if HITS * CARRIED == 1
      const real4 *centres              if HITS == 1
      const int4 *cells                 if HITS * ORIGIN > 0
      const real4 *velocities           if HITS == 1
      const real4 *angular_velocities   if HITS * ANGULAR_VELOCITY == 1
      float hit_speed                   if HITS == 1
      uint *hits                        if HITS == 1
    ]],
  },
  valid = function(p, limits)
    if p.DOUBLE == 1 and not limits.fp64 then return false, "the device has no double" end
    if p.DOUBLE == 1 and p.ORIGIN > 0 then return false, "origin cells are for a state in float" end
    if p.FRICTION == 1 and p.CONTACT_RESPONSE == 0 then return false, "FRICTION without CONTACT_RESPONSE" end
    if p.HITS == 1 and p.CONTACT_RESPONSE == 0 then return false, "HITS without CONTACT_RESPONSE" end
    return true
  end,
}
