// SPDX-License-Identifier: MIT
// A kernel of one device: an entry point of a variant, and its way to the device.
#ifndef RUNTIME_KERNEL_H
#define RUNTIME_KERNEL_H

#include "gen/gen.h"
#include "runtime/opencl/launcher.h"

#include <stdbool.h>

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

// Lets the next build make a kernel that was spared.
void kernel_ask(kernel *k);

// Leaves a kernel out of builds that the asker found it launches never; a built one stays.
void kernel_spare(kernel *k);

#endif
