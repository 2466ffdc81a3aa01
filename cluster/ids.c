// SPDX-License-Identifier: MIT
// If ranges overlap, each rank gets all ids of one piece of them, as a sample of all ranks' ids
// divides them, and looks for neighbours that are equal.
#include "cluster/ids.h"

#include "base/compare.h"
#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SAMPLES = 1 << 16, MOST_OF_RANK = 64 };

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

// How many of its own ids each rank tells all others: those without as many repeat theirs.
static int sample_size(const ranks *r)
{
    int each = MOST_SAMPLES / r->n;
    return each < 1 ? 1 : each < MOST_OF_RANK ? each : MOST_OF_RANK;
}

// sample [n of ranks][sample_size], of which ranks without ids have the greatest number: the last
// pieces then are short.
static void gather_sample(uint64_t *sample, ranks *r, const uint64_t *ids, uint32_t n)
{
    uint64_t own[MOST_OF_RANK];
    int each = sample_size(r);
    for (int i = 0; i < each; ++i)
        own[i] = n > 0 ? ids[(uint64_t)n * (uint64_t)i / (uint64_t)each] : UINT64_MAX;
    ranks_gather(r, own, sample, each * (int)sizeof *own);
    qsort(sample, (size_t)r->n * (size_t)each, sizeof *sample, compare_uint64);
}

// Its ids ascend, so those of a piece lie together, and the pieces in order.
static bool send_pieces(parcels *in, ranks *r, const uint64_t *sample, const uint64_t *ids,
                        uint32_t n, duet_error *err)
{
    parcels out = {0};
    bool ok = parcels_begin(&out, r, sizeof *ids, err);
    for (uint64_t q = 0, from = 0; ok && q < (uint64_t)r->n; ++q) {
        uint64_t to = n;
        if (q + 1 < (uint64_t)r->n)
            to = first_not_below(ids, n, sample[(q + 1) * (uint64_t)sample_size(r)]);
        out.counts[q] = to - from;
        from = to;
    }
    ok = ok && parcels_reserve(&out, r, NULL, err);
    if (ok && n > 0)
        memcpy(out.rows, ids, n * sizeof *ids);
    ok = ranks_exchange(r, ok, &out, in, err);
    parcels_end(&out);
    return ok;
}

// UINT64_MAX may be one: *none is 0 where there is one, else 1.
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
    return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "object %" PRIu64 " is there twice: on rank %" PRIu64 " and on rank %" PRIu64,
                     id, ends[0], UINT64_MAX - ends[1]);
}

static bool compare_all(ranks *r, uint64_t *sample, const uint64_t *ids, uint32_t n,
                        duet_error *err)
{
    parcels piece = {0};
    gather_sample(sample, r, ids, n);
    if (!send_pieces(&piece, r, sample, ids, n, err))
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
    size_t samples = (size_t)r->n * (size_t)sample_size(r);
    range own = {1, 0}, *all = malloc((size_t)r->n * sizeof *all);
    uint64_t *sample = malloc(samples * sizeof *sample);
    bool ok = (all && sample) ||
              error_set(err, DUET_STATUS_NO_MEMORY, "the ids of %d ranks: no memory", r->n);
    ok = ranks_agree(r, ok, err);
    if (n > 0)
        own = (range){ids[0], ids[n - 1]};
    if (ok) {
        ranks_gather(r, &own, all, sizeof own);
        ok = are_apart(all, r->n) || compare_all(r, sample, ids, n, err);
    }
    free(sample);
    free(all);
    return ok;
}
