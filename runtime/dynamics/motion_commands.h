// SPDX-License-Identifier: MIT
// The state that commands leave behind: which places have a body, and its targets (motion_targets.h
// says what a step does with them).
//
// A place is an object's row in all buffers. A body that was removed, or is disabled, keeps its
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

// The pose that a body without mass is to have after the next step.
typedef struct motion_target {
    uint32_t place;
    duet_transform pose;
} motion_target;

struct motion_commands {
    uint32_t capacity; // size of the arrays by place, and of the motion's poses, cells and bodies
    uint32_t *generations;
    uint8_t *states; // place_state
    uint64_t *user_data;
    uint32_t first_empty; // none before it is empty
    uint32_t n_hidden;
    // the end of the next step acts on these
    uint32_t n_left;   // places that become empty
    uint64_t n_pushed; // forces that are over then
    motion_target *targets;
    uint32_t n_targets;
};

// Made at the first command.
bool motion_begin_commands(duet_motion *m, duet_error *err);
void motion_forget_commands(motion_commands *commands);
void motion_forget_recording(duet_motion *m);

// Returns how many places are hidden.
static inline uint32_t motion_count_hidden(const duet_motion *m)
{
    return m->commands ? m->commands->n_hidden : 0;
}

static inline bool motion_is_hidden(const duet_motion *m, uint32_t place)
{
    return m->commands && m->commands->states[place] != PLACE_ENABLED;
}

// At rest, as far as bodies say; to be sent.
void motion_stop(duet_motion *m, uint32_t place);

// A place's id, which is its number and 2^32 times how many bodies had it before; whether it has a
// body, enabled or not.
static inline uint64_t motion_id_at(const duet_motion *m, uint32_t place)
{
    return m->commands ? (uint64_t)m->commands->generations[place] << 32 | place : place;
}

static inline bool motion_has_place(const duet_motion *m, uint32_t place)
{
    return !m->commands || m->commands->states[place] >= PLACE_DISABLED;
}

// BAD_ARGUMENT unless the motion has places [first, first + n).
bool motion_has_range(const duet_motion *m, uint32_t first, uint32_t n, const char *call,
                      duet_error *err);

// BAD_ARGUMENT if the motion lacks an effect that a call needs; if any are missing that `who`
// needs.
bool motion_needs(const duet_motion *m, uint32_t effect, const char *call, duet_error *err);
bool motion_lacks(uint32_t missing, const char *call, const char *who, duet_error *err);

// Turns a centre into an offset in its origin cell; false beyond 2^30 cells.
bool motion_place_pose(const duet_motion *m, duet_pose *pose, cl_int4 *cell);

#endif
