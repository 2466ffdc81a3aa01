// SPDX-License-Identifier: MIT
#include "cluster/waiting.h"

#include "base/compare.h"
#include "base/error.h"
#include "cluster/moving_domains.h"

#include <stdlib.h>

// ---------------------------------------------------------------- whom contacts are told

// An own body that is an end of a contact of the list.
typedef struct waiting_end {
    uint32_t id, contact;
} waiting_end;

typedef LIST_OF(waiting_end, ends) end_list;

// A contact, by its ids, is told to a rank.
typedef struct waiting_told {
    uint32_t rank, owner, other;
} waiting_told;

typedef LIST_OF(waiting_told, rows) told_list;

static int compare_told(const void *left, const void *right)
{
    const waiting_told *a = left, *b = right;
    if (a->rank != b->rank)
        return compare_uint32(&a->rank, &b->rank);
    return a->owner != b->owner ? compare_uint32(&a->owner, &b->owner)
                                : compare_uint32(&a->other, &b->other);
}

static void list_ends(const waiting_list *known, end_list *list)
{
    for (uint32_t i = 0; i < known->n; ++i) {
        const waiting_contact *c = &known->contacts[i];
        list_add(&list->list, &(waiting_end){c->owner, i}, 1, sizeof(waiting_end));
        if (c->other_moves)
            list_add(&list->list, &(waiting_end){c->other, i}, 1, sizeof(waiting_end));
    }
}

// Items from one domain to another follow each other and ascend by ids (halo_settle).
static uint64_t end_of_run(const halo_item *items, uint64_t first, uint64_t n)
{
    const halo_item *of = &items[first];
    uint64_t low = first + 1;
    while (low < n) {
        const uint64_t middle = low + (n - low) / 2;
        const halo_item *item = &items[middle];
        if (item->rank == of->rank && item->to == of->to && item->from == of->from)
            low = middle + 1;
        else
            n = middle;
    }
    return low;
}

static int compare_ids(const void *left, const void *right)
{
    const halo_item *a = left, *b = right;
    return compare_uint32(&a->id, &b->id);
}

// Looks ends up among the ghosts that one domain has of another: these are many more.
static void tell_run(const waiting_list *known, const end_list *ends, const halo_item *items,
                     uint64_t n, told_list *told)
{
    for (uint64_t k = 0; k < ends->n; ++k) {
        const waiting_contact *c = &known->contacts[ends->ends[k].contact];
        const waiting_told one = {items->rank, c->owner, c->other};
        const halo_item key = {.id = ends->ends[k].id};
        if (bsearch(&key, items, n, sizeof *items, compare_ids))
            list_add(&told->list, &one, 1, sizeof one);
    }
}

static void sort_told(told_list *told)
{
    uint64_t kept = 0;
    if (told->n > 0)
        qsort(told->rows, told->n, sizeof *told->rows, compare_told);
    for (uint64_t i = 0; i < told->n; ++i)
        if (kept == 0 || compare_told(&told->rows[kept - 1], &told->rows[i]) != 0)
            told->rows[kept++] = told->rows[i];
    told->n = kept;
}

// The ranks that have an end as a ghost; each contact once.
static void list_told(const moving *m, const waiting_list *known, const end_list *ends,
                      told_list *told)
{
    const halo_item *sent = m->halo.sent.items.items;
    const uint64_t n = m->halo.sent.items.n;
    for (uint64_t from = 0, to; from < n; from = to) {
        to = end_of_run(sent, from, n);
        if (sent[from].rank != (uint32_t)m->ranks->self)
            tell_run(known, ends, sent + from, to - from, told);
    }
    if (!told->failed)
        sort_told(told);
}

static void choose_told(const moving *m, const waiting_list *known, told_list *told,
                        duet_error *own)
{
    end_list ends = {0};
    if (is_well(own) && !known->failed)
        list_ends(known, &ends);
    if (is_well(own) && !known->failed && !ends.failed)
        list_told(m, known, &ends, told);
    if (known->failed || ends.failed || told->failed)
        no_memory(own, "contacts that wait for colours");
    free(ends.ends);
}

// ---------------------------------------------------------------- rounds

typedef struct telling {
    const waiting_list *known;
    const told_list *told;
} telling;

static int rank_of(const void *context, uint64_t i)
{
    return (int)((const telling *)context)->told->rows[i].rank;
}

static const waiting_contact *contact_of(const waiting_list *known, const waiting_told *told)
{
    return &known->contacts[colouring_place(known->contacts, known->n, told->owner, told->other)];
}

static void write_contact(const void *context, uint64_t i, void *row)
{
    const telling *t = context;
    waiting_contact c = *contact_of(t->known, &t->told->rows[i]);
    c.is_decided_here = 0;
    memcpy(row, &c, sizeof c);
}

// Tells so many of them.
static bool tell(moving *m, waiting_list *known, const told_list *told, uint64_t n, duet_error *own)
{
    const telling t = {known, told};
    parcels in = {0};
    const parcels_def out = {.n = n,
                             .row_bytes = sizeof(waiting_contact),
                             .write = write_contact,
                             .rank_of = rank_of,
                             .context = &t};
    if (!parcels_deal(m->ranks, is_well(own), &out, &in, own))
        return false;
    m->counts.told += n;
    list_add(&known->list, in.rows, in.n, sizeof(waiting_contact));
    if (known->failed)
        no_memory(own, "contacts that wait for colours");
    parcels_end(&in);
    return true;
}

// Contacts that have a colour now come first, to be told once more; returns how many.
static uint64_t bring_forward(const waiting_list *known, told_list *told)
{
    uint64_t n = 0;
    for (uint64_t i = 0; i < told->n; ++i)
        if (contact_of(known, &told->rows[i])->colour != COLOUR_WAITS) {
            const waiting_told one = told->rows[i];
            told->rows[i] = told->rows[n];
            told->rows[n++] = one;
        }
    return n;
}

static void forget_first(told_list *told, uint64_t n)
{
    told->n -= n;
    if (n > 0)
        memmove(told->rows, told->rows + n, told->n * sizeof *told->rows);
}

// Colours what it can; t: contacts of all ranks that wait on, and that are still to be told.
static bool run(moving *m, waiting_list *known, told_list *told, uint64_t *n_told, tally *t,
                duet_error *own)
{
    *t = (tally){0};
    if (is_well(own) && colouring_run(known->contacts, &known->n, &t->sums[0], own))
        *n_told = bring_forward(known, told);
    t->sums[1] = *n_told;
    return ranks_agree_and(m->ranks, is_well(own), t, own);
}

static bool run_rounds(moving *m, waiting_list *known, told_list *told, duet_error *own)
{
    tally t = {0};
    uint64_t n = 0;
    bool ok = tell(m, known, told, told->n, own) && run(m, known, told, &n, &t, own);
    while (ok && (t.sums[0] > 0 || (m->every > 1 && t.sums[1] > 0))) {
        ok = tell(m, known, told, n, own);
        forget_first(told, n);
        n = 0;
        ok = ok && run(m, known, told, &n, &t, own);
    }
    return ok;
}

bool waiting_colour(moving *m, waiting_list *known, duet_error *own)
{
    told_list told = {0};
    if (!known->failed)
        known->n = colouring_sort(known->contacts, known->n);
    m->counts.waited += known->n;
    choose_told(m, known, &told, own);
    bool ok = run_rounds(m, known, &told, own);
    free(told.rows);
    return ok;
}
