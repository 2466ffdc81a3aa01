// SPDX-License-Identifier: MIT
#include "cluster/parts.h"

#include "base/error.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLE_A_PART = 1 << 12 };

bool parts_begin(parts *p, uint32_t n, const ranks *r, duet_error *err)
{
    *p = (parts){.n = n, .rank = (uint32_t)r->self, .n_ranks = (uint32_t)r->n};
    p->list = calloc(n, sizeof *p->list);
    p->ranges = calloc(n, sizeof *p->ranges);
    return ((p->list && p->ranges) ||
            error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " parts: no memory", n)) &&
           bisection_begin(&p->cut, n, err);
}

void parts_forget_ghosts(parts *p)
{
    for (uint32_t i = 0; p->list && i < p->n; ++i)
        p->list[i].n_ghosts = 0;
    free(p->ghosts);
    p->ghosts = NULL;
    parcels_end(&p->messages);
}

void ghost_block_end(ghost_block *b)
{
    object_rows_end(&b->rows);
    free(b->keys);
    *b = (ghost_block){0};
}

void parts_end(parts *p)
{
    parts_forget_ghosts(p);
    ghost_block_end(&p->block);
    bisection_end(&p->cut);
    free(p->list);
    free(p->ranges);
    free(p->strays);
    free(p->rows);
    free(p->marks);
    free(p->border);
    free(p->portions);
    *p = (parts){0};
}

// ---------------------------------------------------------------- homes

bool parts_cut(parts *p, duet_error *err)
{
    uint64_t most = (uint64_t)SAMPLE_A_PART * p->n;
    bisection_point *sample = malloc(most * sizeof *sample);
    if (!sample)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " parts: no memory", p->n);
    uint32_t n = cut_sample(sample, most, &p->homes->form, &p->homes->rows);
    bisection_cut(&p->cut, NULL, sample, n);
    free(sample);
    return true;
}

void parts_clear_portions(parts *p, uint32_t thread)
{
    portion *own = parts_portions(p, thread);
    for (uint32_t i = 0; i < p->n; ++i) {
        own[i] = (portion){0};
        for (int k = 0; k < LEVELS; ++k)
            own[i].boxes.upto[k] = reach_none;
    }
}

// Only of the others are boxes needed: what lies deeper in its part, and in its rank's, than any
// reach is wide touches nothing else.
static void mark_homes(void *context, uint32_t thread, uint64_t first, uint64_t end)
{
    parts *p = context;
    const homes *h = p->homes;
    portion *own = parts_portions(p, thread);
    uint64_t n_border = 0;
    parts_clear_portions(p, thread);
    for (uint64_t i = first; i < end; ++i) {
        const void *object = object_row(&h->rows, &h->form, (uint32_t)i);
        double centre[3];
        object_centre(&h->form, object, centre);
        uint32_t part = bisection_part(&p->cut, centre);
        bool deep = reach_holds(&p->list[part].inside, centre, h->widest);
        p->marks[i] = (uint16_t)(part | (deep ? 0 : PART_MARKED));
        ++own[part].homes;
        if (deep)
            continue;
        reach e = reach_of(&h->form, object);
        level_boxes_add(&own[part].boxes, &e, h->widest);
        ++n_border;
    }
    p->n_border[thread] = n_border;
}

static void list_homes(void *context, uint32_t thread, uint64_t first, uint64_t end)
{
    parts *p = context;
    portion *own = parts_portions(p, thread);
    uint32_t *border = p->border + p->n_border[thread];
    for (uint64_t i = first; i < end; ++i) {
        p->rows[own[part_of_mark(p->marks[i])].homes++] = (uint32_t)i;
        if (p->marks[i] & PART_MARKED)
            *border++ = (uint32_t)i;
    }
}

void parts_join_boxes(parts *p, uint32_t n_threads)
{
    for (uint32_t i = 0; i < p->n; ++i) {
        level_boxes *boxes = &p->list[i].boxes;
        for (int k = 0; k < LEVELS; ++k)
            boxes->upto[k] = reach_none;
        for (uint32_t t = 0; t < n_threads; ++t)
            for (int k = 0; k < LEVELS; ++k)
                reach_add(&boxes->upto[k], &parts_portions(p, t)[i].boxes.upto[k]);
        level_boxes_join(boxes);
    }
}

