// SPDX-License-Identifier: MIT
// What a device takes of the input where objects are kept in about the order of cells.
//
// The cut between the slabs is also one between objects: those before it are A's own stretch of
// the input, the others B's. A device takes its own stretch, and of the other one the blocks that
// hold an object of its slab: strays, and ghosts at the border. That is right in any order, and
// little in a good one.
//
// Which blocks these are is a guess: those at the border, or those of the step before. When a
// device computes the keys of its own stretch it marks the blocks that the other one wants, and
// after the step both marks are compared with the guess. So no device waits for the other, and
// the host looks at no object; where a block was missed the step is run again.
#ifndef RUNTIME_STRAYS_H
#define RUNTIME_STRAYS_H

#include "runtime/broadphase/part.h"

// Objects that are taken together: whole work-items of every kernel that takes them.
enum { STRAY_BLOCK = 1024 };

struct strays {
    bool *guessed; // [n_blocks] taken by the device whose own stretch it is not in
    uint32_t capacity;
    uint32_t n;   // objects
    uint32_t cut; // B's first object
    part_range ranges[2];
    uint64_t grid_version;
    uint64_t version; // changes with the guess
    uint32_t margin;  // blocks that are taken beside those that were wanted
};

void strays_close(strays *s);

// Where the guess is not one for these slabs and this number of objects: the blocks at the border
// of objects that are in order.
bool strays_begin(strays *s, const part_task *task, const part_range ranges[2], duet_error *err);

// A device's own stretch; all that it takes; and the slab that the other one wants objects of.
stretch strays_own(const strays *s, int side);
stretches strays_taken(const strays *s, int side);
stretches strays_joined(const stretches *taken); // those side by side as one
const part_range *strays_wanted_by_other(const strays *s, int side);

// What a device marked: blocks [n_blocks] of its own stretch that are `stamp`.
struct stray_marks {
    const uint32_t *blocks;
    uint32_t stamp;
};

// Whether the guess held every block that was marked. If not, there is a better one.
bool strays_guessed_all(strays *s, const stray_marks marks[2]);

#endif
