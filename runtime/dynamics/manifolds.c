// SPDX-License-Identifier: MIT
// Makes the points where contacts touch when a step begins, and wakes what a touch wakes.
#include "runtime/dynamics/domain_motion.h"

// woken: 1 finds those of bodies that woke in this step, which get their mass again before they are
// pushed; 0 those of all that is awake.
static bool find_manifolds(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->solver.woken = woken;
    return motion_launch(m, PREPARE_BODIES, err) && motion_launch(m, BUILD_MANIFOLDS, err);
}

bool motion_begin_manifolds(duet_motion *m, duet_error *err)
{
    product_renew(&m->products, PRODUCT_MANIFOLDS);
    return find_manifolds(m, 0, err) && motion_launch(m, UPDATE_SLEEP, err);
}

// Lists, if there are any, get what woke.
bool motion_end_manifolds(duet_motion *m, duet_error *err)
{
    if (!(m->effects & DUET_EFFECT_SLEEP))
        return true;
    if (m->awake.all_awake)
        return find_manifolds(m, 1, err);
    if (!motion_read_flags(m, err))
        return false;
    motion_count_awake(m);
    return (!m->flags[FLAG_WOKE] || motion_list_woken(m, err)) &&
           (!m->flags[FLAG_FELL_ASLEEP] || find_manifolds(m, 1, err));
}

// ---------------------------------------------------------------- stage by stage

bool domain_find_manifolds(duet_motion *m, duet_error *err)
{
    product_renew(&m->products, PRODUCT_MANIFOLDS);
    return find_manifolds(m, 0, err);
}

bool domain_wake_touched(duet_motion *m, bool fell, duet_error *err)
{
    static const cl_uint one = 1;
    if (m->n == 0 || !fell)
        return true;
    return timeline_write_at(&m->times, "sleep", &m->buffers[FLAG_WORDS],
                             FLAG_FELL_ASLEEP * sizeof one, &one, sizeof one, err) &&
           find_manifolds(m, 1, err);
}
