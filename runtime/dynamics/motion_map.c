// SPDX-License-Identifier: MIT
// Parts of a motion's state for the caller: in place, or in a buffer of the caller's.
#include "runtime/duet_motion_map.h"

#include "base/error.h"
#include "runtime/duet_opencl.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/motion_state.h"
#include "runtime/dynamics/motion_targets.h"
#include "runtime/opencl/callers_buffer.h"

#include <math.h>
#include <stdlib.h>

enum { PARTS = 4 };

struct motion_map {
    motion_rows rows;
    duet_map_access access;
    uint32_t n;
};

static const struct {
    motion_buffer which;
    uint32_t effect; // that the part needs
    uint32_t writes; // and that writing it does
} parts[PARTS] = {
    [DUET_STATE_CENTRES] = {CENTRES, 0, 0},
    [DUET_STATE_ROTATIONS] = {ROTATIONS, DUET_EFFECT_ROTATION, 0},
    [DUET_STATE_VELOCITIES] = {VELOCITIES, 0, DUET_EFFECT_MOTION},
    [DUET_STATE_ANGULAR_VELOCITIES] = {ANGULAR_VELOCITIES, DUET_EFFECT_ANGULAR_VELOCITY, 0},
};

static bool check_part(const duet_motion *m, duet_state_part part, const char *call,
                       duet_error *err)
{
    if (!duet_state_part_name(part))
        return bad_argument(err, "%s: part is %d; expected a duet_state_part", call, (int)part);
    if (part == DUET_STATE_CENTRES && m->cells)
        return bad_argument(err,
                            "%s: centres are in origin cells; expected duet_motion_get_states, or "
                            "duet_motion_set_poses",
                            call);
    return motion_needs(m, parts[part].effect, call, err);
}

// The buffers may go next, and host memory with them: no unmap is under way any more then.
void motion_forget_maps(duet_motion *m)
{
    const bool any = m->mapped != 0;
    for (int part = 0; m->maps && part < PARTS; ++part)
        motion_rows_drop(&m->maps[part].rows);
    free(m->maps);
    m->maps = NULL;
    m->mapped = 0;
    if (any)
        clFinish(m->device->queue);
}

// ---------------------------------------------------------------- begin

static bool begin_maps(duet_motion *m, duet_error *err)
{
    if (!m->maps)
        m->maps = calloc(PARTS, sizeof *m->maps);
    return m->maps || no_memory(err, "mapped states");
}

// Other parts may be mapped.
static bool can_map(duet_motion *m, duet_state_part part, duet_map_access access, const char *call,
                    duet_error *err)
{
    if (!motion_is_steady(m, call, err) || !check_part(m, part, call, err))
        return false;
    if (access != DUET_MAP_READ && access != DUET_MAP_WRITE)
        return bad_argument(err, "%s: access is %d; expected a duet_map_access", call, (int)access);
    if (m->mapped & 1u << part)
        return bad_argument(err, "%s: %s are mapped already", call, duet_state_part_name(part));
    if (access == DUET_MAP_WRITE && m->recording)
        return bad_argument(err,
                            "%s: what is written in place is not recorded; expected "
                            "duet_motion_set_poses or duet_motion_set_bodies",
                            call);
    return access == DUET_MAP_READ ||
           (motion_needs(m, parts[part].writes, call, err) && motion_begin_commands(m, err));
}

// Bodies that are written to stand still where a target was to take them.
static bool forget_targets(duet_motion *m, uint32_t first, uint32_t n, duet_error *err)
{
    if (m->commands->n_targets == 0)
        return true;
    uint32_t *places = malloc((size_t)n * sizeof *places + 1);
    if (!places)
        return no_memory(err, "%u places", n);
    for (uint32_t i = 0; i < n; ++i)
        places[i] = first + i;
    bool ok = motion_forget_targets(m, places, n, err);
    free(places);
    return ok;
}

void *duet_motion_map_states(duet_motion *m, duet_state_part part, duet_map_access access,
                             uint32_t first, uint32_t n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!can_map(m, part, access, __func__, err) || !motion_has_range(m, first, n, __func__, err) ||
        !begin_maps(m, err) || !timeline_finish(&m->times, err))
        return NULL;
    if (access == DUET_MAP_WRITE && !forget_targets(m, first, n, err))
        return NULL;
    struct motion_map *map = &m->maps[part];
    if (!motion_rows_open(m, parts[part].which, first, first + n, &map->rows, err))
        return NULL;
    motion_note_map(m, part);
    map->access = access;
    map->n = n;
    return map->rows.bytes;
}

// ---------------------------------------------------------------- end

static const char *fault_of(const duet_motion *m, duet_state_part part, const motion_rows *rows,
                            uint32_t place)
{
    bool turns = part == DUET_STATE_ROTATIONS;
    double norm = 0;
    for (uint32_t k = 0; k < (turns ? 4u : 3u); ++k) {
        double number = motion_row_get(rows, place, k);
        bool counts = m->def.dims == 3 || (part == DUET_STATE_CENTRES || !turns ? k < 2 : k >= 2);
        counts |= part == DUET_STATE_ANGULAR_VELOCITIES && k == 2;
        if (counts && !isfinite(number))
            return "a number of it is not finite";
        norm += counts ? number * number : 0.0;
    }
    return turns && !(norm > 0.0 && isfinite(norm)) ? "it is no rotation" : NULL;
}

static bool check_rows(const duet_motion *m, duet_state_part part, const struct motion_map *map,
                       const char *call, duet_error *err)
{
    for (uint32_t i = 0; i < map->n; ++i) {
        const char *fault = fault_of(m, part, &map->rows, map->rows.first + i);
        if (fault)
            return error_set(err, DUET_STATUS_BAD_OBJECT, "%s: row %u of %u of the %s: %s", call, i,
                             map->n, duet_state_part_name(part), fault);
    }
    return true;
}

