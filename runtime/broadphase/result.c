// SPDX-License-Identifier: MIT
// What a step hands out: its result, and the pairs on the host or, where the caller wants them
// there, in a buffer on a device.
#include "runtime/broadphase/pair_hash.h"
#include "runtime/broadphase/world.h"

#include "base/clock.h"
#include "base/error.h"

// ---------------------------------------------------------------- the result

static uint32_t largest(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static uint32_t smallest(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

// A part reports the bad objects of its own cells. Two slabs share no cells; two whole
// grids are identical.
static uint32_t count_bad(const duet_world *world)
{
    uint32_t a = world->parts[0].found.bad;
    uint32_t b = world->parts[1].found.bad;
    return world->def.plan.mode == DUET_MODE_SLAB ? a + b : largest(a, b);
}

bool world_check_bad(const duet_world *world, duet_error *err)
{
    const part *a = &world->parts[0];
    const part *b = &world->parts[1];
    uint32_t bad = count_bad(world);
    if (bad == 0 || world->def.keep_bad)
        return true;
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %u of %u is not a number, infinite, negative or without rotation "
                     "(%u such objects)",
                     smallest(a->found.first_bad, b->found.first_bad), world->n, bad);
}

static double kernel_ms(const part *p)
{
    return (double)(p->times.last_end - p->times.first_begin) * 1e-6;
}

void world_tell_result(duet_world *world, duet_result *result)
{
    const part *a = &world->parts[0];
    const part *b = &world->parts[1];
    uint32_t bad = count_bad(world);
    const grid_level *finest = &world->grid.levels[0];
    *result = (duet_result){
        .objects = world->n,
        .bad = bad,
        .first_bad = bad ? smallest(a->found.first_bad, b->found.first_bad) : 0,
        .candidates = a->n_candidates + b->n_candidates,
        .pairs = a->span.n + b->span.n,
        .spans = {a->span, b->span},
        .undecided = a->n_undecided + b->n_undecided,
        .device_ms = {a->wall_ms, b->wall_ms},
        .kernel_ms = {kernel_ms(a), kernel_ms(b)},
        .bytes = {part_bytes(a), part_bytes(b)},
        .cells = {(uint32_t)finest->cells.s[0], (uint32_t)finest->cells.s[1],
                  (uint32_t)finest->cells.s[2]},
        .grid_levels = world->grid.n_levels,
        .hashed = world->grid.kind == GRID_HASHED,
        .cell = world->grid.edge,
        .cell_widened = world->cell_widened,
        .runs = largest(a->runs, b->runs),
        .stages = world->stages,
        .timed = !a->times.untimed && !b->times.untimed,
    };
    if (world->left.device)
        result->spans[0].pairs = result->spans[1].pairs = NULL;
    for (int side = 0; side < 2; ++side) {
        const timeline *t = &world->parts[side].times;
        for (int i = 0; i < t->n_stages; ++i) {
            world->stages[result->n_stages] = t->stages[i];
            world->stages[result->n_stages++].device = side;
        }
    }
}

// ---------------------------------------------------------------- its pairs on the host

// Pairs as a set, whoever found them and in whatever order.
uint64_t duet_pairs_hash(const duet_pair *pairs, uint64_t n)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; pairs && i < n; ++i)
        sum += pair_hash((uint64_t)pairs[i].a << 32 | pairs[i].b);
    return sum;
}

uint64_t duet_result_get_hash(const duet_result *result)
{
    if (!result)
        return 0;
    return duet_pairs_hash(result->spans[0].pairs, result->spans[0].n) +
           duet_pairs_hash(result->spans[1].pairs, result->spans[1].n);
}

duet_pair duet_result_get_pair(const duet_result *result, uint64_t i)
{
    if (!result || i >= result->spans[0].n + result->spans[1].n)
        return (duet_pair){0, 0};
    bool of_a = i < result->spans[0].n;
    const duet_pair *pairs = result->spans[of_a ? 0 : 1].pairs;
    return pairs ? pairs[of_a ? i : i - result->spans[0].n] : (duet_pair){0, 0};
}

// ---------------------------------------------------------------- its pairs on a device

static bool check_space(const pair_buffers *b, uint64_t n, duet_error *err)
{
    return !b->pairs || n <= b->capacity ||
           error_set(err, DUET_STATUS_TOO_MANY,
                     "%llu pairs, and the caller's buffer holds %llu; expected one of %llu bytes",
                     (unsigned long long)n, (unsigned long long)b->capacity,
                     (unsigned long long)(n * sizeof(duet_pair)));
}

// The part whose own buffer can be shown as it is, because it has all pairs; or NULL.
static part *sole_finder(const pair_buffers *b, part parts[2])
{
    for (int i = 0; i < 2; ++i)
        if (!b->pairs && parts[i].device == b->device && parts[i].pairs.mem &&
            parts[1 - i].span.n == 0)
            return &parts[i];
    return NULL;
}

// What was decided on the host lies behind what the device found.
static bool show(pair_buffers *b, part *p, duet_error *err)
{
    b->last.pairs = p->pairs.mem;
    return !p->pairs.host || timeline_write(&p->times, "leave pairs", &p->pairs, p->pairs.host,
                                            (size_t)p->span.n * sizeof(duet_pair), err);
}

