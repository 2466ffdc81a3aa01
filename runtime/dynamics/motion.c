// SPDX-License-Identifier: MIT
// A motion answers between steps, says what each of its buffers holds by object, makes space for
// that, and says what each effect costs.
#include "runtime/dynamics/motion.h"

#include "base/error.h"
#include "runtime/duet_motion_map.h"

uint32_t duet_motion_get_effects(const duet_motion *m)
{
    return m ? m->effects : 0;
}

uint32_t duet_motion_get_count(const duet_motion *m)
{
    return m ? m->n : 0;
}

uint64_t duet_motion_get_step(const duet_motion *m)
{
    return m ? m->step : 0;
}

const char *duet_state_part_name(duet_state_part part)
{
    static const char *const names[] = {
        [DUET_STATE_CENTRES] = "centres",
        [DUET_STATE_ROTATIONS] = "rotations",
        [DUET_STATE_VELOCITIES] = "velocities",
        [DUET_STATE_ANGULAR_VELOCITIES] = "angular_velocities",
    };
    const int n = sizeof names / sizeof names[0];
    return (int)part >= 0 && (int)part < n ? names[part] : NULL;
}

// ---------------------------------------------------------------- by object

// By object, what each buffer holds: the effect that it is there for, another that calls for it,
// reals and 32-bit words.
static const struct {
    uint32_t effect;
    uint32_t also;
    uint32_t reals;
    uint32_t words;
} by_object[MOTION_BUFFERS] = {
#define BY_OBJECT(which, name, type, effect, also, reals, words) \
    [which] = {DUET_EFFECT_##effect, DUET_EFFECT_##also, reals, words},
#define BUFFER(which, name, type)
#define HIDDEN(which)
#include "runtime/dynamics/motion_buffers.inl"
};

static bool has_rows(const duet_motion *m, motion_buffer which)
{
    const uint32_t effect = by_object[which].effect, also = by_object[which].also;
    if (which == CELLS)
        return m->cells;
    if (which == FAR_BOXES && !m->kernels.of[MAKE_FAR_BOXES])
        return false;
    return also == DUET_EFFECT_ALL || (m->effects & (effect | also));
}

uint32_t motion_words(const duet_motion *m, motion_buffer which)
{
    if (!has_rows(m, which))
        return 0;
    return by_object[which].reals * (m->def.doubles ? 2 : 1) +
           by_object[which].words * (which == BODIES ? m->layout.body : 1);
}

bool motion_has_doubles(const duet_motion *m, motion_buffer which)
{
    return by_object[which].reals > 0 && m->def.doubles;
}

// ---------------------------------------------------------------- buffers

// A buffer that must grow gets more than it needs now: fresh pages cost as much time as
// writing them.
static size_t with_room(const duet_motion *m, uint64_t bytes)
{
    uint64_t roomy = bytes + bytes / 4;
    return (size_t)(roomy <= m->device->info.max_buffer_bytes ? roomy : bytes);
}

bool motion_reserve(duet_motion *m, motion_buffer which, uint64_t n, size_t size, duet_error *err)
{
    buffer *b = &m->buffers[which];
    bool grows = b->mem && b->bytes < n * size;
    return buffer_reserve(b, m->device, grows ? with_room(m, n * size) : (size_t)(n * size), err);
}

static bool copy(duet_motion *m, const buffer *from, const buffer *to, size_t bytes,
                 duet_error *err)
{
    cl_command_queue queue = m->device->queue;
    cl_int code = clEnqueueCopyBuffer(queue, from->mem, to->mem, 0, 0, bytes, 0, NULL, NULL);
    if (code == CL_SUCCESS)
        code = clFinish(queue);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: copying %zu bytes", m->device->info.selector, bytes);
}

bool motion_extend(duet_motion *m, motion_buffer which, size_t kept, size_t bytes, duet_error *err)
{
    buffer *b = &m->buffers[which], fresh = {0};
    if (b->bytes >= bytes)
        return true;
    bool ok = buffer_reserve(&fresh, m->device, kept > 0 ? with_room(m, bytes) : bytes, err) &&
              (kept == 0 || copy(m, b, &fresh, kept, err));
    if (ok)
        buffer_swap(b, &fresh);
    buffer_release(&fresh);
    return ok;
}

// New rows are 0.
static bool grow(duet_motion *m, motion_buffer which, uint32_t old_n, duet_error *err)
{
    size_t words = motion_words(m, which), row = words * sizeof(uint32_t);
    size_t bytes = ((size_t)m->n + FIXED) * row;
    return motion_extend(m, which, old_n * row, bytes, err) &&
           timeline_fill(&m->times, "clear", &m->buffers[which], 0, old_n * words,
                         bytes / sizeof(uint32_t), err);
}

bool motion_grow_rows(duet_motion *m, motion_buffer which, uint32_t old_n, duet_error *err)
{
    return motion_words(m, which) == 0 || grow(m, which, old_n, err);
}

bool motion_grow(duet_motion *m, uint32_t old_n, duet_error *err)
{
    bool ok = true;
    for (int which = 0; ok && which < MOTION_BUFFERS; ++which)
        ok = motion_grow_rows(m, (motion_buffer)which, old_n, err);
    return ok;
}

// ---------------------------------------------------------------- costs

// Bytes of state that an object has for an effect.
static uint32_t bytes_for(const duet_motion *m, uint32_t effect)
{
    uint32_t words = 0;
    for (int which = 0; which < MOTION_BUFFERS; ++which)
        if (by_object[which].effect == effect)
            words += motion_words(m, (motion_buffer)which);
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
    bool active = (m->effects & row->effect);
    *info = (duet_effect_info){
        .name = row->name,
        .active = active,
        .called_by = row->called_by,
        .kernels = row->kernels,
        .bytes = active ? bytes_for(m, row->effect) : 0,
    };
    return true;
}
