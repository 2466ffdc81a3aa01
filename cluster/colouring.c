// SPDX-License-Identifier: MIT
#include "cluster/colouring.h"

#include "base/error.h"
#include "cluster/row_order.h"
#include "kernels/dynamics/records.h"

#include <inttypes.h>
#include <stdlib.h>

// ---------------------------------------------------------------- contacts

static int compare_ids(const void *left, const void *right)
{
    const waiting_contact *a = left, *b = right;
    if (a->owner != b->owner)
        return a->owner < b->owner ? -1 : 1;
    return a->other < b->other ? -1 : a->other > b->other;
}

static uint64_t merge_equal(waiting_contact *contacts, uint64_t n)
{
    uint64_t kept = 0;
    for (uint64_t i = 0; i < n; ++i) {
        waiting_contact *last = kept > 0 ? &contacts[kept - 1] : NULL;
        if (!last || compare_ids(last, &contacts[i]) != 0) {
            contacts[kept++] = contacts[i];
            continue;
        }
        last->owner_used |= contacts[i].owner_used;
        last->other_used |= contacts[i].other_used;
        last->colour = last->colour == COLOUR_WAITS ? contacts[i].colour : last->colour;
        last->is_decided_here |= contacts[i].is_decided_here;
    }
    return kept;
}

static uint64_t key_of(const void *row)
{
    const waiting_contact *c = row;
    return (uint64_t)c->owner << 32 | c->other;
}

uint64_t colouring_sort(waiting_contact *contacts, uint64_t n)
{
    if (!rows_sort(contacts, n, sizeof *contacts, key_of))
        qsort(contacts, n, sizeof *contacts, compare_ids);
    return merge_equal(contacts, n);
}

uint64_t colouring_place(const waiting_contact *contacts, uint64_t n, uint32_t owner,
                         uint32_t other)
{
    const waiting_contact key = {.owner = owner, .other = other};
    const waiting_contact *found =
        n > 0 ? bsearch(&key, contacts, n, sizeof *contacts, compare_ids) : NULL;
    return found ? (uint64_t)(found - contacts) : n;
}

uint32_t colouring_find(const waiting_contact *contacts, uint64_t n, uint32_t owner, uint32_t other)
{
    uint64_t place = colouring_place(contacts, n, owner, other);
    return place < n ? contacts[place].colour : COLOUR_NONE;
}

// ---------------------------------------------------------------- ends

typedef struct end {
    uint32_t used;
    bool waits; // a contact of greater rank has no colour yet
} end;

// Contacts that wait for colours, and what these follow from.
typedef struct colouring {
    waiting_contact *contacts;
    uint64_t n;
    end *ends;
    uint32_t (*ends_of)[2]; // [n] places of each contact's owner and other; of one that moves not,
                            // the owner's
    keyed_row *keys;        // [4 n], for whatever is sorted
} colouring;

static uint64_t list_ends(colouring *c)
{
    uint64_t all = 0;
    for (uint64_t i = 0; i < c->n; ++i) {
        c->keys[all++] = (keyed_row){c->contacts[i].owner, 2 * i};
        if (c->contacts[i].other_moves)
            c->keys[all++] = (keyed_row){c->contacts[i].other, 2 * i + 1};
    }
    return all;
}

static void find_ends(colouring *c)
{
    const uint64_t all = list_ends(c);
    uint32_t at = 0;
    keys_order(c->keys, all, 32);
    for (uint64_t i = 0; i < all; ++i) {
        const uint64_t one = c->keys[i].row / 2, is_other = c->keys[i].row % 2;
        const waiting_contact *contact = &c->contacts[one];
        at += i > 0 && c->keys[i].key != c->keys[i - 1].key;
        if (i == 0 || c->keys[i].key != c->keys[i - 1].key)
            c->ends[at] = (end){0};
        c->ends[at].used |= is_other ? contact->other_used : contact->owner_used;
        c->ends_of[one][is_other] = at;
        if (!contact->other_moves)
            c->ends_of[one][1] = at;
    }
}

// ---------------------------------------------------------------- order

// The contact's place among others, as rank_of in graph_colour.cl.
static uint32_t rank_of(uint32_t owner, uint32_t other)
{
    uint32_t k = owner * 0x9E3779B9u ^ (other + 0x7F4A7C15u) * 0x85EBCA6Bu;
    k ^= k >> 15;
    k *= 0x2C1B3C6Du;
    k ^= k >> 13;
    return k;
}

// The greatest rank comes first; of equal ones the first contact.
static void take_turns(colouring *c)
{
    for (uint64_t i = 0; i < c->n; ++i)
        c->keys[i] = (keyed_row){~rank_of(c->contacts[i].owner, c->contacts[i].other), i};
    keys_order(c->keys, c->n, 32);
}

static uint32_t least_free(uint32_t used)
{
    uint32_t colour = 0;
    while (colour < COLOUR_OVERFLOW && (used >> colour & 1u))
        ++colour;
    return colour;
}

static void take_colour(const colouring *all, uint64_t i)
{
    waiting_contact *c = &all->contacts[i];
    end *owner = &all->ends[all->ends_of[i][0]], *other = &all->ends[all->ends_of[i][1]];
    if (c->colour == COLOUR_WAITS && c->is_decided_here && !owner->waits && !other->waits)
        c->colour = least_free(owner->used | other->used);
    uint32_t bit = c->colour < COLOUR_OVERFLOW ? 1u << c->colour : 0;
    owner->used |= bit;
    other->used |= bit;
    owner->waits |= c->colour == COLOUR_WAITS;
    other->waits |= c->colour == COLOUR_WAITS;
}

static uint64_t count_left(const waiting_contact *contacts, uint64_t n)
{
    uint64_t left = 0;
    for (uint64_t i = 0; i < n; ++i)
        left += contacts[i].is_decided_here && contacts[i].colour == COLOUR_WAITS;
    return left;
}

static void colour(colouring *c)
{
    find_ends(c);
    take_turns(c);
    for (uint64_t i = 0; i < c->n; ++i)
        take_colour(c, c->keys[i].row);
}

bool colouring_run(waiting_contact *contacts, uint64_t *n, uint64_t *n_left, duet_error *err)
{
    *n = colouring_sort(contacts, *n);
    colouring c = {.contacts = contacts,
                   .n = *n,
                   .ends = malloc(2 * *n * sizeof *c.ends + 1),
                   .ends_of = malloc(*n * sizeof *c.ends_of + 1),
                   .keys = malloc(4 * *n * sizeof *c.keys + 1)};
    const bool ok = c.ends && c.ends_of && c.keys;
    if (ok)
        colour(&c);
    *n_left = count_left(contacts, *n);
    free(c.ends);
    free(c.ends_of);
    free(c.keys);
    return ok || no_memory(err, "the colours of %" PRIu64 " contacts", *n);
}
