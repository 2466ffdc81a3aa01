// SPDX-License-Identifier: MIT
#include "cluster/halo.h"

#include "base/error.h"
#include "cluster/moving_domains.h"

#include <stdlib.h>

static void end_side(halo_side *s)
{
    free(s->items.items);
    free(s->colours);
    free(s->places);
    for (int i = 0; i < HALO_LISTS; ++i)
        free(s->comes_after[i].rows);
    parcels_end(&s->rows);
}

void halo_end(halo *h)
{
    end_side(&h->sent);
    end_side(&h->received);
    free(h->requests);
    *h = (halo){0};
}

void halo_clear(halo *h)
{
    list_clear(&h->sent.items);
    list_clear(&h->received.items);
}

void halo_add(item_list *items, const halo_item *item)
{
    list_add(items, item, 1, sizeof *item);
}

// ---------------------------------------------------------------- lists

// By the other side's rank; then as the sender and the receiver both know it.
static int compare(const void *left, const void *right)
{
    const halo_item *a = left, *b = right;
    const uint32_t keys[][2] = {
        {a->rank, b->rank}, {a->to, b->to}, {a->from, b->from}, {a->id, b->id}};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
        if (keys[i][0] != keys[i][1])
            return keys[i][0] < keys[i][1] ? -1 : 1;
    return 0;
}

static halo_item *item_at(const halo_side *s, uint64_t i)
{
    return (halo_item *)s->items.items + i;
}

static bool settle_list(halo_side *s, const moving *m, duet_error *own)
{
    ghost_colours *colours = realloc(s->colours, (s->items.n + 1) * sizeof *colours);
    uint32_t *places = realloc(s->places, (s->items.n + 1) * sizeof *places);
    s->colours = colours ? colours : s->colours;
    s->places = places ? places : s->places;
    if (!colours || !places)
        return error_set(own, DUET_STATUS_NO_MEMORY, "a halo: no memory");
    if (s->items.n > 0)
        qsort(s->items.items, s->items.n, sizeof(halo_item), compare);
    for (uint64_t i = 0; i < s->items.n; ++i) {
        halo_item *item = item_at(s, i);
        item->place = moving_place(&m->domains[item->domain], item->id);
    }
    return true;
}

// Domains know which item a ghost of theirs is.
static void note_ghosts(const halo_side *s, moving *m)
{
    for (uint64_t i = 0; i < s->items.n; ++i)
        m->domains[item_at(s, i)->domain].ghost_at[item_at(s, i)->place] = (uint32_t)i;
}

static uint32_t row_bytes(const moving *m, motion_buffer which)
{
    return motion_words(m->domains[0].motion, which) * (uint32_t)sizeof(uint32_t);
}

// The items of an exchange: all, or those of a list.
typedef struct chosen {
    const uint32_t *items; // NULL: all
    uint64_t n;
} chosen;

static chosen all_of(const halo_side *s)
{
    return (chosen){NULL, s->items.n};
}

static chosen come_after(const halo_side *s, uint32_t colour)
{
    return (chosen){s->comes_after[colour].rows, s->comes_after[colour].n};
}

static const halo_item *chosen_at(const halo_side *s, const chosen *c, uint64_t i)
{
    return item_at(s, c->items ? c->items[i] : i);
}

static void count(halo_side *s, const chosen *c, int n_ranks)
{
    memset(s->rows.counts, 0, (size_t)n_ranks * sizeof *s->rows.counts);
    for (uint64_t i = 0; i < c->n; ++i)
        ++s->rows.counts[chosen_at(s, c, i)->rank];
}

// BODIES have the longest rows.
static bool reserve(halo_side *s, const moving *m, duet_error *own)
{
    const chosen all = all_of(s);
    if (!parcels_begin(&s->rows, m->ranks, row_bytes(m, BODIES), own))
        return false;
    count(s, &all, m->ranks->n);
    return parcels_reserve(&s->rows, m->ranks, NULL, own);
}

static bool settle(halo *h, moving *m, duet_error *own)
{
    if (!h->requests)
        h->requests = malloc(4 * (size_t)m->ranks->n * sizeof *h->requests);
    if (!h->requests || h->sent.items.failed || h->received.items.failed)
        return error_set(own, DUET_STATUS_NO_MEMORY, "a halo: no memory");
    if (!settle_list(&h->sent, m, own) || !settle_list(&h->received, m, own))
        return false;
    note_ghosts(&h->received, m);
    return reserve(&h->sent, m, own) && reserve(&h->received, m, own);
}

bool halo_settle(halo *h, moving *m, duet_error *own)
{
    return ranks_agree(m->ranks, is_well(own) && settle(h, m, own), own);
}

// ---------------------------------------------------------------- rows

static size_t bytes_of(const row_parts *parts)
{
    return (parts->words[0] + parts->words[1]) * sizeof(uint32_t);
}

static row_parts whole_row(const moving *m, motion_buffer which)
{
    return (row_parts){.words = {motion_words(m->domains[0].motion, which)}};
}

typedef bool move_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                       const uint32_t *places, uint32_t n, void *packed, duet_error *err);

// Items of one domain that follow each other are moved together.
static void move_items(halo_side *s, const moving *m, motion_buffer which, const chosen *c,
                       const row_parts *parts, move_rows *move, duet_error *own)
{
    char *packed = s->rows.rows;
    for (uint64_t from = 0, to; is_well(own) && from < c->n; from = to) {
        const uint32_t domain = chosen_at(s, c, from)->domain;
        for (to = from; to < c->n && chosen_at(s, c, to)->domain == domain; ++to)
            s->places[to] = chosen_at(s, c, to)->place;
        move(m->domains[domain].motion, which, parts, s->places + from, (uint32_t)(to - from),
             packed + from * bytes_of(parts), own);
    }
}

