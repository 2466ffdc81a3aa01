// SPDX-License-Identifier: MIT
// Sorts out on the host which objects each slab needs, so that a device with
// memory of its own is sent no others.
//
// Threads take blocks of objects as they come and put each object where its
// slab is gathered, an object of a ghost row in both. What is gathered has no
// separations and is sent chunk by chunk while later blocks are still sorted out, so
// a step waits for the slower of the two and not for their sum. A chunk's memory
// is written again once it was sent, so that it stays in the caches: memory is
// then only read, and once.
#ifndef RUNTIME_PACK_H
#define RUNTIME_PACK_H

#include "runtime/broadphase/part.h"

#include <stdatomic.h>

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
} pack;

void pack_open(pack *p);
void pack_close(pack *p);

// Makes space for the slabs that are wanted; devices are the pair.
bool pack_begin(pack *p, const part_task *task, const part_range ranges[2], const bool wanted[2],
                const device devices[2], duet_error *err);

// Sorts out blocks of objects until none is left. Any number of threads may do
// so, other than those that send: it waits for chunks to be sent.
void pack_blocks(void *pack);

bool pack_is_done(pack *p);
void pack_abandon(pack *p); // lets those who wait go, whatever they had to write
bool pack_is_abandoned(pack *p);

// The chunk is whole and all of it written.
bool pack_chunk_is_full(pack_stream *s, uint32_t chunk);

// Threads that this machine has to spare for packing, besides the two that
// drive the devices.
uint32_t pack_threads(void);

// The part still has what it would be sent.
bool part_has_slab(const part *p, const part_task *task, const part_range *range);

// Sends the part the objects of its slab; task->n becomes their number. *placed
// is false where there was no space for them: the rows must be counted again.
bool part_receive_slab(part *p, pack *from, int side, part_task *task, const part_range *range,
                       bool *placed, duet_error *err);

#endif
