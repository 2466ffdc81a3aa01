// SPDX-License-Identifier: MIT
// A motion's plan, taken apart: what its world is given, and what is set of the kernels that only a
// motion has.
#ifndef RUNTIME_MOTION_PLAN_H
#define RUNTIME_MOTION_PLAN_H

#include "runtime/broadphase/kernel_space.h"
#include "runtime/broadphase/variant.h"

// The kernels that only a motion has, in the order in which a step mostly spends its time on them,
// with the stages of a step that the time is in.
typedef struct motion_plan_kernel {
    const char *name;
    const char *stages[KERNEL_SPACE_STAGES];
} motion_plan_kernel;

enum { MOTION_PLAN_KERNELS = 13 };
extern const motion_plan_kernel motion_plan_kernels[MOTION_PLAN_KERNELS];

#define MOTION_PLAN_WORD "motion" // in a kernel's place: "motion.skin=20"

typedef struct motion_plan {
    duet_plan search;       // the plan of the pair search, without the settings
    char own[DUET_VARIANT]; // "solve_contacts.WG=64 bodies.PER_ITEM=1": what the plan says of B
    variant settings;       // the same as numbers; its search is not read
    uint32_t skin;    // "motion.skin=20": in percent of the bodies' mean least extent; 0: the def's
    uint32_t colours; // "motion.colours=4": over ranks, ghosts come after so many colours; 0: each
} motion_plan;

// BAD_ARGUMENT for a setting that is not one of those that may be chosen freely, or a text that is
// none. The world or the kernels' cards say what else is wrong with a text.
bool motion_plan_read(motion_plan *p, const duet_plan *plan, const duet_device_info *b,
                      duet_error *err);

// Fills offers with the settings, and returns how many they are. Their strings are the plan's.
uint32_t motion_plan_offer(motion_plan *p, gen_offer offers[VARIANT_SETTINGS]);

// BAD_ARGUMENT names a setting that no kernel took, or a skin if the motion has none.
bool motion_plan_is_used(const duet_motion *m, duet_error *err);

// How far bounds are grown, by the plan or else by the def.
double motion_skin(const duet_motion *m);

// The def's plan becomes the world's, whose mode may change in a search, with the settings.
void motion_plan_note(duet_motion *m);

#endif
