// SPDX-License-Identifier: MIT
#include "cluster/found.h"

#include "base/error.h"
#include "cluster/owner.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- ghosts

static int by_id(const void *left, const void *right)
{
    const ghost_row *p = left, *q = right;
    return (p->id > q->id) - (p->id < q->id);
}

void ghosts_sort(ghost_row *ghosts, uint64_t n)
{
    if (n > 0)
        qsort(ghosts, n, sizeof *ghosts, by_id);
}

uint32_t ghost_key(const homes *h, const void *object, uint32_t home, uint32_t n_homes)
{
    reach e = reach_of(&h->form, object);
    return owner_key(level_of(reach_widest(&e), h->widest), home, n_homes);
}

ghost_row *ghosts_read(const homes *h, const ranks *r, uint32_t n_parts, const parcels *messages,
                       duet_error *err)
{
    const unsigned char *message = messages->rows;
    ghost_row *ghosts = malloc((messages->n + 1) * sizeof *ghosts), *to = ghosts;
    if (!ghosts) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " ghosts: no memory", messages->n);
        return NULL;
    }
    for (uint32_t q = 0; q < (uint32_t)r->n; ++q)
        for (uint64_t i = 0; i < messages->counts[q]; ++i, message += messages->row_bytes, ++to) {
            memcpy(&to->id, message, sizeof to->id);
            to->object = message + sizeof to->id;
            to->key = ghost_key(h, to->object, q * n_parts, (uint32_t)r->n * n_parts);
        }
    ghosts_sort(ghosts, messages->n);
    return ghosts;
}

// ---------------------------------------------------------------- what is seen

static bool reserve(seen *s, uint64_t n, uint64_t n_ghosts, duet_error *err)
{
    if (!s->is_ghost || n > s->capacity || n_ghosts > s->ghost_capacity) {
        free(s->own_ids);
        free(s->is_ghost);
        free(s->ghosts);
        s->own_ids = NULL;
        s->capacity = n + n / 16;
        s->ghost_capacity = n_ghosts + n_ghosts / 4;
        s->is_ghost = malloc(s->capacity / 8 + 1);
        s->ghosts = malloc((s->ghost_capacity + 1) * sizeof *s->ghosts);
    }
    if (!s->is_ghost || !s->ghosts) {
        seen_end(s);
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects and ghosts: no memory",
                         n);
    }
    if (n_ghosts > 0)
        memset(s->is_ghost, 0, n / 8 + 1);
    return true;
}

// The first n of the list.
static void mark_ghosts(seen *s, uint64_t n)
{
    s->n_listed = n;
    for (uint64_t i = 0; i < n; ++i)
        s->is_ghost[s->ghosts[i].place / 8] |= (uint8_t)(1u << s->ghosts[i].place % 8);
}

static bool reserve_ids(seen *s, duet_error *err)
{
    if (!s->own_ids)
        s->own_ids = malloc((s->capacity + 1) * sizeof *s->own_ids);
    s->rows.ids = s->own_ids;
    return s->own_ids || error_set(err, DUET_STATUS_NO_MEMORY,
                                   "the ids of %" PRIu64 " objects: no memory", s->capacity);
}

// ---------------------------------------------------------------- in any order

// Both are found without a rounding that depends on it.
bool seen_in_any_order(duet_level level)
{
    return level == DUET_LEVEL_CERTIFIED || level == DUET_LEVEL_AABB;
}

// Homes that are gone, each a ghost of another rank, at these places; NULL: before those behind.
static void mark_gone(seen *s, const homes *h, const uint32_t *places)
{
    for (uint32_t i = 0; i < h->n_gone; ++i) {
        const void *object = object_row(&h->rows, &h->form, h->gone[i]);
        s->ghosts[i].place = places ? places[i] : s->behind - h->n_gone + i;
        s->ghosts[i].key = ghost_key(h, object, (uint32_t)h->gone_to[i], s->n_homes);
    }
    mark_ghosts(s, h->n_gone);
}

static bool count_behind(seen *s, const ranks *r, const parcels *ghosts, duet_error *err)
{
    uint32_t *first = realloc(s->first_behind, ((size_t)r->n + 1) * sizeof *first);
    if (!first)
        return error_set(err, DUET_STATUS_NO_MEMORY, "ghosts of %d ranks: no memory", r->n);
    s->first_behind = first;
    first[0] = s->behind;
    for (int q = 0; q < r->n; ++q)
        first[q + 1] = first[q] + (uint32_t)ghosts->counts[q];
    return true;
}

// The last of the rows are the ghosts in the messages.
static bool see_rows(seen *s, const homes *h, const ranks *r, const object_rows *rows,
                     const uint32_t *gone, const parcels *ghosts, duet_error *err)
{
    if (!reserve(s, rows->n, h->n_gone, err))
        return false;
    s->homes = h;
    s->home = (uint32_t)r->self;
    s->n_homes = (uint32_t)r->n;
    s->rows = *rows;
    s->ids_behind = NULL;
    s->behind = rows->n - (uint32_t)ghosts->n;
    s->n_ghosts = h->n_gone + ghosts->n;
    mark_gone(s, h, gone);
    return count_behind(s, r, ghosts, err);
}

