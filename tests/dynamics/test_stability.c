// SPDX-License-Identifier: MIT
// Where a simulation could break: time steps that fit nothing, masses and
// speeds far apart, and energy out of nowhere.
#include "support/figure.h"
#include "support/mover.h"
#include "support/test.h"

// ---------------------------------------------------------------- time steps

// Steps far too short or too long show nothing true, but numbers.
TEST(any_time_step_leaves_numbers)
{
    static const double times[] = {1e-9, 1.0, 10.0};
    for (int i = 0; i < 3; ++i) {
        mover *m = mover_new(3);
        m->def.dt = times[i];
        mover_add_pile(m, 30);
        mover_run(m, 20);
        mover_assert_finite(m);
        assert_close(m->last.time, 20 * times[i], 0.0);
    }
}

// The same time in more steps comes to the same place: time is counted in
// steps, not summed.
TEST(more_steps_come_to_the_same_time)
{
    double places[3];
    for (int i = 0; i < 3; ++i) {
        mover *m = mover_new(3);
        uint32_t steps = 700u << i;
        m->def.doubles = true;
        m->def.dt = 0.1 / (1 << i);
        uint32_t id = mover_add_cube(m, 0, 0, 0, 1);
        m->bodies[id].velocity[0] = 3.0f;
        mover_run(m, steps);
        assert_close(m->last.time, 70.0, 1e-12);
        places[i] = m->states[id].centre[0];
    }
    assert_close(places[0], 210.0, 1e-9);
    assert_close(places[1], places[0], 1e-9);
    assert_close(places[2], places[0], 1e-9);
}

// ---------------------------------------------------------------- masses

static double height_of_heavy(float ratio, uint32_t substeps)
{
    mover *m = mover_new(3);
    m->def.substeps = substeps;
    mover_add_floor(m, 5);
    mover_add_rough_cube(m, 0, 0, 0.5);
    uint32_t heavy = mover_add_rough_cube(m, 0, 0, 1.5);
    m->bodies[heavy].mass = ratio;
    mover_run(m, 300);
    mover_assert_finite(m);
    return m->states[heavy].centre[2];
}

// The word of docs/effects.md on substeps, from its other side.
TEST(too_few_substeps_sink_in)
{
    double f[2];
    figures("effects.md", "a tenth of an edge deep; with # substeps 1 : # sinks in", 2, f);
    assert_true(height_of_heavy(1000, 2) < 1.4);
    assert_true(height_of_heavy((float)f[1], (uint32_t)f[0]) < 1.4);
}

TEST(a_light_box_on_a_heavy_one_needs_nothing)
{
    double height = height_of_heavy(1e-4f, 4);
    assert_close(height, 1.5, 0.02);
}

// ---------------------------------------------------------------- rest

// The whole of them are in tests/long/test_stacks.c.
TEST(a_small_pyramid_does_not_tremble)
{
    mover *m = mover_new(3);
    mover_add_pyramid(m, 8);
    mover_run(m, 480);
    assert_close(mover_greatest_speed(m), 0.0, 1e-3);
}

TEST(a_small_house_of_cards_stands)
{
    mover *m = mover_new(3);
    mover_add_card_house(m, 3);
    double height = m->poses[m->n - 1].centre[2];
    mover_run(m, 300);
    assert_close(mover_greatest_speed(m), 0.0, 1e-3);
    assert_close(m->states[m->n - 1].centre[2], height, 0.01);
}

static double deepest_contact(mover *m)
{
    uint64_t n = 0;
    double deepest = 0.0;
    const duet_contact *contacts = mover_contacts(m, &n);
    assert_true(n > 0);
    for (uint64_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < contacts[i].n; ++k)
            deepest = fmax(deepest, -(double)contacts[i].points[k].separation);
    return deepest;
}

