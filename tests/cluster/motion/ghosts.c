// SPDX-License-Identifier: MIT
// When ghosts come, what is done while they travel, and what is told for them.
#include "cluster/motion/moving.h"

#include "base/rng.h"
#include "kernels/dynamics/records.h"

static void note_travelling(const halo_side *s, uint32_t k, bool *travels)
{
    const halo_item *items = s->items.items;
    for (uint64_t i = 0; i < s->items.n; ++i)
        if (items[i].domain == k)
            travels[items[i].place] = true;
}

// Returns how many of the last step's contacts of a domain are solved while ghosts travel: they
// have no body that does.
static uint64_t inner_contacts(const moving *m, uint32_t k)
{
    uint64_t found = 0;
    domain_contacts c;
    duet_motion *motion = m->domains[k].motion;
    const uint32_t n = motion->graph.n_contacts;
    bool *travels = must(calloc((size_t)motion->n + FIXED, sizeof *travels));
    uint32_t *list = must(malloc(((size_t)n + 1) * sizeof *list));
    note_travelling(&m->halo.sent, k, travels);
    note_travelling(&m->halo.received, k, travels);
    must(domain_read_contacts(motion, false, &c, ERR));
    must(n == 0 || motion_fetch(motion, "list", LIST, 0, list, n * sizeof *list, ERR));
    for (uint32_t colour = 0; colour < COLOUR_OVERFLOW; ++colour) {
        const colour_span *span = &motion->solver.colours[colour];
        for (uint32_t i = span->border; i < span->count; ++i, ++found) {
            const uint32_t *ends = c.links[list[span->first + i]].s;
            MUST(!travels[ends[0]] && !travels[ends[1]],
                 "inner contacts have no body that travels");
        }
    }
    domain_contacts_free(&c);
    free(list);
    free(travels);
    return found;
}

// After a step that exchanged no bodies lists are those that it solved.
FACT_OF_ONE(what_is_solved_while_ghosts_travel_has_none)
{
    static const uint32_t colours[] = {1, 4};
    const moving_scene s = {"falling", {{"n", "800"}, {"sleep", "false"}}, .steps = 100};
    for (int i = 0; i < 2; ++i) {
        uint64_t inner = 0;
        duet_cluster *cluster = begin_on(ALONE, 2, colours[i], &s);
        for (uint32_t step = 0; step < s.steps; ++step) {
            const uint64_t sent = cluster->moving->counts.sent;
            advance(cluster, 1);
            for (uint32_t k = 0; k < 2 && cluster->moving->counts.sent == sent; ++k)
                inner += inner_contacts(cluster->moving, k);
        }
        MUST(inner > 5000, "many contacts are solved while ghosts travel");
        duet_cluster_destroy(cluster);
    }
}

static uint64_t exchanges_of(const moving_scene *s, uint64_t hash, uint32_t colours)
{
    duet_cluster *cluster = begin_on(ALONE, 3, colours, s);
    const duet_cluster_motion_result result = advance(cluster, s->steps);
    MUST(result.contacts >= s->least_contacts, "many push");
    MUST(state_hash(cluster) == hash, "ghosts that come less often give other bits");
    uint64_t n = cluster->moving->halo.n_exchanges;
    duet_cluster_destroy(cluster);
    return n;
}

// A pile of 12 colours; a sweep has an exchange at its end, if each domain solves what it needs.
FACT(ghosts_come_once_a_sweep)
{
    const moving_scene s = {
        "falling", {{"n", "400"}, {"sleep", "false"}}, .steps = 90, .least_contacts = 500};
    uint64_t hash = expected_hash(&s);
    if (rank > 0)
        return;
    uint64_t each = exchanges_of(&s, hash, 1), four = exchanges_of(&s, hash, 4),
             all = exchanges_of(&s, hash, 31);
    MUST(2 * four < each, "half as many after four colours");
    MUST(3 * all < each, "less than a third after all of them");
}

