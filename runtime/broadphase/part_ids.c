// SPDX-License-Identifier: MIT
#include "runtime/broadphase/part_ids.h"

#include "base/compare.h"
#include "kernels/grid/pair_counts.h"

#include <stdlib.h>

// A row that kernels/grid/count_pairs.cl reads.
typedef struct id_change {
    uint32_t place;
    uint32_t low, high;
    uint32_t unused;
} id_change;

static bool has_id(const global_ids *ids, uint32_t place)
{
    return place < ids->n && (ids->n_without == 0 || !bsearch(&place, ids->without, ids->n_without,
                                                              sizeof place, compare_uint32));
}

// Lists each place once, or always with the same id: the kernel writes them in no order. After all
// ids were sent only those that objects do not have are changes.
static uint32_t list_changes(id_change *to, const global_ids *ids, uint64_t n_changed)
{
    uint32_t n = 0;
    for (uint64_t i = 0; i < n_changed; ++i) {
        uint32_t place = ids->changed[i];
        uint64_t id = place < ids->n ? ids->list[place] : 0;
        if (has_id(ids, place))
            to[n++] = (id_change){place, (uint32_t)id, (uint32_t)(id >> 32), 0};
    }
    for (uint32_t i = 0; i < ids->n_without; ++i)
        to[n++] = (id_change){ids->without[i], NO_GLOBAL_ID, NO_GLOBAL_ID, 0};
    return n;
}

static bool send_all(part *p, const global_ids *ids, duet_error *err)
{
    buffer *b = &p->global_ids.own;
    size_t bytes = ids->n * sizeof *ids->list;
    return (bytes <= b->bytes || buffer_reserve(b, p->device, bytes + bytes / 16, err)) &&
           timeline_write_at(&p->times, "send ids", b, 0, ids->list, bytes, err);
}

static bool send_changes(part *p, const global_ids *ids, uint64_t n_changed, duet_error *err)
{
    size_t most = ids->n_without + (size_t)n_changed;
    if (most == 0)
        return true;
    if (!host_block_reserve(&p->changes, p->device, 1, most * sizeof(id_change), err) ||
        !buffer_reserve(&p->id_changes, p->device, p->changes.size, err))
        return false;
    p->args.n_id_changes = list_changes(p->changes.bytes, ids, n_changed);
    return timeline_write_at(&p->times, "send ids", &p->id_changes, 0, p->changes.bytes,
                             p->args.n_id_changes * sizeof(id_change), err) &&
           timeline_launch(&p->times, "send ids", p->kernels.change_ids, p->args.n_id_changes, p,
                           err);
}

// A device that had no work missed changes that are no longer listed, so it is sent all ids.
bool part_update_ids(part *p, const global_ids *ids, duet_error *err)
{
    device_view *v = &p->global_ids;
    const uint64_t has = ids->n * sizeof *ids->list <= v->own.bytes ? v->generation : 0;
    if (ids->n == 0 || (has > 0 && has == ids->generation))
        return true;
    const bool follows =
        has > 0 && has + 1 == ids->generation && ids->n_changed > 0 && ids->n_changed <= ids->n / 4;
    v->generation = 0;
    bool ok = (follows || send_all(p, ids, err)) &&
              send_changes(p, ids, follows ? ids->n_changed : 0, err);
    v->generation = ok ? ids->generation : 0;
    return ok;
}