static bool copy_span(const pair_buffers *b, const part *p, bool kept, uint64_t before,
                      duet_error *err)
{
    size_t at = (size_t)before * sizeof(duet_pair), bytes = (size_t)p->span.n * sizeof(duet_pair);
    if (bytes == 0)
        return true;
    cl_command_queue queue = kept ? p->device->queue : b->device->queue;
    cl_int code =
        kept ? clEnqueueCopyBuffer(queue, p->pairs.mem, b->last.pairs, 0, at, bytes, 0, NULL, NULL)
             : clEnqueueWriteBuffer(queue, b->last.pairs, CL_FALSE, at, bytes, p->span.pairs, 0,
                                    NULL, NULL);
    cl_int finished = clFinish(queue);
    code = code != CL_SUCCESS ? code : finished;
    return code == CL_SUCCESS || error_set_cl(err, code, "%s: leaving %zu bytes of pairs",
                                              b->device->info.selector, bytes);
}

static bool gather(pair_buffers *b, const part parts[2], const bool kept[2], duet_error *err)
{
    if (!b->pairs &&
        !buffer_reserve(&b->own_pairs, b->device, (size_t)b->last.n * sizeof(duet_pair), err))
        return false;
    b->last.pairs = b->pairs ? b->pairs : b->own_pairs.mem;
    return copy_span(b, &parts[0], kept[0], 0, err) &&
           copy_span(b, &parts[1], kept[1], parts[0].span.n, err);
}

static bool write_count(pair_buffers *b, duet_error *err)
{
    cl_ulong n = b->last.n;
    b->last.count = b->count ? b->count : b->own_count.mem;
    cl_int code = clEnqueueWriteBuffer(b->device->queue, b->last.count, CL_TRUE, 0, sizeof n, &n, 0,
                                       NULL, NULL);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: leaving the number of pairs", b->device->info.selector);
}

const buffer *world_join_pairs(duet_world *world, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    pair_buffers *b = &world->left;
    part *parts = world->parts;
    b->last = (duet_pair_buffers){.n = parts[0].span.n + parts[1].span.n};
    part *sole = sole_finder(b, parts);
    bool ok = sole ? show(b, sole, err) : gather(b, parts, world->keeps_pairs, err);
    timeline_add_host(&parts[b->device == parts[1].device].times, "leave pairs",
                      clock_ms_since(begun));
    return !ok ? NULL : sole ? &sole->pairs : &b->own_pairs;
}

bool world_gather_pairs(duet_world *world, duet_error *err)
{
    const part *parts = world->parts;
    return check_space(&world->left, parts[0].span.n + parts[1].span.n, err) &&
           world_join_pairs(world, err) && write_count(&world->left, err);
}

bool world_clear_pairs(duet_world *world)
{
    pair_buffers *b = &world->left;
    b->last = (duet_pair_buffers){0};
    bool cleared = b->device && write_count(b, NULL);
    b->last = (duet_pair_buffers){0};
    return cleared;
}

void pair_buffers_drop(pair_buffers *b)
{
    mem_release(&b->pairs);
    mem_release(&b->count);
    buffer_release(&b->own_pairs);
    buffer_release(&b->own_count);
    *b = (pair_buffers){0};
}

bool duet_world_leave_pairs(duet_world *world, int side, cl_mem pairs, cl_mem count,
                            duet_error *err)
{
    if (!world_is_idle(world, __func__, err))
        return false;
    if (side != 0 && side != 1)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: device is %d; expected 0 for A, 1 for B", __func__, side);
    const device *devices = world->def.pair->devices;
    const buffer_need pairs_need = {__func__, "pairs", BUFFER_WRITTEN, sizeof(duet_pair)};
    const buffer_need count_need = {__func__, "count", BUFFER_WRITTEN, sizeof(cl_ulong)};
    bool has[2];
    if ((pairs && !callers_buffer_check(pairs, &pairs_need, devices, side, has, err)) ||
        (count && !callers_buffer_check(count, &count_need, devices, side, has, err)))
        return false;
    size_t bytes = 0;
    if (pairs)
        clGetMemObjectInfo(pairs, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    pair_buffers left = {.device = &devices[side], .capacity = bytes / sizeof(duet_pair)};
    if (!count && !buffer_reserve(&left.own_count, left.device, sizeof(cl_ulong), err))
        return false;
    left.pairs = callers_buffer_hold(pairs);
    left.count = callers_buffer_hold(count);
    pair_buffers_drop(&world->left);
    world->left = left;
    return true;
}

bool duet_world_bring_pairs(duet_world *world, duet_error *err)
{
    if (!world_is_idle(world, __func__, err))
        return false;
    pair_buffers_drop(&world->left);
    return true;
}

bool duet_world_get_pair_buffers(duet_world *world, duet_pair_buffers *buffers, duet_error *err)
{
    if (!world_is_idle(world, __func__, err) || !error_given(buffers, __func__, "buffers", err))
        return false;
    *buffers = world->left.last;
    return buffers->pairs ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%s: no step has left its pairs in a buffer; expected duet_world_leave_pairs, "
                     "then a step",
                     __func__);
}
