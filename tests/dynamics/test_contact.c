// SPDX-License-Identifier: MIT
// Contacts that push: stacks, ratios of masses, bullets, bounces, friction.
#include "support/figure.h"
#include "support/mover.h"
#include "support/stack.h"
#include "support/test.h"

#include "runtime/opencl/device_pair.h"

// ---------------------------------------------------------------- stacks

TEST(stacks_stand)
{
    stack_figures f = stack_figures_read();
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (int i = 0; i < 2; ++i) {
            stack s = {.dims = dims, .height = f.heights[i], .substeps = f.substeps[i]};
            stack_assert_stands(&s, i == 0 ? 20 : 10); // 60 s: tests/long/test_stacks.c
        }
}

TEST(stacks_stand_far_away_in_doubles)
{
    stack s = {.dims = 3, .height = 10, .substeps = 4, .x = 1e7, .doubles = true};
    stack_assert_stands(&s, 20);
}

// Points of contact that left their corners for a step would kick it.
TEST(a_stack_comes_to_rest)
{
    for (int doubles = 0; doubles < 2; ++doubles) {
        if (!test_takes((uint64_t)doubles, 2))
            continue;
        mover *m = mover_new(3);
        m->def.doubles = doubles;
        m->def.substeps = 4;
        mover_add_floor(m, 5);
        for (uint32_t i = 0; i < 10; ++i)
            mover_add_rough_cube(m, 0, 0, i + 0.5);
        mover_run(m, 20 * 60);
        for (uint32_t second = 0; second < 10; ++second) {
            mover_run(m, 60);
            for (uint32_t i = 1; i <= 10; ++i)
                if (mover_speed(m, i) > 1e-4)
                    fail_msg("box %u of 10 moves by %g after %u s", i, mover_speed(m, i),
                             21 + second);
        }
    }
}

// Each box `aside` further than the one below it: whether the stack falls.
static bool leaning_stack_falls(uint32_t dims, double aside)
{
    enum { HEIGHT = 8 };
    mover *m = mover_new(dims);
    mover_add_floor(m, 10);
    for (uint32_t i = 0; i < HEIGHT; ++i)
        mover_add_rough_cube(m, i * aside, dims == 2 ? i + 0.5 : 0, i + 0.5);
    mover_run(m, 300);
    double height = m->states[HEIGHT].centre[dims - 1];
    return height < HEIGHT - 1;
}

// The seven upper boxes have their middle 4 times as far aside as one box from the next, and
// half an edge below it is the last that holds them. That a manifold is kept hides no such
// lever.
TEST(a_stack_that_leans_too_far_falls)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        assert_false(leaning_stack_falls(dims, 0.1));
        assert_true(leaning_stack_falls(dims, 0.13));
    }
}

// ---------------------------------------------------------------- masses

