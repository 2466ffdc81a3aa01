// SPDX-License-Identifier: MIT
#include "support/stack.h"
#include "support/figure.h"
#include "support/test.h"

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

stack_figures stack_figures_read(void)
{
    double f[10];
    figures("effects.md",
            "stack of #, #, # boxes, # s | needs #, #, # substeps; sways by less than # % of its "
            "height; # boxes with # substeps fall",
            10, f);
    return (stack_figures){
        .heights = {(uint32_t)f[0], (uint32_t)f[1], (uint32_t)f[2]},
        .seconds = (uint32_t)f[3],
        .substeps = {(uint32_t)f[4], (uint32_t)f[5], (uint32_t)f[6]},
        .sway = f[7] / 100,
        .falling_height = (uint32_t)f[8],
        .falling_substeps = (uint32_t)f[9],
    };
}

// Box i, counted from 1: not further aside than the document says, and no lower
// than what is below it is pressed.
static bool is_in_place(const mover *m, const stack *s, uint32_t i, double sway)
{
    const double *c = m->states[i].centre;
    double sideways = hypot(c[0] - s->x, s->dims == 3 ? c[1] : 0.0);
    return sideways < sway && fabs(c[s->dims - 1] - (i - 0.5)) < 0.15 * i &&
           mover_speed(m, i) < 0.02;
}

bool stack_stands(const stack *s, uint32_t seconds)
{
    mover *m = build(s);
    mover_run(m, 60 * seconds);
    double sway = stack_figures_read().sway * s->height;
    uint32_t i = 1;
    while (i <= s->height && is_in_place(m, s, i, sway))
        ++i;
    const double *c = m->states[i <= s->height ? i : 0].centre;
    if (i <= s->height)
        print_message("box %u of %u is at %g %g %g after %u s\n", i, s->height, c[0], c[1], c[2],
                      seconds);
    return i > s->height;
}

void stack_assert_stands(const stack *s, uint32_t seconds)
{
    if (!stack_stands(s, seconds))
        fail_msg("%u boxes with %u substeps do not stand", s->height, s->substeps);
}
