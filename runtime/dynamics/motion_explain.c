// SPDX-License-Identifier: MIT
// What a motion's effects are, and what each costs of memory.
#include "runtime/dynamics/motion.h"

#include <string.h>

// The effect that a buffer by object is there for.
static const struct {
    motion_buffer which;
    uint32_t effect;
} owners[] = {
    {CENTRES, DUET_EFFECT_MOTION},
    {VELOCITIES, DUET_EFFECT_MOTION},
    {ROTATIONS, DUET_EFFECT_ROTATION},
    {ANGULAR_VELOCITIES, DUET_EFFECT_ANGULAR_VELOCITY},
    {INERTIAS, DUET_EFFECT_ANGULAR_VELOCITY},
    {HALVES, DUET_EFFECT_CONTACT},
    {RESTITUTIONS, DUET_EFFECT_CONTACT_RESPONSE},
    {FRICTIONS, DUET_EFFECT_FRICTION},
    {FILTERS, DUET_EFFECT_FILTER},
    {RESTS, DUET_EFFECT_SLEEP},
    {ASLEEP, DUET_EFFECT_SLEEP},
    {FORCES, DUET_EFFECT_FORCES},
    {BODIES, DUET_EFFECT_CONTACT_RESPONSE},
    {BOXES, DUET_EFFECT_CONTACT},
    {STARTS, DUET_EFFECT_CONTACT},
    {RETURN_STARTS, DUET_EFFECT_CONTACT},
    {USED, DUET_EFFECT_CONTACT_RESPONSE},
    {CHOICES, DUET_EFFECT_CONTACT_RESPONSE},
};

static uint32_t bytes_for(const duet_motion *m, uint32_t effect)
{
    uint32_t words = 0;
    for (size_t i = 0; i < sizeof owners / sizeof owners[0]; ++i)
        if (owners[i].effect == effect)
            words += motion_words(m, owners[i].which);
    return words * (uint32_t)sizeof(uint32_t);
}

// No effect, for it changes how positions are kept and nothing of what happens.
static bool explain_origin(const duet_motion *m, duet_effect_info *info)
{
    *info = (duet_effect_info){
        .name = "origin",
        .active = m->cells && m->effects,
        .called_by = "origin = \"cell\"",
        .kernels = "integrate_free_flight, bodies, fat_aabbs, build_manifolds",
        .bytes = motion_words(m, CELLS) * (uint32_t)sizeof(uint32_t),
    };
    return true;
}

bool duet_motion_explain(const duet_motion *m, uint32_t i, duet_effect_info *info)
{
    const effect_row *row = effect_at(i);
    if (!m || !info)
        return false;
    if (!row)
        return i > 0 && effect_at(i - 1) && explain_origin(m, info);
    bool active = motion_has(m, row->effect);
    *info = (duet_effect_info){
        .name = row->name,
        .active = active,
        .called_by = row->called_by,
        .kernels = row->kernels,
        .bytes = active ? bytes_for(m, row->effect) : 0,
    };
    return true;
}
