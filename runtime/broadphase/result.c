// SPDX-License-Identifier: MIT
// Hands out what a step found: its result, and the pairs on the host or, if the caller wants them
// there, in a buffer on a device.
#include "runtime/broadphase/pair_hash.h"
#include "runtime/broadphase/world.h"

#include "base/clock.h"
#include "base/error.h"

// ---------------------------------------------------------------- what was found

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
    uint32_t a = world->parts[0].result.found.bad;
    uint32_t b = world->parts[1].result.found.bad;
    return world->def.plan.mode == DUET_MODE_SLAB ? a + b : largest(a, b);
}

// All but the times.
static duet_result describe_found(const duet_world *world)
{
    const part *a = &world->parts[0];
    const part *b = &world->parts[1];
    const grid_level *finest = &world->grid.levels[0];
    uint32_t bad = count_bad(world);
    bool left = world->left.device;
    return (duet_result){
        .objects = world->objects.all.n,
        .bad = bad,
        .first_bad = bad ? smallest(a->result.found.first_bad, b->result.found.first_bad) : 0,
        .candidates = a->result.n_candidates + b->result.n_candidates,
        .pairs = a->result.span.n + b->result.span.n,
        .spans = {{left ? NULL : a->result.span.pairs, a->result.span.n},
                  {left ? NULL : b->result.span.pairs, b->result.span.n}},
        .undecided = a->result.n_undecided + b->result.n_undecided,
        .device_ms = {a->result.wall_ms, b->result.wall_ms},
        .bytes = {a->bytes, b->bytes},
        .cells = {(uint32_t)finest->cells.s[0], (uint32_t)finest->cells.s[1],
                  (uint32_t)finest->cells.s[2]},
        .grid_levels = world->grid.n_levels,
        .hashed = world->grid.kind == GRID_HASHED,
        .cell = world->grid.edge,
        .cell_widened = world->def.cell > 0.0f && world->grid.widest > world->def.cell,
        .runs = largest(a->result.runs, b->result.runs),
        .stages = world->stages,
        .timed = !a->times.untimed && !b->times.untimed,
    };
}

static bool check_bad(const duet_world *world, const duet_result *found, duet_error *err)
{
    return found->bad == 0 || world->def.keep_bad ||
           error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %u of %u is not a number, infinite, negative or without rotation "
                     "(%u such objects)",
                     found->first_bad, world->objects.all.n, found->bad);
}

// ---------------------------------------------------------------- its pairs on a device

static bool check_space(const pair_buffers *b, duet_error *err)
{
    uint64_t n = b->last.n;
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
            parts[1 - i].result.span.n == 0)
            return &parts[i];
    return NULL;
}

// Into the caller's buffer or our own, A's first.
static bool gather(pair_buffers *b, const part parts[2], duet_error *err)
{
    if (!b->pairs &&
        !buffer_reserve(&b->own_pairs, b->device, (size_t)b->last.n * sizeof(duet_pair), err))
        return false;
    cl_mem to = b->pairs ? b->pairs : b->own_pairs.mem;
    cl_int code = CL_SUCCESS;
    size_t at = 0, bytes = 0;
    for (int side = 0; side < 2 && code == CL_SUCCESS; ++side, at += bytes) {
        const part *p = &parts[side];
        const bool kept = !p->result.span.pairs; // on its device
        bytes = (size_t)p->result.span.n * sizeof(duet_pair);
        if (bytes == 0)
            continue;
        cl_command_queue queue = kept ? p->device->queue : b->device->queue;
        code = kept ? clEnqueueCopyBuffer(queue, p->pairs.mem, to, 0, at, bytes, 0, NULL, NULL)
                    : clEnqueueWriteBuffer(queue, to, CL_FALSE, at, bytes, p->result.span.pairs, 0,
                                           NULL, NULL);
        cl_int finished = clFinish(queue);
        code = code != CL_SUCCESS ? code : finished;
    }
    return code == CL_SUCCESS || error_set_cl(err, code, "%s: leaving %zu bytes of pairs",
                                              b->device->info.selector, bytes);
}

// The buffer that has them all, a part's own if that can be.
static bool join_pairs(duet_world *world, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    pair_buffers *b = &world->left;
    part *parts = world->parts;
    part *sole = sole_finder(b, parts);
    bool ok = sole || gather(b, parts, err);
    b->joined = sole ? &sole->pairs : &b->own_pairs;
    if (sole && sole->pairs.host) // the device sees those that were decided there
        ok = timeline_write(&sole->times, "leave pairs", &sole->pairs, sole->pairs.host,
                            (size_t)b->last.n * sizeof(duet_pair), err);
    timeline_add_host(&parts[b->device == parts[1].device].times, "leave pairs",
                      clock_ms_since(begun));
    return ok;
}

// All in one buffer, and how many, 0 after a failure, if somebody wants the number.
static bool leave_pairs(duet_world *world, bool found, duet_error *err)
{
    pair_buffers *b = &world->left;
    b->last =
        (duet_pair_buffers){.count = b->count ? b->count : b->own_count.mem,
                            .n = world->parts[0].result.span.n + world->parts[1].result.span.n};
    bool ok = found && check_space(b, err) && join_pairs(world, err);
    cl_ulong n = ok ? b->last.n : 0;
    cl_int code = b->last.count ? clEnqueueWriteBuffer(b->device->queue, b->last.count, CL_TRUE, 0,
                                                       sizeof n, &n, 0, NULL, NULL)
                                : CL_SUCCESS;
    if (code != CL_SUCCESS)
        b->last.count = NULL;
    if (ok && code != CL_SUCCESS)
        ok = error_set_cl(err, code, "%s: leaving the number of pairs", b->device->info.selector);
    if (ok)
        b->last.pairs = b->pairs ? b->pairs : b->joined->mem;
    return ok;
}

// ---------------------------------------------------------------- the result

bool world_hand_out(duet_world *world, bool found, uint64_t begun, duet_result *result,
                    duet_error *err)
{
    duet_result handed = describe_found(world);
    found = found && check_bad(world, &handed, err);
    bool ok = world->left.device ? leave_pairs(world, found, err) : found;
    if (!found)
        return false;
    for (int side = 0; side < 2; ++side) {
        const timeline *t = &world->parts[side].times;
        handed.kernel_ms[side] = timeline_kernel_ms(t);
        handed.n_stages = timeline_list_stages(t, side, world->stages, handed.n_stages);
    }
    handed.total_ms = clock_ms_since(begun);
    *result = handed;
    return ok;
}

// ---------------------------------------------------------------- of pairs on the host

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

// ---------------------------------------------------------------- where pairs are left

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
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err))
        return false;
    if (side != 0 && side != 1)
        return bad_argument(err, "%s: device is %d; expected 0 for A, 1 for B", __func__, side);
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
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err))
        return false;
    pair_buffers_drop(&world->left);
    return true;
}

bool duet_world_get_pair_buffers(duet_world *world, duet_pair_buffers *buffers, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err) || !error_given(buffers, __func__, "buffers", err))
        return false;
    *buffers = world->left.last.pairs ? world->left.last : (duet_pair_buffers){0};
    return buffers->pairs || bad_argument(err,
                                          "%s: no step has left its pairs in a buffer; expected "
                                          "duet_world_leave_pairs, then a step",
                                          __func__);
}
