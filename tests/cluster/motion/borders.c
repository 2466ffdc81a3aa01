// SPDX-License-Identifier: MIT
// Which domain a body is in, and how borders follow bodies and their work.
#include "cluster/motion/moving.h"

#include "base/rng.h"
#include "runtime/broadphase/world.h"

#include <math.h>

static extent cube_at(double x, double y)
{
    return (extent){{x - 0.5, y - 0.5, 0.0}, {x + 0.5, y + 0.5, 1.0}};
}

// Two domains side by side, whose reaches overlap for x from 9 to 11.
FACT_OF_ONE(bodies_far_from_borders_stay)
{
    extent reaches[] = {{{0, 0, 0}, {11, 10, 1}}, {{9, 0, 0}, {20, 10, 1}}};
    uint32_t others[] = {1, 0};
    const moving m = {.n_domains = 2, .reaches = reaches};
    const moving_domain first = {.number = 0, .neighbours = {.rows = &others[0], .n = 1}},
                        second = {.number = 1, .neighbours = {.rows = &others[1], .n = 1}};
    static const struct {
        double from, to; // x; y is 5
        bool stays;
    } moves[] = {
        {3, 3.2, true},   // inside
        {3, 8, true},     // it meets the other's reach neither before nor now
        {3, 9, false},    // now it does
        {9, 10.4, true},  // it did before, so it is a ghost there
        {9, 10.6, false}, // it leaves its own domain's reach
        {10.6, 9, true},  // back into it
    };
    for (size_t i = 0; i < sizeof moves / sizeof *moves; ++i) {
        const extent old = cube_at(moves[i].from, 5), now = cube_at(moves[i].to, 5);
        MUST(moving_stays(&m, &first, &old, &now) == moves[i].stays, "whether a body stays");
        const extent mirrored = cube_at(20 - moves[i].from, 5),
                     there = cube_at(20 - moves[i].to, 5);
        MUST(moving_stays(&m, &second, &mirrored, &there) == moves[i].stays, "as in a mirror");
    }
}

static bool is_within(const float b[6], const float e[6])
{
    bool within = true;
    for (int k = 0; k < 3; ++k)
        within = within && b[k] >= e[k] && b[k + 3] <= e[k + 3];
    return within;
}

static bool do_meet(const float b[6], const float e[6])
{
    bool meet = true;
    for (int k = 0; k < 3; ++k)
        meet = meet && b[k] <= e[k + 3] && b[k + 3] >= e[k];
    return meet;
}

// Its own bodies that leave the first extent or meet another, each once and with its bounds.
FACT_OF_ONE(bodies_near_extents_are_listed)
{
    static const float extents[][6] = {{-1, -1, -1, 6, 6, 6}, {0, 0, 0, 2, 2, 3}};
    duet_cluster *cluster = two_domains_after_steps("300", 1, 1);
    const moving_domain *d = &cluster->moving->domains[1];
    domain_near *near;
    uint32_t n, expected = 0;
    bool *told = calloc(d->bodies.n, sizeof *told);
    MUST(told, "memory");
    must(domain_list_near(d->motion, extents[0], 2, &near, &n, ERR));
    float *bounds = kept_bounds_of(d);
    for (uint32_t i = 0; i < n; ++i) {
        MUST(near[i].place < d->bodies.n && !told[near[i].place], "a body is listed once");
        told[near[i].place] = true;
        MUST(memcmp(near[i].bounds, bounds + 6 * near[i].place, sizeof near[i].bounds) == 0,
             "with its bounds");
    }
    for (uint32_t i = 0; i < d->bodies.n; ++i) {
        const float *b = bounds + 6 * i;
        bool is_near = (d->places[i].kind & PLACE_OWN) &&
                       (!is_within(b, extents[0]) || do_meet(b, extents[1]));
        MUST(told[i] == is_near, "own bodies near extents");
        expected += is_near;
    }
    MUST(n == expected && n > 0 && n < d->n_own, "some are near");
    free(near);
    free(bounds);
    free(told);
    duet_cluster_destroy(cluster);
}

// Between steps the borders are cut at random, so that bodies, with their contacts, their sleep and
// what is told of them, change domains all the time.
FACT(borders_change_nothing)
{
    rng r = rng_seed(job_seed); // the same on all ranks
    outcome own = {0};
    const moving_scene s = {"events.lua", .steps = 90};
    const outcome expected = expected_outcome(&s);
    duet_cluster *cluster = begin_on(3, 2, 31, &s);
    for (uint32_t i = 0; cluster && i < s.steps; ++i) {
        for (uint32_t k = 1; k < cluster->moving->cuts.n; ++k)
            cluster->moving->cuts.planes[k] =
                (bisection_plane){rng_between(&r, 0, 6), rng_below(&r, 3)};
        for (uint32_t times = rng_below(&r, 3); times > 0; --times)
            must(moving_settle(cluster->moving, ERR));
        const duet_cluster_motion_result result = advance(cluster, 1);
        add_told(&own, i, &result);
    }
    if (!cluster)
        return;
    own.hash = state_hash(cluster);
    MUST(own.hash == expected.hash, "other borders give other bits");
    must_tell_alike(own, &expected, cluster, "other borders tell of others");
    duet_cluster_destroy(cluster);
}

static uint32_t most_own(const duet_cluster *c)
{
    uint32_t most = c->moving->domains[0].n_own;
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_UINT32_T, MPI_MAX, c->ranks.comm);
    return most;
}