TEST(a_pile_does_not_fall_asleep_deep)
{
    double f[3];
    figures("effects.md", "# boxes that fell and sleep, # s | no contact is deeper than # slops", 3,
            f);
    mover *m = mover_new(3);
    const double slop = 0.0036; // nearly what it is by itself
    m->def.wants = DUET_EFFECT_SLEEP;
    m->def.slop = slop;
    mover_add_pile(m, (uint32_t)f[0]);
    mover_run(m, (uint32_t)(60 * f[1]));
    assert_int_equal(m->last.contacts, 0); // all sleep
    double deepest = deepest_contact(m);
    print_message("%g slops\n", deepest / slop);
    assert_true(deepest < f[2] * slop);
    mover_run(m, 60);
    assert_close(deepest_contact(m), deepest, 0.0);
}

// Unit cubes in a row, each so deep in the next, that are put to sleep.
static mover *make_sleeping_row(uint32_t n, double depth)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_SLEEP;
    m->def.slop = 0.005;
    for (uint32_t i = 0; i < n; ++i)
        mover_add_cube(m, (i - 0.5 * (n - 1)) * (1.0 - depth), 0, 0, 1);
    mover_run(m, 0);
    must(duet_motion_sleep_bodies(m->motion, (duet_body_list){.n = n}, ERR));
    return m;
}

TEST(what_sleeps_deep_in_others_is_pushed_out)
{
    const double slops = 20;
    mover *m = make_sleeping_row(4, slops * 0.005);
    mover_run(m, 1);
    assert_close(deepest_contact(m), slops * 0.005, 1e-5);
    double middle = 0.0;
    for (int step = 0; step < 90; ++step) {
        mover_run(m, 1);
        assert_true(mover_greatest_speed(m) == 0.0);
    }
    for (uint32_t i = 0; i < m->n; ++i)
        middle += m->states[i].centre[0];
    assert_close(middle, 0.0, 1e-5);
    assert_true(deepest_contact(m) < 4 * 0.005);
    assert_int_equal(m->last.n_stages, 0); // nothing is left to do
}

// Two that sleep in each other go apart, one of them into a cube that slides by.
static mover *make_pushed_into_another(double skin)
{
    mover *m = make_sleeping_row(2, 0.4);
    mover_restart(m);
    m->def.skin = skin;
    m->bodies[mover_add_cube(m, 1.45, 0, 0, 1)].velocity[1] = -0.5f;
    mover_run(m, 0);
    must(duet_motion_sleep_bodies(m->motion, (duet_body_list){.n = 2}, ERR));
    return m;
}

TEST(what_is_pushed_meets_the_same_with_a_skin)
{
    mover *plain = make_pushed_into_another(0), *with_skin = make_pushed_into_another(0.2);
    bool met = false;
    for (int step = 0; step < 30; ++step) {
        mover_run_alike(plain, with_skin, 1);
        met = met || plain->states[2].velocity[0] > 0.0f;
    }
    assert_true(met);
}

// One between two of mass 0 that leave it no space. It is pushed for as long as it is long.
TEST(what_has_no_space_sleeps_all_the_same)
{
    mover *m = make_sleeping_row(3, 0.1);
    mover_restart(m);
    m->bodies[0].mass = m->bodies[2].mass = 0.0f;
    mover_run(m, 0);
    must(duet_motion_sleep_bodies(m->motion, (duet_body_list){.first = 1, .n = 1}, ERR));
    mover_run(m, 475);
    assert_true(m->last.n_stages > 0);
    mover_run(m, 15);
    assert_int_equal(m->last.n_stages, 0);
    assert_close(m->states[1].centre[0], 0.0, 1e-5);
}

// ---------------------------------------------------------------- speeds