TEST(heavy_boxes_rest_on_light_ones)
{
    double f[8];
    figures("effects.md",
            "heavy on light, 1 : #, 1 : # and 1 : # | #, # and # substeps, less than a tenth of an "
            "edge deep; with # substeps 1 : # sinks in",
            8, f);
    const struct {
        double ratio, substeps, depth; // depth in parts of the edge
    } cases[] = {{1, 4, 0.02}, {f[0], f[3], 0.1}, {f[1], f[4], 0.1}, {f[2], f[5], 0.1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mover *m = mover_new(3);
        m->def.substeps = (uint32_t)cases[i].substeps;
        mover_add_floor(m, 5);
        mover_add_rough_cube(m, 0, 0, 0.5);
        uint32_t heavy = mover_add_rough_cube(m, 0, 0, 1.5);
        m->bodies[heavy].mass = (float)cases[i].ratio;
        mover_run(m, 600);
        mover_assert_finite(m);
        double height = m->states[heavy].centre[2];
        if (!(height > 1.5 - cases[i].depth) || !(height < 1.6))
            fail_msg("at a ratio of %g the heavy box is at %g", cases[i].ratio, height);
    }
}

// A spring stiffer than its substeps rocks what stands on it, and it walks.
TEST(heavy_boxes_do_not_creep)
{
    double f[4];
    figures("effects.md", "1 : #, 1 : # and 1 : # with 4 substeps, after 5 s | slower than # mm/s",
            4, f);
    for (int i = 0; i < 3; ++i) {
        mover *m = mover_new(3);
        mover_add_floor(m, 5);
        mover_add_rough_cube(m, 0, 0, 0.5);
        uint32_t heavy = mover_add_rough_cube(m, 0, 0, 1.5);
        m->bodies[heavy].mass = (float)f[i];
        mover_run(m, 300);
        double from[2] = {m->states[heavy].centre[0], m->states[heavy].centre[1]};
        mover_run(m, 60);
        const double *to = m->states[heavy].centre;
        double speed = hypot(to[0] - from[0], to[1] - from[1]);
        if (!(speed < 1e-3 * f[3]))
            fail_msg("at a ratio of %g the heavy box creeps by %g mm/s", f[i], 1e3 * speed);
    }
}

TEST(what_has_no_mass_stays)
{
    mover *m = mover_new(3);
    uint32_t floor = mover_add_floor(m, 5);
    uint32_t other = mover_add_cube(m, 0, 0, 0.2, 1); // into the floor
    m->bodies[other].mass = 0.0f;
    mover_add_rough_cube(m, 0, 0, 1.5);
    mover_run(m, 120);
    assert_close(m->states[floor].centre[2], -0.5, 0.0);
    assert_close(m->states[other].centre[2], (double)0.2f, 0.0);
    assert_int_equal(m->last.contacts, 1);
}

// ---------------------------------------------------------------- bullets

typedef struct flight {
    double furthest, back; // place, and speed in the end
} flight;

static flight shoot(double speed, double dt, uint32_t wants, double angle)
{
    mover *m = mover_new(3);
    m->def.dt = dt;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | wants;
    mover_add_fixed(m, 10, 0, 0, 0.05, 2000, 2000);
    uint32_t bullet = mover_add_cube(m, 0.013, 0, 0, 0.1);
    m->bodies[bullet].velocity[0] = (float)(speed * cos(angle));
    m->bodies[bullet].velocity[1] = (float)(speed * sin(angle));
    flight f = {.furthest = -1e30};
    for (int step = 0; step < 60; ++step) {
        mover_run(m, 1);
        f.furthest = fmax(f.furthest, m->states[bullet].centre[0]);
    }
    mover_assert_finite(m);
    f.back = -m->states[bullet].velocity[0];
    return f;
}

TEST(bullets_do_not_pass_a_wall)
{
    double f[5]; // an edge, two speeds, a wall, a part that comes back
    figures("effects.md",
            "bullet # at # and # m/s, wall # | never behind it, and # of the speed comes back", 5,
            f);
    assert_true(f[0] == 0.1 && f[3] == 0.1); // the same as in shoot
    const double *speeds = f + 1;
    static const double times[] = {1.0 / 60, 1.0 / 240};
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j)
            for (int turned = 0; turned < 2; ++turned) {
                if (!test_takes((uint64_t)(i + j + turned), 2))
                    continue;
                flight shot = shoot(speeds[i], times[j], 0, turned * 0.5);
                if (!(shot.furthest < 10.0) || !(shot.back < f[4] * speeds[i]))
                    fail_msg("at %g m/s and dt %g the bullet comes to %g, and back at %g",
                             speeds[i], times[j], shot.furthest, shot.back);
            }
}

// A slow one is not asked about: 0.4 of a half extent a step is in reach of a
// contact's margin or of its depth.
TEST(slow_boxes_need_no_sweep)
{
    assert_true(shoot(0.4 * 0.05 * 60, 1.0 / 60, 0, 0).furthest < 10.0);
}

