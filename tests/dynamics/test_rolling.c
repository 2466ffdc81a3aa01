// SPDX-License-Identifier: MIT
// Rolling resistance against closed forms: what rolls on a plane stops, what lies on a slope stays.
#include "support/mover.h"
#include "support/test.h"

static const double g = 9.81;

typedef struct ball {
    uint32_t dims;
    double radius, speed, slope;
    float resistance;
    double dt;
    uint32_t substeps;
} ball;

// A ball that rolls without slip along x, or lies, on a plane that gravity leans `slope` against.
static mover *roll(const ball *b)
{
    mover *m = mover_new(b->dims);
    uint32_t up = b->dims - 1;
    m->def.dt = b->dt;
    m->def.substeps = b->substeps;
    mover_add_floor(m, 100 * b->radius);
    m->def.gravity[0] = g * sin(b->slope);
    m->def.gravity[up] = -g * cos(b->slope);
    m->def.slop = 0.005 * b->radius;
    double at[3] = {0, 0, 0};
    at[up] = b->radius;
    uint32_t id = mover_add(m, at[0], at[1], at[2], 0, 0, 0);
    m->bodies[id].radius = (float)b->radius;
    m->bodies[id].friction = 2.0f;
    m->bodies[id].rolling_resistance = b->resistance;
    m->bodies[id].velocity[0] = (float)b->speed;
    m->bodies[id].angular_velocity[3 - up] = (float)(b->speed / b->radius * (up == 1 ? -1.0 : 1.0));
    return m;
}

// m v' = -F and I w' = F r - c r N of a ball that does not slip: v' = -c g / (1 + k), where I is
// k m r^2, 2/5 of a sphere and 1/2 of a disc. It stops after v^2 (1 + k) / (2 c g), and stays.
TEST(a_ball_on_a_plane_stops_where_the_closed_form_says)
{
    static const float resistances[] = {0.01f, 0.05f, 0.2f};
    static const double radii[] = {0.05, 0.5, 2.0};
    for (int i = 0; i < 3 * 3 * 2 * 2; ++i) {
        ball b = {.dims = i / 9 % 2 ? 3 : 2,
                  .radius = radii[i / 3 % 3],
                  .resistance = resistances[i % 3],
                  .dt = i / 18 ? 1.0 / 240.0 : 1.0 / 60.0,
                  .substeps = i / 18 ? 1 : 4};
        double k = b.dims == 3 ? 0.4 : 0.5, way = 6 * b.radius;
        double slows = (double)b.resistance * g / (1 + k);
        b.speed = sqrt(2 * slows * way);
        mover *m = roll(&b);
        mover_run(m, (uint32_t)(1.2 * b.speed / slows / b.dt) + 60);
        double h = b.dt / b.substeps, off = m->states[1].centre[0] - way;
        print_message("%uD, radius %g, resistance %g, h %g: off by %.2g of %g m\n", b.dims,
                      b.radius, (double)b.resistance, h, off, way);
        if (!(fabs(off) < 0.5 * b.speed * h + 0.001 * way))
            fail_msg("off by %g m", off);
        assert_true(mover_speed(m, 1) < 1e-4);
    }
}

// On a slope the ball stays while its tangent is below the coefficient, and else goes as
// (sin - c cos) g / (1 + k).
TEST(a_ball_on_a_slope_stays_or_rolls)
{
    for (int i = 0; i < 4; ++i) {
        ball b = {.dims = i % 2 ? 3 : 2,
                  .radius = 0.5,
                  .resistance = 0.1f,
                  .slope = i / 2 ? 0.2 : 0.08,
                  .dt = 1.0 / 60.0,
                  .substeps = 4};
        mover *m = roll(&b);
        mover_run(m, 60);
        double k = b.dims == 3 ? 0.4 : 0.5, moves = sin(b.slope) - 0.1 * cos(b.slope);
        double expected = i / 2 ? moves * g / (1 + k) : 0.0;
        assert_close(m->states[1].velocity[0], expected, 0.005);
    }
}

