// SPDX-License-Identifier: MIT
// A device keeps the ids from step to step and is sent only those that changed.
#include "runtime/broadphase/pair_count.h"

#include "base/compare.h"
#include "base/error.h"
#include "kernels/grid/pair_counts.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- ids

// As kernels/grid/count_pairs.cl reads it.
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

// Each place once, or always with the same id: they are written in no order.
static uint32_t list_changes(id_change *to, const global_ids *ids, bool all_sent)
{
    uint32_t n = 0;
    for (uint64_t i = 0; !all_sent && i < ids->n_changed; ++i) {
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
    size_t bytes = ids->n * sizeof *ids->list;
    if (bytes > p->global_ids.bytes &&
        !buffer_reserve(&p->global_ids, p->device, bytes + bytes / 16, err))
        return false;
    return timeline_write_at(&p->times, "send ids", &p->global_ids, 0, ids->list, bytes, err);
}

static bool send_changes(part *p, const global_ids *ids, bool all_sent, duet_error *err)
{
    size_t most = ids->n_without + (all_sent ? 0 : (size_t)ids->n_changed);
    if (most == 0)
        return true;
    if (!host_block_reserve(&p->changes, p->device, 1, most * sizeof(id_change), err) ||
        !buffer_reserve(&p->id_changes, p->device, p->changes.size, err))
        return false;
    p->args.n_id_changes = list_changes(p->changes.bytes, ids, all_sent);
    return timeline_write_at(&p->times, "send ids", &p->id_changes, 0, p->changes.bytes,
                             p->args.n_id_changes * sizeof(id_change), err) &&
           timeline_launch(&p->times, "send ids", p->kernels.change_ids, p->args.n_id_changes, p,
                           err);
}

// What a device missed while it had no work is in no list any more.
bool part_send_ids(part *p, const global_ids *ids, duet_error *err)
{
    bool has_some = p->ids_version > 0 && ids->n * sizeof *ids->list <= p->global_ids.bytes;
    if (ids->n == 0 || (has_some && p->ids_version == ids->version))
        return true;
    bool follows = has_some && p->ids_version == ids->before && !ids->all_changed &&
                   ids->n_changed < ids->n / 4;
    p->ids_version = 0;
    bool ok = (follows || send_all(p, ids, err)) && send_changes(p, ids, !follows, err);
    p->ids_version = ok ? ids->version : 0;
    return ok;
}

// ---------------------------------------------------------------- pairs

// It reads itself how many pairs there are, and counts those that had a place.
bool part_count_pairs(part *p, duet_error *err)
{
    return timeline_fill(&p->times, "count pairs", &p->pair_counts, 0, 0, PAIR_COUNTS, err) &&
           timeline_launch(&p->times, "count pairs", p->kernels.count_pairs, p->args.pair_capacity,
                           p, err);
}

// Those that the host decided stand at the span's end, and nowhere else.
bool part_bring_counted(part *p, duet_error *err)
{
    uint64_t n = p->found.pairs, n_decided = p->span.n - p->counted.left;
    if (p->counted.n == 0)
        return true;
    duet_pair *decided = malloc((size_t)n_decided * sizeof *decided + 1);
    if (!decided)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%llu pairs: no memory",
                         (unsigned long long)n_decided);
    if (n_decided > 0)
        memcpy(decided, p->span.pairs + p->counted.left, (size_t)n_decided * sizeof *decided);
    bool ok = host_block_reserve(&p->fetched, p->device, 1,
                                 (size_t)(n + n_decided) * sizeof *decided, err) &&
              timeline_read(&p->times, "fetch pairs", &p->pairs, p->fetched.bytes,
                            (size_t)n * sizeof *decided, err) &&
              timeline_finish(&p->times, err);
    duet_pair *all = p->fetched.bytes;
    if (ok && n_decided > 0)
        memcpy(all + n, decided, (size_t)n_decided * sizeof *decided);
    free(decided);
    p->span = ok ? (duet_span){all, n + n_decided} : (duet_span){0};
    p->counted = (part_counted){0};
    return ok;
}
