// SPDX-License-Identifier: MIT
// What is recorded of a motion, in the form of the file (docs/formats.md, "Recordings"): a head,
// then a record for each command, each run of steps and each hash that is kept of a state
// (recorded_steps.h). The motion holds these bytes; a file ends with the state's hash and a sum.
#ifndef RUNTIME_RECORDING_H
#define RUNTIME_RECORDING_H

#include "runtime/commands/command.h"
#include "runtime/commands/packed.h"
#include "runtime/dynamics/recorded_steps.h"

typedef struct recording_head {
    char magic[16];
    uint32_t dims;
    uint32_t n; // places
    uint64_t step;
    uint64_t hash;
} recording_head;

extern const char recording_magic[16];

// The first record of a motion on a ground is the ground's, of this kind: one sum follows.
enum { RECORDED_GROUND = 255 };

// Sums the ground that bodies of a motion touch (FNV-1a); 0: there is none.
uint64_t recorded_ground_sum(const duet_motion *m);

// Behind a command's record n ids follow if bodies are listed, then n rows, then n bodies; bodies
// and defs are packed.
typedef struct recorded_sizes {
    size_t ids, row, body; // bytes of one
} recorded_sizes;

recorded_sizes recorded_sizes_of(const command_op *op);

// Adds a command that was carried out, if the motion is recorded.
void recording_add(duet_motion *m, const command *c);

#endif