TEST(a_bullet_that_misses_is_not_held)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    mover_add_fixed(m, 10, 0, 0, 0.05, 1, 1);
    uint32_t bullet = mover_add_cube(m, 0, 1.2, 0, 0.1);
    m->bodies[bullet].velocity[0] = 2000.0f;
    mover_run(m, 6);
    assert_true(duet_motion_get_effects(m->motion) & DUET_EFFECT_CONTINUOUS);
    assert_close(m->states[bullet].velocity[0], 2000.0, 1e-9);
    assert_close(m->states[bullet].centre[0], 200.0, 1e-2);
}

// ---------------------------------------------------------------- overlap

TEST(deep_overlap_is_left_without_a_shot)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    uint32_t a = mover_add_cube(m, 0, 0, 0, 1);
    uint32_t b = mover_add_cube(m, 0.3, 0.1, 0.05, 1);
    double fastest = 0.0;
    for (int step = 0; step < 120; ++step) {
        mover_run(m, 1);
        fastest = fmax(fastest, fmax(mover_speed(m, a), mover_speed(m, b)));
    }
    double apart = m->states[b].centre[0] - m->states[a].centre[0];
    assert_true(apart > 0.97);
    assert_true(fastest <= m->def.max_push_speed);
}

TEST(boxes_in_one_place_give_no_nan)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    for (int i = 0; i < 5; ++i)
        mover_add_cube(m, 0, 0, 0, 1);
    mover_add(m, 0, 0, 0, 0, 0, 0);
    mover_add(m, 0, 0, 0, 1, 0, 0);
    mover_add(m, 0, 0, 0, 1, 1, 0);
    mover_run(m, 120);
    mover_assert_finite(m);
}

// ---------------------------------------------------------------- bounces

TEST(an_elastic_ball_keeps_its_energy)
{
    mover *m = mover_new(3);
    mover_wall_in(m, 0, 10.0);
    m->def.restitution_threshold = 0.0;
    uint32_t ball = mover_add_cube(m, 5, 5, 5, 0.5);
    m->bodies[ball].restitution = 1.0f;
    m->bodies[ball].fixed_rotation = true;
    m->bodies[ball].velocity[0] = 30.0f;
    m->bodies[ball].velocity[1] = 17.0f;
    double before = mover_energy(m).kinetic;
    mover_run(m, 60 * 200); // about 1 000 bounces
    double f[2];            // bounces, energy
    figures("effects.md", "elastic box between walls, # bounces | kinetic energy within #", 2, f);
    assert_true(f[0] == 1000);
    assert_close(mover_energy(m).kinetic / before, 1.0, f[1]);
}

// Corners of boxes that tumble come at different speeds, and a push at one changes
// the others': some of the energy is lost, none is made.
TEST(tumbling_elastic_boxes_gain_nothing)
{
    rng r = rng_seed(test_seed());
    mover *m = mover_new(3);
    mover_wall_in(m, 0, 8.0);
    m->def.restitution_threshold = 0.0;
    for (int i = 0; i < 48; ++i) {
        uint32_t id =
            mover_add(m, 1 + 2 * (i % 4), 1 + 2 * (i / 4 % 4), 1 + 2 * (i / 16), 0.3, 0.4, 0.5);
        mover_turn(m, id, rng_normal(&r), rng_normal(&r), rng_normal(&r), rng_between(&r, 0, 3));
        m->bodies[id].restitution = 1.0f;
        for (int k = 0; k < 3; ++k)
            m->bodies[id].velocity[k] = (float)rng_between(&r, -2, 2);
    }
    double before = mover_energy(m).kinetic; // nothing turns yet
    double f[5];                             // boxes, steps, gained, lost from and to, per cent
    figures(
        "effects.md",
        "# elastic boxes that tumble between walls, # steps | never # % above their energy; # to "
        "# % are lost",
        5, f);
    assert_int_equal(m->n, (int)f[0]);
    mover_run(m, (uint32_t)f[1]);
    duet_energy after = mover_energy(m);
    double left = (after.kinetic + after.turning) / before;
    print_message("%.3f of the energy is left\n", left);
    assert_true(left < 1 + f[2] / 100);
    assert_in_range((int)(1e4 * left), 1e4 - 100 * f[4], 1e4 - 100 * f[3]);
    assert_true(after.turning > 0.3 * before); // half of it, in the end
}

