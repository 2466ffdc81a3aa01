// SPDX-License-Identifier: MIT
// What B holds of a motion, in the order of motion_buffer: the name and the type that kernels know a
// buffer by. Which buffers there are follows from the effects.
//
//   BY_OBJECT  a row for each object: the effect that it is there for, another that calls for it,
//              reals and 32-bit words of a row
//   BUFFER     rows of something else
//   HIDDEN     known to no kernel by a name of its own
BY_OBJECT(CENTRES, "centres", "real4 *", MOTION, ALL, 4, 0)
BY_OBJECT(CELLS, "cells", "int4 *", ALL, ALL, 0, 4) // of centres; only with origin cells
BY_OBJECT(VELOCITIES, "velocities", "real4 *", MOTION, ALL, 4, 0)
BY_OBJECT(ROTATIONS, "rotations", "real4 *", ROTATION, ROTATION, 4, 0)
BY_OBJECT(ANGULAR_VELOCITIES, "angular_velocities", "real4 *", ANGULAR_VELOCITY, ANGULAR_VELOCITY,
          4, 0)
BY_OBJECT(INERTIAS, "inertias", "float4 *", ANGULAR_VELOCITY, ANGULAR_VELOCITY, 0, 4)
BY_OBJECT(HALVES, "halves", "float4 *", CONTACT, BOUNDARY, 0, 4)
BY_OBJECT(RESTITUTIONS, "restitutions", "float *", CONTACT_RESPONSE, CONTACT_RESPONSE, 0, 1)
BY_OBJECT(FRICTIONS, "frictions", "float *", FRICTION, FRICTION, 0, 1)
BY_OBJECT(ROLLING_RESISTANCES, "rolling_resistances", "float *", ROLLING_RESISTANCE,
          ROLLING_RESISTANCE, 0, 1)
BY_OBJECT(SURFACE_VELOCITIES, "surface_velocities", "float4 *", SURFACE_VELOCITY, SURFACE_VELOCITY,
          0, 4)
BY_OBJECT(MATERIALS_OF, "materials", "uint *", MATERIALS, MATERIALS, 0, 1)
BY_OBJECT(FILTERS, "filters", "uint2 *", FILTER, FILTER, 0, 2)
BY_OBJECT(SENSORS, "sensors", "float *", SENSORS, SENSORS, 0, 1)
BY_OBJECT(RESTS, "rests", "float *", SLEEP, SLEEP, 0, 1)
BY_OBJECT(ASLEEP, "asleep", "uint *", SLEEP, SLEEP, 0, 1)
BY_OBJECT(FORCES, "forces", "float4 *", FORCES, FORCES, 0, 8)
BY_OBJECT(BODIES, "bodies", "float4 *", CONTACT_RESPONSE, CONTACT_RESPONSE, 0, 4) // times the layout's
BY_OBJECT(BOXES, "boxes", "float *", CONTACT, CONTACT, 0, 6)
BY_OBJECT(FAR_BOXES, "far_boxes", "float *", CONTACT, CONTACT, 0, 6) // of a domain
BY_OBJECT(STARTS, "starts", "uint *", CONTACT, CONTACT, 0, 1)
BY_OBJECT(RETURN_STARTS, "return_starts", "uint *", CONTACT, CONTACT, 0, 1)
BY_OBJECT(USED, "used", "uint *", CONTACT_RESPONSE, CONTACT_RESPONSE, 0, 1)
BY_OBJECT(CHOICES, "choices", "uint *", CONTACT_RESPONSE, CONTACT_RESPONSE, 0, 1)
BUFFER(PAIRS, "found_pairs", "uint2 *") // of altered bodies, and of all others that hold on
// by contact
BUFFER(OTHERS, "others", "uint *")
BUFFER(LINKS, "links", "uint2 *")
BUFFER(RETURNS, "returns", "uint *")
BUFFER(CONTACTS, "contacts", "float *")
BUFFER(TOUCHES, "touches", "uint *")
BUFFER(COLOUR_OF, "colours", "uint *")
BUFFER(OLD_LINKS, "old_links", "uint2 *")
BUFFER(OLD_CONTACTS, "old_contacts", "float *")
BUFFER(OLD_TOUCHES, "old_touches", "uint *")
BUFFER(OLD_COLOURS, "old_colours", "uint *")
BUFFER(LIST, "list", "uint *") // contacts by colour
BUFFER(LIST_KEYS, "keys", "uint *")
BUFFER(LIST_SPARE, "entry_rows", "uint *") // also a team's, while it makes rows
BUFFER(LIST_KEYS_SPARE, "entry_values", "uint *")
BUFFER(ROW_COUNTS, "row_counts", "uint *") // of each part of a team's, by buckets
BUFFER(COLOUR_STARTS, "key_starts", "uint *")
BUFFER(KEY_COUNTS, "key_counts", "uint *") // of each part of a team's
BUFFER(SPANS, "spans", "uint4 *")
BUFFER(BLOCKS, "blocks", "float *")      // contacts by colour while they are solved
BUFFER(TEAM, "team", "uint *")
BUFFER(TOUCHING, "touching", "uint *") // a bit for each contact
BUFFER(HITS, "hits", "uint *")
BUFFER(FLAG_WORDS, "flags", "uint *")
BUFFER(SHOCKED, "shocked", "uint *") // a word
BUFFER(MATERIAL_RULES, "material_rules", "float *") // a row for each two materials
// what a step may change
BUFFER(LEVELS, "levels", "uint *")
BUFFER(PART_COUNTS, "part_counts", "uint *")
BUFFER(AWAKE, "awake", "uint *")
BUFFER(AWAKE_CONTACTS, "awake_contacts", "uint *")
BUFFER(N_LISTED, "n_listed", "uint *")
// a domain's: ids and kinds of its places, and the contacts that its host is told of
BUFFER(PLACES_OF, "places", "uint2 *")
BUFFER(MOVED_TO, "moved", "uint *")
BUFFER(BORDER_STARTS, "border_starts", "uint *")
BUFFER(BORDER, "border", "uint4 *")
BUFFER(GHOSTS, "ghosts", "uint4 *")
BUFFER(KEPT, "kept", "uint *")
BUFFER(CLOSING, "closing", "uint *")
BUFFER(ASKED, "asked", "uint2 *")
HIDDEN(SENT_IDS)
HIDDEN(RECEIVED_IDS)
BUFFER(EXTENTS, "extents", "float *")
BUFFER(NEAR, "near", "uint *")
// while states are read, and as they were read last
BUFFER(READ_IDS, "ids", "uint *")
BUFFER(GATHERED, "gathered", "uint *")
BUFFER(CHANGED, "changed", "uint *")
HIDDEN(LAST_CENTRES)
HIDDEN(LAST_CELLS)
HIDDEN(LAST_ROTATIONS)
// the table of altered bodies
BUFFER(ALTERED, "altered", "uint *")
BUFFER(IS_ALTERED, "is_altered", "uint *")
BUFFER(ALTERED_HEADS, "heads", "uint *")
BUFFER(ALTERED_ENTRIES_OF, "entries", "int4 *")
BUFFER(ALTERED_NEXTS, "nexts", "uint *")
BUFFER(ALTERED_WIDE_ONES, "wide", "uint *")
BUFFER(ALTERED_COUNT_WORDS, "altered_counts", "uint *")
#undef BY_OBJECT
#undef BUFFER
#undef HIDDEN