// A ball that spins about the normal stops, and no axis is left out.
TEST(a_spinning_ball_stops)
{
    ball b = {.dims = 3, .radius = 0.5, .resistance = 0.02f, .dt = 1.0 / 60.0, .substeps = 4};
    mover *m = roll(&b);
    m->bodies[1].angular_velocity[2] = 3.0f;
    mover_run(m, 30);
    // I w' = -c r N: w' = -5/2 c g / r
    assert_close(m->states[1].angular_velocity[2], 3.0 - 2.5 * 0.02 * g / 0.5 * 0.5, 0.02);
    mover_run(m, 180);
    assert_close(m->states[1].angular_velocity[2], 0.0, 1e-4);
}

// Two balls that roll against each other have the greater coefficient, and no torque from nothing.
TEST(resistance_keeps_momentum_and_takes_energy)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    for (int i = 0; i < 2; ++i) {
        uint32_t id = mover_add(m, i ? 0.99 : 0, 0, 0, 0, 0, 0);
        m->bodies[id].radius = 0.5f;
        m->bodies[id].velocity[0] = i ? -1.0f : 1.0f;
        m->bodies[id].angular_velocity[0] = i ? 5.0f : -1.0f;
        m->bodies[id].rolling_resistance = i ? 0.5f : 0.0f;
        m->bodies[id].mass = 1.0f + (float)i;
    }
    duet_energy before = mover_energy(m);
    mover_run(m, 20);
    duet_energy after = mover_energy(m);
    for (int k = 0; k < 3; ++k) {
        assert_close(after.momentum[k], before.momentum[k], 1e-5);
        assert_close(after.angular[k], before.angular[k], 1e-5);
    }
    assert_true(after.turning < 0.9 * before.turning);
}

TEST(a_thousand_balls_all_fall_asleep)
{
    enum { BALLS = 1000 };
    mover *m = mover_new(3);
    mover_add_floor(m, 40);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.skin = 0.1;
    for (int i = 0; i < BALLS; ++i) {
        uint32_t id = mover_add(m, 1.3 * (i % 32) - 20 + 0.01 * (i % 7), 1.3 * (i / 32) - 20,
                                0.5 + 0.3 * (i % 5), 0, 0, 0);
        m->bodies[id].radius = 0.5f;
        m->bodies[id].friction = 0.5f;
        m->bodies[id].rolling_resistance = 0.02f;
        m->bodies[id].velocity[0] = (float)sin(i);
        m->bodies[id].velocity[1] = (float)cos(3 * i);
    }
    mover_run(m, 60 * 20);
    assert_int_equal(m->last.contacts, 0);
    assert_true(mover_greatest_speed(m) == 0.0);
}

// A motion that needs a number is told.
TEST(what_is_no_resistance_is_refused)
{
    ball b = {.dims = 3, .radius = 0.5, .resistance = -1.0f, .dt = 1.0 / 60.0, .substeps = 4};
    mover *m = roll(&b);
    must_fail(duet_motion_create(&m->def, m->poses, m->bodies, m->n, ERR), DUET_STATUS_BAD_OBJECT,
              "rolling resistance");
}

// Set by a command it acts from then on.
TEST(a_command_sets_it)
{
    ball b = {
        .dims = 3, .radius = 0.5, .resistance = 1e-6f, .speed = 2, .dt = 1.0 / 60.0, .substeps = 4};
    mover *m = roll(&b);
    mover_run(m, 60);
    assert_close(m->states[1].velocity[0], 2.0, 0.01);
    duet_body body = duet_default_body();
    body.rolling_resistance = 0.2f;
    duet_body_list one = {.first = 1, .n = 1};
    must(duet_motion_set_bodies(m->motion, one, DUET_BODY_ROLLING_RESISTANCE, &body, ERR));
    mover_run(m, 60);
    assert_close(m->states[1].velocity[0], 2.0 - 0.2 * g / 1.4, 0.02);
}

TEST_MAIN(mover_open_pair, mover_close_pair)
