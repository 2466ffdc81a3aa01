// SPDX-License-Identifier: MIT
// The arguments of `duet run`, and its three ways.
#ifndef CLI_RUN_H
#define CLI_RUN_H

#include "cli/inputs.h"

typedef struct arguments {
    scene_options scene;
    plan_options plan;
    level_options level;
    const char *pair;
    const char *task; // a task file; NULL: a scene is run
    uint64_t repeat;
    uint64_t steps;         // 0: the scene is not advanced
    const char *picture;    // a PNG of the last step
    const char *frames;     // a folder for frames, 30 of a second of the scene
    const char *format;     // the name of a frames_format
    const char *record;     // the file to which the scene's commands go
    const char *replay;     // the file from which they come
    uint64_t every;         // steps from one checkpoint to the next
    const char *checkpoint; // the file to which the motion is saved
    const char *resume;     // a saved motion that the run goes on from
    const char *input;      // the name of a timed_input
    bool ordered;
    const char *pairs_path;
    const char *timeline; // an SVG of one step's time lines
    bool check;
    bool json;
} arguments;

// Finds the pairs of a scene, which it may put in order, and tells them or how long they took.
bool run_still(const arguments *args, const char *path, duet_scene *scene, duet_device_pair *pair,
               duet_error *err);

// Advances the scene and tells what was done: energy and pairs as it goes, then
// the time of each effect. Ctrl-C ends it with what was done until then.
bool run_motion(const arguments *args, const char *path, const duet_scene *scene,
                duet_device_pair *pair, duet_error *err);

// Runs a task by the plan that is known or given, checks each launch, and tells where the time
// goes.
bool run_task(const arguments *args, duet_error *err);

#endif