static void gather_homes(parts *p, uint32_t n_threads)
{
    uint64_t all = 0;
    parts_join_boxes(p, n_threads);
    for (uint32_t i = 0; i < p->n; ++i) {
        home_part *of = &p->list[i];
        uint64_t before = all;
        for (uint32_t t = 0; t < n_threads; ++t)
            count_before(&parts_portions(p, t)[i].homes, &all);
        of->rows = p->rows + before;
        of->n = (uint32_t)(all - before);
    }
    p->all_border = 0;
    for (uint32_t t = 0; t < n_threads; ++t)
        count_before(&p->n_border[t], &p->all_border);
}

bool parts_reserve_marks(parts *p, uint64_t n)
{
    if (!p->portions)
        p->portions =
            aligned_alloc(alignof(portion), PARALLEL_MOST * (size_t)p->n * sizeof *p->portions);
    if (n > p->capacity) {
        free(p->marks);
        p->marks = malloc(n * sizeof *p->marks);
        p->capacity = p->marks ? n : 0;
    }
    return p->portions && n <= p->capacity;
}

static bool reserve_homes(parts *p, uint32_t n)
{
    if (n > p->row_capacity) {
        free(p->rows);
        p->rows = malloc(n * sizeof *p->rows);
        p->row_capacity = p->rows ? n : 0;
    }
    return parts_reserve_marks(p, n) && n <= p->row_capacity;
}

static bool reserve_border(parts *p)
{
    if (p->all_border > p->border_capacity) {
        free(p->border);
        p->border_capacity = p->all_border + p->all_border / 4;
        p->border = malloc(p->border_capacity * sizeof *p->border);
        p->border_capacity = p->border ? p->border_capacity : 0;
    }
    return p->all_border <= p->border_capacity;
}

static void mark_all(parts *p, const cut *c)
{
    for (uint32_t i = 0; i < p->n; ++i) {
        reach *in = &p->list[i].inside;
        bisection_box(&p->cut, i, in->lower, in->upper);
        for (int k = 0; k < 3; ++k) {
            in->lower[k] = fmax(in->lower[k], c->lower[k]);
            in->upper[k] = fmin(in->upper[k], c->upper[k]);
        }
    }
    gather_homes(p, parallel_each(p->homes->threads, p->homes->rows.n, mark_homes, p));
}

double parts_unevenness(const parts *p)
{
    uint32_t n = homes_count(p->homes), most = 0;
    for (uint32_t i = 0; i < p->n; ++i)
        most = p->list[i].n > most ? p->list[i].n : most;
    return n > 0 ? (double)most * p->n / n : 1;
}

// The cut stays as long as its parts are about as even, so that grids of parts can stay too.
static bool divide_homes(parts *p, const cut *c, duet_error *err)
{
    uint32_t n = p->homes->rows.n;
    bool ok = reserve_homes(p, n);
    if (ok && p->unevenness > 0)
        mark_all(p, c);
    p->is_cut_anew = p->unevenness == 0 || !parts_are_even(p);
    if (ok && p->is_cut_anew) {
        ok = parts_cut(p, err);
        mark_all(p, c);
        p->unevenness = parts_unevenness(p);
    }
    ok = ok && reserve_border(p);
    if (ok)
        parallel_each(p->homes->threads, n, list_homes, p);
    return ok ||
           error_set(err, DUET_STATUS_NO_MEMORY, "parts of %" PRIu32 " objects: no memory", n);
}

// ---------------------------------------------------------------- ghosts

// An object, where it is at home, and its level.
typedef struct guest {
    ghost_row as;
    reach reach;
    uint32_t home; // a rank's part
    int level;
} guest;

static uint32_t home_of_part(const parts *p, uint32_t part)
{
    return p->rank * p->n + part;
}

static guest guest_of(const parts *p, uint64_t id, const void *object, uint32_t home)
{
    guest g = {.as = {.id = id, .object = object}, .home = home};
    g.reach = reach_of(&p->homes->form, object);
    g.level = level_of(reach_widest(&g.reach), p->homes->widest);
    g.as.key = owner_key(g.level, home, p->n_ranks * p->n);
    return g;
}

static guest guest_of_border(const parts *p, uint64_t i)
{
    const homes *h = p->homes;
    bool in_place = h->n_ranges > 0;
    uint32_t row = in_place ? h->edges.rows[i] : p->border[i];
    return guest_of(p, h->rows.ids[row], object_row(&h->rows, &h->form, row),
                    home_of_part(p, part_of_mark(p->marks[in_place ? i : row])));
}

static guest guest_of_gone(const parts *p, uint64_t i)
{
    const homes *h = p->homes;
    uint32_t row = h->gone[i];
    return guest_of(p, h->rows.ids[row], object_row(&h->rows, &h->form, row),
                    (uint32_t)h->gone_to[i] * p->n);
}

