// SPDX-License-Identifier: MIT
// A part's buffers, the arguments of its kernels, and its states.
#include "runtime/broadphase/part.h"

#include "runtime/opencl/device_pair.h"

#include <assert.h>
#include <stddef.h>

// A chunk is at least 5 MB: it travels for 0.1 ms, a launch takes some 3 microseconds.
enum { LEAST_CHUNK = 1 << 17 };

// The places of a part's buffers.
static const size_t buffers[] = {
    offsetof(part, objects.own), offsetof(part, objects.ids),    offsetof(part, sizes.own),
    offsetof(part, levels.own),  offsetof(part, global_ids.own), offsetof(part, keys),
    offsetof(part, ids),         offsetof(part, keys_spare),     offsetof(part, ids_spare),
    offsetof(part, counts),      offsetof(part, starts),         offsetof(part, bounds),
    offsetof(part, boxes),       offsetof(part, counters),       offsetof(part, next_counters),
    offsetof(part, candidates),  offsetof(part, pairs),          offsetof(part, undecided),
    offsetof(part, gathered),    offsetof(part, requests.words), offsetof(part, id_changes),
    offsetof(part, pair_counts), offsetof(part, left),           offsetof(part, interior.blocks),
    offsetof(part, edges)};

#define BUFFER(name, type, member) BIND_BUFFER(part, name, type, member)
#define VALUE(name) BIND_VALUE(part, #name, args.name)

// The arguments in kernels/grid and kernels/narrowphase. Bounds and boxes are
// laid out as the search asks for.
const binding part_bindings[] = {BUFFER("objects", "float *", args.objects),
                                 BUFFER("sizes", "float *", sizes.own),
                                 BUFFER("names", "uint *", objects.ids),
                                 BUFFER("levels", "grid_level *", levels.own),
                                 BUFFER("keys", "uint *", keys),
                                 BUFFER("ids", "uint *", ids),
                                 BUFFER("ranks", "uint *", keys_spare),
                                 BUFFER("counts", "uint *", counts),
                                 BUFFER("edges", "uint *", edges),
                                 BUFFER("others", "uint *", ids), // until they are sorted
                                 BUFFER("starts", "uint *", starts),
                                 BUFFER("key_starts", "uint *", starts),
                                 BUFFER("bounds", "float4 *", bounds),
                                 BUFFER("bounds", "float *", bounds),
                                 BUFFER("bounds_by_id", "float4 *", bounds),
                                 BUFFER("sorted_bounds", "float4 *", bounds),
                                 BUFFER("sorted_bounds", "float *", bounds),
                                 BUFFER("boxes", "float4 *", boxes),
                                 BUFFER("boxes", "float *", boxes),
                                 BUFFER("sorted_boxes", "float4 *", boxes),
                                 BUFFER("sorted_boxes", "float *", boxes),
                                 BUFFER("candidates", "uint2 *", candidates),
                                 BUFFER("found", "uint2 *", args.found),
                                 BUFFER("pairs", "uint2 *", pairs),
                                 BUFFER("undecided", "uint2 *", undecided),
                                 BUFFER("counters", "uint *", counters),
                                 BUFFER("next_counters", "uint *", next_counters),
                                 BUFFER("marks", "uint *", requests.words),
                                 BUFFER("blocks", "interior_block *", interior.blocks),
                                 BUFFER("global_ids", "uint2 *", global_ids.own),
                                 BUFFER("id_changes", "uint4 *", id_changes),
                                 BUFFER("pair_counts", "uint *", pair_counts),
                                 BUFFER("left", "uint2 *", left),
                                 BIND_VALUE(part, "stamp", requests.last.epoch),
                                 BIND_VALUE(part, "n_keys", args.n),
                                 BIND_VALUE(part, "place_capacity", place_capacity),
                                 VALUE(n),
                                 VALUE(n_levels),
                                 VALUE(n_cells),
                                 BIND_VALUE(part, "key_from", task.range.key_from),
                                 VALUE(n_hashed),
                                 BIND_VALUE(part, "key_home_to", task.range.home_to),
                                 VALUE(marked_from),
                                 VALUE(marked_to),
                                 BIND_VALUE(part, "key_to", task.range.key_to),
                                 VALUE(key_end),
                                 VALUE(n_home_cells),
                                 VALUE(n_own_cells),
                                 VALUE(n_counters),
                                 VALUE(n_counts),
                                 BIND_VALUE(part, "first", task.range.first),
                                 VALUE(last),
                                 VALUE(found_capacity),
                                 VALUE(candidate_capacity),
                                 VALUE(pair_capacity),
                                 VALUE(undecided_capacity),
                                 VALUE(interior_from),
                                 VALUE(inside_lower),
                                 VALUE(inside_upper),
                                 VALUE(n_owned),
                                 VALUE(n_id_changes),
                                 VALUE(left_capacity),
                                 VALUE(cells),
                                 {0}};

