// SPDX-License-Identifier: MIT
// Which objects lie in each slab, found by threads of the host, so that a device with memory of its
// own is sent no others: the LIST of a view.
//
//   threads                          staging slots             driver of the device
//   take the next block of objects   [chunk % n_slots]         while blocks are left:
//   find their rows of cells
//   write each object to the list's ---> chunk i fills ------> send chunk i once it is full
//   next place, with its id               slot is free <------ it has travelled
//                                                              then the rest, and the ids
//
// The list has no gaps, and a step waits for the slower of the two and not for their sum. A slot is
// written again once it was sent, so that it stays in the caches: memory is only read, and once.
//
// Invariants: taken is how many places were given away, and a place below capacity is written by
// the one thread that took it. Chunk i is in slot i % n_slots, and is written only if
// i < sent + n_slots; it is sent only if filled[i] is the chunk.
#ifndef RUNTIME_COMPACTION_H
#define RUNTIME_COMPACTION_H

#include "runtime/broadphase/slab.h"
#include "runtime/broadphase/view.h"
#include "runtime/opencl/thread_pool.h"

#include <stdatomic.h>

enum { COMPACTION_CHUNKS = 128 };

// The list of one device's slab, in the order in which objects are found: those of rows of cells
// [row_from, row_to). Without rows there is none to find: the view is right, or wants no list.
typedef struct compaction_list {
    uint32_t row_from, row_to;
    host_block objects; // [n_slots][chunk]
    host_block ids;     // [capacity]
    uint32_t capacity;
    uint32_t chunk; // objects in each but the last
    uint32_t n_slots;
    atomic_uint taken;                     // above capacity: some objects were not written
    atomic_uint filled[COMPACTION_CHUNKS]; // objects written to each chunk
    atomic_uint sent;                      // chunks whose slots may be written again
} compaction_list;

typedef struct compaction {
    uint32_t least_chunk; // objects
    const grid_objects *objects;
    const grid *grid;
    uint32_t n_blocks;
    atomic_uint done;      // blocks
    atomic_bool cancelled; // a device failed and sends no more
    compaction_list lists[2];
    thread_pool *threads; // NULL before the first time
} compaction;

void compaction_open(compaction *c);
void compaction_close(compaction *c);

// Whether a list of the slab has so much less than all objects that finding it pays.
bool compaction_pays(const part_range *slab, uint32_t n);

// Starts to list the objects of these slabs (NULL: none). *threads do it, and the caller waits for
// them; NULL if nothing is to be listed. The arrays and the grid stay as they are until then.
bool compaction_start(compaction *c, const grid_objects *objects, const grid *g,
                      const part_range *const slabs[2], const device *const devices[2],
                      thread_pool **threads, duet_error *err);

// Ends the waits of both devices and of the threads; the lists are not whole then.
void compaction_cancel(compaction *c);

#endif
