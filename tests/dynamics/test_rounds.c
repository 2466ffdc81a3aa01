// SPDX-License-Identifier: MIT
// A colouring of more rounds than a launch of a team counts: a chain of bodies whose contacts have
// falling ranks, so that a round colours one. Ranks are computed here again, and the chain gives
// the truth: the rounds are its contacts, and colours alternate.
#include "support/mover.h"
#include "support/test.h"

#include "kernels/dynamics/records.h"
#include "runtime/dynamics/motion.h"

enum { ALL = 2200, CHAIN = TEAM_ROUNDS + 76 };

#define SPEED 1.5f

static uint32_t order[ALL]; // the bodies of the chain, then the others

// As rank_of of colour_choice.clh.
static uint32_t rank_of(uint32_t a, uint32_t b)
{
    uint32_t x = a < b ? a : b, y = a < b ? b : a;
    uint32_t k = x * 0x9E3779B9u ^ (y + 0x7F4A7C15u) * 0x85EBCA6Bu;
    k ^= k >> 15;
    k *= 0x2C1B3C6Du;
    return k ^ k >> 13;
}

// The unused body whose contact with the last has the greatest rank below `rank`.
static uint32_t find_next(const bool *used, uint32_t last, uint32_t *rank)
{
    uint32_t next = ALL, best = 0;
    for (uint32_t id = 0; id < ALL; ++id) {
        uint32_t r = rank_of(last, id);
        if (!used[id] && r < *rank && r >= best) {
            best = r;
            next = id;
        }
    }
    *rank = best;
    return next;
}

static void find_chain(void)
{
    bool used[ALL] = {false};
    uint32_t rank = UINT32_MAX, n = 1;
    used[order[0] = 0] = true;
    for (; n <= CHAIN; ++n) {
        order[n] = find_next(used, order[n - 1], &rank);
        assert_true(order[n] < ALL);
        used[order[n]] = true;
    }
    for (uint32_t id = 0; id < ALL; ++id)
        if (!used[id])
            order[n++] = id;
}

// A chain of cubes along x, every other one on top of its two neighbours, from which it rises; the
// rest stand far from all.
static mover *make_chain(duet_device_pair *pair, const char *kernels)
{
    mover *m = mover_new(2);
    m->def.pair = pair;
    m->def.plan = duet_default_plan(pair);
    m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE;
    m->def.skin = 0.5;
    snprintf(m->def.plan.variant_b, sizeof m->def.plan.variant_b, "%s", kernels);
    for (uint32_t id = 0; id < ALL; ++id)
        mover_add(m, 0, 0, 0, 0.5, 0.5, 0.5);
    for (uint32_t k = 0; k < ALL; ++k) {
        bool is_upper = k <= CHAIN && k % 2;
        m->poses[order[k]].centre[0] = (k <= CHAIN ? 0.99f : 3.0f) * (float)k;
        m->poses[order[k]].centre[1] = k > CHAIN ? 10.0f : is_upper ? 0.995f : 0.0f;
        m->bodies[order[k]].velocity[1] = is_upper ? SPEED : 0.0f;
    }
    return m;
}

static void fall_again(mover *m)
{
    duet_body down = duet_default_body();
    down.velocity[1] = -SPEED;
    for (uint32_t k = 1; k <= CHAIN; k += 2) {
        const duet_body_list one = {.first = order[k], .n = 1};
        must(duet_motion_set_bodies(m->motion, one, DUET_BODY_VELOCITY, &down, ERR));
    }
}

// Runs until the chain's contacts are coloured, which is in one step.
static void run_to_chain(mover *m)
{
    for (int step = 0; step == 0 || m->last.contacts == 0; ++step) {
        assert_true(step < 20);
        mover_run(m, 1);
    }
    assert_int_equal(m->last.contacts, CHAIN);
    assert_int_equal(m->last.colours, 2);
    assert_int_equal(m->motion->flags[FLAG_ROUNDS], CHAIN);
}

// The second time there is space for all colours, so that only the rounds keep a step from being
// sent whole.
TEST(a_team_takes_more_rounds_than_it_counts)
{
    duet_device_pair *pair = kept(duet_device_pair_open("pocl:0,pocl:0", ERR));
    find_chain();
    mover *team = make_chain(pair, "auto"), *launches = make_chain(pair, "auto graph_colour.WG=64");
    run_to_chain(team);
    run_to_chain(launches);
    assert_non_null(team->motion->kernels.of[COLOUR_CONTACTS]);
    assert_null(launches->motion->kernels.of[COLOUR_CONTACTS]);
    mover_run_alike(team, launches, 10);
    assert_int_equal(team->last.contacts, 0);
    fall_again(team);
    fall_again(launches);
    run_to_chain(team);
    run_to_chain(launches);
    mover_run_alike(team, launches, 4);
}
