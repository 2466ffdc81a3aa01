// SPDX-License-Identifier: MIT
// Every kind of query about a motion's bodies, and a plain C twin that answers the same.
#ifndef TESTS_ASKER_H
#define TESTS_ASKER_H

#include "base/rng.h"
#include "runtime/duet.h"

enum { ASKED = 16, ASKED_NEAREST = 3 };

// One question of each kind, ASKED times, about a world of that size.
typedef struct questions {
    uint32_t dims;
    duet_ray rays[ASKED];
    duet_sweep sweeps[ASKED];
    duet_pose boxes[ASKED];
    duet_point points[ASKED];
} questions;

questions questions_random(rng *r, uint32_t dims, double size);

typedef struct asker asker;

// Lasts until the test ends.
asker *asker_open(duet_device_pair *pair, uint32_t dims, uint32_t share);

// Asks where the motion's bodies are. A sum over the bits of all answers; with twin they are
// compared with the twin's.
uint64_t asker_ask(asker *a, duet_motion *motion, const questions *q, bool twin);

#endif