// In kernels/dynamics/read_rows.cl ids are those of the undecided pairs. Only the first of its two
// entries is launched.
const binding part_gather_bindings[] = {BUFFER("rows", "uint *", args.objects),
                                        BUFFER("ids", "uint *", undecided),
                                        BUFFER("gathered", "uint *", gathered),
                                        BUFFER("last_rows", "uint *", gathered),
                                        BUFFER("changed", "uint *", gathered),
                                        VALUE(row_words),
                                        VALUE(n_ids),
                                        VALUE(n),
                                        {0}};

bool part_open(part *p, const duet_device_pair *pair, int side, duet_error *err)
{
    const device *d = &pair->devices[side];
    *p = (part){.device = d,
                .devices = pair->devices,
                .side = side,
                .scan = {.device = d},
                .radix = {.device = d, .scan = &p->scan},
                .least_chunk = LEAST_CHUNK};
    p->gen = gen_open(pair->kernel_dir, err);
    p->programs = p->gen ? program_set_open(p->device, p->gen, &pair->builder, err) : NULL;
    p->limits = program_limits(&p->device->info);
    bool ok = p->programs &&
              buffer_reserve(&p->counters, p->device, COUNTERS * sizeof(uint32_t), err) &&
              buffer_reserve(&p->next_counters, p->device, COUNTERS * sizeof(uint32_t), err) &&
              buffer_reserve(&p->levels.own, p->device, sizeof((grid *)0)->levels, err);
    p->bytes = part_bytes(p);
    if (!ok)
        part_close(p);
    return ok;
}

void part_close(part *p)
{
    timeline_clear(&p->times);
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i)
        buffer_release((buffer *)((char *)p + buffers[i]));
    scan_close(&p->scan);
    radix_sort_close(&p->radix);
    host_block_release(&p->fetched);
    host_block_release(&p->early);
    host_block_release(&p->sent);
    host_block_release(&p->requests.on_host);
    host_block_release(&p->interior.on_host);
    host_block_release(&p->changes);
    program_set_close(p->programs);
    gen_close(p->gen);
    *p = (part){0};
}

// ---------------------------------------------------------------- states

void part_begin(part *p, const host_array *objects, uint64_t step)
{
    if (objects->n > 0 && view_is_prefetched(&p->objects) &&
        p->objects.generation == objects->generation)
        return;
    p->objects.n_chunks = 0;
    timeline_begin_step(&p->times, p->device, step);
    p->result = (part_result){.found.first_bad = UINT32_MAX};
}

void part_enter(part *p, part_state to)
{
    assert(p->state == PART_BEGUN || p->state == PART_HAS_GRID || to == PART_BEGUN);
    assert(to != PART_HAS_GRID || p->state == PART_BEGUN);
    assert(to != PART_DONE || p->state == PART_HAS_GRID);
    p->state = to;
}

void part_take(part *p, const part_task *task)
{
    part_enter(p, PART_BEGUN);
    p->err = (duet_error){0};
    p->task = *task;
}

void part_invalidate(part *p)
{
    device_view *views[] = {&p->objects, &p->sizes, &p->levels, &p->global_ids};
    timeline_clear(&p->times);
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i)
        view_forget(views[i]);
    p->zero_words = 0;
}

void part_forget_grid(part *p)
{
    view_forget(&p->levels);
    if (p->objects.there.kind == SELECT_LIST)
        view_forget(&p->objects);
}

uint64_t part_bytes(const part *p)
{
    uint64_t bytes = p->scan.sums.bytes + p->scan.told.bytes + p->radix.tiles.bytes;
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i)
        bytes += ((const buffer *)((const char *)p + buffers[i]))->bytes;
    return bytes;
}