TEST(a_falling_elastic_ball_gains_nothing)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    m->bodies[0].restitution = 1.0f;
    uint32_t ball = mover_add_cube(m, 0, 0, 2.5, 1);
    m->bodies[ball].fixed_rotation = true;
    double before = mover_total(m);
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 60);
        assert_true(mover_total(m) < before * 1.03);
    }
}

// The greatest height within so many steps.
static double apex(mover *m, uint32_t id, int steps)
{
    double height = 0;
    for (int i = 0; i < steps; ++i) {
        mover_run(m, 1);
        height = fmax(height, m->states[id].centre[2]);
    }
    return height;
}

// A cube that falls from so high, by so many substeps: what a bounce takes of its
// height, as a mean of the bounces of some seconds.
static double loss_of_a_bounce(double drop, uint32_t substeps, double *n)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    m->bodies[0].restitution = 1.0f;
    m->def.substeps = substeps;
    uint32_t ball = mover_add_cube(m, 0, 0, 0.5 + drop, 1);
    m->bodies[ball].fixed_rotation = true;
    double period = 2 * sqrt(2 * drop / -m->def.gravity[2]);
    mover_run(m, 1200);
    *n = floor(1200 * m->def.dt / period);
    double left = (apex(m, ball, (int)(period / m->def.dt) + 2) - 0.5) / drop;
    return 1 - pow(left, 1 / *n);
}

TEST(an_elastic_bounce_keeps_its_height)
{
    static const struct {
        double drop;
        uint32_t substeps;
    } cases[] = {{2, 4}, {2, 1}, {2, 8}, {0.7, 4}, {5.3, 4}, {11, 2}};
    double most = figure("effects.md", "a bounce takes or gives less than # % of its height");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        if (!test_takes(i, 3))
            continue;
        double n, loss = loss_of_a_bounce(cases[i].drop, cases[i].substeps, &n);
        print_message("%g m, %u substeps, %.0f bounces: %.5f of the height lost each time\n",
                      cases[i].drop, cases[i].substeps, n, loss);
        assert_close(loss, 0.0, most / 100);
    }
}

typedef struct bounce {
    double restitution, drop, dt;
    uint32_t substeps;
    bool round; // a sphere, else a cube
} bounce;

// How high it comes up again.
static double height_after(const bounce *b)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    m->def.dt = b->dt;
    m->def.substeps = b->substeps;
    uint32_t ball = mover_add_cube(m, 0, 0, 0.5 + b->drop, b->round ? 0 : 1);
    m->bodies[ball].radius = b->round ? 0.5f : 0.0f;
    m->bodies[ball].restitution = (float)b->restitution;
    const double *speed = &m->states[ball].velocity[2];
    for (mover_run(m, 1); *speed <= 0;)
        mover_run(m, 1);
    while (*speed > 0)
        mover_run(m, 1);
    double g = -m->def.gravity[2];
    double now = *speed - 0.5 * g * b->dt / b->substeps; // velocities are half a substep old
    return m->states[ball].centre[2] - 0.5 + now * now / (2 * g);
}