// *sender is that of the message before, or 0, and *upto the messages of all up to it.
static guest guest_of_message(const parts *p, uint64_t i, uint32_t *sender, uint64_t *upto)
{
    const unsigned char *message =
        (const unsigned char *)p->messages.rows + i * p->messages.row_bytes;
    uint64_t id;
    while (i >= *upto)
        *upto += p->messages.counts[++*sender];
    memcpy(&id, message, sizeof id);
    return guest_of(p, id, message + sizeof id, *sender * p->n);
}

// Adds it to all parts but its own whose objects it may touch and be owned by; where `to` is NULL
// it is only counted.
static void add_guest(const parts *p, const guest *g, portion *own, ghost_row *to)
{
    for (uint32_t i = 0; i < p->n; ++i) {
        uint32_t place = home_of_part(p, i);
        int level = owners_upto(g->level, g->home, place);
        if (place == g->home || level < 0 ||
            !reaches_meet(&p->list[i].boxes.upto[level], &g->reach))
            continue;
        if (to)
            to[own[i].ghosts] = g->as;
        ++own[i].ghosts;
    }
}

// Homes, by ascending id where they lie so, then those that are gone, and what others sent.
static void add_guests(const parts *p, uint64_t first, uint64_t end, portion *own, ghost_row *to)
{
    uint32_t sender = 0;
    uint64_t upto = p->messages.counts[0], n_own = p->all_border + p->homes->n_gone;
    for (uint64_t i = first; i < end; ++i) {
        guest g = i < p->all_border ? guest_of_border(p, i)
                  : i < n_own       ? guest_of_gone(p, i - p->all_border)
                                    : guest_of_message(p, i - n_own, &sender, &upto);
        add_guest(p, &g, own, to);
    }
}

static void count_ghosts(void *context, uint32_t thread, uint64_t first, uint64_t end)
{
    const parts *p = context;
    portion *own = parts_portions(p, thread);
    for (uint32_t i = 0; i < p->n; ++i)
        own[i].ghosts = 0;
    add_guests(p, first, end, own, NULL);
}

static void write_ghosts(void *context, uint32_t thread, uint64_t first, uint64_t end)
{
    const parts *p = context;
    add_guests(p, first, end, parts_portions(p, thread), p->ghosts);
}

bool parts_divide_ghosts(parts *p, duet_error *err)
{
    uint64_t n = p->all_border + p->homes->n_gone + p->messages.n, all = 0;
    uint32_t n_threads = parallel_each(p->homes->threads, n, count_ghosts, p);
    for (uint32_t i = 0; i < p->n; ++i) {
        uint64_t before = all;
        for (uint32_t t = 0; t < n_threads; ++t)
            count_before(&parts_portions(p, t)[i].ghosts, &all);
        p->list[i].n_ghosts = all - before;
    }
    p->ghosts = malloc((all + 1) * sizeof *p->ghosts);
    if (!p->ghosts)
        return error_set(err, DUET_STATUS_NO_MEMORY,
                         "%" PRIu64 " ghosts of %" PRIu32 " parts: no memory", all, p->n);
    parallel_each(p->homes->threads, n, write_ghosts, p);
    ghost_row *ghosts = p->ghosts;
    for (uint32_t i = 0; i < p->n; ghosts += p->list[i++].n_ghosts) {
        p->list[i].ghosts = ghosts;
        if (p->messages.n > 0 && p->homes->n_ranges == 0)
            ghosts_sort(ghosts, p->list[i].n_ghosts);
    }
    return true;
}

bool parts_divide(parts *p, const homes *h, const cut *c, const ranks *r, parcels *messages,
                  duet_error *err)
{
    parts_forget_ghosts(p);
    p->homes = h;
    p->messages = *messages;
    *messages = (parcels){0};
    if (p->n > 1)
        return divide_homes(p, c, err) && parts_divide_ghosts(p, err);
    p->ghosts = ghosts_read(h, r, 1, &p->messages, err);
    return p->ghosts;
}

sight parts_sight(const parts *p, uint32_t i)
{
    sight s = {.home = home_of_part(p, i), .n_homes = p->n_ranks * p->n};
    if (p->n == 1) {
        s.n = p->homes->rows.n;
        s.ghosts = p->ghosts;
        s.n_ghosts = p->messages.n;
        return s;
    }
    s.rows = p->list[i].rows;
    s.n = p->list[i].n;
    s.ghosts = p->list[i].ghosts;
    s.n_ghosts = p->list[i].n_ghosts;
    return s;
}
