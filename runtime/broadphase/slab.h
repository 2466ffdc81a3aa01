// SPDX-License-Identifier: MIT
// The slabs of the grid: where it is cut in two, and how a slab's objects reach its device.
#ifndef RUNTIME_SLAB_H
#define RUNTIME_SLAB_H

#include "runtime/broadphase/part.h"
#include "runtime/opencl/thread_pool.h"

#include <stdatomic.h>

// The grid is cut by the work that lies on each side.
//
// A cut lies between two rows of cells, so that each slab is one run of keys.
// Pairs are found from the object that comes first, whose neighbours are at
// most one layer, one row and one cell ahead: so many ghost rows are added to
// the slab before the cut, and none to the one after it.
typedef struct split {
    uint32_t *cell_rows; // [n_rows] objects in each row of cells
    uint32_t n_rows;
    bool stale; // the objects are to be counted again
    struct {
        bool known;
        uint32_t share, n;
        part_range ranges[2];
    } last; // where it was cut last: adding up the rows takes as long as a tenth of a GPU's step
} split;

void split_free(split *s);

// The slabs of A and B, of a dense grid of one level: A's home has about share of the work.
// A slab without rows is empty: its first and last are 0.
bool split_cut(split *s, const part_task *task, uint32_t share, part_range ranges[2],
               duet_error *err);

// A pack sorts out on the host which objects each slab needs, so that a device with
// memory of its own is sent no others.
//
// Threads take blocks of objects as they come and put each object where its
// slab is gathered, an object of a ghost row in both. What is gathered has no
// gaps and is sent chunk by chunk while later blocks are still sorted out, so
// a step waits for the slower of the two and not for their sum. A chunk's memory
// is written again once it was sent, so that it stays in the caches: memory is
// then only read, and once.
enum { PACK_CHUNKS = 128 };

// Objects on their way to one device, in the order in which they were found.
typedef struct pack_stream {
    host_block objects; // [n_slots][chunk]
    host_block names;   // [capacity] their ids
    uint32_t capacity;
    uint32_t chunk;                  // objects in each but the last
    uint32_t n_slots;                // chunk i lies in slot i % n_slots
    atomic_uint taken;               // places given away; above capacity: some were not written
    atomic_uint filled[PACK_CHUNKS]; // objects written to each chunk
    atomic_uint sent;                // chunks whose slots may be written again
} pack_stream;

// What one device is sent. The kernels know the homes by coming first.
typedef struct pack_slab {
    bool wanted;
    uint32_t row_from, row_home_to, row_to;
    pack_stream homes;
    pack_stream ghosts;
} pack_slab;

typedef struct pack {
    uint32_t least_chunk; // objects
    part_task task;
    uint32_t n_blocks;
    atomic_uint begun; // blocks
    atomic_uint done;
    atomic_bool abandoned; // a device sends no more; what is packed is lost
    pack_slab slabs[2];
    thread_pool *threads; // pack while the drivers send; NULL before the first time
} pack;

void pack_open(pack *p);
void pack_close(pack *p);

// The device has memory of its own, and its slab leaves out enough of the objects to pay for
// packing. The paper's kernels want every object by its id; large poses and transforms are
// not packed.
bool pack_pays(const part_task *task, const part_range ranges[2], int side, const part *p,
               const variant *v);

// Starts to pack for each part whose objects are to be packed and that does not have them
// yet. *packers do it and are to be waited for; NULL where nothing is to be packed.
bool pack_start(pack *p, const part parts[2], const part_task *task, const part_range ranges[2],
                const bool packed[2], thread_pool **packers, duet_error *err);

// Ends the waits of both parts, whether or not all is written.
void pack_abandon(pack *p);

// Sends the part the objects of its slab; task->n becomes their number. *placed
// is false where there was no space for them: the rows must be counted again.
bool part_receive_slab(part *p, pack *from, int side, part_task *task, const part_range *range,
                       bool *placed, duet_error *err);

#endif
