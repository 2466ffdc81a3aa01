// SPDX-License-Identifier: MIT
#include "cluster/found.h"

#include "base/error.h"
#include "cluster/owner.h"
#include "runtime/broadphase/pair_hash.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- what is seen

// The rank that sent each message is known by the message's place.
static int sender(const parcels *ghosts, uint64_t place)
{
    int rank = 0;
    while (place >= ghosts->counts[rank])
        place -= ghosts->counts[rank++];
    return rank;
}

static uint32_t key_of(const seen *s, const void *object, int rank)
{
    reach e = reach_of(&s->homes->form, object);
    return owner_key(level_of(reach_widest(&e), s->homes->widest), rank, s->n_ranks);
}

static bool reserve(seen *s, uint64_t n, uint64_t n_ghosts, duet_error *err)
{
    if (!s->is_ghost || n > s->capacity || n_ghosts > s->ghost_capacity) {
        seen_end(s);
        s->capacity = n + n / 16;
        s->ghost_capacity = n_ghosts + n_ghosts / 4;
        s->rows.ids = malloc((s->capacity + 1) * sizeof *s->rows.ids);
        s->is_ghost = malloc(s->capacity / 8 + 1);
        s->ghosts = malloc((s->ghost_capacity + 1) * sizeof *s->ghosts);
    }
    if (!s->rows.ids || !s->is_ghost || !s->ghosts) {
        seen_end(s);
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects and ghosts: no memory",
                         n);
    }
    memset(s->is_ghost, 0, n / 8 + 1);
    return true;
}

typedef struct filling {
    seen *s;
    const homes *h;
    const parcels *messages;
    const arrival *arrivals;
    duet_error errors[PARALLEL_MOST];
} filling;

// The first ghost whose id is not below that of a home.
static uint64_t ghosts_before(const filling *f, uint64_t home)
{
    uint64_t first = 0, last = f->messages->n;
    if (home >= f->h->rows.n)
        return last;
    while (first < last) {
        uint64_t middle = first + (last - first) / 2;
        if (f->arrivals[middle].id < f->h->rows.ids[home])
            first = middle + 1;
        else
            last = middle;
    }
    return first;
}

// Homes [first, end) and the ghosts between the first of them and the home after the last.
static void fill_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    filling *f = context;
    const object_form *form = &f->h->form;
    uint64_t ghost = first == 0 ? 0 : ghosts_before(f, first);
    uint64_t last_ghost = ghosts_before(f, end);
    // A view of these rows alone, which begins where they do.
    object_rows part_rows = {.ids = f->h->rows.ids + first,
                             .objects = object_row(&f->h->rows, form, (uint32_t)first),
                             .n = (uint32_t)(end - first)};
    object_rows to = {.ids = f->s->rows.ids + first + ghost,
                      .objects = object_row(&f->s->rows, form, (uint32_t)(first + ghost))};
    if (!object_rows_merge(&to, form, &part_rows, NULL, 0, f->arrivals + ghost, last_ghost - ghost,
                           &f->errors[part]))
        return;
    uint32_t at = 0;
    for (uint64_t k = ghost; k < last_ghost; ++k) {
        at = object_rows_find(&to, at, to.n, f->arrivals[k].id);
        f->s->ghosts[k] = (seen_ghost){
            (uint32_t)(first + ghost) + at,
            key_of(f->s, f->arrivals[k].object, sender(f->messages, f->arrivals[k].place))};
    }
}

bool seen_fill(seen *s, const homes *h, const ranks *r, const parcels *ghosts, worker *w,
               duet_error *err)
{
    uint64_t n = h->rows.n + ghosts->n;
    if (n > UINT32_MAX - 1)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%u objects and %" PRIu64 " ghosts on one rank; expected more ranks",
                         h->rows.n, ghosts->n);
    filling *f = calloc(1, sizeof *f);
    arrival *arrivals = arrivals_read(&h->form, ghosts->rows, ghosts->n, err);
    bool ok = f || error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects: no memory", n);
    ok = ok && arrivals && reserve(s, n, ghosts->n, err);
    if (ok) {
        s->homes = h;
        s->self = r->self;
        s->n_ranks = r->n;
        s->rows.objects = w->map(w, (uint32_t)n, err);
        ok = s->rows.objects;
    }
    if (ok) {
        *f = (filling){.s = s, .h = h, .messages = ghosts, .arrivals = arrivals};
        uint32_t parts = parallel_each(h->threads, h->rows.n, fill_part, f);
        for (uint32_t i = 0; ok && i < parts; ++i)
            ok = f->errors[i].status == DUET_STATUS_OK ||
                 error_set(err, f->errors[i].status, "%s", f->errors[i].text);
    }
    if (ok) {
        s->rows.n = (uint32_t)n;
        s->n_ghosts = ghosts->n;
    }
    for (uint64_t k = 0; ok && k < s->n_ghosts; ++k)
        s->is_ghost[s->ghosts[k].place / 8] |= (uint8_t)(1u << s->ghosts[k].place % 8);
    free(arrivals);
    free(f);
    return ok;
}

