// SPDX-License-Identifier: MIT
// A replay in parts, for callers that look at the state between commands and step, and for a motion
// that is more than a duet_motion.
#ifndef RUNTIME_REPLAY_H
#define RUNTIME_REPLAY_H

#include "runtime/commands/command.h"
#include "runtime/duet_replay.h"

// Gives the motion the commands that come before the next step, once: duet_replay_advance then
// steps alone. Fails as that does. *given: some came with this call.
bool replay_give(duet_replay *replay, duet_motion *motion, bool *given, duet_error *err);

// A motion as its recording begins: places, and the sum of its ground (recording.h).
typedef struct replay_begin {
    uint32_t n, dims;
    uint64_t step, hash, ground;
} replay_begin;
bool replay_check_begin(const duet_replay *replay, const replay_begin *begin, duet_error *err);

// A recorded command, in memory of its own.
typedef struct replayed {
    command c;
    duet_motion_def def;
    uint64_t *ids;
    void *rows;
    duet_body *bodies;
} replayed;

// Takes the next command that comes before the next step, for a motion of that def; c.op NULL:
// there is none. Free it whatever this returns.
bool replay_take(duet_replay *replay, const duet_motion_def *def, replayed *r, duet_error *err);
void replayed_free(replayed *r);

// How far a replay is, to which it can be set back.
typedef struct replay_place {
    size_t at; // the next record's offset
    uint32_t steps_left;
    uint64_t steps_done, commands_done, equal_step;
    bool begun;
} replay_place;

replay_place replay_get_place(const duet_replay *replay);
void replay_set_place(duet_replay *replay, const replay_place *place);

// Passes what was recorded up to a step that the motion, which went on from a file, has made. Fails
// as check_begin if the motion has not that ground and dims, or so many steps were not recorded.
bool replay_pass(duet_replay *replay, const replay_begin *motion, duet_error *err);

// Says which recorded command failed, from 1 on; returns false.
bool replay_blame(const char *path, uint64_t number, uint64_t n, const duet_error *why,
                  duet_error *err);

// Notes a step that was made; returns whether it was the last.
bool replay_note_step(duet_replay *replay);

// Whether a hash was recorded of the state that the noted step left, before commands come. If so,
// check fails with WRONG_RESULT, and a line that names the steps one of which differs first, unless
// it is this one. After the last step and the commands that follow, check_end does the same.
bool replay_has_hash(const duet_replay *replay);
bool replay_check_hash(duet_replay *replay, uint64_t hash, duet_error *err);
bool replay_check_end(const duet_replay *replay, uint64_t hash, duet_error *err);

#endif
