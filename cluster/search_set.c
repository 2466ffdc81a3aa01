// SPDX-License-Identifier: MIT
#include "cluster/search_set.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- memory

// Returns memory for n elements of that size, whatever was in it; NULL without.
static void *reserve(void *memory, uint64_t *capacity, uint64_t n, size_t bytes, duet_error *err)
{
    if (memory && n <= *capacity)
        return memory;
    free(memory);
    *capacity = n + n / 16;
    memory = malloc((*capacity + 1) * bytes);
    if (!memory)
        no_memory(err, "%llu objects and ghosts", (unsigned long long)n);
    return memory;
}

void search_set_end(search_set *s)
{
    free(s->keys);
    free(s->is_leaver);
    free(s->ids);
    *s = (search_set){0};
}

static void begin(search_set *s, set_kind kind, const owned *o, const ranks *r, uint32_t d)
{
    s->kind = kind;
    s->owned = o;
    s->place = (uint32_t)r->self * o->most_domains + d;
    s->n_places = (uint32_t)r->n * o->most_domains;
    s->n_leavers = 0;
}

// Marks the leavers of a set whose own rows are the rank's.
static bool mark_leavers(search_set *s, duet_error *err)
{
    const row_list *all = &s->owned->leavers;
    if (all->n == 0)
        return true;
    s->is_leaver = reserve(s->is_leaver, &s->bits_capacity, s->n_own / 8 + 1, 1, err);
    if (!s->is_leaver)
        return false;
    memset(s->is_leaver, 0, s->n_own / 8 + 1);
    for (uint64_t k = 0; k < all->n; ++k)
        s->is_leaver[all->rows[k] / 8] |= (uint8_t)(1u << all->rows[k] % 8);
    s->n_leavers = (uint32_t)all->n;
    return true;
}

// ---------------------------------------------------------------- ghosts

typedef struct writing {
    search_set *s;
    const ghosts *g;
    uint64_t from;
} writing;

static uint32_t key_of(const search_set *s, const void *object, uint32_t place)
{
    extent e = extent_of(&s->owned->form, object);
    return owner_key(level_of(extent_widest(&e), s->owned->widest), place, s->n_places);
}

static void write_some(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const writing *w = context;
    search_set *s = w->s;
    (void)part;
    for (uint64_t i = first; i < end; ++i) {
        ghost at = ghosts_get(w->g, w->from + i);
        uint32_t row = s->n_own + (uint32_t)i;
        s->rows.ids[row] = at.id;
        memcpy(object_row(&s->rows, &s->owned->form, row), at.object, s->owned->form.bytes);
        s->keys[i] = key_of(s, at.object, at.from);
    }
}

// Writes ghosts behind the own rows, where there is space.
static bool write_ghosts(search_set *s, const ghosts *g, uint32_t d, duet_error *err)
{
    uint64_t n = g->first[d + 1] - g->first[d];
    writing w = {s, g, g->first[d]};
    s->keys = reserve(s->keys, &s->keys_capacity, n, sizeof *s->keys, err);
    if (!s->keys)
        return false;
    parallel_each(s->owned->threads, n, write_some, &w);
    return true;
}

static bool is_empty(const search_set *s)
{
    return s->n_own == s->n_leavers || (s->kind == SET_BOUNDARY && search_set_ghosts(s) == 0);
}

// ---------------------------------------------------------------- sets

// Makes the own rows all that the rank has.
static void take_rows(search_set *s, const owned *o)
{
    s->rows = (object_rows){.ids = o->rows.ids, .objects = o->rows.objects, .n = o->rows.n};
    s->n_own = o->rows.n;
}

bool search_set_in_place(search_set *s, owned *o, const ghosts *g, const ranks *r, duet_error *err)
{
    begin(s, SET_WHOLE, o, r, 0);
    if (!owned_reserve(o, g->first[1], err))
        return false;
    take_rows(s, o);
    s->rows.n += (uint32_t)g->first[1];
    return mark_leavers(s, err) && write_ghosts(s, g, 0, err);
}

bool search_set_inner(search_set *s, const owned *o, const ranks *r, duet_error *err)
{
    begin(s, SET_INNER, o, r, 0);
    take_rows(s, o);
    return mark_leavers(s, err);
}

