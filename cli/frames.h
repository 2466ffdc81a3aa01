// SPDX-License-Identifier: MIT
// Frames of a motion in a folder, 30 for each second of it: pictures, or files for ParaView.
#ifndef CLI_FRAMES_H
#define CLI_FRAMES_H

#include "cli/vtk/vtk_frames.h"

// Makes the folder, unless it is there.
bool frame_folder_make(const char *folder, duet_error *err);

// Whether frame n is due at a time of the scene.
bool frame_is_due(uint64_t n, double time);

typedef enum frames_format { FRAMES_PNG, FRAMES_VTU } frames_format;

// By its name: "png", "vtu".
bool frames_format_named(const char *name, frames_format *format);

typedef struct frames {
    const char *folder; // NULL: no frames
    frames_format format;
    duet_motion *motion;
    const struct snapshot *pictures; // how they look
    vtk_frames vtk;
    uint64_t n; // so far
} frames;

// Makes the folder. motion and pictures are borrowed. Call frames_end whatever this returns.
bool frames_begin(frames *f, const char *folder, frames_format format, duet_motion *motion,
                  const struct snapshot *pictures, duet_error *err);
// Adds a frame if its time has come.
bool frames_add(frames *f, double time, duet_error *err);
void frames_end(frames *f);

#endif
