// SPDX-License-Identifier: MIT
// A variant's text, read: "auto", "simd", "gpu", "paper", "auto
// sort=radix BUF=512".
//
// The first word names the search. auto is the one over merged rows in the
// shape that suits the device, simd on a CPU and gpu elsewhere. sort is
// counting or radix; grid is auto, uniform, dense or hashed; cells is free or
// fixed (compiled in, for as long as a dense grid's stay the same). send says how
// a device with memory of its own gets the objects: chunks, which are hashed while
// the next travels, all at once, or packed (only what the device's slab needs, in
// mode slab: worth it if the bus is slow, docs/notes/performance.md). Every other
// NAME=V sets a parameter of each kernel whose card has it, or of one kernel as
// KERNEL.NAME=V.
#ifndef RUNTIME_VARIANT_H
#define RUNTIME_VARIANT_H

#include "runtime/duet.h"

// gpu: an object a work-item, as GPUs like it; simd: eight side by side in a
// work-item, as CPUs do; paper: section 2.3 of the paper.
typedef enum variant_search { SEARCH_GPU, SEARCH_SIMD, SEARCH_PAPER } variant_search;

typedef enum variant_sort { SORT_COUNTING, SORT_RADIX } variant_sort;

typedef enum variant_grid {
    VARIANT_GRID_AUTO,
    VARIANT_GRID_UNIFORM, // dense, one size of cells
    VARIANT_GRID_DENSE,   // sizes of cells as the objects have
    VARIANT_GRID_HASHED
} variant_grid;

typedef enum variant_send { SEND_ALL, SEND_CHUNKS, SEND_PACKED } variant_send;

enum { VARIANT_SETTINGS = 16 };

typedef struct variant_setting {
    char kernel[32]; // empty: every kernel that has the parameter
    char name[24];
    int64_t value;
    bool used; // some kernel had it
} variant_setting;

typedef struct variant {
    variant_search search;
    variant_sort sort;
    variant_grid grid;
    variant_send send;
    bool fixed; // the grid's cells are compiled in
    bool fused; // candidates are tested where they are found, unless it is set otherwise
    variant_setting settings[VARIANT_SETTINGS];
    uint32_t n_settings;
} variant;

// BAD_ARGUMENT names the word that is wrong and what would be right.
bool variant_parse(variant *v, const char *text, const duet_device_info *device, duet_error *err);

// Whether both ask for the same.
bool variant_is(const variant *a, const variant *b);

// False for a name that no mode has.
bool mode_from_name(const char *name, duet_mode *mode);

// Name of a mode; NULL past the last.
const char *mode_name(int mode);

// The same for the modes that a tuning may search: all but the default, which is none of its own.
const char *mode_to_search_name(int mode);

#endif