TEST(a_bounce_keeps_the_square_of_the_restitution)
{
    double f[5]; // drops and restitutions from and to, per cent
    figures("effects.md",
            "falls # to # m with a restitution of # to # | comes up to its square of the height "
            "within g h^2 / 2 and # %",
            5, f);
    const double drops[] = {f[0], 1, 3, f[1]}, restitutions[] = {f[2], 0.5, f[3]};
    static const double times[] = {1.0 / 60, 1.0 / 120, 1.0 / 240};
    for (uint64_t i = 0; i < 4 * 3 * 3 * 2 * 2; ++i) {
        bounce b = {.drop = drops[i % 4],
                    .restitution = restitutions[i / 4 % 3],
                    .dt = times[i / 12 % 3],
                    .substeps = i / 36 % 2 ? 4 : 1,
                    .round = i / 72};
        if (!test_takes(i, 5))
            continue;
        double h = b.dt / b.substeps, expected = b.restitution * b.restitution * b.drop;
        double off = height_after(&b) - expected;
        if (!(fabs(off) < 0.5 * 9.81 * h * h + f[4] / 100 * expected))
            fail_msg("%s that falls %g m, restitution %g, %u substeps of %g s: off by %g m",
                     b.round ? "sphere" : "cube", b.drop, b.restitution, b.substeps, h, off);
    }
}

TEST(an_inelastic_ball_comes_to_rest)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    uint32_t ball = mover_add_rough_cube(m, 0, 0, 3);
    mover_run(m, 180);
    assert_true(mover_speed(m, ball) < 1e-3);
    assert_close(m->states[ball].centre[2], 0.5, 0.01);
}

// Covers a cradle, and collisions.
static double kept_momentum(int which)
{
    double f[2];
    figures("effects.md", "momentum within # (cradle) and # of its size", 2, f);
    return f[which];
}

// Equal boxes in a row without gravity: the last one takes the speed.
TEST(a_cradle_hands_the_speed_on)
{
    mover *m = mover_new(3);
    m->def.restitution_threshold = 0.0;
    for (int i = 0; i < 5; ++i) {
        uint32_t id = mover_add_cube(m, i == 0 ? -3 : 1.2 * i, 0, 0, 1);
        m->bodies[id].restitution = 1.0f;
        m->bodies[id].fixed_rotation = true;
    }
    m->bodies[0].velocity[0] = 2.0f;
    mover_run(m, 300);
    assert_close(mover_energy(m).momentum[0], 2.0, 2 * kept_momentum(0));
    assert_close(mover_energy(m).kinetic, 2.0, 1e-4);
    assert_close(m->states[4].velocity[0], 2.0, 1e-4);
}

TEST(momentum_is_kept_in_a_collision)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    for (int i = 0; i < 3; ++i) {
        uint32_t id = mover_add_cube(m, 1.5 * i, 0.3 * i, 0.2 * i, 1);
        mover_turn(m, id, 1, 2, i, 0.3 * i);
        m->bodies[id].velocity[0] = 2.0f - 2.0f * (float)i;
        m->bodies[id].friction = 0.5f;
        m->bodies[id].restitution = 0.3f;
        m->bodies[id].mass = 1.0f + (float)i;
    }
    duet_energy before = mover_energy(m);
    mover_run(m, 120);
    duet_energy after = mover_energy(m);
    assert_true(after.kinetic + after.turning < before.kinetic);
    for (int k = 0; k < 3; ++k)
        assert_close(after.momentum[k], before.momentum[k], kept_momentum(1));
}

// Two cubes without restitution, face to face: along an axis, at a speed, of such masses.
static void strike(uint32_t axis, double speed, double ratio, double dt, double most)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    m->def.dt = dt;
    for (int i = 0; i < 2; ++i) {
        double at[3] = {0};
        at[axis] = i ? 2 : -2;
        uint32_t id = mover_add_cube(m, at[0], at[1], at[2], 1);
        m->bodies[id].mass = i ? (float)ratio : 1.0f;
        m->bodies[id].velocity[axis] = (float)(i ? -0.25 * speed : 0.75 * speed);
    }
    double common = (0.75 - 0.25 * ratio) * speed / (1 + ratio);
    mover_run(m, (uint32_t)lround(8 / (speed * dt)));
    for (int i = 0; i < 2; ++i)
        for (uint32_t k = 0; k < 3; ++k) {
            double off = m->states[i].velocity[k] - (k == axis ? common : 0);
            double spin = m->states[i].angular_velocity[k];
            if (!(fabs(off) < most * speed && fabs(spin) < most * speed))
                fail_msg("along %u at %g m/s, masses 1 : %g, steps of %g s: body %d is %g m/s off "
                         "along %u and turns at %g",
                         axis, speed, ratio, dt, i, off, k, spin);
        }
}

