// SPDX-License-Identifier: MIT
#include "cluster/closure.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

// The search, from the last colour back.
typedef struct search {
    closure *c;
    uint64_t first[CLOSURE_COLOURS + 2]; // of each colour's contacts in by_colour
    uint64_t *by_colour;                 // [n_contacts]
    uint32_t *kept;                      // [n_ghosts] colours of contacts that may be solved here
    bool *is_needed;                     // [n_ghosts] right after the colour that is looked at
    uint64_t *needed;                    // which these are
    uint64_t n_needed;
} search;

static bool begin(search *s, closure *c)
{
    const uint64_t n = c->n_ghosts;
    *s = (search){.c = c};
    s->by_colour = malloc(c->n_contacts * sizeof *s->by_colour + 1);
    s->kept = calloc(n + 1, sizeof *s->kept);
    s->is_needed = calloc(n + 1, sizeof *s->is_needed);
    s->needed = malloc((n + 1) * sizeof *s->needed);
    return s->by_colour && s->kept && s->is_needed && s->needed;
}

static void end(search *s)
{
    free(s->by_colour);
    free(s->kept);
    free(s->is_needed);
    free(s->needed);
}

static void sort_by_colour(search *s)
{
    const closure *c = s->c;
    uint64_t at[CLOSURE_COLOURS + 1];
    for (uint64_t i = 0; i < c->n_contacts; ++i)
        ++s->first[c->contacts[i].colour + 1];
    for (uint32_t k = 0; k <= CLOSURE_COLOURS; ++k)
        s->first[k + 1] += s->first[k];
    memcpy(at, s->first, sizeof at);
    for (uint64_t i = 0; i < c->n_contacts; ++i)
        s->by_colour[at[c->contacts[i].colour]++] = i;
}

static void note_kept(search *s)
{
    const closure *c = s->c;
    for (uint64_t i = 0; i < c->n_contacts; ++i)
        for (int k = 0; k < 2; ++k)
            if (c->contacts[i].ghosts[k] != CLOSURE_NONE)
                s->kept[c->contacts[i].ghosts[k]] |= 1u << c->contacts[i].colour;
}

static void need(search *s, uint32_t ghost)
{
    if (ghost == CLOSURE_NONE || s->is_needed[ghost])
        return;
    s->is_needed[ghost] = true;
    s->needed[s->n_needed++] = ghost;
}

static bool is_needed(const search *s, const border_contact *one)
{
    bool needed = one->is_solved;
    for (int k = 0; k < 2; ++k)
        needed = needed || (one->ghosts[k] != CLOSURE_NONE && s->is_needed[one->ghosts[k]]);
    return needed;
}

// Takes the contacts of a colour that are needed.
static void take(search *s, uint32_t colour)
{
    for (uint64_t i = s->first[colour]; i < s->first[colour + 1]; ++i) {
        border_contact *one = &s->c->contacts[s->by_colour[i]];
        one->is_solved = is_needed(s, one);
        for (int k = 0; one->is_solved && k < 2; ++k) {
            if (one->ghosts[k] != CLOSURE_NONE)
                s->c->ghosts[one->ghosts[k]].here |= 1u << colour;
            need(s, one->ghosts[k]);
        }
    }
}

// Contacts that are solved in order come when all ghosts are right.
static void take_in_order(search *s)
{
    for (uint64_t i = s->first[CLOSURE_COLOURS]; i < s->first[CLOSURE_COLOURS + 1]; ++i) {
        const border_contact *one = &s->c->contacts[s->by_colour[i]];
        for (int k = 0; one->is_solved && k < 2; ++k)
            if (one->ghosts[k] != CLOSURE_NONE)
                s->c->ghosts[one->ghosts[k]].here |= 1u << CLOSURE_COLOURS;
    }
}

// Whether a ghost that is needed after a colour is changed by it, at home and not here.
static bool lacks(const search *s, uint32_t colour)
{
    bool found = false;
    for (uint64_t i = 0; !found && i < s->n_needed; ++i) {
        const uint64_t ghost = s->needed[i];
        found = (s->c->ghosts[ghost].at_home & ~s->kept[ghost]) >> colour & 1u;
    }
    return found;
}

// Ghosts that are needed come after a colour.
static void bring(search *s, uint32_t colour)
{
    for (uint64_t i = 0; i < s->n_needed; ++i) {
        s->c->ghosts[s->needed[i]].comes |= 1u << colour;
        s->is_needed[s->needed[i]] = false;
    }
    s->n_needed = 0;
}

static void find_solved(search *s)
{
    uint32_t taken = 0;
    for (uint32_t colour = CLOSURE_COLOURS; colour-- > 0;) {
        if (taken >= s->c->every || lacks(s, colour)) {
            bring(s, colour);
            taken = 0;
        }
        take(s, colour);
        taken += s->first[colour + 1] > s->first[colour];
    }
}

// Leaves the times at which a ghost is wrong, of those at which it is needed.
static void leave_wrong(ghost_colours *g)
{
    const uint32_t all = (1u << CLOSURE_COLOURS) - 1, lost = g->at_home & ~g->here & all;
    uint32_t wanted = g->comes;
    bool is_wrong = false;
    g->comes = 0;
    for (uint32_t colour = 0; lost != 0 && colour < CLOSURE_COLOURS; ++colour) {
        is_wrong = is_wrong || (lost >> colour & 1u);
        if (is_wrong && (wanted >> colour & 1u)) {
            g->comes |= 1u << colour;
            is_wrong = false;
        }
    }
    if (g->here != 0 && is_wrong)
        g->comes |= 1u << CLOSURE_END;
}

bool closure_find(closure *c, duet_error *err)
{
    search s;
    for (uint64_t i = 0; i < c->n_ghosts; ++i)
        c->ghosts[i] = (ghost_colours){.at_home = c->ghosts[i].at_home};
    bool ok = begin(&s, c);
    if (ok) {
        sort_by_colour(&s);
        note_kept(&s);
        take_in_order(&s);
        find_solved(&s);
        for (uint64_t i = 0; i < c->n_ghosts; ++i)
            leave_wrong(&c->ghosts[i]);
    }
    end(&s);
    return ok || error_set(err, DUET_STATUS_NO_MEMORY, "the contacts at a border: no memory");
}
