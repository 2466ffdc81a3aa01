// SPDX-License-Identifier: MIT
// Which ranges of the input each device reads, if objects are kept in about the order of cells.
//
// The cut between the slabs is also a cut between objects: those before it are A's own range of
// the input, the others B's. A device reads its own range, and of the other's range the blocks that
// hold an object of its slab: ghosts at the border, and objects out of order. That is right in any
// order, and little in a good one.
//
//   host                          device A                      device B
//   guess the blocks of the
//   other's range that each needs
//        |---- ranges ------------> update the view               update the view <----|
//        |                          hash the own range, and       hash the own range, and
//        |                          request blocks with keys      request blocks with keys
//        |                          of B's slab                   of A's slab
//        |                          hash the other ranges         hash the other ranges
//        |                          sort, search                  sort, search
//        | <------ requests ------|                            |---- requests --->
//   every requested block was guessed: done
//   else: guess what was requested, and run both again
//
// So no device waits for the other, and the host looks at no object. The first guess is the blocks
// at the border; the guess of a step that was right holds for the next.
#ifndef RUNTIME_INPUT_RANGES_H
#define RUNTIME_INPUT_RANGES_H

#include "runtime/broadphase/slab.h"
#include "runtime/broadphase/view.h"

// Objects that are read together: whole work-items of every kernel that reads them.
enum { INPUT_BLOCK = 1024 };

// Invariants: the guess is for these slabs of the grid of that generation, and for n objects; the
// selections list it, each with the device's own range: [0, cut) for A, [cut, n) for B.
typedef struct input_ranges {
    bool *guessed; // [n_blocks] read by the device whose own range the block is not in
    uint32_t capacity;
    uint32_t n;   // objects
    uint32_t cut; // B's first object
    part_range slabs[2];
    uint32_t margin; // blocks that are read on both sides of those that were requested
    selection selections[2];
} input_ranges;

void input_ranges_close(input_ranges *r);

// Makes the first guess, unless there is one for these slabs and this number of objects.
bool input_ranges_begin(input_ranges *r, uint32_t n, const part_range slabs[2], duet_error *err);

// Blocks of its own range that a device marked for the other: those whose word is `epoch`.
typedef struct block_requests {
    const uint32_t *words; // [n_blocks]
    uint32_t epoch;
} block_requests;

// Whether the guess had every block that was requested. If not, there is a better guess.
bool input_ranges_held(input_ranges *r, const block_requests requests[2]);

#endif
