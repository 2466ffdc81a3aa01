// SPDX-License-Identifier: MIT
// A world stepped again and again, with the times of each step; or a task launched again and again.
#ifndef CLI_TIMED_H
#define CLI_TIMED_H

#include "base/core_watch.h"
#include "runtime/duet.h"
#include "runtime/task/task_launch.h"

// One timed step, with stages of its own.
typedef struct timed_step {
    double total_ms;
    double device_ms[2];
    double kernel_ms[2];
    duet_stage *stages;
    uint32_t n_stages;
} timed_step;

typedef struct timed {
    timed_step *steps; // by time, least first; then, likewise, those timed by stages besides
    uint32_t n;
    uint32_t n_staged; // the steps timed by stages
    duet_result last;  // pairs and counts
    core_tally cores;  // the share of other programs meanwhile
    uint64_t hash;
} timed;

// The input of each step.
typedef enum timed_input {
    TIMED_INPUT_HOST,       // all of the objects, as a frame of a game would
    TIMED_INPUT_RESIDENT,   // nothing: the objects stay on the devices
    TIMED_INPUT_TRANSFORMS, // centres and rotations; the world has the sizes apart
    TIMED_INPUT_COMPACT,    // the same, with rotations rounded to 16 bits: 20 bytes a box
    TIMED_INPUTS
} timed_input;

const char *timed_input_name(timed_input input); // "host", ...
bool timed_input_named(const char *name, timed_input *input);

// Steps the world once to warm up and then repeat times, and where those are not timed by
// stages a few times more, for the stages. Ctrl-C ends it with what was timed until then;
// INTERRUPTED if that is nothing. WRONG_RESULT if two steps found different pairs.
bool timed_run(timed *t, duet_world *world, const duet_scene *scene, uint32_t repeat,
               timed_input input, duet_error *err);
// The same of a task, whose launches are checked. It has no pairs and no hash.
bool timed_task_run(timed *t, task_launcher *l, const duet_device_pair *pair, const duet_plan *plan,
                    uint32_t repeat, duet_error *err);
void timed_free(timed *t);

// The step with the median time; of an even number the lesser.
const timed_step *timed_median(const timed *t);
// The same of the steps whose stages were timed, for stages and kernel_ms.
const timed_step *timed_staged(const timed *t);

#endif
