// SPDX-License-Identifier: MIT
// A motion's insides, for the files that make up its step.
//
// B holds the state from step to step and solves; pairs are found by both
// devices, by a world of the objects' bounds.
#ifndef RUNTIME_MOTION_H
#define RUNTIME_MOTION_H

#include "runtime/bodies/effect.h"
#include "runtime/bodies/motion_def.h"
#include "runtime/dynamics/altered.h"
#include "runtime/dynamics/awake.h"
#include "runtime/dynamics/border.h"
#include "runtime/dynamics/contact_graph.h"
#include "runtime/dynamics/ground.h"
#include "runtime/dynamics/motion_events.h"
#include "runtime/dynamics/motion_kernels.h"
#include "runtime/dynamics/motion_plan.h"
#include "runtime/dynamics/motion_read.h"
#include "runtime/dynamics/phase.h"
#include "runtime/dynamics/products.h"
#include "runtime/dynamics/solver.h"
#include "runtime/dynamics/team.h"
#include "runtime/opencl/background.h"
#include "runtime/opencl/device_pair.h"

enum { MOTION_WALLS = AT_GROUND };

#define MOTION_MOST (DUET_MOST_OBJECTS - FIXED) // objects

// Contacts are kept while a separation is below this many slops.
enum { MOTION_SLOPS = 4 };

typedef enum motion_buffer {
#define BY_OBJECT(which, name, type, effect, also, reals, words) which,
#define BUFFER(which, name, type) which,
#define HIDDEN(which) which,
#include "runtime/dynamics/motion_buffers.inl"
    MOTION_BUFFERS
} motion_buffer;

// A step tells its kernels these, by the names that their cards use (motion_step.c). Other
// arguments of a launch stand in the struct of the file that launches it.
typedef struct motion_args {
    arg_real4 gravity; // or the centre and strength of an attraction
    cl_float4 gravity_float;
    arg_real4 lower, upper; // walls
    arg_real4 times, drags; // a substep's parts', in free flight
    cl_uint substeps;
    cl_float dt;
    arg_real dt_real;
    cl_float h, per_h, drag; // a substep's
    cl_float4 spring, hard_spring, fall;
    cl_float load_speed, margin, least_speed;
    cl_float soon; // 1 / two substeps' time
    arg_real skin, horizon, skins;
    arg_real aabb_margin, contact_margin; // bounds of objects: with half a skin, and without
    cl_float sleep_speed, sleep_after;
    cl_float hit_speed;
    cl_int4 base; // the cell that others are counted from
    cl_uint key_end;
} motion_args;

// A step in two halves: its thread, and how long that took.
typedef struct motion_halves {
    background thread;
    double ms;
} motion_halves;

// The state that commands (runtime/duet_motion_commands.h) leave behind.
typedef struct motion_commands motion_commands;

// In a step each file changes its own struct and the products that it makes, and reads the rest.
// Between steps commands change bodies and forget what they made wrong; a load changes all.
struct duet_motion {
    // the bodies and their def
    duet_motion_def def;
    motion_plan plan; // the def's
    uint32_t effects;
    bool is_domain; // of a rank, which takes a step's stages one by one (domain_motion.h)
    effect_facts facts;
    cl_uint n;
    duet_pose *poses;  // the given ones; with an origin each centre is an offset in its cell
    cl_int4 *cells;    // NULL without
    duet_body *bodies; // the given ones
    double extent;     // the bodies' mean least one, at the start
    double margin;     // contacts are kept to that far apart
    duet_substep_info substeps; // substeps.c

    // on B
    const device *device;
    gen *gen;
    program_set *programs;
    motion_kernels kernels;
    motion_layout layout;
    motion_args args; // motion_step.c
    timeline times;
    buffer buffers[MOTION_BUFFERS];
    uint32_t flags[FLAGS]; // the values that were read last

    // from step to step
    motion_phase phase; // phase.c
    uint64_t step;
    products products;
    altered_bodies altered;
    contact_graph graph;
    awake_lists awake;
    contact_solver solver;
    motion_team team;
    motion_border border; // a domain's
    motion_events told;
    motion_ground ground;
    motion_halves halves; // motion_step.c

    // kept for callers
    motion_reading reading;
    struct motion_map *maps;   // [parts of the state]; NULL before the first (motion_map.c)
    uint32_t mapped;           // a bit for each part that is mapped (phase.c)
    buffer poses_to;           // a tree's, while poses are written (motion_poses.c)
    motion_commands *commands; // NULL before the first
    struct text *recording;    // a file's bytes (runtime/commands); NULL: nothing is recorded
    uint64_t recorded_step;    // steps up to it are in there
    uint64_t hashed_step;      // the last of them whose hash is, too, or that it begins with
};

// Fills words [from, to) of a buffer with 0; reads bytes of one from byte `at`, which waits for all
// that was launched.
static inline bool motion_clear(duet_motion *m, const char *stage, motion_buffer which, size_t from,
                                size_t to, duet_error *err)
{
    return timeline_fill(&m->times, stage, &m->buffers[which], 0, from, to, err);
}

static inline bool motion_fetch(duet_motion *m, const char *stage, motion_buffer which, size_t at,
                                void *to, size_t bytes, duet_error *err)
{
    return timeline_read_at(&m->times, stage, &m->buffers[which], at, to, bytes, err);
}

// Reads the flags, likewise.
static inline bool motion_read_flags(duet_motion *m, duet_error *err)
{
    return timeline_read(&m->times, "flags", &m->buffers[FLAG_WORDS], m->flags, sizeof m->flags,
                         err);
}

// 32-bit words of state that an object has in a buffer; 0: not by object, or not called for.
uint32_t motion_words(const duet_motion *m, motion_buffer which);

// Whether a buffer has reals by object, and these are doubles.
bool motion_has_doubles(const duet_motion *m, motion_buffer which);

// Makes space for all n objects, of which the first old_n have it. The state of the others becomes
// 0; the device may still be writing that on return.
bool motion_grow(duet_motion *m, uint32_t old_n, duet_error *err);
bool motion_grow_rows(duet_motion *m, motion_buffer which, uint32_t old_n,
                      duet_error *err); // one buffer's

// Space for so many bytes in a buffer, which keeps the first of them, and waits for nothing if that
// is none.
bool motion_extend(duet_motion *m, motion_buffer which, size_t kept, size_t bytes, duet_error *err);

// Space for n elements of `size` bytes in a buffer.
bool motion_reserve(duet_motion *m, motion_buffer which, uint64_t n, size_t size, duet_error *err);

// ---------------------------------------------------------------- of files above

// Without writing what was mapped.
void motion_forget_maps(duet_motion *m);

// Sets the share of the following searches, of a motion that finds pairs.
bool motion_set_share(duet_motion *m, uint32_t share, duet_error *err);

// The skin, if there is one, and the kernels that only a motion has, of those that this one has
// built, as kernel_spaces_read.
bool motion_kernel_spaces(duet_motion *m, kernel_spaces *to, duet_error *err);

// Sums the state, as duet_motion_get_hash of a motion that is whole.
bool motion_hash(duet_motion *m, uint64_t *hash, duet_error *err);

// Adds a body's state to a sum, which over all bodies is the state hash.
uint64_t motion_hash_state(uint64_t sum, const duet_state *state, uint64_t id);

// Takes bodies apart whose manifolds are deep; *parted: some were, and are elsewhere now.
bool motion_part_deep(duet_motion *m, bool *parted, duet_error *err);

#endif