// Between steps another number of colours is drawn, after which ghosts come.
FACT(colours_between_change_nothing)
{
    static const uint32_t drawn[] = {1, 2, 3, 4, 8, 31};
    const moving_scene s = {
        "falling", {{"n", "200"}, {"sleep", "false"}}, .steps = 90, .least_contacts = 200};
    const uint64_t hash = expected_hash(&s);
    rng r = rng_seed(job_seed); // the same on all ranks
    duet_cluster_motion_result result = {0};
    duet_cluster *cluster = begin_on(3, 2, 1, &s);
    if (!cluster)
        return;
    for (uint32_t i = 0; i < s.steps; ++i) {
        const uint32_t every = drawn[rng_below(&r, sizeof drawn / sizeof *drawn)];
        must(moving_set_every(cluster->moving, every, ERR));
        MUST(moving_get_every(cluster->moving) == every, "the colours that were set");
        result = advance(cluster, 1);
    }
    MUST(result.contacts >= s.least_contacts && result.ghosts > 0, "contacts at borders");
    MUST(state_hash(cluster) == hash,
         "ghosts that come now more and now less often give other bits");
    duet_cluster_destroy(cluster);
}

// Each look at the clock takes as long, so exchanges are a large part of a step.
static uint64_t ticks_ns;

static uint64_t tick_ns(void)
{
    return ticks_ns += 1000;
}

static duet_cluster_motion_result advance_by_ticks(duet_cluster *cluster, uint32_t steps)
{
    uint64_t (*now_ns)(void) = ranks_now_ns;
    ranks_now_ns = tick_ns;
    const duet_cluster_motion_result result = advance(cluster, steps);
    ranks_now_ns = now_ns;
    return result;
}

static bool is_rival(uint32_t every)
{
    bool is = false;
    for (int i = 0; i < EVERY_RIVALS; ++i)
        is = is || every_rivals[i] == every;
    return is;
}

// If nobody says how often ghosts come, each number is tried; once somebody does, none is.
FACT(ghosts_that_are_tried_change_nothing)
{
    const moving_scene s = {
        "falling", {{"n", "200"}, {"sleep", "false"}}, .steps = 130, .least_contacts = 200};
    const uint64_t hash = expected_hash(&s);
    duet_cluster *cluster = begin_on(2, 1, 0, &s);
    if (!cluster)
        return;
    const every_trial *t = moving_get_trial(cluster->moving);
    const duet_cluster_motion_result result = advance_by_ticks(cluster, s.steps);
    MUST(t->is_tried && is_rival(moving_get_every(cluster->moving)), "each number is tried");
    for (int i = 0; i < EVERY_RIVALS; ++i)
        MUST(t->best_ns[i] > 0, "each number's time");
    MUST(result.contacts >= s.least_contacts && result.ghosts > 0, "contacts at borders");
    MUST(state_hash(cluster) == hash, "a trial of how often ghosts come gives other bits");
    must(moving_set_every(cluster->moving, 2, ERR));
    advance_by_ticks(cluster, 40);
    MUST(!t->is_tried && t->turn == 0 && moving_get_every(cluster->moving) == 2, "as was said");
    duet_cluster_destroy(cluster);
}

// Each contact goes to few of eight ranks, however many these are.
FACT(what_waits_is_told_to_who_has_an_end)
{
    const moving_scene s = {"falling", {{"n", "600"}}, .steps = 110, .least_contacts = 900};
    const uint64_t hash = expected_hash(&s);
    duet_cluster *cluster = begin_on(8, 1, 1, &s);
    const duet_cluster_motion_result result = advance(cluster, s.steps);
    uint64_t counts[2] = {cluster->moving->counts.waited, cluster->moving->counts.told};
    ranks_sum(&cluster->ranks, counts, 2);
    MUST(state_hash(cluster) == hash && result.contacts >= s.least_contacts, "one motion's pile");
    MUST(counts[0] > 100 && counts[1] < 4 * counts[0], "seven are not told of all that waits");
    duet_cluster_destroy(cluster);
}

