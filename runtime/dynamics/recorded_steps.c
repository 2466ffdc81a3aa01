// SPDX-License-Identifier: MIT
#include "runtime/dynamics/recorded_steps.h"

#include "runtime/dynamics/motion.h"

#include <assert.h>

static_assert(sizeof(recorded) == 16, "no byte of a file is left to chance");

enum { STEPS_BETWEEN = 32, MANY_BODIES = 1 << 16 };

void recorded_steps_begin(duet_motion *m, text *recording)
{
    m->recording = recording;
    m->recorded_step = m->step;
    m->hashed_step = m->step;
}

void recorded_steps_add(duet_motion *m)
{
    uint64_t steps = m->step - m->recorded_step;
    while (steps > 0) {
        uint32_t some = steps < UINT32_MAX ? (uint32_t)steps : UINT32_MAX;
        const recorded r = {.kind = RECORDED_STEPS, .n = some};
        text_add_bytes(m->recording, (const char *)&r, sizeof r);
        steps -= some;
    }
    m->recorded_step = m->step;
}

static bool hash_is_due(const duet_motion *m)
{
    uint64_t between = STEPS_BETWEEN * (1 + (uint64_t)m->n / MANY_BODIES);
    return m->recording && m->step - m->hashed_step >= between;
}

void recorded_steps_note(duet_motion *m)
{
    const recorded r = {.kind = RECORDED_HASH, .n = 1};
    duet_error why = {0};
    uint64_t hash;
    if (!hash_is_due(m) || !motion_hash(m, &hash, &why))
        return;
    recorded_steps_add(m);
    m->hashed_step = m->step;
    text_add_bytes(m->recording, (const char *)&r, sizeof r);
    text_add_bytes(m->recording, (const char *)&hash, sizeof hash);
}
