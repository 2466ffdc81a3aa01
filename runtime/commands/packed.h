// SPDX-License-Identifier: MIT
// Bodies and defs as files have them: without bytes between their members, and without what a
// command cannot change.
#ifndef RUNTIME_PACKED_H
#define RUNTIME_PACKED_H

#include "runtime/duet_motion.h"

typedef struct packed_body {
    float velocity[3], angular_velocity[3], mass, restitution, friction;
    uint32_t group, mask, flags;
    float radius, rolling_resistance, surface_velocity[3];
} packed_body;

// The material is in the bits of the flags from PACKED_MATERIAL on.
enum {
    PACKED_FIXED_ROTATION = 1,
    PACKED_SENSOR = 2,
    PACKED_MATERIAL = 4,
    PACKED_FLAGS = 3 | (DUET_MATERIALS - 1) << PACKED_MATERIAL
};

typedef struct packed_def {
#define DEF_MEMBER(name) __typeof__(((duet_motion_def *)0)->name) name;
#include "runtime/commands/def_members.inl"
} packed_def;

packed_body packed_body_of(const duet_body *body);
duet_body packed_to_body(const packed_body *packed);
packed_def packed_def_of(const duet_motion_def *def);
void packed_to_def(const packed_def *packed, duet_motion_def *def);

#endif