// Makes space for copies in a worker's memory.
static bool map(search_set *s, uint64_t n_own, uint64_t n_ghosts, worker *w, duet_error *err)
{
    uint64_t n = n_own + n_ghosts;
    if (n > DUET_MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%llu objects and ghosts at one time; expected more ranks or parts",
                         (unsigned long long)n);
    s->ids = reserve(s->ids, &s->ids_capacity, n, sizeof *s->ids, err);
    if (!s->ids)
        return false;
    s->rows = (object_rows){.ids = s->ids, .objects = w->map(w, (uint32_t)n, err)};
    s->rows.n = (uint32_t)n;
    s->n_own = (uint32_t)n_own;
    return s->rows.objects;
}

typedef struct copying {
    search_set *s;
    const domain *d;
} copying;

// Returns the run that has a row of the domain.
static const row_run *find_run(const owned *o, const domain *d, uint64_t row)
{
    const row_run *first = o->runs.runs + d->run, *end = first + d->n_runs;
    while (end - first > 1) {
        const row_run *middle = first + (end - first) / 2;
        *(middle->at <= row ? &first : &end) = middle;
    }
    return first;
}

static void copy_some(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const copying *c = context;
    const owned *o = c->s->owned;
    object_rows to = c->s->rows;
    (void)part;
    to.n = (uint32_t)first;
    for (const row_run *run = find_run(o, c->d, first); to.n < end; ++run) {
        uint32_t skipped = to.n - run->at, left = (uint32_t)end - to.n, from = run->first + skipped;
        uint32_t n = run->n - skipped < left ? run->n - skipped : left;
        object_rows_append(&to, &o->form, o->rows.ids + from, object_row(&o->rows, &o->form, from),
                           n);
    }
}

bool search_set_copy_domain(search_set *s, const owned *o, const ghosts *g, const ranks *r,
                            uint32_t index, worker *w, duet_error *err)
{
    const domain *d = &o->domains[index];
    copying c = {s, d};
    begin(s, SET_WHOLE, o, r, index);
    if (!map(s, d->n, g->first[index + 1] - g->first[index], w, err))
        return false;
    if (d->n > 0)
        parallel_each(o->threads, d->n, copy_some, &c);
    return write_ghosts(s, g, index, err);
}

static void copy_boundary(void *set, uint32_t part, uint64_t first, uint64_t end)
{
    search_set *s = set;
    const owned *o = s->owned;
    (void)part;
    object_rows_gather(&s->rows, &o->form, first, &o->rows, o->boundary.rows + first, end - first);
}

bool search_set_copy_boundary(search_set *s, const owned *o, const ghosts *g, const ranks *r,
                              worker *w, duet_error *err)
{
    begin(s, SET_BOUNDARY, o, r, 0);
    if (!map(s, o->boundary.n, g->first[1], w, err))
        return false;
    parallel_each(o->threads, o->boundary.n, copy_boundary, s);
    if (!write_ghosts(s, g, 0, err))
        return false;
    if (!is_empty(s))
        w->begin(w, s->rows.n);
    return true;
}

// ---------------------------------------------------------------- searching

static global_ids ids_of(const search_set *s)
{
    const owned *o = s->owned;
    bool in_place = o->n_domains == 1 && s->kind != SET_BOUNDARY;
    return (global_ids){
        .list = s->rows.ids,
        .n = s->n_own,
        .without = o->leavers.rows,
        .n_without = s->n_leavers,
        .changed = o->renamed.rows,
        .n_changed = in_place && !o->renamed.failed ? o->renamed.n : ALL_IDS_CHANGED,
    };
}

static bool check_found(const search_set *s, const worker_found *found, duet_error *err)
{
    return !found->has_bad ||
           error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %llu is not a number, infinite, negative or without rotation",
                     (unsigned long long)s->rows.ids[found->first_bad]);
}

bool search_set_find(search_set *s, worker *w, bool counts, worker_found *found, duet_error *err)
{
    *found = (worker_found){0};
    if (is_empty(s))
        return true;
    const global_ids ids = ids_of(s);
    bool tells = counts && s->kind != SET_BOUNDARY;
    return w->find(w, tells ? &ids : NULL, found, err) && check_found(s, found, err);
}

// The object with the lesser key is its owner's. Two ghosts are others'.
bool search_set_owns_with_ghost(const search_set *s, duet_pair pair)
{
    bool a = pair.a >= s->n_own, b = pair.b >= s->n_own;
    uint32_t own = a ? pair.b : pair.a, other = a ? pair.a : pair.b;
    if ((a && b) || (s->n_leavers > 0 && s->is_leaver[own / 8] >> own % 8 & 1))
        return false;
    const void *object = object_row(&s->rows, &s->owned->form, own);
    return key_of(s, object, s->place) < s->keys[other - s->n_own];
}
