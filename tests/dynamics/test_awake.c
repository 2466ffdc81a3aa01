// SPDX-License-Identifier: MIT
// A step goes over lists of what is awake. If most bodies are awake it goes over all, which makes
// the truth here: the same bodies, beside three times as many that fall for ever far away.
//
// And a step is sent whole, in the hope that it goes as the last one did. Steps whose contacts are
// solved by a launch for each colour never are, and make the truth for that.
#include "base/rng.h"
#include "support/commands.h"
#include "support/mover.h"
#include "support/test.h"

enum { ROWS = 6, HIGH = 4, SPANS = 8 };

// Towers with a beam across each two, so that beams lean on sleepers that lean on sleepers.
static mover *make(bool crowded)
{
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.slop = 0.005; // by default it is a part of the mean size
    m->def.substeps = 4;
    m->def.skin = crowded ? 0.0 : 0.05;
    mover_add_floor(m, 60);
    for (int row = 0; row < ROWS; ++row)
        for (int span = 0; span <= SPANS; ++span)
            for (int k = 0; k < HIGH; ++k)
                mover_add_rough_cube(m, 2 * span, 3 * row, k + 0.5);
    for (int row = 0; row < ROWS; ++row)
        for (int span = 0; span < SPANS; ++span)
            mover_add(m, 2 * span + 1, 3 * row, HIGH + 0.25, 0.95, 0.4, 0.25);
    for (uint32_t i = 0, n = 3 * m->n; crowded && i < n; ++i)
        mover_add(m, 3 * (i % 40), 400 + 3 * (i / 40), 5000, 0.5, 0.5, 0.5);
    return m;
}

static void assert_same_states(const mover *few, const mover *many, uint32_t step)
{
    for (uint32_t i = 0; i < few->n; ++i)
        if (memcmp(&few->states[i], &many->states[i], sizeof few->states[i]) != 0)
            fail_msg("after step %u body %u is at %.9g %.9g %.9g, not at %.9g %.9g %.9g", step, i,
                     few->states[i].centre[0], few->states[i].centre[1], few->states[i].centre[2],
                     many->states[i].centre[0], many->states[i].centre[1],
                     many->states[i].centre[2]);
}

static uint32_t count_moving(const mover *m)
{
    uint32_t moving = 0;
    for (uint32_t i = 1; i < m->n; ++i)
        moving += mover_speed(m, i) > 0;
    return moving;
}

// All sleep; then a block in the middle of a tower goes, and another is thrown at a tower.
TEST(sleepers_that_lose_their_support_move_as_if_all_were_gone_over)
{
    mover *few = make(false), *many = make(true);
    uint32_t least = UINT32_MAX, most = 0;
    uint32_t taken = 1 + 2 * (SPANS + 1) * HIGH + 3 * HIGH + 1, thrown = taken + 1 + HIGH;
    for (uint32_t step = 0; step < 480; step += 10) {
        mover_run(few, 10);
        mover_run(many, 10);
        assert_same_states(few, many, step + 10);
        uint32_t moving = count_moving(few);
        least = moving < least ? moving : least;
        most = step >= 240 && moving > most ? moving : most;
        if (step == 240) {
            const duet_impulse push = {.impulse = {0, 4, 0}};
            must(duet_motion_disable_bodies(few->motion, one(taken), ERR));
            must(duet_motion_disable_bodies(many->motion, one(taken), ERR));
            must(duet_motion_apply_impulses(few->motion, one(thrown), &push, ERR));
            must(duet_motion_apply_impulses(many->motion, one(thrown), &push, ERR));
        }
    }
    assert_int_equal(least, 0);
    assert_true(most > 4 && most < few->n / 4);
}

enum { LANES = 24 };

static const char by_launches[] = "auto solve_contacts.WG=64 solve_contacts.LANES=1";

static mover *make_sleepy(const char *variant)
{
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.slop = 0.005;
    m->def.substeps = 4;
    m->def.skin = 0.05;
    strcpy(m->def.plan.variant_b, variant);
    return m;
}

// In each lane a ball rolls at a cube that sleeps under another one, half a meter further away than
// in the lane before.
static mover *make_lanes(const char *variant)
{
    mover *m = make_sleepy(variant);
    mover_add_floor(m, 60);
    for (int lane = 0; lane < LANES; ++lane) {
        mover_add_rough_cube(m, 0, 4 * lane - 46, 0.5);
        mover_add_rough_cube(m, 0.1, 4 * lane - 46, 1.5);
        uint32_t ball = mover_add(m, -3 - 0.5 * lane, 4 * lane - 45.8, 0.5, 0, 0, 0);
        m->bodies[ball].radius = 0.5f;
        m->bodies[ball].friction = 0.5f;
        m->bodies[ball].velocity[0] = 2.0f;
        m->bodies[ball].angular_velocity[1] = 4.0f;
    }
    return m;
}

