// SPDX-License-Identifier: MIT
// A device classifies objects that were prefetched, for a host that has to look at all others.
#include "runtime/broadphase/part.h"

#include <string.h>

// The kernel does not know origin cells, sizes that lie apart, and radii. It is built when it is
// first asked for.
static bool has_kernel(part *p, const duet_world_def *def, duet_error *err)
{
    const bool knows = (def->shape == DUET_SHAPE_POSES || def->shape == DUET_SHAPE_BOUNDS) &&
                       def->origin_edge == 0.0f && !def->separate_sizes;
    return knows && (p->kernels.skim || part_prepare_skim(p, err));
}

// The blocks of a chunk travel while the next one is on its way.
static bool skim_chunk(part *p, uint32_t from, uint32_t i, duet_error *err)
{
    const view_chunk *c = &p->objects.chunks[i];
    size_t at = from / SKIM_ROWS, end = ((size_t)c->to + SKIM_ROWS - 1) / SKIM_ROWS;
    p->args.skim_from = from;
    p->args.n = c->to;
    bool ok =
        timeline_launch_after(&p->times, "skim", p->kernels.skim, c->to - from, c->sent, p, err) &&
        timeline_start_read(&p->times, "fetch skim", &p->skimmed.blocks, at * sizeof(skim_block),
                            (skim_block *)p->skimmed.seen.bytes + at,
                            (end - at) * sizeof(skim_block), err);
    p->skimmed.done[i] = timeline_last_event(&p->times);
    return ok;
}

bool part_skim(part *p, const duet_world_def *def, const float inside_lower[3],
               const float inside_upper[3], duet_error *err)
{
    const device_view *v = &p->objects;
    if (!view_is_prefetched(v, v->generation) || !has_kernel(p, def, err))
        return false;
    uint32_t n = v->chunks[v->n_chunks - 1].to, from = 0;
    size_t bytes = ((size_t)n + SKIM_ROWS - 1) / SKIM_ROWS * sizeof(skim_block);
    bool ok = buffer_reserve(&p->skimmed.blocks, p->device, bytes, err) &&
              host_block_reserve(&p->skimmed.seen, p->device, 1, bytes, err);
    p->args = (part_args){.objects = v->own};
    memcpy(&p->args.inside_lower, inside_lower, 3 * sizeof *inside_lower);
    memcpy(&p->args.inside_upper, inside_upper, 3 * sizeof *inside_upper);
    for (uint32_t i = 0; ok && i < v->n_chunks; from = v->chunks[i++].to)
        ok = skim_chunk(p, from, i, err);
    return ok;
}

uint32_t part_await_skim(part *p, uint32_t from, const skim_block **blocks)
{
    uint32_t i = 0;
    while (i + 1 < p->objects.n_chunks && p->objects.chunks[i].to <= from)
        ++i;
    timeline_spin(&p->times, p->skimmed.done[i]);
    *blocks = p->skimmed.seen.bytes;
    return p->objects.chunks[i].to;
}
