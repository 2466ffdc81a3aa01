// SPDX-License-Identifier: MIT
// Ghosts of bodies that move have a cost, which forecasts take as it was counted in a pile
// (docs/cluster.md), for each object at a border: those that a still step sends.
#ifndef CLUSTER_GHOST_TRAFFIC_H
#define CLUSTER_GHOST_TRAFFIC_H

#include "cluster/ghosts.h"

typedef struct ghost_traffic {
    uint32_t colours;    // after which ghosts come at the latest
    uint32_t apart;      // colours between two exchanges of a sweep, as it was counted
    double colour_bytes; // that each side sends between the colours of a sweep
    double begin_bytes;  // as a substep begins
    double end_bytes;    // after all colours
    double step_bytes;   // and at the end of a step
    double work;         // in bodies': ghosts, and contacts that are solved on both sides
    double border;       // bodies whose contacts wait for messages
} ghost_traffic;

// Few colours first.
enum { GHOST_TRAFFICS = 5 };
extern const ghost_traffic ghost_traffics[GHOST_TRAFFICS];

// The one of most colours that are not more than those; 0: of one.
const ghost_traffic *ghost_traffic_of(uint32_t colours);

// Takes the time of a step of n own bodies of this rank and what their ghosts cost, and sends what
// these are sent. Messages travel while contacts that do not wait for them are solved, as in
// moving_step.c. Collective; fails on all ranks if one is not well.
bool ghost_traffic_take(const ghost_traffic *t, const ghosts *g, ranks *r, uint64_t n,
                        duet_error *err);

#endif
