// SPDX-License-Identifier: MIT
// A motion's insides, for the files that make up its step.
//
// B holds the state from step to step and solves; pairs are found by both
// devices, by a world of the objects' bounds.
#ifndef RUNTIME_MOTION_H
#define RUNTIME_MOTION_H

#include "kernels/dynamics/records.h"
#include "runtime/dynamics/effect.h"
#include "runtime/dynamics/motion_events.h"
#include "runtime/dynamics/motion_plan.h"
#include "runtime/opencl/background.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/radix_sort.h"

enum { MOTION_WALLS = 6 };

#define MOTION_MOST (DUET_MOST_OBJECTS - MOTION_WALLS) // objects

// Contacts are kept while a separation is below this many slops.
enum { MOTION_SLOPS = 4 };

// Keys that contacts are sorted by: several of a colour.
enum { KEYS = COLOURS * COLOUR_KEYS, KEY_BITS = 8 };

// What B holds. Which buffers there are follows from the effects.
typedef enum motion_buffer {
    CENTRES, // by object
    CELLS,   // of centres, with an origin
    VELOCITIES,
    ROTATIONS,
    ANGULAR_VELOCITIES,
    INERTIAS,
    HALVES,
    RESTITUTIONS,
    FRICTIONS,
    FILTERS,
    SENSORS,
    RESTS,
    ASLEEP,
    FORCES,
    BODIES,
    BOXES,
    STARTS,
    RETURN_STARTS,
    USED,
    CHOICES,
    PAIRS,  // of bodies that commands altered, and of all that hold on
    OTHERS, // by contact
    LINKS,
    RETURNS,
    CONTACTS,
    TOUCHES,
    COLOUR_OF,
    OLD_LINKS,
    OLD_CONTACTS,
    OLD_TOUCHES,
    OLD_COLOURS,
    LIST, // contacts by colour
    LIST_KEYS,
    LIST_SPARE,
    LIST_KEYS_SPARE,
    COLOUR_STARTS,
    SPANS,
    BLOCKS,   // contacts by colour while they are solved
    TOUCHING, // a bit for each contact
    HITS,
    FLAG_WORDS,
    READ_IDS, // while states are read
    GATHERED,
    CHANGED,
    LAST_CENTRES, // as they were read last
    LAST_CELLS,
    LAST_ROTATIONS,
    ALTERED, // bodies that commands altered, while their pairs are searched
    IS_ALTERED,
    ALTERED_HEADS,
    ALTERED_ENTRIES_OF,
    ALTERED_NEXTS,
    ALTERED_WIDE_ONES,
    ALTERED_COUNT_WORDS,
    MOTION_BUFFERS
} motion_buffer;

typedef struct motion_kernels {
    kernel *integrate_free_flight;
    kernel *compute_fat_aabbs, *check_fat_aabbs;
    kernel *contact_graph_pairs, *contact_graph_walls, *contact_graph_sort, *contact_graph_reverse;
    kernel *match_contacts;
    kernel *build_manifolds;
    kernel *update_sleep, *push_sleepers, *move_sleepers;
    kernel *contact_events;
    kernel *prepare_bodies, *integrate_velocities, *integrate_positions, *finalize_bodies;
    kernel *graph_colour_mark, *graph_colour_choose, *graph_colour_take, *graph_colour_key;
    kernel *prepare_contacts, *store_impulses;
    kernel *solve_contacts, *apply_restitution;
    kernel *row_start;
    kernel *write_poses; // NULL until a tree asks for it
    // likewise, a command
    kernel *compute_altered_aabbs, *place_altered, *find_altered_pairs, *keep_pairs;
} motion_kernels;

