// SPDX-License-Identifier: MIT
#include "runtime/dynamics/pair_list.h"

#include "base/error.h"

#include <stdlib.h>

bool pair_list_grow(void **rows, size_t *capacity, size_t n, size_t size, duet_error *err)
{
    if (n <= *capacity)
        return true;
    void *grown = realloc(*rows, n * size);
    if (!grown)
        return no_memory(err, "%zu pairs", n);
    *rows = grown;
    *capacity = n;
    return true;
}

bool pair_list_reserve(pair_list *list, size_t n, duet_error *err)
{
    return pair_list_grow((void **)&list->pairs, &list->capacity, n, sizeof *list->pairs, err);
}

void pair_list_free(pair_list *list)
{
    free(list->pairs);
    *list = (pair_list){0};
}

// ---------------------------------------------------------------- order

enum { DIGIT = 11, DIGITS = 1 << DIGIT };

// Numbers that order like pairs. No pair has the greatest one: its ids differ.
static uint64_t key_of(duet_pair p)
{
    return (uint64_t)p.a << 32 | p.b;
}

static uint32_t digit_of(duet_pair p, uint32_t shift)
{
    return (uint32_t)(key_of(p) >> shift) & (DIGITS - 1);
}

// By one digit; false if all have the same, and nothing is moved.
static bool sort_by(const duet_pair *from, duet_pair *to, size_t n, uint32_t shift)
{
    size_t places[DIGITS] = {0};
    for (size_t i = 0; i < n; ++i)
        ++places[digit_of(from[i], shift)];
    if (places[digit_of(from[0], shift)] == n)
        return false;
    size_t before = 0;
    for (uint32_t d = 0; d < DIGITS; ++d) {
        size_t count = places[d];
        places[d] = before;
        before += count;
    }
    for (size_t i = 0; i < n; ++i)
        to[places[digit_of(from[i], shift)]++] = from[i];
    return true;
}

// Whether pairs ascend, once each has its lesser id first.
static bool order_each(pair_list *list)
{
    uint64_t last = 0;
    bool ascend = true;
    for (size_t i = 0; i < list->n; ++i) {
        duet_pair *p = &list->pairs[i];
        if (p->b < p->a)
            *p = (duet_pair){p->b, p->a};
        ascend = ascend && last <= key_of(*p);
        last = key_of(*p);
    }
    return ascend;
}

bool pair_list_sort(pair_list *list, duet_error *err)
{
    if (order_each(list))
        return true;
    pair_list other = {0};
    if (!pair_list_reserve(&other, list->capacity, err))
        return false;
    other.n = list->n;
    for (uint32_t shift = 0; shift < 64; shift += DIGIT) {
        if (!sort_by(list->pairs, other.pairs, list->n, shift))
            continue;
        pair_list kept = *list;
        *list = other;
        other = kept;
    }
    pair_list_free(&other);
    return true;
}

// ---------------------------------------------------------------- changes

bool pair_changes_find(pair_changes *c, const pair_list *before, const pair_list *now,
                       duet_error *err)
{
    if (!pair_list_reserve(&c->stays, now->n, err) ||
        !pair_list_grow((void **)&c->events, &c->capacity, before->n + now->n, sizeof *c->events,
                        err))
        return false;
    c->n_events = c->stays.n = 0;
    for (size_t i = 0, k = 0; i < before->n || k < now->n;) {
        uint64_t was = i < before->n ? key_of(before->pairs[i]) : UINT64_MAX;
        uint64_t is = k < now->n ? key_of(now->pairs[k]) : UINT64_MAX;
        duet_pair p = was < is ? before->pairs[i] : now->pairs[k];
        i += was <= is;
        k += is <= was;
        if (was == is)
            c->stays.pairs[c->stays.n++] = p;
        else
            c->events[c->n_events++] = (duet_event){p.a, p.b, is < was};
    }
    return true;
}

void pair_changes_free(pair_changes *c)
{
    pair_list_free(&c->stays);
    free(c->events);
    *c = (pair_changes){0};
}