TEST(a_plastic_hit_leaves_one_velocity_and_no_spin)
{
    static const double ways[] = {1 / 60.0, 1 / 30.0, 1 / 15.0}, ratios[] = {1, 3, 20},
                        times[] = {1.0 / 60, 1.0 / 240};
    double most = figure("effects.md", "one velocity, and no spin, within # of the speed");
    for (uint64_t i = 0; i < 3 * 3 * 3 * 2; ++i)
        if (test_takes(i, 4))
            strike(i % 3, ways[i / 3 % 3] / times[i / 27], ratios[i / 9 % 3], times[i / 27], most);
}

// ---------------------------------------------------------------- friction

typedef struct slope {
    uint32_t dims, substeps;
    double angle, friction, dt;
} slope;

// A box on it for two seconds: its way and its speed.
static duet_state slide(const slope *s)
{
    mover *m = mover_new(s->dims);
    uint32_t up = s->dims - 1;
    bool flat = s->dims == 2;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    m->def.dt = s->dt;
    m->def.substeps = s->substeps;
    m->def.gravity[0] = 9.81 * sin(s->angle); // the slope is level, and gravity leans
    m->def.gravity[up] = -9.81 * cos(s->angle);
    uint32_t floor = mover_add(m, 0, 0, 0, 50, flat ? 0.5 : 50, 0.5);
    m->poses[floor].centre[up] = -0.5f;
    m->bodies[floor].mass = 0.0f;
    m->bodies[floor].friction = (float)s->friction;
    uint32_t box = mover_add(m, 0, flat ? 0.25 : 0, 0.25, 0.5, flat ? 0.25 : 0.5, 0.25);
    m->bodies[box].friction = (float)s->friction;
    mover_run(m, (uint32_t)lround(2 / s->dt));
    return m->states[box];
}

TEST(friction_holds_up_to_its_angle)
{
    double f[2];
    figures("effects.md", "holds at # tan, slides at # tan;", 2, f);
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        slope s = {dims, 4, 0.5, f[0] * tan(0.5), 1.0 / 60};
        assert_true(fabs(slide(&s).centre[0]) < 0.02);
        s.friction = f[1] * tan(0.5);
        assert_true(slide(&s).centre[0] > 0.1);
    }
}

TEST(friction_slows_as_its_closed_form)
{
    static const double slopes[] = {0.2, 0.5, 1}, parts[] = {0, 0.6, 0.9, 0.98};
    static const double times[] = {1.0 / 60, 1.0 / 240};
    double most = figure("effects.md", "its speed is the closed form's within g h / #");
    for (uint64_t i = 0; i < 3 * 4 * 2 * 2 * 2; ++i) {
        double tangent = slopes[i % 3], friction = parts[i / 3 % 4] * tangent;
        slope s = {2 + (uint32_t)(i / 48), i / 12 % 2 ? 4 : 1, atan(tangent), friction,
                   times[i / 24 % 2]};
        if (!test_takes(i, 5))
            continue;
        double expected = 2 * 9.81 * (sin(s.angle) - friction * cos(s.angle));
        double h = s.dt / s.substeps, off = slide(&s).velocity[0] - expected;
        if (!(fabs(off) < 9.81 * h / most))
            fail_msg("in %uD with friction %g on a slope of %g, %u substeps of %g s: %g m/s, off "
                     "by %g, %g g h",
                     s.dims, friction, tangent, s.substeps, h, expected, off, off / (9.81 * h));
    }
}

