// SPDX-License-Identifier: MIT
#include "support/stack.h"
#include "support/test.h"

#include <math.h>

static mover *build(const stack *s)
{
    mover *m = mover_new(s->dims);
    m->def.substeps = s->substeps;
    m->def.doubles = s->doubles;
    m->def.origin[0] = s->x;
    mover_add_floor(m, 5);
    for (uint32_t i = 0; i < s->height; ++i)
        mover_add_rough_cube(m, 0, s->dims == 2 ? i + 0.5 : 0, i + 0.5);
    return m;
}

// Box i, counted from 1: less than a hundredth of its edge aside, and no lower
// than what is below it is pressed.
static bool is_in_place(const mover *m, const stack *s, uint32_t i)
{
    const double *c = m->states[i].centre;
    double sideways = hypot(c[0] - s->x, s->dims == 3 ? c[1] : 0.0);
    return sideways < 0.01 && fabs(c[s->dims - 1] - (i - 0.5)) < 0.15 * i &&
           mover_speed(m, i) < 0.02;
}

bool stack_stands(const stack *s, uint32_t seconds)
{
    mover *m = build(s);
    mover_run(m, 60 * seconds);
    uint32_t i = 1;
    while (i <= s->height && is_in_place(m, s, i))
        ++i;
    const double *c = m->states[i <= s->height ? i : 0].centre;
    if (i <= s->height)
        print_message("box %u of %u is at %g %g %g after %u s\n", i, s->height, c[0], c[1], c[2],
                      seconds);
    mover_free(m);
    return i > s->height;
}

void stack_assert_stands(const stack *s, uint32_t seconds)
{
    if (!stack_stands(s, seconds))
        fail_msg("%u boxes with %u substeps do not stand", s->height, s->substeps);
}
