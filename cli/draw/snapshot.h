// SPDX-License-Identifier: MIT
// A scene that moves, drawn to PNG files: in 3D from above and aside without
// perspective, in 2D from straight above.
#ifndef CLI_SNAPSHOT_H
#define CLI_SNAPSHOT_H

#include "cli/draw/view.h"

typedef struct snapshot {
    const duet_motion_def *def;
    const duet_scene *scene;
    uint32_t n;
    colour *colours; // [n]
    bool *is_shot;   // [n]
    extent part;     // shown by all frames
} snapshot;

// How a scene is drawn follows from its start: colours say where an object then
// was, which shows how they mix; what was shot, or brought by commands, is red, what has no
// mass grey.
// def and scene are borrowed.
bool snapshot_begin(snapshot *s, const duet_motion_def *def, const duet_scene *scene,
                    duet_motion *motion, duet_error *err);
void snapshot_end(snapshot *s);

// One of many pictures, which all show the same part of space; or one by itself,
// which shows where the objects are. The few outermost may lie outside. Words below say
// what is seen, and at which time of the scene in seconds.
bool snapshot_frame(const snapshot *s, const char *path, duet_motion *motion, double time,
                    duet_error *err);
bool snapshot_picture(const snapshot *s, const char *path, duet_motion *motion, double time,
                      duet_error *err);

// Whether a picture can be written, before the work that it is for: a file stays as it is, and a
// device is given an empty page.
bool snapshot_try(const char *path, duet_error *err);

#endif