bool seen_append(seen *s, homes *h, const ranks *r, const parcels *ghosts, duet_error *err)
{
    if (!homes_write_behind(h, ghosts, err))
        return false;
    object_rows rows = {.ids = h->rows.ids, .objects = h->rows.objects};
    rows.n = h->rows.n + (uint32_t)ghosts->n;
    return see_rows(s, h, r, &rows, h->gone, ghosts, err);
}

bool seen_at_border(seen *s, const homes *h, const ranks *r, const object_rows *rows,
                    const parcels *ghosts, duet_error *err)
{
    s->is_border = true;
    return see_rows(s, h, r, rows, NULL, ghosts, err);
}

void seen_in_place(seen *s, const homes *h, const sight_in_place *from)
{
    s->homes = h;
    s->home = from->home;
    s->n_homes = from->n_homes;
    s->rows = (object_rows){.ids = h->rows.ids + from->first,
                            .objects = object_row(&h->rows, &h->form, from->first),
                            .n = from->n + from->n_ghosts};
    s->behind = from->n;
    s->ids_behind = from->ghost_ids;
    s->keys_behind = from->ghost_keys;
    s->ranges = NULL;
    s->n_listed = 0;
    s->n_ghosts = from->n_ghosts;
}

// The least key owns all pairs.
bool seen_leave_out(seen *s, const uint32_t *places, uint32_t n, duet_error *err)
{
    if (n == 0)
        return true;
    if (!reserve(s, s->rows.n, n, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        s->ghosts[i] = (seen_ghost){places[i], 0};
    mark_ghosts(s, n);
    s->n_ghosts = n;
    return true;
}

void seen_at_edges(seen *s, const homes *h, const sight_at_edges *from)
{
    s->homes = h;
    s->home = from->home;
    s->n_homes = from->n_homes;
    s->rows = from->rows;
    s->behind = from->rows.n - from->n_ghosts;
    s->ids_behind = from->rows.ids + s->behind;
    s->keys_behind = from->ghost_keys;
    s->ranges = from->ranges;
    s->n_listed = 0;
    s->n_ghosts = from->n_ghosts;
}

// ---------------------------------------------------------------- by ascending id

typedef struct filling {
    seen *s;
    const homes *h;
    const sight *from;
} filling;

static uint32_t row_at(const sight *from, uint64_t i)
{
    return from->rows ? from->rows[i] : (uint32_t)i;
}

// The first ghost whose id is not below that of a home.
static uint64_t ghosts_before(const filling *f, uint64_t home)
{
    uint64_t first = 0, last = f->from->n_ghosts;
    if (home >= f->from->n)
        return last;
    uint64_t id = f->h->rows.ids[row_at(f->from, home)];
    while (first < last) {
        uint64_t middle = first + (last - first) / 2;
        if (f->from->ghosts[middle].id < id)
            first = middle + 1;
        else
            last = middle;
    }
    return first;
}

// Homes up to the one whose id is not below that of the next ghost, `end` at most.
static uint64_t add_homes(const filling *f, object_rows *to, uint64_t first, uint64_t end,
                          const ghost_row *next)
{
    const object_rows *rows = &f->h->rows;
    if (!f->from->rows) {
        uint64_t run =
            next ? object_rows_find(rows, (uint32_t)first, (uint32_t)end, next->id) : end;
        object_rows_append(to, &f->h->form, rows->ids + first,
                           object_row(rows, &f->h->form, (uint32_t)first), (uint32_t)(run - first));
        return run;
    }
    for (; first < end; ++first) {
        uint32_t row = f->from->rows[first];
        if (next && rows->ids[row] >= next->id)
            break;
        object_rows_append(to, &f->h->form, &rows->ids[row], object_row(rows, &f->h->form, row), 1);
    }
    return first;
}

// Homes [first, end) and the ghosts between the first of them and the home after the last.
static void fill_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    filling *f = context;
    seen *s = f->s;
    (void)part;
    uint64_t k = first == 0 ? 0 : ghosts_before(f, first), last = ghosts_before(f, end);
    uint64_t at = first + k;
    object_rows to = {.ids = s->rows.ids + at,
                      .objects = object_row(&s->rows, &f->h->form, (uint32_t)at)};
    for (;; ++k) {
        const ghost_row *next = k < last ? &f->from->ghosts[k] : NULL;
        first = add_homes(f, &to, first, end, next);
        if (!next)
            return;
        s->ghosts[k] = (seen_ghost){(uint32_t)at + to.n, next->key};
        object_rows_append(&to, &f->h->form, &next->id, next->object, 1);
    }
}

bool seen_fill(seen *s, const homes *h, const sight *from, worker *w, duet_error *err)
{
    uint64_t n = from->n + from->n_ghosts;
    if (n > UINT32_MAX - 1)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%u objects and %" PRIu64 " ghosts on one rank; expected more ranks",
                         from->n, from->n_ghosts);
    if (!reserve(s, n, from->n_ghosts, err) || !reserve_ids(s, err))
        return false;
    s->homes = h;
    s->home = from->home;
    s->n_homes = from->n_homes;
    s->rows.objects = w->map(w, (uint32_t)n, err);
    if (!s->rows.objects)
        return false;
    filling f = {.s = s, .h = h, .from = from};
    parallel_each(h->threads, from->n, fill_part, &f);
    s->rows.n = s->behind = (uint32_t)n;
    s->ids_behind = NULL;
    s->n_ghosts = from->n_ghosts;
    mark_ghosts(s, s->n_ghosts);
    return true;
}