// A box that is still when the motion begins, and then falls onto a thin floor
// faster than the floor is thick in a step.
static double fall(uint32_t dims, bool doubles, uint32_t wants, double height, double gravity)
{
    mover *m = mover_new(dims);
    uint32_t k = dims - 1;
    m->def.doubles = doubles;
    m->def.gravity[k] = -gravity;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | wants;
    uint32_t floor = mover_add(m, 0, 0, 0, 5, 5, 5);
    m->poses[floor].half_extents[k] = 0.05f;
    m->bodies[floor].mass = 0.0f;
    double from[3] = {0};
    from[k] = height;
    uint32_t box = mover_add_cube(m, from[0], from[1], from[2], 0.2);
    mover_run(m, 60);
    mover_assert_finite(m);
    return m->states[box].centre[k];
}

// Whether `fast` is called for is seen from the start alone; what only becomes
// fast asks for it. Without it what moves further in a step than both are thick
// may pass.
TEST(what_becomes_fast_is_held_where_that_is_asked_for)
{
    // 268 m/s at the floor: 4.5 m a step, where box and floor are 0.3 thick
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (int doubles = 0; doubles < 2; ++doubles) {
            assert_true(fall(dims, doubles, DUET_EFFECT_CONTINUOUS, 90.07, 400) > 0.0);
            assert_true(fall(dims, doubles, 0, 90.07, 400) < -10.0);
            assert_true(fall(dims, doubles, 0, 2.07, 9.81) > 0.0);
        }
}

TEST(filters_hold_in_2d_and_in_doubles)
{
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (int doubles = 0; doubles < 2; ++doubles) {
            mover *m = mover_new(dims);
            m->def.doubles = doubles;
            m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
            for (int i = 0; i < 4; ++i) {
                uint32_t id = mover_add_cube(m, 1.5 * (i % 2), 3 * (i / 2), 0, 1);
                m->bodies[id].velocity[0] = i % 2 ? -1.0f : 1.0f;
            }
            m->bodies[0].group = m->bodies[0].mask = 1;
            m->bodies[1].group = m->bodies[1].mask = 2;
            mover_run(m, 120);
            assert_close(m->states[0].centre[0], 2.0, 1e-4); // through its partner
            assert_true(m->states[2].centre[0] < 0.6);       // stopped by it
        }
}

// ---------------------------------------------------------------- energy

static double speed_after_impact(double speed)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    mover_add_fixed(m, 2, 0, 0, 0.5, 2, 2);
    uint32_t ball = mover_add_cube(m, 0, 0, 0, 1);
    m->bodies[ball].restitution = 0.5f;
    m->bodies[ball].fixed_rotation = true;
    m->bodies[ball].velocity[0] = (float)speed;
    mover_run(m, (uint32_t)(90.0 / speed));
    return -m->states[ball].velocity[0];
}

TEST(impacts_bounce_from_a_speed_on)
{
    assert_close(duet_default_motion_def().restitution_threshold, 1.0, 0.0);
    assert_close(speed_after_impact(1.1), 0.55, 1e-3);
    assert_close(speed_after_impact(0.9), 0.0, 1e-3);
}

// Nothing adds energy to a pile. Its energy rises only by what contacts, which
// are springs, were pressed with in an impact and give back.
TEST(a_pile_gets_back_little_of_an_impact)
{
    double f[2];
    figures("effects.md", "# boxes get back less than # % of their greatest kinetic energy", 2, f);
    for (int fast = 0; fast < 2; ++fast) {
        mover *m = mover_new(3);
        m->def.wants = fast ? DUET_EFFECT_CONTINUOUS : 0;
        mover_add_pile(m, (uint32_t)f[0]);
        double before = mover_total(m), least = before, gain = 0.0, kinetic = 0.0;
        for (int k = 0; k < 60; ++k) {
            mover_run(m, 5);
            duet_energy e = mover_energy(m);
            double total = e.kinetic + e.turning + e.potential;
            least = fmin(least, total);
            gain = fmax(gain, total - least);
            kinetic = fmax(kinetic, e.kinetic + e.turning);
            assert_true(total < 1.005 * before); // some overlap at the start
        }
        assert_true(kinetic > 1000.0);
        if (!(gain < f[1] / 100 * kinetic))
            fail_msg("%g of %g came back", gain, kinetic);
    }
}
