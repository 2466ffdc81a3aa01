// SPDX-License-Identifier: MIT
#include "cluster/colouring.h"

#include "base/error.h"
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

uint64_t colouring_sort(waiting_contact *contacts, uint64_t n)
{
    if (n > 0)
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
    uint32_t id, used;
    bool waits; // a contact of greater rank has no colour yet
} end;

static int compare_ends(const void *left, const void *right)
{
    const end *a = left, *b = right;
    return a->id < b->id ? -1 : a->id > b->id;
}

static uint64_t list_ends(const waiting_contact *contacts, uint64_t n, end *ends)
{
    uint64_t all = 0, kept = 0;
    for (uint64_t i = 0; i < n; ++i) {
        ends[all++] = (end){contacts[i].owner, contacts[i].owner_used, false};
        if (contacts[i].other_moves)
            ends[all++] = (end){contacts[i].other, contacts[i].other_used, false};
    }
    qsort(ends, all, sizeof *ends, compare_ends);
    for (uint64_t i = 0; i < all; ++i)
        if (kept > 0 && ends[kept - 1].id == ends[i].id)
            ends[kept - 1].used |= ends[i].used;
        else
            ends[kept++] = ends[i];
    return kept;
}

static end *find_end(end *ends, uint64_t n, uint32_t id)
{
    const end key = {.id = id};
    return bsearch(&key, ends, n, sizeof *ends, compare_ends);
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

typedef struct turn {
    uint32_t rank;
    waiting_contact *contact;
} turn;

// The greatest rank comes first; of equal ones the first contact.
static int compare_turns(const void *left, const void *right)
{
    const turn *a = left, *b = right;
    if (a->rank != b->rank)
        return a->rank > b->rank ? -1 : 1;
    return a->contact < b->contact ? -1 : a->contact > b->contact;
}

static uint32_t least_free(uint32_t used)
{
    uint32_t colour = 0;
    while (colour < COLOUR_OVERFLOW && (used >> colour & 1u))
        ++colour;
    return colour;
}

static void take_colour(waiting_contact *c, end *ends, uint64_t n_ends)
{
    end *owner = find_end(ends, n_ends, c->owner);
    end *other = c->other_moves ? find_end(ends, n_ends, c->other) : owner;
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

bool colouring_run(waiting_contact *contacts, uint64_t *n, uint64_t *n_left, duet_error *err)
{
    *n = colouring_sort(contacts, *n);
    end *ends = malloc(2 * *n * sizeof *ends + 1);
    turn *turns = malloc(*n * sizeof *turns + 1);
    bool ok = ends && turns;
    uint64_t n_ends = ok && *n > 0 ? list_ends(contacts, *n, ends) : 0;
    for (uint64_t i = 0; ok && i < *n; ++i)
        turns[i] = (turn){rank_of(contacts[i].owner, contacts[i].other), &contacts[i]};
    if (ok && *n > 0)
        qsort(turns, *n, sizeof *turns, compare_turns);
    for (uint64_t i = 0; ok && i < *n; ++i)
        take_colour(turns[i].contact, ends, n_ends);
    *n_left = count_left(contacts, *n);
    free(ends);
    free(turns);
    return ok || error_set(err, DUET_STATUS_NO_MEMORY,
                           "the colours of %" PRIu64 " contacts: no memory", *n);
}