void seen_end(seen *s)
{
    free(s->own_ids);
    free(s->is_ghost);
    free(s->ghosts);
    free(s->first_behind);
    *s = (seen){0};
}

// ---------------------------------------------------------------- pairs

static inline bool is_ghost(const seen *s, uint32_t place)
{
    return place >= s->behind || (s->n_listed > 0 && s->is_ghost[place / 8] >> place % 8 & 1);
}

// The rank at home of a ghost behind the homes.
static uint32_t home_behind(const seen *s, uint32_t place)
{
    uint32_t first = 0, last = s->n_homes;
    while (last - first > 1) {
        uint32_t middle = first + (last - first) / 2;
        if (s->first_behind[middle] <= place)
            first = middle;
        else
            last = middle;
    }
    return first;
}

static uint32_t key_of_ghost(const seen *s, uint32_t place)
{
    uint64_t first = 0, last = s->n_listed;
    if (place >= s->behind && s->ids_behind)
        return s->keys_behind[place - s->behind];
    if (place >= s->behind)
        return ghost_key(s->homes, object_row(&s->rows, &s->homes->form, place),
                         home_behind(s, place), s->n_homes);
    while (last - first > 1) {
        uint64_t middle = first + (last - first) / 2;
        if (s->ghosts[middle].place <= place)
            first = middle;
        else
            last = middle;
    }
    return s->ghosts[first].key;
}

// The object with the lesser key is at home. Two ghosts have no home.
static bool owns_with_ghost(const seen *s, duet_pair pair)
{
    bool a = is_ghost(s, pair.a), b = is_ghost(s, pair.b);
    if (a && b)
        return false;
    uint32_t home = a ? pair.b : pair.a, ghost = a ? pair.a : pair.b;
    const void *object = object_row(&s->rows, &s->homes->form, home);
    return ghost_key(s->homes, object, s->home, s->n_homes) < key_of_ghost(s, ghost);
}

static inline bool is_own(const seen *s, duet_pair pair)
{
    if (is_ghost(s, pair.a) | is_ghost(s, pair.b))
        return owns_with_ghost(s, pair);
    if (!s->ranges)
        return !s->is_border;
    return s->ranges[pair.a] != s->ranges[pair.b] || s->ranges[pair.a] == NO_RANGE;
}

typedef struct taking {
    const seen *s;
    const worker_found *found;
    duet_pair64 *pairs;
    uint64_t counts[PARALLEL_MOST]; // of each part, and then where its pairs begin
    uint64_t hashes[PARALLEL_MOST];
} taking;

static inline duet_pair pair_at(const worker_found *found, uint64_t i)
{
    return i < found->spans[0].n ? found->spans[0].pairs[i]
                                 : found->spans[1].pairs[i - found->spans[0].n];
}

// By the ids of its objects.
static inline duet_pair64 pair_of(const seen *s, duet_pair p)
{
    uint64_t a = seen_id(s, p.a), b = seen_id(s, p.b);
    return a < b ? (duet_pair64){a, b} : (duet_pair64){b, a};
}

static void count_part(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    taking *t = context;
    uint64_t n = 0, hash = 0;
    for (uint64_t i = first; i < end; ++i) {
        duet_pair p = pair_at(t->found, i);
        if (!is_own(t->s, p))
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
        if (is_own(t->s, p))
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
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " pairs: no memory", n);
    own->pairs = pairs;
    own->capacity = most;
    return true;
}

bool own_pairs_add(own_pairs *own, const seen *s, const worker_found *found, duet_error *err)
{
    uint64_t n = found->spans[0].n + found->spans[1].n, all = own->n;
    taking t = {.s = s, .found = found};
    uint32_t parts = parallel_each(s->homes->threads, n, count_part, &t);
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
        parallel_each(s->homes->threads, n, take_part, &t);
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

bool seen_check_found(const seen *s, const worker_found *found, duet_error *err)
{
    return !found->has_bad ||
           error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %llu is not a number, infinite, negative or without rotation",
                     (unsigned long long)seen_id(s, found->first_bad));
}