// Devices may still be reading what came before.
static void await_unpacked(const moving *m, duet_error *own)
{
    for (uint32_t k = 0; k < m->parts; ++k)
        domain_await_rows(m->domains[k].motion, own);
}

static void exchange(halo *h, moving *m, motion_buffer which, const chosen *out, const chosen *in,
                     const row_parts *parts, duet_error *own)
{
    if (out->n == 0 && in->n == 0)
        return;
    ++h->n_exchanges;
    h->sent.rows.row_bytes = h->received.rows.row_bytes = (uint32_t)bytes_of(parts);
    count(&h->sent, out, m->ranks->n);
    count(&h->received, in, m->ranks->n);
    move_items(&h->sent, m, which, out, parts, domain_pack_rows, own);
    await_unpacked(m, own);
    parcels_pass(m->ranks, &h->sent.rows, &h->received.rows, h->requests);
    move_items(&h->received, m, which, in, parts, domain_unpack_rows, own);
}

void halo_exchange(halo *h, moving *m, motion_buffer which, duet_error *own)
{
    const chosen out = all_of(&h->sent), in = all_of(&h->received);
    const row_parts whole = whole_row(m, which);
    exchange(h, m, which, &out, &in, &whole, own);
}

// ---------------------------------------------------------------- after a colour

// Velocities of a body lie first (kernels/dynamics/records.h). The fourth numbers of vectors are no
// part of them.
static row_parts parts_of_body(const duet_motion *motion, bool warm)
{
    enum { VECTOR = 4, SENT = 3 };
    const bool turns = motion->layout.body == BODY_OF(1);
    const uint32_t both = (turns ? 2 : 1) * SENT;
    return (row_parts){.at = {0, BODY_WARM_IMPULSE_OF(turns) * VECTOR},
                       .words = {both, warm ? both : 0},
                       .of_four = SENT};
}

void halo_exchange_after(halo *h, moving *m, uint32_t colour, bool warm, duet_error *own)
{
    const chosen out = come_after(&h->sent, colour), in = come_after(&h->received, colour);
    const row_parts parts = parts_of_body(m->domains[0].motion, warm);
    exchange(h, m, BODIES, &out, &in, &parts, own);
}

void halo_exchange_late(halo *h, moving *m, duet_error *own)
{
    const chosen out = come_after(&h->sent, HALO_LATE), in = come_after(&h->received, HALO_LATE);
    const row_parts whole = whole_row(m, BODIES);
    exchange(h, m, BODIES, &out, &in, &whole, own);
}

bool halo_comes(const halo *h, uint32_t colour)
{
    return h->sent.comes_after[colour].n > 0 || h->received.comes_after[colour].n > 0;
}

// ---------------------------------------------------------------- what comes when

// Sends a row of each item, of which there are parcels on both sides; colours were read since rows
// were unpacked, so no device still reads these.
static void tell(halo *h, moving *m, halo_side *from, halo_side *to, uint32_t bytes)
{
    const chosen out = all_of(from), in = all_of(to);
    from->rows.row_bytes = to->rows.row_bytes = bytes;
    count(from, &out, m->ranks->n);
    count(to, &in, m->ranks->n);
    parcels_pass(m->ranks, &from->rows, &to->rows, h->requests);
}

void halo_tell_home(halo *h, moving *m)
{
    uint32_t *at_home = h->sent.rows.rows;
    const uint32_t *theirs = h->received.rows.rows;
    for (uint64_t i = 0; i < h->sent.items.n; ++i) {
        const halo_item *item = item_at(&h->sent, i);
        at_home[i] = m->domains[item->domain].used[item->place];
    }
    tell(h, m, &h->sent, &h->received, sizeof *at_home);
    for (uint64_t i = 0; i < h->received.items.n; ++i)
        h->received.colours[i] = (ghost_colours){.at_home = theirs[i]};
}

// The colours of contacts that leave the ghost wrong. Not all need be here of those without a
// colour of their own.
static uint32_t lost_of(const ghost_colours *c)
{
    return c->at_home & ~(c->here & ((1u << HALO_COLOURS) - 1));
}

static void list_ghost(halo_side *s, uint64_t i)
{
    const ghost_colours *c = &s->colours[i];
    for (uint32_t left = c->comes; left != 0; left &= left - 1)
        row_list_add(&s->comes_after[__builtin_ctz(left)], (uint32_t)i);
    if (c->here != 0 && lost_of(c) != 0)
        row_list_add(&s->comes_after[HALO_ANY], (uint32_t)i);
    if (c->here == 0 && c->at_home != 0)
        row_list_add(&s->comes_after[HALO_LATE], (uint32_t)i);
}

static void list_ghosts(halo_side *s, duet_error *own)
{
    bool failed = false;
    for (int k = 0; k < HALO_LISTS; ++k)
        list_clear(&s->comes_after[k].list);
    for (uint64_t i = 0; i < s->items.n; ++i)
        list_ghost(s, i);
    for (int k = 0; k < HALO_LISTS; ++k)
        failed = failed || s->comes_after[k].failed;
    if (failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "a halo: no memory");
}

void halo_ask(halo *h, moving *m, duet_error *own)
{
    const size_t bytes = sizeof(ghost_colours);
    memcpy(h->received.rows.rows, h->received.colours, h->received.items.n * bytes);
    tell(h, m, &h->received, &h->sent, (uint32_t)bytes);
    memcpy(h->sent.colours, h->sent.rows.rows, h->sent.items.n * bytes);
    list_ghosts(&h->sent, own);
    list_ghosts(&h->received, own);
}
