// SPDX-License-Identifier: MIT
// The table of materials, for kernels and host alike: a row for each two materials.
#ifndef KERNELS_DYNAMICS_MATERIALS_H
#define KERNELS_DYNAMICS_MATERIALS_H

#define MATERIALS_MOST 16 // with 0, which stands for a body's own numbers

// Rules by which two numbers become a contact's: those of duet_combine, and a number that the
// table has.
#define RULE_AVERAGE 0.0f
#define RULE_GEOMETRIC_MEAN 1.0f
#define RULE_MIN 2.0f
#define RULE_PRODUCT 3.0f
#define RULE_MAX 4.0f
#define RULE_GIVEN 5.0f

// A row of floats.
#define RULE_FRICTION 0
#define RULE_RESTITUTION 1
#define GIVEN_FRICTION 2
#define GIVEN_RESTITUTION 3
#define MATERIAL_ROW 4

#endif
