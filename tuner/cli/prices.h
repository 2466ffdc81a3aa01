// SPDX-License-Identifier: MIT
// What each level of accuracy costs on each device of a pair, and what it gets
// wrong on the same objects.
#ifndef CLI_PRICES_H
#define CLI_PRICES_H

#include "runtime/duet.h"

enum { PRICES_ROUNDS = 100 };

typedef struct price {
    duet_level level;
    int device;      // 0: A, 1: B, each alone
    double step_ms;  // the median
    double relative; // to sat15 on that device
    uint64_t pairs;
    uint64_t candidates;
    uint64_t undecided;    // by float, left to the host
    uint64_t missed;       // that collide
    uint64_t added;        // that do not
    double deepest_missed; // how deep the worst of those missed, the objects' unit
    double widest_added;   // how far apart the worst of those added
    bool front;            // nothing on that device is both faster and more right
} price;

typedef struct prices {
    price rows[2 * DUET_LEVELS]; // by device, the cheapest to compute first
    uint32_t n;
    uint64_t truth;  // pairs that collide
    uint32_t rounds; // that were timed
} prices;

// Steps the scene at each level on each device once a round, so that whatever
// disturbs one disturbs all. A device without double has no row for it. Ctrl-C
// ends it with the whole rounds until then; INTERRUPTED where there are none.
bool prices_measure(prices *p, duet_device_pair *pair, const duet_scene *scene, uint32_t rounds,
                    duet_error *err);

#endif
