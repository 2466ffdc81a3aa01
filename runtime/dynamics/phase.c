// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion.h"

#include "base/error.h"
#include "runtime/duet_motion_map.h"

#include <assert.h>

// Asserts what holds in each phase, besides the products' own.
static void assert_phase(const duet_motion *m)
{
    assert(m->phase <= MOTION_BROKEN);
    assert(m->phase == MOTION_MAPPED || m->phase == MOTION_BROKEN || m->mapped == 0);
    assert(m->phase != MOTION_MAPPED || m->mapped != 0);
    assert(m->phase == MOTION_STEPPING || !m->halves.thread.owner);
    assert(m->graph.n_contacts == 0 || m->phase == MOTION_BROKEN ||
           product_was_made(&m->products, PRODUCT_ROWS));
    assert(m->altered.n == 0 || product_is_forgotten(&m->products, PRODUCT_PAIRS));
    products_assert(&m->products);
    (void)m;
}

// ---------------------------------------------------------------- what calls ask

// Whether the phase is one of these (a bit for each); else what is expected.
static bool is_in(const duet_motion *m, uint32_t phases, const char *call, duet_error *err)
{
    uint32_t part = 0;
    if (m->phase != MOTION_STEPPING) // a thread may be changing the rest
        assert_phase(m);
    if (phases & 1u << m->phase)
        return true;
    switch (m->phase) {
    case MOTION_STEPPING:
        return bad_argument(
            err, "%s: a step of the motion is under way; expected duet_motion_advance_end first",
            call);
    case MOTION_MAPPED:
        while (!(m->mapped >> part & 1u))
            ++part;
        return bad_argument(err, "%s: %s are mapped; expected duet_motion_unmap_states first", call,
                            duet_state_part_name((duet_state_part)part));
    default:
        return bad_argument(err,
                            "the motion failed in its step %llu; expected a saved one to be "
                            "loaded, or a new motion",
                            (unsigned long long)m->step + 1);
    }
}

bool motion_is_whole(const duet_motion *m, const char *call, duet_error *err)
{
    return error_given(m, call, "motion", err) && is_in(m, 1u << MOTION_READY, call, err);
}

bool motion_is_steady(const duet_motion *m, const char *call, duet_error *err)
{
    return error_given(m, call, "motion", err) &&
           is_in(m, 1u << MOTION_READY | 1u << MOTION_MAPPED, call, err);
}

bool motion_is_loadable(const duet_motion *m, const char *call, duet_error *err)
{
    return error_given(m, call, "motion", err) &&
           is_in(m, 1u << MOTION_READY | 1u << MOTION_BROKEN, call, err);
}

// ---------------------------------------------------------------- transitions

static void enter(duet_motion *m, motion_phase phase)
{
    m->phase = phase;
    assert_phase(m);
}

void motion_enter_step(duet_motion *m)
{
    assert(m->phase == MOTION_READY);
    enter(m, MOTION_STEPPING);
}

void motion_leave_step(duet_motion *m, bool made)
{
    assert(m->phase == MOTION_STEPPING);
    enter(m, made ? MOTION_READY : MOTION_BROKEN);
}

void motion_note_map(duet_motion *m, duet_state_part part)
{
    assert(m->phase == MOTION_READY || m->phase == MOTION_MAPPED);
    m->mapped |= 1u << part;
    enter(m, MOTION_MAPPED);
}

void motion_note_unmap(duet_motion *m, duet_state_part part)
{
    m->mapped &= ~(1u << part);
    if (m->phase == MOTION_MAPPED && m->mapped == 0)
        enter(m, MOTION_READY);
}

bool motion_keep_whole(duet_motion *m, bool made)
{
    if (!made)
        enter(m, MOTION_BROKEN);
    return made;
}

void motion_mend(duet_motion *m)
{
    assert(m->phase == MOTION_READY || m->phase == MOTION_BROKEN);
    enter(m, MOTION_READY);
}
