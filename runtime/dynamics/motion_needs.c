// SPDX-License-Identifier: MIT
// Whether a motion has the effects that a command calls for.
#include "runtime/dynamics/motion_commands.h"

#include "base/error.h"

#include <stdio.h>

static bool lacks(uint32_t missing, const char *call, const char *what, duet_error *err)
{
    for (uint32_t i = 0; effect_at(i); ++i)
        if (missing & effect_at(i)->effect)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: %sneeds the effect %s; expected the motion's wants to ask for it",
                             call, what, effect_at(i)->name);
    return true;
}

bool motion_needs(const duet_motion *m, uint32_t effect, const char *call, duet_error *err)
{
    return lacks(effect & ~m->effects, call, "it ", err);
}

// Adds some objects to what is known of all, and returns the effects that the motion then lacks.
// How fast they are is not looked at: continuous is called for by what a motion begins with.
static uint32_t missing_with(const duet_motion *m, effect_facts *all, const duet_pose *poses,
                             const duet_body *bodies, uint32_t n)
{
    effect_facts_add(all, &m->def, poses, bodies, n);
    all->reach = m->facts.reach;
    return effect_infer(&m->def, all) & ~m->effects;
}

// What one body alone does not call for, it may with those before it.
static bool tell_who_lacks(const duet_motion *m, const motion_placed *p, const char *call,
                           duet_error *err)
{
    effect_facts all = m->facts;
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->n; ++i) {
        char what[48];
        snprintf(what, sizeof what, "body %u of %u ", i, p->n);
        ok = lacks(missing_with(m, &all, &p->poses[i], &p->bodies[i], 1), call, what, err);
    }
    return ok;
}

bool motion_placed_admit(duet_motion *m, const motion_placed *p, const char *call, duet_error *err)
{
    const effect_facts before = m->facts;
    effect_facts all = before;
    if (missing_with(m, &all, p->poses, p->bodies, p->n))
        return tell_who_lacks(m, p, call, err);
    m->facts = all;
    bool tumbles = (m->effects & DUET_EFFECT_ANGULAR_VELOCITY) && all.uneven && !before.uneven;
    if (!tumbles || motion_prepare_again(m, err))
        return true;
    m->facts = before;
    return false;
}
