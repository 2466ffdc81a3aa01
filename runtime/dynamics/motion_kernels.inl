// SPDX-License-Identifier: MIT
// The kernels of a motion, in the order of motion_kernel: the entry point and its file, the stage
// of a step that its time counts for, and over how many objects, pairs or contacts it is launched;
// 0: who launches it says how many.
//
//   KERNEL  built with the motion if it is wanted, by a condition of ask_wanted (motion_kernels.c);
//           else to launch it does nothing
//   LATER   built with all such kernels of its file when one of them is first launched
#ifndef LATER
#define LATER(which, entry, file, stage, work) KERNEL(which, entry, file, false, stage, work)
#endif
KERNEL(INTEGRATE_FREE_FLIGHT, integrate_free_flight, "integrate_free_flight", flight, "integrate",
       m->n)
// bounds and rows
KERNEL(COMPUTE_FAT_AABBS, compute_fat_aabbs, "fat_aabbs", contact, "grid", m->n)
KERNEL(CHECK_FAT_AABBS, check_fat_aabbs, "fat_aabbs", skin, "fat_aabbs",
       m->graph.of_all ? m->n : m->awake.n_bodies)
KERNEL(CONTACT_GRAPH_ROWS, contact_graph_rows, "contact_graph", contact, "contact_graph",
       m->graph.n_pairs > m->n ? m->graph.n_pairs : m->n)
KERNEL(CONTACT_GRAPH_SORT, contact_graph_sort, "contact_graph", contact, "contact_graph", m->n)
KERNEL(CONTACT_GRAPH_REVERSE, contact_graph_reverse, "contact_graph", contact, "contact_graph",
       m->n)
KERNEL(MAKE_ROWS, make_rows, "contact_graph", contact && cpu, "contact_graph", 0)
KERNEL(MAKE_RETURNS, make_returns, "contact_graph", contact && cpu, "contact_graph", 0)
KERNEL(MATCH_CONTACTS, match_contacts, "match_contacts", contact, "match_contacts", m->graph.n_old)
// what is awake, and manifolds
KERNEL(MARK_AWAKE, mark_awake, "awake", sleep, "sleep", m->n)
KERNEL(SPREAD_AWAKE, spread_awake, "awake", sleep, "sleep", 0)
KERNEL(COUNT_AWAKE, count_awake, "awake", sleep, "sleep", 0)
KERNEL(LIST_AWAKE, list_awake, "awake", sleep, "sleep", 0)
KERNEL(PREPARE_BODIES, prepare_bodies, "bodies", response, "integrate",
       (uint64_t)m->awake.n_bodies + FIXED)
KERNEL(BUILD_MANIFOLDS, build_manifolds, "build_manifolds", contact, "manifolds",
       m->awake.n_contacts)
KERNEL(UPDATE_SLEEP, update_sleep, "update_sleep", sleep, "sleep", m->awake.n_bodies)
KERNEL(WAKE_TOUCHING, wake_touching, "update_sleep", sleep, "sleep", m->awake.n_bodies)
// colours: each stage, and a launch that does what these and the sort do
KERNEL(GRAPH_COLOUR_MARK, graph_colour_mark, "graph_colour", response, "graph_colour",
       m->awake.n_contacts)
KERNEL(GRAPH_COLOUR_CHOOSE, graph_colour_choose, "graph_colour", response, "graph_colour",
       m->awake.n_bodies)
KERNEL(GRAPH_COLOUR_TAKE, graph_colour_take, "graph_colour", response, "graph_colour",
       m->awake.n_bodies)
KERNEL(GRAPH_COLOUR_KEY, graph_colour_key, "graph_colour", response, "graph_colour",
       m->awake.n_contacts)
KERNEL(ROW_START, row_start, "cell_start", response, "graph_colour",
       (uint64_t)m->awake.n_contacts + 1)
KERNEL(COLOUR_CONTACTS, colour_contacts, "colour_contacts", response && (cpu || meets),
       "graph_colour", 0)
// the solver: each stage, and a launch of passes
KERNEL(PREPARE_CONTACTS, prepare_contacts, "prepare_contacts", response, "solve_contacts", 0)
KERNEL(INTEGRATE_VELOCITIES, integrate_velocities, "bodies", response, "integrate",
       m->awake.n_bodies)
