// SPDX-License-Identifier: MIT
// What commands leave behind: which places have a body, and what the next step is to do.
//
// A place is an object's row in all buffers. What was removed, or is disabled, keeps its
// place: without mass and with bounds that no search takes (hidden).
#ifndef RUNTIME_MOTION_COMMANDS_H
#define RUNTIME_MOTION_COMMANDS_H

#include "runtime/dynamics/motion.h"

typedef enum place_state {
    PLACE_EMPTY,    // the next body that is added takes the first of these
    PLACE_LEFT,     // its contacts end in the next step, which makes it empty
    PLACE_DISABLED, // a body that takes no part
    PLACE_ENABLED,
    PLACE_STATES
} place_state;

// Where a body without mass is to be after the next step.
typedef struct motion_target {
    uint32_t place;
    duet_transform pose;
} motion_target;

// What a motion was made of, for files that were saved before the first command.
typedef struct motion_given {
    uint32_t n;
    duet_motion_def def;
    duet_pose *poses;
    cl_int4 *cells;
    duet_body *bodies;
} motion_given;

struct motion_commands {
    motion_given given;
    uint32_t capacity; // of the arrays by place, and of the motion's poses, cells and bodies
    uint32_t *generations;
    uint8_t *states; // place_state
    uint64_t *user_data;
    uint32_t first_empty; // none before it is empty
    uint32_t n_hidden;
    bool any_left;
    uint32_t *altered; // places whose pairs rows lack or have too many of
    uint32_t n_altered, altered_capacity;
    bool pushed; // some forces wait for the next step
    motion_target *targets;
    uint32_t n_targets;
};

// Made at the first command.
bool motion_begin_commands(duet_motion *m, duet_error *err);
void motion_forget_commands(motion_commands *commands);

static inline bool motion_is_hidden(const duet_motion *m, uint32_t place)
{
    return m->commands && m->commands->states[place] != PLACE_ENABLED;
}

// Rows are to be searched about these places, or as a whole where that is no more work.
void motion_alter_places(duet_motion *m, const uint32_t *places, uint32_t n);

static inline bool motion_rows_are_stale(const duet_motion *m)
{
    return m->rows_stale || (m->commands && m->commands->n_altered > 0);
}

// At rest, as far as bodies say; to be sent.
void motion_stop(duet_motion *m, uint32_t place);

// BAD_ARGUMENT where the motion lacks an effect that a call needs.
bool motion_needs(const duet_motion *m, uint32_t effect, const char *call, duet_error *err);

// Whether a command's changes were made; one that was left half-way breaks the motion.
bool motion_keep_whole(duet_motion *m, bool made);

// Whether poses and bodies call for nothing that the motion lacks; what differs in them
// from those before is then known.
bool motion_admit(duet_motion *m, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                  const char *call, duet_error *err);

// The places of a list's bodies, which the caller frees. NULL where the motion, an id, or a
// place of the range is wrong, or where enabled is asked for and one is disabled.
uint32_t *motion_places_of(duet_motion *m, duet_body_list list, bool enabled, const char *call,
                           duet_error *err);

// Bodies that were changed are awake, and those that they touch will be.
bool motion_wake_places(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err);
// The same of bodies that are where they were, or altered: the others' bounds hold as they did.
bool motion_wake_still(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err);
bool motion_wake_all(duet_motion *m, duet_error *err);

// Forgets the targets of some places, whose bodies then stand still.
bool motion_forget_targets(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err);

// Centres of poses as offsets in their origin cells [n], where the motion has some; *cells
// is then the caller's to free.
bool motion_place_poses(const duet_motion *m, duet_pose *poses, uint32_t n, cl_int4 **cells,
                        const char *call, duet_error *err);

// What poses and bodies say of some places, which the caller frees; NULL without memory.
duet_pose *motion_poses_at(const duet_motion *m, const uint32_t *places, uint32_t n,
                           duet_error *err);
duet_body *motion_bodies_at(const duet_motion *m, const uint32_t *places, uint32_t n,
                            duet_error *err);

// Puts bodies exactly where their targets are.
bool motion_arrive(duet_motion *m, duet_error *err);

// What a step leaves of commands: targets are reached, forces are over, and what was
// removed is forgotten.
bool motion_end_commands(duet_motion *m, duet_error *err);

#endif