TEST(a_box_slides_over_a_seam)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 2);
    mover_add_fixed(m, 4, 0, -0.5, 2, 2, 0.5);
    for (uint32_t id = 0; id < m->n; ++id)
        m->bodies[id].friction = 0.0f;
    uint32_t box = mover_add_cube(m, 0, 0, 0.5, 1);
    m->bodies[box].velocity[0] = 3.0f;
    mover_run(m, 10); // it comes to rest on the floor
    for (int step = 10; step < 90; ++step) {
        mover_run(m, 1);
        assert_true(fabs(m->states[box].velocity[2]) < 0.02);
    }
    assert_close(m->states[box].velocity[0], 3.0, 0.01);
    assert_true(m->states[box].centre[0] > 4.0);
}

// ---------------------------------------------------------------- sleep, events

TEST(what_rests_sleeps_and_is_woken)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP;
    m->def.gravity[2] = -9.81;
    mover_add_fixed(m, 0, 0, -0.5, 20, 5, 0.5);
    for (int i = 0; i < 3; ++i)
        mover_add_cube(m, 0, 0, i + 0.5, 1);
    uint32_t ball = mover_add_cube(m, -15, 0, 1.5, 1);
    m->bodies[ball].velocity[0] = 5.0f;
    mover_run(m, 120);
    assert_int_equal(m->last.contacts, 1); // only the ball's; the others sleep
    uint64_t pairs = m->last.pairs;
    double before = m->states[1].centre[0];
    assert_true(pairs >= 3);
    mover_run(m, 240);
    assert_true(fabs(m->states[1].centre[0] - before) > 0.1);
}

// The lower of two boxes that sleep is shot away, within one step further than
// anything that touches the upper one.
TEST(what_slept_on_a_box_that_is_gone_falls)
{
    for (int skin = 0; skin < 2; ++skin) {
        mover *m = mover_new(3);
        m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP | DUET_EFFECT_CONTINUOUS;
        m->def.gravity[2] = -9.81;
        m->def.skin = skin * 0.05;
        mover_add_fixed(m, 0, 0, -0.5, 300, 5, 0.5);
        mover_add_cube(m, 0, 0, 0.5, 1);
        uint32_t upper = mover_add_cube(m, 0, 0, 1.5, 1);
        uint32_t bullet = mover_add_cube(m, -250, 0, 0.5, 0.5);
        m->bodies[bullet].mass = 100.0f;
        m->bodies[bullet].velocity[0] = 240.0f;
        mover_run(m, 55);
        assert_int_equal(m->last.contacts, 1); // only the bullet's
        mover_run(m, 65);
        assert_close(m->states[upper].centre[2], 0.5, 0.02);
    }
}

static bool hopping_box_sleeps(float speed)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP;
    m->def.sleep_speed = 0.05;
    m->def.restitution_threshold = 0.0;
    mover_add_floor(m, 5);
    m->def.gravity[2] = -0.5;
    uint32_t box = mover_add_cube(m, 0, 0, 0.5, 1);
    m->bodies[box].restitution = 1.0f;
    m->bodies[box].fixed_rotation = true;
    m->bodies[box].velocity[2] = speed;
    mover_run(m, 120);
    return mover_speed(m, box) == 0.0;
}

// A box that hops, up to six fifths of the speed below which it rests, or to four times.
TEST(what_is_mostly_slow_sleeps)
{
    assert_true(hopping_box_sleeps(0.06f));
    assert_false(hopping_box_sleeps(0.2f));
}

TEST(events_begin_and_end)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_EVENTS;
    uint32_t a = mover_add_cube(m, 0, 0, 0, 1);
    uint32_t b = mover_add_cube(m, 2, 0, 0, 1);
    m->bodies[a].velocity[0] = 1.0f;
    m->bodies[a].restitution = 1.0f;
    m->def.restitution_threshold = 0.0;
    int begins = 0, ends = 0;
    for (int step = 0; step < 180; ++step) {
        mover_run(m, 1);
        for (uint64_t i = 0; i < m->last.n_events; ++i) {
            assert_int_equal(m->last.events[i].a, a);
            assert_int_equal(m->last.events[i].b, b);
            begins += m->last.events[i].begins;
            ends += !m->last.events[i].begins;
            assert_true(begins >= ends);
        }
    }
    assert_int_equal(begins, 1);
    assert_int_equal(ends, 1);
}

