// SPDX-License-Identifier: MIT
#include "cluster/interior.h"

#include <math.h>
#include <string.h>

// The nearest floats not below a number, and not above it.
static float above(float rounded, double number)
{
    return (double)rounded < number ? nextafterf(rounded, INFINITY) : rounded;
}

static float below(float rounded, double number)
{
    return (double)rounded > number ? nextafterf(rounded, -INFINITY) : rounded;
}

void interior_box(const extent *inside, float lower[3], float upper[3])
{
    for (int k = 0; k < 3; ++k) {
        lower[k] = above((float)inside->lower[k], inside->lower[k]);
        upper[k] = below((float)inside->upper[k], inside->upper[k]);
    }
}

// A block of bounds has more than their centres; squares are short by less than 2^-21.
void interior_add_block(interior *s, const interior_block *block)
{
    for (int k = 0; k < 3; ++k) {
        s->centres.lower[k] = lesser(s->centres.lower[k], (double)block->lower[k]);
        s->centres.upper[k] = greater(s->centres.upper[k], (double)block->upper[k]);
    }
    s->square = greater(s->square, (double)block->square * (1 + 0x1p-20));
}

enum { SIDE_BY_SIDE = 4 }; // numbers that a compiler takes together

// A pose is ten numbers: its centre and a half extent, three half extents and one of the rotation,
// the rotation. Without a branch but the one that ends it, so that it takes little longer than
// reading the rows.
static uint32_t add_poses(const duet_pose *poses, uint32_t dims, uint32_t first, uint32_t end,
                          const extent *inside, interior *to)
{
    float lower[SIDE_BY_SIDE], upper[SIDE_BY_SIDE], least[SIDE_BY_SIDE], most[SIDE_BY_SIDE];
    double square = to->square, in_3d = dims == 3;
    interior_box(inside, lower, upper);
    for (int k = 0; k < SIDE_BY_SIDE; ++k) {
        if ((uint32_t)k >= dims) {
            lower[k] = -INFINITY;
            upper[k] = INFINITY;
        }
        least[k] = INFINITY;
        most[k] = -INFINITY;
    }
    uint32_t i = first;
    for (; i < end; ++i) {
        float centre[SIDE_BY_SIDE], half[SIDE_BY_SIDE], turn[SIDE_BY_SIDE];
        memcpy(centre, poses[i].centre, sizeof centre);
        memcpy(half, poses[i].half_extents, sizeof half);
        memcpy(turn, poses[i].rotation, sizeof turn);
        int odd = 0;
        for (int k = 0; k < SIDE_BY_SIDE; ++k) {
            float zero = 0.0f * (centre[k] + half[k] + turn[k]);
            odd |= !(zero == 0.0f) | !(centre[k] > lower[k]) | !(centre[k] < upper[k]);
        }
        odd |= !(half[0] >= 0.0f) | !(half[1] >= 0.0f) | !(half[2] >= 0.0f);
        odd |= (turn[2] == 0.0f) & (turn[3] == 0.0f);
        if (odd)
            break;
        for (int k = 0; k < SIDE_BY_SIDE; ++k) {
            least[k] = centre[k] < least[k] ? centre[k] : least[k];
            most[k] = centre[k] > most[k] ? centre[k] : most[k];
        }
        double x = (double)half[0], y = (double)half[1], z = in_3d * (double)half[2];
        square = greater(x * x + y * y + z * z, square);
    }
    for (uint32_t k = 0; k < 3; ++k) {
        bool along = k < dims;
        to->centres.lower[k] = lesser(along ? (double)least[k] : 0, to->centres.lower[k]);
        to->centres.upper[k] = greater(along ? (double)most[k] : 0, to->centres.upper[k]);
    }
    to->square = square;
    return i;
}

uint32_t object_rows_add_interior(const object_rows *rows, const object_form *form, uint32_t first,
                                  uint32_t end, const extent *inside, interior *s)
{
    if (form->shape == DUET_SHAPE_POSES && form->origin > 0.0f)
        return first;
    if (form->shape == DUET_SHAPE_POSES)
        return add_poses((const duet_pose *)(const void *)rows->objects, form->dims, first, end,
                         inside, s);
    for (; first < end; ++first) {
        const void *object = object_row(rows, form, first);
        double at[3];
        object_centre(form, object, at);
        if (!object_is_sound(form, object) || !extent_holds(inside, at))
            break;
        double half = object_half(form, object);
        s->square = greater(half * half, s->square);
        extent_add(&s->centres, at);
    }
    return first;
}

double interior_widest(const interior *s, const object_form *form)
{
    double far = 0, half = sqrt(s->square), slack = 0;
    if (s->centres.lower[0] > s->centres.upper[0])
        return 0;
    for (int k = 0; k < 3; ++k)
        far = greater(far, greater(fabs(s->centres.lower[k]), fabs(s->centres.upper[k])));
    if (form->shape != DUET_SHAPE_BOUNDS)
        slack = object_slack(form, half, far);
    return 2 * (1 + 0x1p-20) * (half + slack);
}
