// SPDX-License-Identifier: MIT
// Boxes drawn to a PNG file.
#ifndef CLI_SNAPSHOT_H
#define CLI_SNAPSHOT_H

#include "runtime/duet.h"

// What is looked at: the corners of a box that stays in view.
typedef struct snapshot_view {
    uint32_t dims;
    double lower[3];
    double upper[3];
} snapshot_view;

// A view that holds all objects, and the walls where there are some.
snapshot_view snapshot_view_of(const duet_motion_def *def, const duet_pose *poses,
                               const duet_state *states, uint32_t n);

// Draws n boxes, turned and shaded; colours tell them apart, and what has no
// mass is grey.
bool snapshot_write(const char *path, const snapshot_view *view, const duet_pose *poses,
                    const duet_body *bodies, const duet_state *states, uint32_t n, duet_error *err);

#endif