KERNEL(SOLVE_SHOCKS, solve_shocks, "solve_shocks", shocks, "solve_contacts", 0)
KERNEL(SOLVE_CONTACTS, solve_contacts, "solve_contacts", response, "solve_contacts", 0)
KERNEL(INTEGRATE_POSITIONS, integrate_positions, "integrate_positions", response, "integrate",
       m->awake.n_bodies)
KERNEL(APPLY_RESTITUTION, apply_restitution, "solve_contacts", response, "solve_contacts", 0)
KERNEL(STORE_IMPULSES, store_impulses, "prepare_contacts", response, "solve_contacts", 0)
KERNEL(SOLVE_SUBSTEPS, solve_substeps, "solve_substeps", at_once, "solve_contacts", 0)
// a step's end
KERNEL(CONTACT_EVENTS, contact_events, "contact_events", events, "events",
       ((uint64_t)m->graph.n_contacts + 31) / 32)
KERNEL(FINALIZE_BODIES, finalize_bodies, "bodies", response, "integrate", m->awake.n_bodies)
KERNEL(PUSH_SLEEPERS, push_sleepers, "push_sleepers", sleep, "sleep", m->awake.n_bodies)
// bodies that commands altered
KERNEL(PLACE_ALTERED, place_altered, "altered_pairs", skin, "altered_pairs", m->altered.n)
KERNEL(FIND_ALTERED_PAIRS, find_altered_pairs, "altered_pairs", skin, "altered_pairs", m->n)
KERNEL(KEEP_PAIRS, keep_pairs, "altered_pairs", skin, "altered_pairs", m->graph.n_contacts)
LATER(COMPUTE_ALTERED_AABBS, compute_fat_aabbs, "fat_aabbs", "grid", m->altered.n)
// what callers read
LATER(GATHER_ROWS, gather_rows, "read_rows", "fetch", m->reading.n_ids)
LATER(CHANGED_ROWS, changed_rows, "read_rows", "moved", ((uint64_t)m->n + 31) / 32)
LATER(WRITE_POSES, write_poses, "write_poses", "fetch", m->n)
// rows, contacts and bodies of a domain
LATER(PACK_ROWS, pack_rows, "row_parts", "domain", m->reading.n_ids)
LATER(UNPACK_ROWS, unpack_rows, "row_parts", "domain", m->reading.n_ids)
LATER(KEEP_CONTACTS, keep_contacts, "keep_contacts", "domain", m->graph.n_contacts)
LATER(MARK_BORDER, mark_border, "border", "domain", m->graph.n_contacts)
LATER(CHOOSE_INNER, choose_inner, "border", "graph_colour", m->awake.n_bodies)
LATER(COUNT_BORDER, count_border, "border", "domain", (uint64_t)m->graph.n_contacts + 1)
LATER(LIST_BORDER, list_border, "border", "domain", m->graph.n_contacts)
LATER(BORDER_KEY, border_key, "border", "graph_colour", m->awake.n_contacts)
LATER(USED_COLOURS, used_colours, "border", "domain", m->reading.n_ids)
LATER(LIST_NEAR, list_near, "list_near", "domain", m->n)
LATER(LIST_MEETING, list_meeting, "list_near", "domain", m->n)
LATER(MAKE_FAR_BOXES, make_far_boxes, "list_near", "domain", m->n)
// contacts that a domain solves for ghosts
LATER(BEGIN_GHOSTS, begin_ghosts, "closure", "closure", m->n)
LATER(NOTE_KEPT, note_kept, "closure", "closure", m->border.n_border)
LATER(NOTE_LACKS, note_lacks, "closure", "closure", m->n)
LATER(TAKE_NEEDED, take_needed, "closure", "closure", m->border.n_border)
LATER(TAKE_OWN, take_own, "closure", "closure", m->border.n_border)
LATER(END_CONTACTS, end_contacts, "closure", "closure", m->border.n_border)
LATER(END_GHOSTS, end_ghosts, "closure", "closure", m->n)
LATER(READ_ASKED, read_asked, "asked_contacts", "closure", m->reading.n_ids)
LATER(TAKE_ASKED, take_asked, "asked_contacts", "closure", m->reading.n_ids)
#undef KERNEL
#undef LATER
