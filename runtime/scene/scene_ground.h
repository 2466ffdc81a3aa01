// SPDX-License-Identifier: MIT
// Fields that tables of grounds have in common.
#ifndef RUNTIME_SCENE_GROUND_H
#define RUNTIME_SCENE_GROUND_H

#include "gen/field.h"
#include "runtime/duet.h"

extern const field_type field_spacing; // double[2], as one number for both or two
extern const field_type field_origin;  // double[3], as three numbers
extern const field_type field_carrier; // 1 + the id of a body

// clang-format off
#define GROUND_FIELDS(struct_)                                                    \
    FIELD(field_origin, struct_, origin),                                         \
    FIELD_WITHIN(struct_, , material, 1, DUET_MATERIALS - 1,                      \
                 "the number of one of the materials")
// clang-format on

#endif
