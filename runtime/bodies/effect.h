// SPDX-License-Identifier: MIT
// The table of effects, and which of them a scene calls for.
#ifndef RUNTIME_EFFECT_H
#define RUNTIME_EFFECT_H

#include "runtime/duet.h"

// Facts of the objects and the def that call for effects.
typedef struct effect_facts {
    bool rotated;  // some rotation is not the identity
    bool moving;   // some velocity is not 0
    bool turning;  // some angular velocity is not 0
    bool massive;  // something has a mass
    bool turnable; // and something of that can be turned by others
    bool uneven;   // some inertia is not the same along all axes
    bool elastic;  // some restitution is not 0
    bool rough;    // some friction is not 0
    bool resists;  // some rolling resistance is not 0
    bool conveys;  // some surface velocity is not 0
    bool made;     // some body names a material
    bool filtered; // some group or mask is not all
    bool sensing;  // some body is a sensor
    bool round;    // some radius is not 0
    double reach;  // the most that something moves in a step, in its least half extents
} effect_facts;

// Adds what some objects say to what others said.
void effect_facts_add(effect_facts *facts, const duet_motion_def *def, const duet_pose *poses,
                      const duet_body *bodies, uint32_t n);

// The effects that facts and def call for, and all that those need.
uint32_t effect_infer(const duet_motion_def *def, const effect_facts *facts);

// A row of the table; NULL past the last.
typedef struct effect_row {
    uint32_t effect;
    const char *name;
    uint32_t needs;        // effects that come with it
    const char *called_by; // says what calls for it
    const char *word;      // is in no kernel's text without it
    const char *kernels;
} effect_row;

const effect_row *effect_at(uint32_t i);

#endif
