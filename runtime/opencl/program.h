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
#include "runtime/opencl/launcher.h"

// How the groups of a launch go through its stages, by the parameters TEAM and MEET of its card.
typedef enum kernel_groups {
    GROUPS_APART, // each alone
    GROUPS_TEAM,  // together, one work-item each (kernels/dynamics/team.clh)
    GROUPS_MEET   // together, all at once on a GPU (kernels/dynamics/meet.clh)
} kernel_groups;

// A kernel's way to the device. Only a built one can be launched.
//
//     asked for --> ASKED -------- a build --------> BUILT
//                   |   ^
//    kernel_spare,  |   |  asked for again
//    a failed build v   |
//                  SPARED
//
typedef enum kernel_state {
    KERNEL_ASKED,  // the next build makes it
    KERNEL_SPARED, // builds leave it out
    KERNEL_BUILT   // stays, whatever is asked for or fails later
} kernel_state;

// An entry point of a variant.
typedef struct kernel {
    cl_kernel cl; // NULL unless it is built
    kernel_state state;
    kernel_groups groups;
    uint32_t group;    // work-items a group
    uint32_t per_item; // objects, pairs or values a work-item does
    uint32_t n_axes;   // in a launch
    gen_axis more[2];  // along the second and the third
    char name[192];    // the variant's name: "radix.BITS8.WG1.PER_ITEM16384"
    launcher launcher;
} kernel;

// A parameter's value in the variant's name; the kernel's card must have more
// than one value for it.
int64_t kernel_param(const kernel *k, const char *param);

// Whether k is a variant of the kernel of that name; false for NULL.
bool kernel_is(const kernel *k, const char *name);

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

// Leaves a kernel out of builds that the asker found it launches never; a built one stays.
void kernel_spare(kernel *k);

// Builds what was asked for and is not built. BUILD_FAILED names the variant, the device
// and the compiler's first line; INTERRUPTED where the program is to stop. After a failure
// kernels that are not built are spared, so that it does not come back with the next build.
bool program_set_build(program_set *set, duet_error *err);

// Builds the variant and keeps nothing: whether the device's compiler takes it.
bool program_set_check(program_set *set, const char *kernel_name, const gen_setting *settings,
                       uint32_t n_settings, duet_error *err);

#endif
