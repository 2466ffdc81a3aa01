// SPDX-License-Identifier: MIT
// What each effect of a motion costs.
#include "runtime/dynamics/motion.h"

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
    bool active = (m->effects & row->effect);
    *info = (duet_effect_info){
        .name = row->name,
        .active = active,
        .called_by = row->called_by,
        .kernels = row->kernels,
        .bytes = active ? motion_bytes_for(m, row->effect) : 0,
    };
    return true;
}
