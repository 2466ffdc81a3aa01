// SPDX-License-Identifier: MIT
// Kernels of one device, generated and built when first asked for and kept.
#ifndef RUNTIME_PROGRAM_H
#define RUNTIME_PROGRAM_H

#include "gen/gen.h"
#include "runtime/opencl/device.h"
#include "runtime/opencl/launcher.h"

// An entry point of a built variant.
typedef struct kernel {
    cl_kernel cl;
    uint32_t group;    // work-items a group
    uint32_t per_item; // objects, pairs or values a work-item does
    char name[160];    // of the variant: "radix.BITS8.WG1.PER_ITEM16384"
    launcher launcher;
} kernel;

// A parameter's value in the variant's name; the kernel's card must have more
// than one value for it.
int64_t kernel_param(const kernel *k, const char *param);

// What of a device its variants depend on.
gen_limits program_limits(const duet_device_info *info);

typedef struct program_set program_set;

// Borrows the device and the gen, which are not shared with another thread
// while kernels are asked for.
program_set *program_set_open(const device *d, gen *g, const char *cache_dir, duet_error *err);
void program_set_close(program_set *set);
gen_limits program_set_limits(const program_set *set);

// The entry point of the kernel with these settings, to be launched with a struct that
// `from` describes. The kernel is the set's; an entry is asked for with the same bindings
// each time. BUILD_FAILED names the variant, the device and the compiler's first line, or
// the argument that the bindings lack.
kernel *program_set_kernel(program_set *set, const char *kernel_name, const char *entry,
                           const gen_setting *settings, uint32_t n_settings, bindings from,
                           duet_error *err);

// Builds the variant and keeps nothing: whether the device's compiler takes it.
bool program_set_check(program_set *set, const char *kernel_name, const gen_setting *settings,
                       uint32_t n_settings, duet_error *err);

#endif
