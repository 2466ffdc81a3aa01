// SPDX-License-Identifier: MIT
// The free parameters of a kernel that a world runs: those of its card that neither the scene nor
// the variant decides, and the configs that are valid on the device.
#ifndef RUNTIME_KERNEL_SPACE_H
#define RUNTIME_KERNEL_SPACE_H

#include "gen/gen.h"
#include "runtime/duet.h"

struct kernel;

enum {
    KERNEL_SPACE_PARAMS = 8,
    KERNEL_SPACE_VALUES = 16,
    KERNEL_SPACE_CONFIGS = 1024,
    KERNEL_SPACE_STAGES = 3,
    KERNEL_SPACE_OFFERS = 48,
};

typedef struct kernel_space {
    char kernel[48];
    const char *stages[KERNEL_SPACE_STAGES]; // a step's, that the kernel's time is in
    struct {
        char name[24];
        int64_t values[KERNEL_SPACE_VALUES];
        uint32_t n_values;
    } params[KERNEL_SPACE_PARAMS];
    uint32_t n_params;
    uint8_t configs[KERNEL_SPACE_CONFIGS][KERNEL_SPACE_PARAMS]; // which value of each parameter
    uint32_t n_configs;
    uint32_t now; // the config that ran
} kernel_space;

// The source of a kernel: a parameter that its offers name is not free.
typedef struct kernel_space_source {
    gen *gen;
    gen_limits limits;
    const gen_offer *offers;
    uint32_t n_offers; // at most KERNEL_SPACE_OFFERS
} kernel_space_source;

// The spaces of several kernels, which kernel_spaces_free gives back; zeroed it is empty.
typedef struct kernel_spaces {
    kernel_space *of;
    uint32_t n;
} kernel_spaces;

void kernel_spaces_free(kernel_spaces *s);
bool kernel_spaces_add(kernel_spaces *s, const kernel_space *space, duet_error *err);

// Adds the space of the kernel k of that name, which was made from `from`, if it has several
// configs.
bool kernel_space_read(const kernel_space_source *from, const char *name,
                       const char *const stages[KERNEL_SPACE_STAGES], const struct kernel *k,
                       kernel_spaces *to, duet_error *err);

// Adds the kernels of a device, in the order in which a step mostly spends its time on them; side 0
// is A. Steps the world unless its last step was by the plan's kernels. A device without work has
// none.
bool kernel_spaces_read(duet_world *world, int side, kernel_spaces *to, duet_error *err);

// Adds to a variant's text what a config sets otherwise than the one that ran:
// "gpu pair_search_gpu.WG=64". False if the text would be too long.
bool kernel_space_write(const kernel_space *space, uint32_t config, char text[DUET_VARIANT]);

#endif
