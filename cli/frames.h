// SPDX-License-Identifier: MIT
// Frames of a motion in a folder, 30 for each second of it: pictures, or files for ParaView.
#ifndef CLI_FRAMES_H
#define CLI_FRAMES_H

#include "cli/draw/snapshot.h"
#include "cli/vtk/vtk_frames.h"

typedef enum frames_format { FRAMES_PNG, FRAMES_VTU } frames_format;

// By its name: "png", "vtu".
bool frames_format_named(const char *name, frames_format *format);

typedef struct frames {
    const char *folder; // NULL: no frames
    frames_format format;
    duet_motion *motion;
    const snapshot *pictures; // how they look
    vtk_frames vtk;
    uint64_t n; // so far
} frames;

// Makes the folder. motion and pictures are borrowed. Call frames_end whatever this returns.
bool frames_begin(frames *f, const char *folder, frames_format format, duet_motion *motion,
                  const snapshot *pictures, duet_error *err);
// Adds a frame if its time has come.
bool frames_add(frames *f, double time, duet_error *err);
void frames_end(frames *f);

#endif