// A rotation that is one up to rounding stays as it is, bit for bit.
static void settle_rotation(const duet_motion *m, const motion_rows *rows, uint32_t place)
{
    const double near = rows->doubles ? 0x1p-40 : 0x1p-16;
    double q[4], norm = 0;
    for (uint32_t k = 0; k < 4; ++k) {
        q[k] = m->def.dims == 3 || k >= 2 ? motion_row_get(rows, place, k) : 0.0;
        norm += q[k] * q[k];
    }
    double length = fabs(norm - 1.0) <= near ? 1.0 : sqrt(norm);
    for (uint32_t k = 0; k < 4; ++k)
        motion_row_set(rows, place, k, q[k] / length);
}

// Sets the numbers that are not the caller's to write as the motion has them.
static void settle_numbers(const duet_motion *m, duet_state_part part, const motion_rows *rows,
                           uint32_t place)
{
    bool moves = part != DUET_STATE_CENTRES, hidden = motion_is_hidden(m, place);
    bool turns = part == DUET_STATE_ANGULAR_VELOCITIES;
    for (uint32_t k = 0; k < 3; ++k)
        if ((moves && hidden) || (m->def.dims == 2 && (turns ? k < 2 : k == 2)))
            motion_row_set(rows, place, k, 0.0);
    float mass = part == DUET_STATE_VELOCITIES && !hidden ? m->bodies[place].mass : 0.0f;
    motion_row_set(rows, place, 3, mass > 0.0f ? 1.0 / mass : 0.0);
}

static uint32_t *settle(const duet_motion *m, duet_state_part part, const struct motion_map *map,
                        uint32_t *n_awake, duet_error *err)
{
    uint32_t *awake = malloc((size_t)map->n * sizeof *awake + 1);
    *n_awake = 0;
    if (!awake)
        no_memory(err, "%u places", map->n);
    for (uint32_t i = 0; awake && i < map->n; ++i) {
        uint32_t place = map->rows.first + i;
        if (part == DUET_STATE_ROTATIONS)
            settle_rotation(m, &map->rows, place);
        else
            settle_numbers(m, part, &map->rows, place);
        if (!motion_is_hidden(m, place))
            awake[(*n_awake)++] = place;
    }
    return awake;
}

// A part that cannot be written stays mapped.
static bool write_back(duet_motion *m, duet_state_part part, struct motion_map *map,
                       const char *call, duet_error *err)
{
    uint32_t n = 0;
    uint32_t *awake = check_rows(m, part, map, call, err) ? settle(m, part, map, &n, err) : NULL;
    bool ok =
        awake && motion_keep_whole(m, (map->n == 0 || motion_rows_close(m, &map->rows, err)) &&
                                          motion_wake_places(m, awake, n, err));
    free(awake);
    return ok;
}

bool duet_motion_unmap_states(duet_motion *m, duet_state_part part, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_steady(m, __func__, err))
        return false;
    if (!duet_state_part_name(part) || !(m->mapped & 1u << part))
        return bad_argument(err, "%s: %s are not mapped; expected duet_motion_map_states first",
                            __func__,
                            duet_state_part_name(part) ? duet_state_part_name(part) : "states");
    struct motion_map *map = &m->maps[part];
    bool ok = map->access == DUET_MAP_READ || write_back(m, part, map, __func__, err);
    if (!ok && m->phase != MOTION_BROKEN)
        return false;
    motion_rows_drop(&map->rows);
    *map = (struct motion_map){0};
    motion_note_unmap(m, part);
    return ok;
}

// ---------------------------------------------------------------- in a buffer of the caller's

static bool check_events(cl_mem rows, cl_uint n, const cl_event *events, const char *call,
                         duet_error *err)
{
    cl_context context = NULL;
    clGetMemObjectInfo(rows, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    return callers_events_check(n, events, context, call, err);
}

// The motion's queue runs in order, so that later steps follow the copy.
static bool copy_rows(duet_motion *m, const buffer *from, cl_mem to, size_t bytes, cl_event *done,
                      duet_error *err)
{
    const device *d = m->device;
    cl_int code = bytes == 0
                      ? clEnqueueMarkerWithWaitList(d->queue, 0, NULL, done)
                      : clEnqueueCopyBuffer(d->queue, from->mem, to, 0, 0, bytes, 0, NULL, done);
    if (code == CL_SUCCESS)
        code = done ? clFlush(d->queue) : clFinish(d->queue);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: copying %zu bytes of states", d->info.selector, bytes);
}

bool duet_motion_copy_states(duet_motion *m, duet_state_part part, cl_mem rows, cl_uint n_events,
                             const cl_event *events, cl_event *done, duet_error *err)
{
    PUBLIC_CALL(err);
    bool has[2];
    callers_events ready = {0};
    if (done)
        *done = NULL;
    if (!motion_is_whole(m, __func__, err) || !check_part(m, part, __func__, err))
        return false;
    const motion_buffer which = parts[part].which;
    const size_t bytes = (size_t)m->n * motion_words(m, which) * sizeof(cl_uint);
    const buffer_need need = {__func__, "rows", BUFFER_WRITTEN, bytes};
    bool ok = callers_buffer_check(rows, &need, m->def.pair->devices, 1, has, err) &&
              check_events(rows, n_events, events, __func__, err) &&
              callers_events_hold(&ready, n_events, events, err) &&
              callers_events_wait(&ready, "the states", err) && timeline_finish(&m->times, err) &&
              copy_rows(m, &m->buffers[which], rows, bytes, done, err);
    callers_events_release(&ready);
    return ok;
}
