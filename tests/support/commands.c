// SPDX-License-Identifier: MIT
#include "support/commands.h"

duet_body_list one(uint32_t place)
{
    return (duet_body_list){.first = place, .n = 1};
}

duet_body_list by_ids(const uint64_t *ids, uint32_t n)
{
    return (duet_body_list){.ids = ids, .n = n};
}

mover *make_rows(uint32_t n, uint32_t high)
{
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_SLEEP | DUET_EFFECT_FORCES;
    m->def.sleep_after = 0.1;
    mover_add_floor(m, 50);
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < high; ++k)
            mover_add_rough_cube(m, 3.0 * i, 0, k + 0.5);
    return m;
}
