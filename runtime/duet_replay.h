// SPDX-License-Identifier: MIT
// Recordings: a motion's commands and steps as a file, which gives the same state on any
// device.
#ifndef DUET_REPLAY_H
#define DUET_REPLAY_H

#include "duet_motion_commands.h"

DUET_C_BEGIN

// Records the motion's commands and steps from now on, with the state's hash after each 32nd step
// (of more than 65 536 bodies less often), and drops an earlier recording. A load, and a step that
// fails, end the recording.
DUET_API bool duet_motion_record(duet_motion *motion, duet_error *err);

// Writes what was recorded so far, and the state's hash; the recording goes on. BAD_ARGUMENT
// if nothing is recorded.
DUET_API bool duet_motion_save_recording(duet_motion *motion, const char *path, duet_error *err);

// A file of recorded commands; it may come from anyone.
typedef struct duet_replay duet_replay;

typedef struct duet_replay_info {
    uint64_t steps;
    uint64_t commands;
    uint64_t steps_done;
} duet_replay_info;

// Reads the file. BAD_INPUT if it is truncated, or no recording.
DUET_API duet_replay *duet_replay_create(const char *path, duet_error *err);
DUET_API void duet_replay_destroy(duet_replay *replay);

DUET_API duet_replay_info duet_replay_get_info(const duet_replay *replay);

// Gives the motion the commands that come before the next step, and advances it. After the
// last step it also gives the commands recorded after it, and compares the state's hash.
//
// The motion must be as the recorded one was when its recording began: BAD_INPUT if its
// places, step or hash differ, or if it refuses a command. WRONG_RESULT at the first recorded
// hash that differs, with a line that says between which steps the states parted. BAD_ARGUMENT
// after the last step.
DUET_API bool duet_replay_advance(duet_replay *replay, duet_motion *motion,
                                  duet_motion_result *result, duet_error *err);

DUET_C_END

#endif
