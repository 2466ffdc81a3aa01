// SPDX-License-Identifier: MIT
// Kernels of one device: asked for one by one, built together, and kept.
//
// program.c: gen writes the text of a kernel that is asked for, and what its launches hand over is
// found by the names of its arguments. Programs are taken from those that the device has, or else
// looked up in the folder of built ones; what is in neither is compiled by program_build.c.
#ifndef RUNTIME_PROGRAM_H
#define RUNTIME_PROGRAM_H

#include "gen/gen.h"
#include "runtime/opencl/device.h"
#include "runtime/opencl/kernel.h"

// Returns the limits of a device that its variants depend on.
gen_limits program_limits(const duet_device_info *info);

typedef struct program_set program_set;

// Borrows the device and the gen, which are not shared with another thread
// while kernels are asked for, and what the builder names; NULL is one that keeps and
// tells nothing.
program_set *program_set_open(const device *d, gen *g, const program_builder *builder,
                              duet_error *err);
void program_set_close(program_set *set);
gen_limits program_set_limits(const program_set *set);

// The entry point of the kernel with these settings, to be launched with a struct that
// `from` describes, once it is built. The kernel is the set's; an entry is asked for with
// the same bindings each time. BUILD_FAILED names the argument that the bindings lack.
kernel *program_set_kernel(program_set *set, const char *kernel_name, const char *entry,
                           const gen_setting *settings, uint32_t n_settings, bindings from,
                           duet_error *err);

// A kernel that somebody wants, in a list of those that are asked for together.
typedef struct kernel_request {
    kernel **at; // receives the kernel; NULL if it is not wanted
    bool wanted;
    const char *name;
    const char *entry;
    bindings from;
} kernel_request;

// All that the list wants, each with what the offers say of its parameters. After a failure none of
// the list is there.
bool program_set_kernels(program_set *set, const kernel_request *list, size_t n,
                         const gen_offer *offers, uint32_t n_offers, duet_error *err);

// Builds what was asked for and is not built. BUILD_FAILED names the variant, the device
// and the compiler's first line; INTERRUPTED where the program is to stop. After a failure
// kernels that are not built are spared, so that it does not come back with the next build.
bool program_set_build(program_set *set, duet_error *err);

// Leaves out of later builds what was asked for and is not built: whoever asked will not launch it.
void program_set_spare(program_set *set);

// Builds the variant and keeps nothing: whether the device's compiler takes it.
bool program_set_check(program_set *set, const char *kernel_name, const gen_setting *settings,
                       uint32_t n_settings, duet_error *err);

#endif
