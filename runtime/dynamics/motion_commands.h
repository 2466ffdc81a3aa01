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

struct motion_commands {
    uint32_t capacity; // of the arrays by place, and of the motion's poses, cells and bodies
    uint32_t *generations;
    uint8_t *states; // place_state
    uint64_t *user_data;
    uint32_t first_empty; // none before it is empty
    uint32_t n_hidden;
    bool any_left;
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

// At rest, as far as bodies say; to be sent.
void motion_stop(duet_motion *m, uint32_t place);

// BAD_ARGUMENT where the motion lacks an effect that a call needs.
bool motion_needs(const duet_motion *m, uint32_t effect, const char *call, duet_error *err);

// Bodies that a command gives or changes: copies of what is at their places, until it is kept.
typedef struct motion_placed {
    uint32_t n;
    uint32_t *places;
    duet_pose *poses;
    duet_body *bodies;
    cl_int4 *cells; // of the poses, once they are placed; NULL without origin cells
} motion_placed;

// Those of a list; closed in any case.
bool motion_placed_open(motion_placed *p, duet_motion *m, duet_body_list list, bool enabled,
                        const char *call, duet_error *err);
void motion_placed_close(motion_placed *p);

// BAD_OBJECT where a pose is wrong, or a body, of whichever these parts are.
bool motion_placed_check(const duet_motion *m, const motion_placed *p, uint32_t parts,
                         const char *call, duet_error *err);

// Where the motion has origin cells, centres become offsets in these; false beyond 2^30 cells.
bool motion_place_pose(const duet_motion *m, duet_pose *pose, cl_int4 *cell);
bool motion_placed_settle(const duet_motion *m, motion_placed *p, const char *call,
                          duet_error *err);

// Their poses are the motion's from then on, to be sent.
void motion_placed_keep(duet_motion *m, const motion_placed *p);

// Whether they call for nothing that the motion lacks; what differs in them from those before is
// then known.
bool motion_placed_admit(duet_motion *m, const motion_placed *p, const char *call, duet_error *err);

// The places of a list's bodies, which the caller frees. NULL where the motion, an id, or a
// place of the range is wrong, or where enabled is asked for and one is disabled.
uint32_t *motion_places_of(duet_motion *m, duet_body_list list, bool enabled, const char *call,
                           duet_error *err);

// Bodies that were changed are awake, and those that they touch will be.
bool motion_wake_places(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err);
// The same, or asleep, of bodies that are where they were, or altered: the others' bounds hold as
// they did.
bool motion_set_asleep(duet_motion *m, const uint32_t *places, uint32_t n, bool asleep,
                       duet_error *err);
bool motion_wake_all(duet_motion *m, duet_error *err);

// Forgets the targets of some places, whose bodies then stand still.
bool motion_forget_targets(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err);

// What a step leaves of targets: bodies are exactly there.
bool motion_arrive(duet_motion *m, duet_error *err);

// What it leaves of other commands: what was removed is forgotten, and forces are over.
bool motion_end_commands(duet_motion *m, duet_error *err);

#endif