// All bodies are one domain's, and the world is cut anew in the next step.
FACT(borders_follow_bodies)
{
    const moving_scene s = {"orbit2d", {{"n", "400"}}, .steps = 0};
    duet_cluster *cluster = begin_on(4, 1, 0, &s);
    if (!cluster)
        return;
    moving *m = cluster->moving;
    for (uint32_t k = 1; k < m->cuts.n; ++k)
        m->cuts.planes[k] = (bisection_plane){1e6, 0};
    must(moving_settle(m, ERR));
    MUST(most_own(cluster) == 400, "all are of one domain");
    advance(cluster, 1);
    MUST(most_own(cluster) <= 104, "a quarter is each domain's");
    duet_cluster_destroy(cluster);
}

// Own bodies and ghosts whose bounds begin outside of the cells in which pairs were searched, or
// nearly so, and how many there are.
static void count_outside(const moving_domain *d, uint64_t counts[2])
{
    const grid_level *cells = &d->motion->graph.world->grid.levels[0];
    float *bounds = bounds_of(d);
    for (uint64_t i = 0; i < d->bodies.n; ++i) {
        bool inside = true;
        for (int k = 0; k < 3; ++k) {
            const float at = (bounds[6 * i + k] - cells->lower.s[k]) * cells->per_cell.s[k];
            inside &= at > -1.0f && at < (float)cells->cells.s[k] + 1.0f;
        }
        counts[0] += !inside;
        ++counts[1];
    }
    free(bounds);
}

// The world is cut across another side, and each domain's bodies lie elsewhere than before: the
// cells in which it searches pairs are where they are.
FACT(cells_follow_bodies)
{
    const moving_scene s = {"falling", {{"n", "2000"}}, .steps = 0};
    duet_cluster *cluster = begin_on(2, 1, 1, &s);
    if (!cluster)
        return;
    moving *m = cluster->moving;
    for (uint32_t axis = 0; axis < 4; ++axis) {
        uint64_t counts[2] = {0};
        m->cuts.planes[1] = (bisection_plane){8.5, axis % 2};
        must(moving_settle(m, ERR));
        advance(cluster, 1);
        count_outside(&m->domains[0], counts);
        MUST(counts[1] >= 900 && counts[0] == 0, "bodies lie in the cells");
    }
    duet_cluster_destroy(cluster);
}

// A step that one domain searches its pairs for has all of them search.
FACT(domains_search_together)
{
    const moving_scene s = {"falling", {{"n", "3000"}}, .steps = 30};
    uint32_t searched = 0;
    duet_cluster *cluster = begin_on(3, 2, 1, &s);
    for (uint32_t i = 0; cluster && i < s.steps; ++i) {
        uint64_t counts[2] = {0};
        advance(cluster, 1);
        for (uint32_t k = 0; k < cluster->moving->parts; ++k) {
            duet_motion *motion = cluster->moving->domains[k].motion;
            duet_result search;
            counts[0] += motion->n > 0;
            counts[1] += motion_take_search(motion, &search);
        }
        ranks_sum(&cluster->ranks, counts, 2);
        MUST(counts[1] == 0 || counts[1] == counts[0], "all domains search, or none does");
        searched += counts[1] > 0;
    }
    MUST(!cluster || (searched > 5 && searched + 5 < s.steps), "some steps have a search");
    duet_cluster_destroy(cluster);
}

// How much more the rank with the most work has than the mean one, as ranks weigh bodies and ends.
static double imbalance_of(const duet_cluster *c)
{
    const moving_domain *d = &c->moving->domains[0];
    const double ends = 2.0 * d->motion->solver.n_pushing;
    double most = work_of(&c->moving->balance.model, d->n_own, ends), sum = most;
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, c->ranks.comm);
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, c->ranks.comm);
    return most * c->ranks.n / sum;
}

FACT(ranks_have_alike_much_to_do)
{
    const moving_scene s = {"unequal.lua", .steps = 60, .least_contacts = 900};
    duet_cluster_motion_result result = {0};
    double first = 0, mean = 0;
    duet_cluster *cluster = begin_on(4, 1, 1, &s);
    for (uint32_t i = 0; cluster && i < s.steps; ++i) {
        result = advance(cluster, 1);
        const double now = imbalance_of(cluster);
        first = i == 0 ? now : first;
        mean += now / s.steps;
    }
    MUST(!cluster || result.contacts >= s.least_contacts, "a pile");
    MUST(!cluster || (first > 1.5 && mean < 1.2), "borders follow the work");
    duet_cluster_destroy(cluster);
}

// Times are made of what bodies and ends cost, and these are found in them; of ranks that all have
// as many ends for a body nothing is learnt.
FACT_OF_ONE(times_tell_what_contacts_cost)
{
    rng r = rng_seed(job_seed);
    work_model model = work_begin(), alike = work_begin();
    const double at_first = alike.end;
    for (int i = 0; i < 12; ++i) {
        work_row rows[3], same[3];
        for (int k = 0; k < 3; ++k) {
            double bodies = rng_between(&r, 1000, 2000), ends = rng_between(&r, 0, 9000);
            rows[k] = (work_row){bodies, ends, 300 * bodies + 750 * ends};
            same[k] = (work_row){bodies, 2 * bodies, rng_between(&r, 1e5, 1e6)};
        }
        work_note(&model, rows, 3);
        work_note(&alike, same, 3);
    }
    MUST(fabs(model.end - 2.5) < 1e-9, "an end costs two and a half bodies");
    MUST(alike.end == at_first, "nothing is learnt of ranks that are alike");
    MUST(fabs(work_of(&model, 100, 20) - 150) < 1e-6, "20 ends are the work of 50 bodies");
}
