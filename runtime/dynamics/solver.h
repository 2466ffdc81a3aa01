// SPDX-License-Identifier: MIT
// What contacts do to bodies in a step: makes manifolds and colours (products.h), and solves
// contacts by colour: contacts of one colour share no body that moves.
#ifndef RUNTIME_SOLVER_H
#define RUNTIME_SOLVER_H

#include "kernels/dynamics/border.h"
#include "kernels/dynamics/records.h"
#include "runtime/opencl/radix_sort.h"

// Keys that contacts are sorted by, at most: several of a colour.
enum { KEYS = COLOUR_KEY(COLOURS, BORDER_KEYS), KEY_BITS = 8 };

// More bodies than that are never solved in one launch.
enum { SOLVER_FEW = 1024 };

// A row of so many bodies hands an impact on from end to end.
enum { SHOCK_SWEEPS = 16 };

// Contacts of one colour: where in the list, and where in blocks. A uint4 on devices. In a domain
// the first ones, in whole blocks, are its border's (domain_take_colours). One more entry stands
// behind those of all colours: first, the end of the colours that have contacts; count, of all
// blocks.
typedef struct colour_span {
    cl_uint first;
    cl_uint count;
    cl_uint slot;
    cl_uint border;
} colour_span;

typedef struct contact_solver {
    radix_sort radix;
    colour_span colours[COLOUR_SPANS];
    uint32_t n_colours; // that are not empty
    uint32_t n_pushing; // contacts of all colours
    uint32_t n_blocks;
    uint32_t rounds; // that the next colouring sends at once; 0: the device is asked first
    // what a launch is told besides
    cl_uint hopes; // of a step that is sent whole (motion_step.c)
    cl_uint woken, soft, round;
    cl_uint sweep, first_sweep; // of shocks, counted on from substep to substep
    cl_uint sorts;              // 1: contacts are listed by colour even if none changed its colour
    cl_uint block_capacity;     // blocks that BLOCKS has space for
    cl_uint from_colour, to_colour, each;
    cl_uint from_pass, to_pass;   // of solve_substeps
    cl_uint from_round, to_round; // of push_sleepers
    cl_int4 span;                 // from_colour's
} contact_solver;

// Each in two calls: what is sent before the host has to know anything, and what it then goes on
// with.
bool motion_begin_manifolds(duet_motion *m, duet_error *err);
bool motion_end_manifolds(duet_motion *m, duet_error *err);
bool motion_begin_colours(duet_motion *m, duet_error *err);
bool motion_end_colours(duet_motion *m, duet_error *err);

// Once flags were read: notes whether the colours of the step before still hold; else reads how
// others lie that were made at once, and makes space for them.
bool motion_keep_colours(duet_motion *m, duet_error *err);

// With contact response: the substeps, of bodies and colours that are right.
bool motion_solve(duet_motion *m, duet_error *err);

// Whether all of it is in launches that do nothing if the host has to go on first.
bool motion_solves_at_once(const duet_motion *m);

// Whether something elastic passes impacts on; the speeds that contacts return then need no more.
bool motion_has_shocks(const duet_motion *m);

// Brings to the objects what the substeps leave. presses: some may sleep deep in others, and are
// pushed out of them.
bool motion_finalize(duet_motion *m, bool presses, duet_error *err);

#endif
