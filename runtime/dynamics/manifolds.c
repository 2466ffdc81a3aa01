// SPDX-License-Identifier: MIT
// Makes the points where contacts touch when a step begins, and wakes what a touch wakes.
#include "runtime/dynamics/domain_motion.h"

// woken: only of what woke in this step, if anything did.
static bool find_manifolds(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->solver.woken = woken;
    return motion_launch(m, "manifolds", m->kernels.build_manifolds, m->awake.n_contacts, err);
}

static bool prepare_bodies(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->solver.woken = woken;
    return motion_launch(m, "integrate", m->kernels.prepare_bodies,
                         (uint64_t)m->awake.n_bodies + FIXED, err);
}

// A body that a touch wakes has its mass again before it is pushed.
static bool prepare_woken(duet_motion *m, duet_error *err)
{
    return prepare_bodies(m, 1, err) && find_manifolds(m, 1, err);
}

bool motion_begin_manifolds(duet_motion *m, duet_error *err)
{
    product_renew(&m->products, PRODUCT_MANIFOLDS);
    return (!(m->effects & DUET_EFFECT_CONTACT_RESPONSE) || prepare_bodies(m, 0, err)) &&
           find_manifolds(m, 0, err) &&
           (!(m->effects & DUET_EFFECT_SLEEP) ||
            motion_launch(m, "sleep", m->kernels.update_sleep, m->awake.n_bodies, err));
}

// Lists, if there are any, get what woke.
bool motion_end_manifolds(duet_motion *m, duet_error *err)
{
    if (!(m->effects & DUET_EFFECT_SLEEP))
        return true;
    if (m->awake.all_awake)
        return prepare_woken(m, err);
    if (!motion_read_flags(m, err))
        return false;
    motion_count_awake(m);
    return (!m->flags[FLAG_WOKE] || motion_list_woken(m, err)) &&
           (!m->flags[FLAG_FELL_ASLEEP] || prepare_woken(m, err));
}

// ---------------------------------------------------------------- stage by stage

static bool find_first_manifolds(duet_motion *m, duet_error *err)
{
    product_renew(&m->products, PRODUCT_MANIFOLDS);
    return prepare_bodies(m, 0, err) && find_manifolds(m, 0, err);
}

bool domain_find_manifolds(duet_motion *m, duet_error *err)
{
    return m->n == 0 || find_first_manifolds(m, err);
}

bool domain_update_sleep(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "sleep", m->kernels.update_sleep, m->n, err);
}

bool domain_wake_touched(duet_motion *m, bool fell, duet_error *err)
{
    static const cl_uint one = 1;
    if (m->n == 0 || !fell)
        return true;
    return timeline_write_at(&m->times, "sleep", &m->buffers[FLAG_WORDS],
                             FLAG_FELL_ASLEEP * sizeof one, &one, sizeof one, err) &&
           prepare_woken(m, err);
}
