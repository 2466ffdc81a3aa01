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

typedef struct strays {
    bool *guessed; // [n_blocks] taken by the device whose own stretch it is not in
    uint32_t capacity;
    uint32_t n;   // objects
    uint32_t cut; // B's first object
    part_range ranges[2];
    uint64_t grid_version;
    uint64_t version; // changes with the guess
    uint32_t margin;  // blocks that are taken beside those that were wanted
    part_intake intakes[2];
} strays;

void strays_close(strays *s);

// Where the guess is not one for these slabs and this number of objects: the blocks at the border
// of objects that are in order.
bool strays_begin(strays *s, const part_task *task, const part_range ranges[2], duet_error *err);

// Those that lie side by side as one.
stretches strays_joined(const stretches *list);

// What a device marked: blocks [n_blocks] of its own stretch that are `stamp`.
typedef struct stray_marks {
    const uint32_t *blocks;
    uint32_t stamp;
} stray_marks;

// Once a step is over.
stray_marks strays_marks_of(const part *p);

// Whether the guess held every block that was marked. If not, there is a better one.
bool strays_guessed_all(strays *s, const stray_marks marks[2]);

#endif
