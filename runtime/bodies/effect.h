// SPDX-License-Identifier: MIT
// The table of effects, and which of them a scene calls for.
#ifndef RUNTIME_EFFECT_H
#define RUNTIME_EFFECT_H

#include "runtime/duet.h"

// The facts that call for effects: a set of these.
typedef enum effect_fact {
    // that the objects have
    FACT_ROTATED = 1 << 0,   // some rotation is not the identity
    FACT_MOVING = 1 << 1,    // some velocity is not 0
    FACT_TURNING = 1 << 2,   // some angular velocity is not 0
    FACT_MASSIVE = 1 << 3,   // something has a mass
    FACT_TURNABLE = 1 << 4,  // and something of that can be turned by others
    FACT_UNEVEN = 1 << 5,    // some inertia is not the same along all axes
    FACT_ELASTIC = 1 << 6,   // some restitution is not 0
    FACT_ROUGH = 1 << 7,     // some friction is not 0
    FACT_RESISTS = 1 << 8,   // some rolling resistance is not 0
    FACT_CONVEYS = 1 << 9,   // some surface velocity is not 0
    FACT_MATERIAL = 1 << 10, // some body names a material
    FACT_FILTERED = 1 << 11, // some group or mask is not all
    FACT_SENSING = 1 << 12,  // some body is a sensor
    FACT_ROUND = 1 << 13,    // some radius is not 0
    FACT_FAST = 1 << 14,     // something moves more than half its least half extent in a step
    // of the def
    FACT_PULLED = 1 << 15,  // gravity or attraction
    FACT_DRAGGED = 1 << 16, // drag
    FACT_BOUNDED = 1 << 17, // walls, or a periodic world
    FACT_HITS = 1 << 18,    // a hit_speed
    FACT_GROUND = 1 << 19,  // heights or a mesh
    FACT_SKIN = 1 << 20,    // a skin
    FACT_CARRIED = 1 << 21, // a mesh that a body carries
} effect_fact;

typedef uint32_t effect_facts;

// Adds what some objects say to what others said.
void effect_facts_add(effect_facts *facts, const duet_motion_def *def, const duet_pose *poses,
                      const duet_body *bodies, uint32_t n);

// The same facts, but as fast as others.
static inline effect_facts effect_facts_as_fast(effect_facts facts, effect_facts others)
{
    return (facts & ~(effect_facts)FACT_FAST) | (others & FACT_FAST);
}

// The effects that facts and def call for, and all that those need.
uint32_t effect_infer(const duet_motion_def *def, effect_facts facts);

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
