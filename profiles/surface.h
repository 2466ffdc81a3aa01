// SPDX-License-Identifier: MIT
// Surfaces: what a store keeps of one workload on one device pair, as a search meets it. For a
// search of mode and share that is every launch of every plan with the same variants, for one of
// kernels and share together what the strategy brute measured.
#ifndef PROFILES_SURFACE_H
#define PROFILES_SURFACE_H

#include "profiles/session.h"

typedef struct profile_surface {
    char scene[64];
    uint64_t n;     // objects, or items of the query
    char query[32]; // "rays closest", asked of `boxes` boxes; empty: steps of a world
    uint64_t boxes;
    char a[160]; // the devices, with their parts
    char b[160];
    char level[16];
    bool joint;                      // kernels and share together vary
    char variant_a[PROFILE_VARIANT]; // one of several if joint
    char variant_b[PROFILE_VARIANT];
    int64_t pair_id;
    int64_t workload_id;
    char kernels[PROFILE_SHA];
    char host[PROFILE_SHA]; // times of two machines are two surfaces
} profile_surface;

// One launch of a plan that ran and found the right pairs.
typedef struct profile_launch {
    uint32_t share;
    char mode[16];                   // "own" for one device alone, which has no mode
    char variant_a[PROFILE_VARIANT]; // empty for a device without work
    char variant_b[PROFILE_VARIANT];
    bool warm_up;
    int64_t total_ns;
    int64_t a_ns;
    int64_t b_ns;
} profile_launch;

// Gets the surfaces with both single devices and at least 16 plans, by scene and size, joint ones
// last. The caller frees them.
bool profile_surfaces_get(store *s, profile_surface **surfaces, uint32_t *n, duet_error *err);

// All launches of a surface by mode, share, variants, warm_up and total_ns. The caller frees them.
bool profile_surface_launches(store *s, const profile_surface *surface, profile_launch **launches,
                              uint32_t *n, duet_error *err);

#endif
