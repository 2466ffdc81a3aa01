// SPDX-License-Identifier: MIT
// The configs of kernels that a store's variants tell of: their texts have what differs from the
// config that ran at first, whose own values nobody wrote down.
#ifndef TUNER_RECORDED_SPACE_H
#define TUNER_RECORDED_SPACE_H

#include "runtime/broadphase/kernel_space.h"
#include "tuner/search.h"

#define RECORDED_DEFAULT INT64_MIN // stands for the value that ran at first

typedef struct recorded_space {
    kernel_space kernels[SEARCH_KERNELS];
    uint32_t n;
    char base[DUET_VARIANT]; // the text without configs
} recorded_space;

// Adds the configs of "auto k.WG=64 k.TILE=1". Configs beyond the limits of a kernel_space are left
// out.
void recorded_space_add(recorded_space *s, const char *variant);

// Gives the words of a variant that was added the order in which kernel_space_write has them.
void recorded_space_order(recorded_space *s, char variant[DUET_VARIANT]);

#endif
