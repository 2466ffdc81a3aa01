// SPDX-License-Identifier: MIT
#include "cluster/found.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <inttypes.h>
#include <stdlib.h>

// ---------------------------------------------------------------- what is seen

// The rank that sent each message is known by the message's place.
static int sender(const parcels *ghosts, uint64_t place)
{
    int rank = 0;
    while (place >= ghosts->counts[rank])
        place -= ghosts->counts[rank++];
    return rank;
}

static uint32_t key_of_home(const homes *h, const ranks *r, uint64_t home)
{
    return 2 * owner_key(h->levels[home], r->self, r->n) + 1;
}

static uint32_t key_of_ghost(const homes *h, const ranks *r, const parcels *ghosts, uint64_t place,
                             const void *object)
{
    reach e = reach_of(&h->form, object);
    int level = level_of(reach_widest(&e), h->widest);
    return 2 * owner_key(level, sender(ghosts, place), r->n);
}

static bool reserve(seen *s, uint64_t n, duet_error *err)
{
    seen_end(s);
    s->ids = malloc((n + 1) * sizeof *s->ids);
    s->keys = malloc((n + 1) * sizeof *s->keys);
    return (s->ids && s->keys) ||
           error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects and ghosts: no memory", n);
}

bool seen_fill(seen *s, const homes *h, const ranks *r, const parcels *ghosts, worker *w,
               duet_error *err)
{
    uint64_t n = h->rows.n + ghosts->n;
    if (n > UINT32_MAX - 1)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%u objects and %" PRIu64 " ghosts on one rank; expected more ranks",
                         h->rows.n, ghosts->n);
    uint64_t *sources = malloc((n + 1) * sizeof *sources);
    arrival *arrivals = arrivals_sort(&h->form, ghosts->rows, ghosts->n, err);
    object_rows rows = {0};
    bool ok = sources || error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects: no memory", n);
    ok = ok && arrivals && reserve(s, n, err);
    rows.ids = s->ids;
    rows.objects = ok ? w->map(w, (uint32_t)n, err) : NULL;
    ok = ok && rows.objects;
    ok =
        ok && object_rows_merge(&rows, &h->form, &h->rows, NULL, arrivals, ghosts->n, sources, err);
    s->n = ok ? rows.n : 0;
    for (uint32_t i = 0; i < s->n; ++i)
        s->keys[i] = sources[i] < h->rows.n ? key_of_home(h, r, sources[i])
                                            : key_of_ghost(h, r, ghosts, sources[i] - h->rows.n,
                                                           object_row(&rows, &h->form, i));
    free(arrivals);
    free(sources);
    return ok;
}

void seen_end(seen *s)
{
    free(s->ids);
    free(s->keys);
    *s = (seen){0};
}

// ---------------------------------------------------------------- pairs

static uint64_t mix(uint64_t key)
{
    key *= 0x9E3779B97F4A7C15u;
    key ^= key >> 29;
    key *= 0xBF58476D1CE4E5B9u;
    key ^= key >> 32;
    return key;
}

uint64_t pair64_hash(duet_pair64 pair)
{
    uint64_t low = (pair.a << 32) | (pair.b & UINT32_MAX);
    uint64_t high = (pair.a >> 32 << 32) | (pair.b >> 32);
    return mix(low ^ mix(high)); // mix(0) is 0
}

static bool is_own(const seen *s, duet_pair pair)
{
    uint32_t a = s->keys[pair.a], b = s->keys[pair.b];
    return (a < b ? a : b) & 1;
}

static void take_span(own_pairs *own, const seen *s, duet_span span)
{
    for (uint64_t i = 0; i < span.n; ++i) {
        if (!is_own(s, span.pairs[i]))
            continue;
        duet_pair64 pair = {s->ids[span.pairs[i].a], s->ids[span.pairs[i].b]};
        own->pairs[own->n++] = pair;
        own->hash += pair64_hash(pair);
    }
}

bool own_pairs_take(own_pairs *own, const seen *s, const worker_found *found, duet_error *err)
{
    uint64_t n = found->spans[0].n + found->spans[1].n;
    own_pairs_end(own);
    own->pairs = malloc((n + 1) * sizeof *own->pairs);
    if (!own->pairs)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " pairs: no memory", n);
    take_span(own, s, found->spans[0]);
    take_span(own, s, found->spans[1]);
    return true;
}

void own_pairs_end(own_pairs *own)
{
    free(own->pairs);
    *own = (own_pairs){0};
}