// Contacts of a ball and of what it wakes begin in the same step, and none is coloured before the
// others are known.
TEST(what_wakes_while_a_step_is_sent_whole_is_solved_in_the_same_order)
{
    mover *whole = make_lanes("auto"), *waits = make_lanes(by_launches);
    for (uint32_t step = 0; step < 480; step += 20) {
        mover_run(whole, 20);
        mover_run(waits, 20);
        assert_same_states(whole, waits, step + 20);
    }
    for (uint32_t lane = 0; lane < LANES; ++lane)
        assert_true(whole->states[1 + 3 * lane].centre[0] > 0.01); // it was hit
}

static uint32_t run_both(mover *whole, mover *waits, uint32_t n_steps, uint32_t each)
{
    uint32_t asleep = 0;
    for (uint32_t step = 0; step < n_steps; step += each) {
        mover_run(whole, each);
        mover_run(waits, each);
        assert_same_states(whole, waits, step + each);
        const uint32_t now = whole->n - 1 - count_moving(whole);
        asleep = now > asleep ? now : asleep;
    }
    return asleep;
}

// Cubes that fall into a pit on each other: some come to rest, and wake when the next ones land.
static mover *make_pit(const char *variant)
{
    rng r = rng_seed(7);
    mover *m = make_sleepy(variant);
    m->def.boundary = DUET_BOUNDARY_WALLS;
    m->def.upper[0] = m->def.upper[1] = 8.0;
    m->def.upper[2] = 400.0;
    for (uint32_t i = 0; i < 400; ++i)
        mover_add_rough_cube(m, rng_between(&r, 1, 7), rng_between(&r, 1, 7), 1 + 0.6 * i);
    return m;
}

TEST(a_pile_that_grows_and_falls_asleep_has_the_bits_of_steps_that_wait)
{
    uint32_t asleep = run_both(make_pit("auto"), make_pit(by_launches), 600, 20);
    print_message("%u asleep at most\n", asleep);
    assert_true(asleep > 50);
}

// One cube lies on the floor, and then a square of others lands in the same step: colours need many
// times the space that they had.
static mover *make_square(const char *variant)
{
    mover *m = make_sleepy(variant);
    mover_add_floor(m, 100);
    mover_add_rough_cube(m, -60, 0, 0.5);
    for (int i = 0; i < 40 * 40; ++i)
        mover_add_rough_cube(m, 1.5 * (i % 40) - 30, 1.5 * (i / 40) - 30, 1.0);
    return m;
}

TEST(contacts_that_need_more_space_in_a_step_that_is_sent_whole_are_solved_in_it)
{
    mover *whole = make_square("auto");
    run_both(whole, make_square(by_launches), 40, 1);
    assert_true(whole->last.contacts >= 1600);
}

// Pairs of cubes lie in each other and are pushed out more slowly than what sleeps: so they fall
// asleep as they are, and are pushed out asleep. Others fall meanwhile, so that no lists are made
// and nothing else keeps such a step from being sent whole.
static mover *make_deep(const char *variant)
{
    mover *m = make_sleepy(variant);
    m->def.max_push_speed = 0.01;
    mover_add_floor(m, 60);
    for (int i = 0; i < 20; ++i) {
        mover_add_rough_cube(m, 3 * i - 30, 0, 0.5);
        mover_add_rough_cube(m, 3 * i - 30, 0, 1.5 - 0.01 * i);
    }
    for (int i = 0; i < 100; ++i)
        mover_add_rough_cube(m, 3 * (i % 10), 3 * (i / 10), 1000);
    return m;
}

TEST(what_falls_asleep_deep_in_others_is_pushed_out_in_the_step_that_finds_it)
{
    mover *whole = make_deep("auto");
    const uint32_t asleep = run_both(whole, make_deep(by_launches), 240, 1);
    assert_true(asleep >= 20);
    assert_true(whole->states[40].centre[2] > 1.35);
}

// Cubes that sleep, beside one that slides on a slab.
static mover *make_slide(uint32_t *slab, uint32_t *cube)
{
    mover *m = make_sleepy("auto");
    mover_add_floor(m, 60);
    for (int i = 0; i < 40; ++i)
        mover_add_rough_cube(m, 3 * (i % 10), 3 * (i / 10), 0.5);
    *slab = mover_add_fixed(m, 0, -20, 5, 4, 4, 0.5);
    m->bodies[*slab].friction = 0.5f;
    *cube = mover_add_rough_cube(m, 0, -20, 6);
    mover_run(m, 120);
    return m;
}

// The slab stands still once it is there, and brakes the cube, though all is woken in between.
TEST(what_a_target_moved_stands_still_for_those_that_a_new_def_wakes)
{
    uint32_t slab, cube;
    mover *m = make_slide(&slab, &cube);
    for (int i = 1; i <= 5; ++i) {
        const duet_transform target = {.centre = {0.02f * (float)i, -20, 5},
                                       .rotation = {0, 0, 0, 1}};
        must(duet_motion_set_targets(m->motion, one(slab), &target, ERR));
        mover_run(m, 1);
    }
    const double before = m->states[cube].velocity[0], braked = 0.5 * 9.81 / 60;
    assert_close(before, 5 * braked, 0.5 * braked);
    const duet_motion_def def = *duet_motion_get_def(m->motion);
    must(duet_motion_set_def(m->motion, &def, ERR));
    mover_run(m, 1);
    assert_close(m->states[cube].velocity[0], before - braked, 0.1 * braked);
}
