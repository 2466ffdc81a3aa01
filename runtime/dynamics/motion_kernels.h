// SPDX-License-Identifier: MIT
// Which kernels a motion runs, and with which parameters and arguments.
#ifndef RUNTIME_MOTION_KERNELS_H
#define RUNTIME_MOTION_KERNELS_H

#include "runtime/duet.h"
#include "runtime/opencl/program.h"

typedef struct motion_kernels {
    kernel *integrate_free_flight;
    kernel *compute_fat_aabbs, *check_fat_aabbs;
    kernel *contact_graph_pairs, *contact_graph_walls, *contact_graph_ground;
    kernel *contact_graph_sort, *contact_graph_reverse;
    kernel *make_rows, *make_returns; // do what these do; a team's
    kernel *match_contacts;
    kernel *build_manifolds;
    kernel *mark_awake, *spread_awake, *count_awake, *list_awake;
    kernel *update_sleep, *wake_touching, *push_sleepers, *move_sleepers;
    kernel *contact_events;
    kernel *prepare_bodies, *integrate_velocities, *integrate_positions, *finalize_bodies;
    kernel *graph_colour_mark, *graph_colour_choose, *graph_colour_take, *graph_colour_key;
    kernel *colour_contacts; // does what these and the sort do; NULL: no groups of a launch wait
    kernel *prepare_contacts, *store_impulses;
    kernel *solve_contacts, *apply_restitution, *solve_shocks;
    kernel *solve_substeps; // NULL with shocks, and if more bodies are always awake than a GPU's
                            // group takes
    kernel *row_start;
    kernel *write_poses; // NULL until a tree asks for it
    // likewise, a command
    kernel *compute_altered_aabbs, *place_altered, *find_altered_pairs, *keep_pairs;
} motion_kernels;

// How long the records of kernels/dynamics/records.h are, in floats; bodies in vectors
// of four.
typedef struct motion_layout {
    uint32_t head, point, points, record;
    uint32_t body;
    uint32_t constraint, block; // a block is so many constraints
} motion_layout;

// Kernels with what the scene says of their parameters, for all bodies or for those that commands
// altered, which are built when they are first asked for. After a failure none is there.
bool motion_build_kernels(duet_motion *m, const kernel_request *list, size_t n, bool altered,
                          duet_error *err);
extern const binding motion_bindings[];

// Fills offers for the kernels, and returns how many they are: what the scene says of their
// parameters, then what the plan does.
enum { MOTION_OFFERS = 48 };
uint32_t motion_offers(duet_motion *m, bool altered, gen_offer offers[MOTION_OFFERS]);

// Whether a team takes whole substeps; whether one launch chooses and lists all colours, and lays
// them out.
bool motion_team_solves(const motion_kernels *k);
bool motion_colours_at_once(const duet_motion *m);

// Generates and builds what the effects need; again: for facts or a plan that have changed.
bool motion_prepare(duet_motion *m, duet_error *err);
bool motion_prepare_again(duet_motion *m, duet_error *err);

#endif
