// SPDX-License-Identifier: MIT
// The standard set of `duet bench`: which scenes, and which plans for each.
#ifndef CLI_BENCH_SET_H
#define CLI_BENCH_SET_H

#include "runtime/duet.h"

typedef struct bench_scene {
    const char *name; // one of those that come with Duet
    const char *n;    // objects, as a scene's setting
    const char *quick_n;
    const char *world; // edge of the world; NULL: the scene's own
    const char *quick_world;
    bool mixed;  // sizes: plans that need one size of cells are left out
    bool levels; // of accuracy are measured too
    bool moves;  // its effects' costs are measured, and nothing else
} bench_scene;

extern const bench_scene bench_scenes[]; // ends with a NULL name

enum { BENCH_PLANS_MOST = 16 };

// The plans for a scene on this pair: each device alone, shares in between, the
// other modes and the other kernels, each at half. Returns how many.
uint32_t bench_plans(const bench_scene *scene, const duet_device_pair *pair,
                     duet_plan plans[BENCH_PLANS_MOST]);

#endif
