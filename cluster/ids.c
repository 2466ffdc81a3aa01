// SPDX-License-Identifier: MIT
// If the ranges of ranks overlap, a hash of each id names the rank that gets it from all others,
// and looks for equal ones.
#include "cluster/ids.h"

#include "base/compare.h"
#include "base/error.h"
#include "cluster/parcels.h"
#include "runtime/broadphase/pair_hash.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

// A rank without ids has first above last.
typedef struct range {
    uint64_t first, last;
} range;

// ---------------------------------------------------------------- ranges

static int by_first(const void *left, const void *right)
{
    return compare_uint64(&((const range *)left)->first, &((const range *)right)->first);
}

static bool are_apart(range *all, int n)
{
    const range *before = NULL;
    bool apart = true;
    qsort(all, (size_t)n, sizeof *all, by_first);
    for (int q = 0; q < n; ++q) {
        if (all[q].first > all[q].last)
            continue;
        apart = apart && !(before && before->last >= all[q].first);
        before = &all[q];
    }
    return apart;
}

// ---------------------------------------------------------------- pieces

static uint64_t first_not_below(const uint64_t *ids, uint64_t n, uint64_t id)
{
    uint64_t first = 0, last = n;
    while (first < last) {
        uint64_t middle = first + (last - first) / 2;
        if (ids[middle] < id)
            first = middle + 1;
        else
            last = middle;
    }
    return first;
}

// Ids that are dealt out among so many ranks.
typedef struct dealing {
    const uint64_t *ids;
    uint64_t n_ranks;
} dealing;

static int rank_of(const void *context, uint64_t i)
{
    const dealing *d = context;
    return (int)(pair_hash(d->ids[i]) % d->n_ranks);
}

// UINT64_MAX may be one: *none is 0 if there is one, else 1.
static void find_double(parcels *piece, uint64_t *none, uint64_t *id)
{
    uint64_t *ids = piece->rows;
    *none = 1;
    *id = UINT64_MAX;
    qsort(ids, piece->n, sizeof *ids, compare_uint64);
    for (uint64_t i = 1; *none && i < piece->n; ++i)
        if (ids[i] == ids[i - 1]) {
            *none = 0;
            *id = ids[i];
        }
}

// ---------------------------------------------------------------- the line

static bool refuse(ranks *r, uint64_t id, const uint64_t *ids, uint32_t n, duet_error *err)
{
    uint64_t at = first_not_below(ids, n, id), self = (uint64_t)r->self;
    bool has = at < n && ids[at] == id;
    uint64_t ends[2] = {has ? self : UINT64_MAX, has ? UINT64_MAX - self : UINT64_MAX};
    ranks_least(r, ends, 2);
    return bad_argument(
        err, "object %" PRIu64 " is there twice: on rank %" PRIu64 " and on rank %" PRIu64, id,
        ends[0], UINT64_MAX - ends[1]);
}

static bool compare_all(ranks *r, const uint64_t *ids, uint32_t n, duet_error *err)
{
    parcels piece = {0};
    const dealing d = {ids, (uint64_t)r->n};
    const parcels_def out = {
        .n = n, .row_bytes = sizeof *ids, .rows = ids, .rank_of = rank_of, .context = &d};
    if (!parcels_deal(r, true, &out, &piece, err))
        return false;
    uint64_t none_and_id[2];
    find_double(&piece, &none_and_id[0], &none_and_id[1]);
    parcels_end(&piece);
    ranks_least(r, none_and_id, 2);
    return none_and_id[0] == 1 || refuse(r, none_and_id[1], ids, n, err);
}

bool ids_are_distinct(ranks *r, const uint64_t *ids, uint32_t n, duet_error *err)
{
    if (r->n == 1)
        return true;
    range own = {1, 0}, *all = malloc((size_t)r->n * sizeof *all);
    bool ok = all || no_memory(err, "the ids of %d ranks", r->n);
    ok = ranks_agree(r, ok, err);
    if (n > 0)
        own = (range){ids[0], ids[n - 1]};
    if (ok) {
        ranks_gather(r, &own, all, sizeof own);
        ok = are_apart(all, r->n) || compare_all(r, ids, n, err);
    }
    free(all);
    return ok;
}