// What kernels are told besides the motion's buffers, by the names that their cards use.
typedef struct motion_args {
    // of a step
    arg_real4 gravity; // or the centre and strength of an attraction
    cl_float4 gravity_float;
    arg_real4 lower, upper; // walls
    arg_real4 times, drags; // of a substep's parts, in free flight
    cl_uint substeps;
    cl_float dt;
    arg_real dt_real;
    cl_float h, per_h, drag; // of a substep
    cl_float4 spring, hard_spring, fall;
    cl_float load_speed, margin, least_speed;
    arg_real skin;
    arg_real aabb_margin, contact_margin; // bounds of objects: with half a skin, and without
    cl_float sleep_speed, sleep_after;
    cl_float hit_speed;
    cl_int4 base; // the cell that others are counted from

    // of a launch
    cl_uint n_pairs, n_old;
    cl_uint fill, woken, soft;
    cl_uint from_colour, to_colour, each;
    cl_int4 span; // of from_colour
    cl_uint round;
    cl_uint key_end;
    buffer pairs; // that rows are made of
    buffer row_starts, row_values;
    buffer rows, last_rows; // of a state, by object
    buffer poses;           // a tree's
    cl_uint row_words, n_ids;
    cl_uint n_altered, n_heads, pair_capacity;
    cl_float per_edge;
} motion_args;

// How long the records of kernels/dynamics/records.h are, in floats; bodies in vectors
// of four.
typedef struct motion_layout {
    uint32_t head, point, points, record;
    uint32_t body;
    uint32_t constraint, block; // a block is so many constraints
} motion_layout;

// Contacts of one colour: where in the list, and where in blocks. A uint4 on devices.
typedef struct colour_span {
    cl_uint first;
    cl_uint count;
    cl_uint slot;
    cl_uint spare;
} colour_span;

// What was told of the bodies that moved (motion_read.c).
typedef struct motion_reading {
    kernel *gather_rows, *changed_rows; // NULL until something is read
    bool begun;                         // the device has what was read last
    uint32_t n;
    uint32_t *ids; // [n] that moved
    duet_state *states;
} motion_reading;

// What commands (runtime/duet_motion_commands.h) leave behind.
typedef struct motion_commands motion_commands;

struct duet_motion {
    duet_motion_def def;
    motion_plan plan; // the def's
    uint32_t effects;
    effect_facts facts;
    cl_uint n;
    duet_pose *poses;  // as given; with an origin each centre is an offset in its cell
    cl_int4 *cells;    // NULL without
    duet_body *bodies; // as given
    const device *device;
    gen *gen;
    program_set *programs;
    motion_kernels kernels;
    motion_layout layout;
    motion_args args;
    scan scan;
    radix_sort radix;
    timeline times;
    motion_commands *commands; // NULL before the first
    struct text *recording;    // a file's bytes (runtime/commands); NULL: nothing is recorded
    uint64_t recorded_step;    // steps up to it are in there
    struct motion_map *maps;   // [parts of the state], NULL before the first (motion_map.c)
    uint32_t mapped;           // those that are: a bit for each
    background background;     // of a step in two halves, and what that took
    double background_ms;
    buffer buffers[MOTION_BUFFERS];
    duet_world *world;    // of bounds; NULL without contact
    duet_result searched; // what it found and took last
    double extent;        // the bodies' mean least one, at the start
    double margin;        // contacts are kept to that far apart
    uint64_t step;
    cl_uint n_contacts; // in rows
    colour_span colours[COLOUR_OVERFLOW + 1];
    uint32_t n_colours; // that are not empty
    uint32_t n_pushing; // contacts of all colours
    uint32_t n_blocks;
    uint64_t n_pairs;
    bool has_graph;
    bool rows_stale; // they are not of the bodies that there are, besides those that are altered
    bool bounds_checked; // since something moved, against the bounds that rows are made of
    bool list_stale;     // the list by colour is not that of the contacts
    bool recoloured;     // some contacts had another colour in the last step
    uint32_t rounds;     // that gave them colours
    bool at_rest;        // everything sleeps: a step changes nothing
    bool rebuilt;
    bool broken; // a step failed half-way: only a load makes it whole again
    uint32_t flags[FLAGS];
    motion_events told;
    motion_reading reading;
};

// Reads the flags, which waits for all that was launched.
static inline bool motion_read_flags(duet_motion *m, duet_error *err)
{
    return timeline_read(&m->times, "flags", &m->buffers[FLAG_WORDS], m->flags, sizeof m->flags,
                         err);
}

// The objects of a motion: poses, or with origin cells large_poses [n]; the other is NULL.
duet_motion *motion_create(const duet_motion_def *def, const duet_pose *poses,
                           const duet_large_pose *large_poses, const duet_body *bodies, uint32_t n,
                           duet_error *err);