// ---------------------------------------------------------------- the same

// The state is equal bit for bit, however the search for pairs is shared.
// Half a skin is passed in two steps, and what the bounds reach ahead in four more.
TEST(bounds_last_while_a_body_flies)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS;
    m->def.skin = 0.05;
    mover_add_floor(m, 5);
    uint32_t box = mover_add_rough_cube(m, 0, 0, 3);
    m->bodies[box].velocity[0] = 1.0f;
    m->def.gravity[2] = 0.0;
    int searches = 0;
    for (int step = 0; step < 60; ++step) {
        mover_run(m, 1);
        searches += m->last.rebuilt;
    }
    assert_close(m->states[box].centre[0], 1.0, 1e-4);
    assert_in_range(searches, 8, 15);
}

TEST(the_share_changes_nothing)
{
    static const struct {
        uint32_t share;
        duet_mode mode;
        double skin;
    } ways[] = {
        {0, DUET_MODE_OWN, 0},
        {DUET_SHARE_ONE, DUET_MODE_OWN, 0},
        {DUET_SHARE_ONE / 3, DUET_MODE_SHARED, 0},
        {DUET_SHARE_ONE / 2, DUET_MODE_SLAB, 0},
        {DUET_SHARE_ONE / 2, DUET_MODE_OWN, 0.2},
    };
    uint64_t expected[3] = {0};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; ++i) {
        mover *m = mover_new(3);
        m->def.plan.share = ways[i].share;
        m->def.plan.mode = ways[i].mode;
        m->def.skin = ways[i].skin;
        mover_add_pile(m, 150);
        for (int k = 0; k < 3; ++k) {
            mover_run(m, 60);
            if (i == 0)
                expected[k] = mover_hash(m);
            assert_true(mover_hash(m) == expected[k]);
        }
        mover_assert_finite(m);
    }
}

// A CPU solves eight contacts side by side and a GPU one a work-item.
TEST(one_lane_gives_the_bits_of_eight)
{
    uint64_t hashes[2];
    duet_device_info *info = &default_pair()->devices[1].info;
    duet_device_kind kind = info->kind;
    for (int i = 0; i < 2; ++i) {
        mover *m = mover_new(3);
        mover_add_pile(m, 100);
        info->kind = i == 0 ? DUET_KIND_CPU : DUET_KIND_GPU;
        mover_run(m, 90);
        info->kind = kind;
        assert_true(m->last.contacts > m->n);
        hashes[i] = mover_hash(m);
    }
    assert_true(hashes[0] == hashes[1]);
}

TEST(a_pile_stays_between_its_walls_and_rests)
{
    mover *m = mover_new(3);
    mover_add_pile(m, 200);
    double before = mover_total(m);
    for (int k = 0; k < 6; ++k) {
        mover_run(m, 60);
        assert_true(mover_total(m) < before);
        for (uint32_t id = 0; id < m->n; ++id)
            for (int axis = 0; axis < 3; ++axis) {
                assert_true(m->states[id].centre[axis] > m->def.lower[axis] + 0.2);
                assert_true(m->states[id].centre[axis] < m->def.upper[axis] - 0.2);
            }
    }
    double f[3]; // boxes, seconds, mm/s
    figures("effects.md", "# boxes that fell in a heap, # s | nothing is faster than # mm/s", 3, f);
    assert_int_equal(m->n, (int)f[0]);
    mover_run(m, (uint32_t)(60 * f[1]) - 6 * 60);
    if (!(mover_greatest_speed(m) < 1e-3 * f[2]))
        fail_msg("the pile moves by %g m/s", mover_greatest_speed(m));
}
