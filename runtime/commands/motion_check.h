// SPDX-License-Identifier: MIT
// Checks what a saved motion says before kernels use it.
//
// The checksum at a file's end detects damage, not malice: anyone can compute it. Kernels
// do not check indices and counts, so each one is compared here with what a motion's own
// steps leave behind.
#ifndef RUNTIME_MOTION_CHECK_H
#define RUNTIME_MOTION_CHECK_H

#include "runtime/dynamics/motion.h"

// The parts of a file. at is NULL for buffers that the motion does not keep.
typedef struct motion_saved {
    const char *path;
    uint32_t n_contacts;
    uint32_t has_graph; // rows
    bool rows_stale;    // the next step makes rows anew and takes only contacts over
    uint64_t n_pairs;
    const void *at[MOTION_BUFFERS];
} motion_saved;

// BAD_INPUT says where the file differs from what the motion could have saved.
bool motion_check(const duet_motion *m, const motion_saved *s, duet_error *err);

#endif