// Whether a public call has a motion whose state is that of a whole step, none of which is under
// way, and of which nothing is mapped; BAD_ARGUMENT where it has not. Steady: something may be
// mapped. Idle: and a step may have failed.
bool motion_is_idle(const duet_motion *m, const char *call, duet_error *err);
bool motion_is_steady(const duet_motion *m, const char *call, duet_error *err);
bool motion_is_whole(const duet_motion *m, const char *call, duet_error *err);
bool motion_is_unmapped(const duet_motion *m, const char *call, duet_error *err);

// Without writing what was mapped; and what was told of the bodies that moved.
void motion_forget_maps(duet_motion *m);
void motion_forget_moved(motion_reading *r);

// Kernels with what the scene says of their parameters, for all bodies or for those that commands
// altered, which are built when they are first asked for. After a failure none is there.
bool motion_build_kernels(duet_motion *m, const kernel_request *list, size_t n, bool altered,
                          duet_error *err);
extern const binding motion_bindings[];

// What is wrong with a pose, a body or a def; a def's fault is told by err.
const char *motion_pose_fault(const duet_pose *pose, uint32_t dims);
const char *motion_body_fault(const duet_body *body);
bool motion_check_def(const duet_motion_def *def, duet_error *err);

// What kernels are offered, and returns how many that is: what the scene says of their parameters,
// then what the plan does.
enum { MOTION_OFFERS = 40 };
uint32_t motion_offers(duet_motion *m, bool altered, gen_offer offers[MOTION_OFFERS]);

// Generates and builds what the effects need; again: for facts or a plan that have changed.
bool motion_prepare(duet_motion *m, duet_error *err);
bool motion_prepare_again(duet_motion *m, duet_error *err);

// The skin, if there is one, and the kernels that only a motion has, of those that this one has
// built, as kernel_spaces_read.
bool motion_kernel_spaces(duet_motion *m, kernel_space **spaces, uint32_t *n, duet_error *err);

// Puts poses and bodies into B's buffers, and 0 into what they lack.
bool motion_reset(duet_motion *m, duet_error *err);

// The rotation and the angular velocity that an object was given.
void motion_given_state(const duet_motion *m, uint32_t id, duet_state *state);

// All states, which the caller frees; NULL where a number of them is no longer finite.
duet_state *motion_read_states(duet_motion *m, duet_error *err);

// States of n bodies whose ids are valid, or without ids of the first n. Where cells are asked for,
// centres are offsets in these.
bool motion_fetch_states(duet_motion *m, const uint32_t *ids, uint32_t n, duet_state *states,
                         cl_int4 *cells, duet_error *err);

// One over the inertia of an object about each of its own axes; 0: never turned about it.
void motion_inverse_inertia(const duet_motion *m, uint32_t id, double inverse[3]);

// 32-bit words of state that an object has in a buffer; 0: not by object, or
// not called for.
uint32_t motion_words(const duet_motion *m, motion_buffer which);

// Bytes of state that an object has for an effect.
uint32_t motion_bytes_for(const duet_motion *m, uint32_t effect);

// Puts what poses and bodies say of some objects into B's buffers; places NULL: of all n.
enum motion_part {
    PART_POSE = 1 << 0, // centre and rotation
    PART_SIZE = 1 << 1,
    PART_VELOCITY = 1 << 2,
    PART_ANGULAR_VELOCITY = 1 << 3,
    PART_MASS = 1 << 4,
    PART_SURFACE = 1 << 5, // restitution and friction
    PART_FILTER = 1 << 6,
    PART_SENSOR = 1 << 7,
    PART_ALL = (1 << 8) - 1
};
bool motion_send_places(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t parts,
                        duet_error *err);

// Makes space for all n objects, of which the first old_n have it. The state of the others becomes
// 0; the device may still be writing that on return.
bool motion_grow(duet_motion *m, uint32_t old_n, duet_error *err);

// Where objects may touch: bounds to pairs, pairs to the contacts of each.
bool motion_check_bounds(duet_motion *m, duet_error *err); // sets FLAG_MOVED
bool motion_build_graph(duet_motion *m, duet_error *err);

// Manifolds, and with response sleep, colours and substeps: what contacts do to bodies in a step.
bool motion_solve(duet_motion *m, duet_error *err);

// Space for n elements of `size` bytes in a buffer.
bool motion_reserve(duet_motion *m, motion_buffer which, uint64_t n, size_t size, duet_error *err);

#endif
