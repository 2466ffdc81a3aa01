// SPDX-License-Identifier: MIT
#include "cluster/parts.h"

#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLE_A_PART = 1 << 12 };

bool parts_begin(parts *p, uint32_t n, const ranks *r, duet_error *err)
{
    *p = (parts){.n = n, .rank = (uint32_t)r->self, .n_ranks = (uint32_t)r->n};
    p->list = calloc(n, sizeof *p->list);
    return (p->list || error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " parts: no memory", n)) &&
           bisection_begin(&p->cut, n, err);
}

static void forget_ghosts(parts *p)
{
    for (uint32_t i = 0; p->list && i < p->n; ++i)
        p->list[i].n_ghosts = 0;
    free(p->ghosts);
    p->ghosts = NULL;
    parcels_end(&p->messages);
}

void parts_end(parts *p)
{
    forget_ghosts(p);
    for (uint32_t i = 0; p->list && i < p->n; ++i)
        free(p->list[i].ghosts);
    bisection_end(&p->cut);
    free(p->list);
    free(p->rows);
    *p = (parts){0};
}

// ---------------------------------------------------------------- homes

static bool cut_homes(parts *p, duet_error *err)
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

static uint32_t part_of(const parts *p, const void *object)
{
    double centre[3];
    object_centre(&p->homes->form, object, centre);
    return bisection_part(&p->cut, centre);
}

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

static void count_homes(parts *p)
{
    const homes *h = p->homes;
    for (uint32_t i = 0; i < p->n; ++i) {
        p->list[i].n = 0;
        for (int k = 0; k < LEVELS; ++k)
            p->list[i].boxes.upto[k] = reach_none;
    }
    for (uint32_t i = 0; i < h->rows.n; ++i) {
        const void *object = object_row(&h->rows, &h->form, i);
        home_part *to = &p->list[part_of(p, object)];
        reach e = reach_of(&h->form, object);
        reach_add(&to->boxes.upto[level_of(reach_widest(&e), h->widest)], &e);
        ++to->n;
    }
    for (uint32_t i = 0; i < p->n; ++i)
        level_boxes_join(&p->list[i].boxes);
}

static bool list_homes(parts *p, duet_error *err)
{
    const homes *h = p->homes;
    if (h->rows.n > p->capacity) {
        free(p->rows);
        p->rows = malloc(h->rows.n * sizeof *p->rows);
        p->capacity = p->rows ? h->rows.n : 0;
    }
    if (h->rows.n > p->capacity)
        return error_set(err, DUET_STATUS_NO_MEMORY, "parts of %" PRIu32 " objects: no memory",
                         h->rows.n);
    uint32_t *at = p->rows;
    for (uint32_t i = 0; i < p->n; ++i) {
        p->list[i].rows = at;
        at += p->list[i].n;
        p->list[i].n = 0;
    }
    for (uint32_t i = 0; i < h->rows.n; ++i) {
        home_part *to = &p->list[part_of(p, object_row(&h->rows, &h->form, i))];
        to->rows[to->n++] = i;
    }
    return true;
}

// ---------------------------------------------------------------- ghosts

static bool add_ghost(home_part *to, const ghost_row *g)
{
    if (to->n_ghosts == to->capacity) {
        uint64_t capacity = to->capacity ? 2 * to->capacity : 1024;
        ghost_row *ghosts = realloc(to->ghosts, capacity * sizeof *ghosts);
        if (!ghosts)
            return false;
        to->ghosts = ghosts;
        to->capacity = capacity;
    }
    to->ghosts[to->n_ghosts++] = *g;
    return true;
}

// To all parts but its own whose objects it may touch and be owned by.
static bool send_guest(parts *p, const guest *g)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->n; ++i) {
        uint32_t place = home_of_part(p, i);
        int level = owners_upto(g->level, g->home, place);
        if (place != g->home && level >= 0 &&
            reaches_meet(&p->list[i].boxes.upto[level], &g->reach))
            ok = add_ghost(&p->list[i], &g->as);
    }
    return ok;
}

// Objects deeper inside of their part than any reaches meet no other part.
static bool send_homes(parts *p)
{
    const homes *h = p->homes;
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->n; ++i) {
        const home_part *from = &p->list[i];
        reach inside = reach_none;
        bisection_box(&p->cut, i, inside.lower, inside.upper);
        for (uint32_t k = 0; ok && k < from->n; ++k) {
            const void *object = object_row(&h->rows, &h->form, from->rows[k]);
            double centre[3];
            object_centre(&h->form, object, centre);
            if (reach_holds(&inside, centre, h->widest))
                continue;
            guest g = guest_of(p, h->rows.ids[from->rows[k]], object, home_of_part(p, i));
            ok = send_guest(p, &g);
        }
    }
    return ok;
}

static bool send_ghosts(parts *p)
{
    const unsigned char *message = p->messages.rows;
    bool ok = true;
    for (uint32_t q = 0; q < p->n_ranks; ++q)
        for (uint64_t i = 0; ok && i < p->messages.counts[q]; ++i) {
            uint64_t id;
            memcpy(&id, message, sizeof id);
            guest g = guest_of(p, id, message + sizeof id, q * p->n);
            ok = send_guest(p, &g);
            message += p->messages.row_bytes;
        }
    return ok;
}

bool parts_divide(parts *p, const homes *h, const ranks *r, parcels *messages, duet_error *err)
{
    forget_ghosts(p);
    p->homes = h;
    p->messages = *messages;
    *messages = (parcels){0};
    if (p->n == 1) {
        p->ghosts = ghosts_read(h, r, 1, &p->messages, err);
        return p->ghosts;
    }
    if (!cut_homes(p, err))
        return false;
    count_homes(p);
    if (!list_homes(p, err))
        return false;
    if (!send_homes(p) || !send_ghosts(p))
        return error_set(err, DUET_STATUS_NO_MEMORY, "ghosts of %" PRIu32 " parts: no memory",
                         p->n);
    for (uint32_t i = 0; i < p->n; ++i)
        ghosts_sort(p->list[i].ghosts, p->list[i].n_ghosts);
    return true;
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
