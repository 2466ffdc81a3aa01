// SPDX-License-Identifier: MIT
// What a device takes of the input where objects are kept in about the order of cells.
//
// The cut between the slabs is also one between objects: those before it are A's own stretch of
// the input, the others B's. A device takes its own stretch, and of the other one the blocks that
// hold an object of its slab: strays, and ghosts at the border. That is right in any order, and
// little in a good one.
#ifndef RUNTIME_STRAYS_H
#define RUNTIME_STRAYS_H

#include "runtime/broadphase/part.h"

#include <stdatomic.h>

// Objects that are taken together: whole work-items of every kernel that takes them.
enum { STRAY_BLOCK = GRID_ROWS_AT_ONCE };

struct strays {
    bool *wanted; // [n_blocks] by the device whose own stretch it is not in
    uint32_t capacity;
    uint32_t cut; // B's first object
    part_range ranges[2];
    grid grid;
    grid_objects objects;
    uint64_t objects_version, grid_version;
    struct {
        atomic_uint next;              // block to be looked at for the device
        atomic_uint n_known;           // that were
        uint32_t from_block, to_block; // the other device's own
    } looked[2];
};

void strays_close(strays *s);

// Begins to look for the blocks that each device wants of these objects and slabs, unless they
// are known.
bool strays_begin(strays *s, const part_task *task, const part_range ranges[2], duet_error *err);

// Looks at blocks for one device, or for both, until all are taken; any thread may help.
void strays_look(strays *s, int side);
void strays_look_for_both(void *s);

// Waits for those who help.
void strays_await(const strays *s, int side);

// A device's own stretch; and once the blocks are known all that it takes.
stretch strays_own(const strays *s, int side);
stretches strays_taken(const strays *s, int side);

#endif
