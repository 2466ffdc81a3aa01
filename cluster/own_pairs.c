// SPDX-License-Identifier: MIT
#include "cluster/own_pairs.h"

#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>

typedef struct taking {
    const search_set *s;
    const worker_found *found;
    duet_pair64 *pairs;
    uint64_t counts[PARALLEL_MOST]; // each part's pairs, and then where they begin
    uint64_t hashes[PARALLEL_MOST];
} taking;

static inline duet_pair pair_at(const worker_found *found, uint64_t i)
{
    return i < found->spans[0].n ? found->spans[0].pairs[i]
                                 : found->spans[1].pairs[i - found->spans[0].n];
}

static inline duet_pair64 pair_of(const search_set *s, duet_pair p)
{
    uint64_t a = s->rows.ids[p.a], b = s->rows.ids[p.b];
    return a < b ? (duet_pair64){a, b} : (duet_pair64){b, a};
}

static void count_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    taking *t = context;
    uint64_t n = 0, hash = 0;
    for (uint64_t i = first; i < end; ++i) {
        duet_pair p = pair_at(t->found, i);
        if (!search_set_owns(t->s, p))
            continue;
        ++n;
        hash += pair64_hash(pair_of(t->s, p));
    }
    t->counts[part] = n;
    t->hashes[part] = hash;
}

static void take_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    taking *t = context;
    duet_pair64 *to = t->pairs + t->counts[part];
    for (uint64_t i = first; i < end; ++i) {
        duet_pair p = pair_at(t->found, i);
        if (search_set_owns(t->s, p))
            *to++ = pair_of(t->s, p);
    }
}

static bool reserve_pairs(own_pairs *own, uint64_t n, duet_error *err)
{
    if (own->pairs && n <= own->capacity)
        return true;
    uint64_t most = n + n / 16 + 1;
    duet_pair64 *pairs = realloc(own->pairs, most * sizeof *pairs);
    if (!pairs)
        return no_memory(err, "%" PRIu64 " pairs", n);
    own->pairs = pairs;
    own->capacity = most;
    return true;
}

bool own_pairs_add(own_pairs *own, const search_set *s, const worker_found *found, duet_error *err)
{
    uint64_t n = found->spans[0].n + found->spans[1].n, all = own->n;
    taking t = {.s = s, .found = found};
    uint32_t parts = parallel_each(s->owned->threads, n, count_part, &t);
    for (uint32_t i = 0; i < parts; ++i) {
        uint64_t own_n = t.counts[i];
        t.counts[i] = all;
        all += own_n;
        own->hash += t.hashes[i];
    }
    if (own->lists && !reserve_pairs(own, all, err))
        return false;
    t.pairs = own->pairs;
    if (own->lists)
        parallel_each(s->owned->threads, n, take_part, &t);
    own->n = all + found->n_counted;
    own->hash += found->hash;
    return true;
}

void own_pairs_begin(own_pairs *own, bool lists)
{
    own->n = own->hash = 0;
    own->lists = lists;
}

void own_pairs_end(own_pairs *own)
{
    free(own->pairs);
    *own = (own_pairs){0};
}