// The home of each body, and how many own bodies have bounds that leave their domain's box.
static uint64_t note_homes(moving *m, uint32_t *home)
{
    uint64_t leaving = 0;
    for (uint32_t k = 0; k < m->parts; ++k) {
        const moving_domain *d = &m->domains[k];
        const extent box = bisection_box(&m->cuts, d->number, &extent_all);
        float *bounds = bounds_of(d);
        for (uint32_t i = 0; i < d->bodies.n; ++i) {
            const float *b = bounds + 6 * i;
            const extent e = {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
            if (!moving_is_own(d, &d->bodies.rows[i]))
                continue;
            home[d->bodies.rows[i].id] = d->number;
            leaving += !extent_within(&e, &box);
        }
        free(bounds);
    }
    return leaving;
}

// Own bodies that another domain has as ghosts, by their far boxes; those that were there before.
static uint64_t count_ghosts(const moving *m, const moving_domain *d, const uint32_t *home,
                             uint64_t *stayed)
{
    const row_parts whole = {.words = {6}};
    uint64_t n = 0;
    for (uint32_t i = 0; i < d->bodies.n; ++i) {
        float b[6];
        must(domain_pack_rows(d->motion, FAR_BOXES, &whole, &i, 1, b, ERR));
        const extent e = {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
        for (uint32_t to = 0; moving_is_own(d, &d->bodies.rows[i]) && to < m->n_domains; ++to) {
            bool is_ghost = to != d->number && extents_meet(&e, &m->reaches[to]);
            n += is_ghost;
            *stayed += is_ghost && home[d->bodies.rows[i].id] == d->number;
        }
    }
    return n;
}

// The states of bodies that may leave their domain's box and of ghosts are read, and those of no
// others, however many there are.
FACT_OF_ONE(an_exchange_reads_what_travels)
{
    enum { N = 6000 };
    duet_cluster *cluster = two_domains_after_steps("6000", 1, 1);
    moving *m = cluster->moving;
    uint32_t home[N], moved = 0;
    const moving_counts before = m->counts;
    const uint64_t leaving = note_homes(m, home);
    uint64_t shared = 0, stayed = 0;
    must(moving_settle(m, ERR));
    for (uint32_t k = 0; k < m->parts; ++k) {
        const moving_domain *d = &m->domains[k];
        shared += count_ghosts(m, d, home, &stayed);
        for (uint32_t i = 0; i < d->bodies.n; ++i)
            moved +=
                moving_is_own(d, &d->bodies.rows[i]) && home[d->bodies.rows[i].id] != d->number;
    }
    MUST(m->counts.read - before.read == leaving + stayed, "what may travel is read");
    MUST(m->counts.sent - before.sent == moved + shared, "what travels is sent");
    MUST(leaving > 0 && stayed > 0 && leaving + stayed < N / 2, "most bodies do not");
    duet_cluster_destroy(cluster);
}

// A motion begins, or goes on from a file, with the ghosts that its next exchange would choose. The
// scene's origin lies outside of one half, whose reach has nothing there.
FACT_OF_ONE(a_motion_begins_with_the_ghosts_that_it_needs)
{
    enum { N = 6000 };
    for (uint32_t steps = 0; steps < 2; ++steps) {
        const moving_scene s = {"falling", {{"n", "6000"}}, .steps = steps, .saved_at = steps};
        duet_cluster *cluster = two_domains_after_steps("6000", 1, steps);
        if (steps > 0)
            save_and_resume(cluster, &s);
        moving *m = cluster->moving;
        const uint64_t at_first = m->halo.sent.items.n;
        must(moving_settle(m, ERR));
        MUST(at_first > 0 && at_first == m->halo.sent.items.n, "no ghost that is not needed");
        MUST(at_first < N / 2, "most bodies are far from the border");
        duet_cluster_destroy(cluster);
    }
}