void seen_end(seen *s)
{
    free(s->rows.ids);
    free(s->is_ghost);
    free(s->ghosts);
    *s = (seen){0};
}

// ---------------------------------------------------------------- pairs

uint64_t pair64_hash(duet_pair64 pair)
{
    uint64_t low = (pair.a << 32) | (pair.b & UINT32_MAX);
    uint64_t high = (pair.a >> 32 << 32) | (pair.b >> 32);
    return pair_hash(low ^ pair_hash(high));
}

static bool is_ghost(const seen *s, uint32_t place)
{
    return s->is_ghost[place / 8] >> place % 8 & 1;
}

static uint32_t key_of_ghost(const seen *s, uint32_t place)
{
    uint64_t first = 0, last = s->n_ghosts;
    while (last - first > 1) {
        uint64_t middle = first + (last - first) / 2;
        if (s->ghosts[middle].place <= place)
            first = middle;
        else
            last = middle;
    }
    return s->ghosts[first].key;
}

// The object with the lesser key is at home. Two homes need no keys, and two ghosts have none.
static bool is_own(const seen *s, duet_pair pair)
{
    bool a = is_ghost(s, pair.a), b = is_ghost(s, pair.b);
    if (a == b)
        return !a;
    uint32_t home = a ? pair.b : pair.a, ghost = a ? pair.a : pair.b;
    return key_of(s, object_row(&s->rows, &s->homes->form, home), s->self) < key_of_ghost(s, ghost);
}

typedef struct taking {
    const seen *s;
    const worker_found *found;
    duet_pair64 *pairs;
    uint64_t counts[PARALLEL_MOST]; // of each part, and then where its pairs begin
    uint64_t hashes[PARALLEL_MOST];
} taking;

static duet_pair pair_at(const worker_found *found, uint64_t i)
{
    return i < found->spans[0].n ? found->spans[0].pairs[i]
                                 : found->spans[1].pairs[i - found->spans[0].n];
}

static void count_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    taking *t = context;
    uint64_t n = 0;
    for (uint64_t i = first; i < end; ++i)
        n += is_own(t->s, pair_at(t->found, i));
    t->counts[part] = n;
}

static void take_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    taking *t = context;
    duet_pair64 *to = t->pairs + t->counts[part];
    uint64_t hash = 0;
    for (uint64_t i = first; i < end; ++i) {
        duet_pair p = pair_at(t->found, i);
        if (!is_own(t->s, p))
            continue;
        *to = (duet_pair64){t->s->rows.ids[p.a], t->s->rows.ids[p.b]};
        hash += pair64_hash(*to++);
    }
    t->hashes[part] = hash;
}

bool own_pairs_take(own_pairs *own, const seen *s, const worker_found *found, duet_error *err)
{
    uint64_t n = found->spans[0].n + found->spans[1].n;
    taking t = {.s = s, .found = found};
    own->n = own->hash = 0;
    if (n == 0)
        return true;
    uint32_t parts = parallel_each(s->homes->threads, n, count_part, &t);
    for (uint32_t i = 0; i < parts; ++i) {
        uint64_t own_n = t.counts[i];
        t.counts[i] = own->n;
        own->n += own_n;
    }
    if (own->n > own->capacity) {
        uint64_t most = own->n + own->n / 16;
        free(own->pairs);
        own->pairs = malloc(most * sizeof *own->pairs);
        own->capacity = own->pairs ? most : 0;
    }
    if (own->n > own->capacity) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " pairs: no memory", own->n);
        own_pairs_end(own);
        return false;
    }
    t.pairs = own->pairs;
    parallel_each(s->homes->threads, n, take_part, &t);
    for (uint32_t i = 0; i < parts; ++i)
        own->hash += t.hashes[i];
    return true;
}

void own_pairs_end(own_pairs *own)
{
    free(own->pairs);
    *own = (own_pairs){0};
}
