// SPDX-License-Identifier: MIT
// Contacts between domains have the colours that follow from their ids, whoever tells of them.
#include "cluster/motion/moving.h"

#include "base/rng.h"
#include "cluster/colouring.h"
#include "kernels/dynamics/records.h"

enum { MOST_CONTACTS = 200, MOST_BODIES = 40 };

// Contacts of two bodies in six, each end of which has a colour already.
static uint64_t draw_contacts(rng *r, waiting_contact c[MOST_CONTACTS])
{
    uint64_t n = 0;
    for (uint32_t a = 0; a < MOST_BODIES; ++a)
        for (uint32_t b = a + 1; b < MOST_BODIES && n < MOST_CONTACTS; ++b)
            if (rng_below(r, 6) == 0)
                c[n++] =
                    (waiting_contact){a, b, b % 7 != 0, 1u << a % 5, 1u << b % 5, COLOUR_WAITS, 1};
    return n;
}

// Whether no two contacts at one body have one colour, of those below COLOUR_OVERFLOW.
static bool are_apart(const waiting_contact *c, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i)
        for (uint64_t k = 0; k < i; ++k) {
            bool meet = c[i].owner == c[k].owner ||
                        (c[i].other_moves && c[i].other == c[k].owner) ||
                        (c[k].other_moves && c[k].other == c[i].owner) ||
                        (c[i].other_moves && c[k].other_moves && c[i].other == c[k].other);
            if (meet && c[i].colour == c[k].colour && c[i].colour < COLOUR_OVERFLOW)
                return false;
        }
    return true;
}

// Which domain tells of a contact, and in which order, changes no colour.
FACT_OF_ONE(colours_follow_from_ids)
{
    rng r = rng_seed(job_seed);
    waiting_contact once[MOST_CONTACTS], twice[2 * MOST_CONTACTS];
    uint64_t n = draw_contacts(&r, once), m = 0, left;
    for (uint64_t i = n; i-- > 0;) {
        twice[m] = once[i];
        twice[m++].owner_used = 0;
        twice[m] = once[i];
        twice[m++].other_used = 0;
    }
    must(colouring_run(once, &n, &left, ERR) && left == 0);
    must(colouring_run(twice, &m, &left, ERR) && left == 0);
    MUST(m == n, "contacts that two domains know are one");
    MUST(memcmp(once, twice, n * sizeof *once) == 0, "other colours");
    MUST(are_apart(once, n), "two contacts of a body have one colour");
    for (uint64_t i = 0; i < n; ++i) {
        uint32_t used = once[i].owner_used | (once[i].other_moves ? once[i].other_used : 0);
        MUST(!(used >> once[i].colour & 1u), "a colour that an end had");
        MUST(colouring_find(once, n, once[i].owner, once[i].other) == once[i].colour, "found");
    }
    MUST(colouring_find(once, n, MOST_BODIES, 0) == COLOUR_NONE, "no such contact");
}

enum { HOMES = 4 };

// The contacts that a home knows: those of its own bodies, and of the bodies that these touch.
typedef struct home_contacts {
    waiting_contact contacts[5 * MOST_CONTACTS];
    uint64_t n, n_left;
} home_contacts;

static bool has_body(const waiting_contact *all, uint64_t n, const uint32_t *home, uint32_t k,
                     uint32_t body)
{
    bool has = home[body] == k;
    for (uint64_t i = 0; i < n && !has; ++i)
        has = (all[i].owner == body && home[all[i].other] == k) ||
              (all[i].other == body && all[i].other_moves && home[all[i].owner] == k);
    return has;
}

static bool is_of(const waiting_contact *c, const uint32_t *home, uint32_t k)
{
    return home[c->owner] == k || (c->other_moves && home[c->other] == k);
}

// Tells each home what another one decides, as far as it has an end of it.
static void tell_homes(const waiting_contact *all, uint64_t n, const uint32_t *home,
                       home_contacts *homes)
{
    static home_contacts before[HOMES];
    memcpy(before, homes, sizeof before);
    for (uint32_t k = 0; k < HOMES; ++k)
        for (uint32_t from = 0; from < HOMES; ++from)
            for (uint64_t i = 0; from != k && i < n; ++i) {
                const waiting_contact *c = &all[i];
                uint64_t place =
                    colouring_place(before[from].contacts, before[from].n, c->owner, c->other);
                if (place == before[from].n || !before[from].contacts[place].is_decided_here ||
                    !(has_body(all, n, home, k, c->owner) ||
                      (c->other_moves && has_body(all, n, home, k, c->other))))
                    continue;
                waiting_contact told = before[from].contacts[place];
                told.is_decided_here = 0;
                MUST(homes[k].n < 5 * MOST_CONTACTS, "space");
                homes[k].contacts[homes[k].n++] = told;
            }
}

// Homes that know of no more than their bodies and the ones that these touch find the colours that
// follow from all contacts, in some rounds.
FACT_OF_ONE(homes_colour_together)
{
    static home_contacts homes[HOMES];
    rng r = rng_seed(job_seed);
    waiting_contact all[MOST_CONTACTS];
    uint32_t home[MOST_BODIES];
    for (uint32_t a = 0; a < MOST_BODIES; ++a)
        home[a] = rng_below(&r, HOMES);
    uint64_t n = draw_contacts(&r, all), left = 1, rounds = 0;
    for (uint32_t k = 0; k < HOMES; ++k) {
        homes[k].n = 0;
        for (uint64_t i = 0; i < n; ++i) {
            if (!is_of(&all[i], home, k))
                continue;
            waiting_contact c = all[i];
            c.owner_used = home[c.owner] == k ? c.owner_used : 0;
            c.other_used = home[c.other] == k ? c.other_used : 0;
            homes[k].contacts[homes[k].n++] = c;
        }
    }
    for (; left > 0 && rounds < MOST_CONTACTS; ++rounds) {
        tell_homes(all, n, home, homes);
        left = 0;
        for (uint32_t k = 0; k < HOMES; ++k) {
            must(colouring_run(homes[k].contacts, &homes[k].n, &homes[k].n_left, ERR));
            left += homes[k].n_left;
        }
    }
    MUST(rounds > 1 && left == 0, "rounds end");
    must(colouring_run(all, &n, &left, ERR));
    for (uint32_t k = 0; k < HOMES; ++k)
        for (uint64_t i = 0; i < homes[k].n; ++i) {
            const waiting_contact *c = &homes[k].contacts[i];
            MUST(!c->is_decided_here || colouring_find(all, n, c->owner, c->other) == c->colour,
                 "a home finds the colours of all");
        }
}
