// SPDX-License-Identifier: MIT
// Work on both devices of a pair at the same time, divided by a share: A has the first items
// and B the rest.
#ifndef RUNTIME_SHARED_WORK_H
#define RUNTIME_SHARED_WORK_H

#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/thread_pool.h"
#include "runtime/opencl/timeline.h"

// One device's part. A kind of work puts its own members behind it.
typedef struct work_side {
    const device *device; // NULL where it has no share
    gen *gen;
    program_set *programs;
    timeline times;       // begun and finished around a run
    uint64_t first, last; // items of a run
    double wall_ms;
    bool ok;
    duet_error err;
} work_side;

typedef struct shared_work {
    duet_device_pair *pair; // held
    uint32_t share;
    uint32_t part;       // of each side's items, of DUET_SHARE_ONE, that runs do; 0: all
    thread_pool *driver; // drives A while the caller's thread drives B
    work_side *sides[2];
} shared_work;

// BAD_ARGUMENT for no share.
bool shared_work_check(uint32_t share, duet_error *err);

// Opens the sides that have a share: programs are then to be asked for and built, of kernels in
// that folder; NULL: the carried ones.
bool shared_work_open(shared_work *w, duet_device_pair *pair, const char *kernel_dir,
                      uint32_t share, work_side *a, work_side *b, duet_error *err);
void shared_work_close(shared_work *w);

// Divides n items for the next run.
void shared_work_divide(shared_work *w, uint64_t n);

// Each side that has some of the n items does its part. The first failure counts: A's, if it
// has one.
bool shared_work_run(shared_work *w, uint64_t n, bool (*part)(work_side *), duet_error *err);

#endif
