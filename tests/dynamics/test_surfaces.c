// SPDX-License-Identifier: MIT
// Surfaces against closed forms: what rolls on a plane stops, what lies on a slope stays, and what
// lies on a belt gains speed by friction until it goes as the belt does.
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

// ---------------------------------------------------------------- belts

typedef struct belt {
    uint32_t dims;
    double friction, speed, turn; // of the belt about the height, in 3D
    bool carried;                 // the box's own surface moves, and the floor stands
    double dt;
    uint32_t substeps;
} belt;

// A box at rest on a floor whose surface moves along the floor's own x axis.
static mover *make_belt(const belt *b)
{
    mover *m = mover_new(b->dims);
    uint32_t up = b->dims - 1;
    m->def.dt = b->dt;
    m->def.substeps = b->substeps;
    uint32_t floor = mover_add_floor(m, 50);
    double at[3] = {0, 0, 0};
    at[up] = 0.25;
    uint32_t box = mover_add(m, at[0], at[1], at[2], 0.5, b->dims == 3 ? 0.5 : 0.25, 0.25);
    mover_turn(m, b->carried ? box : floor, 0, 0, 1, b->turn);
    m->bodies[floor].friction = m->bodies[box].friction = (float)b->friction;
    m->bodies[b->carried ? box : floor].surface_velocity[0] = (float)b->speed;
    return m;
}

// v = mu g t up to the belt's speed, along the belt; from then on that speed.
TEST(a_box_on_a_belt_gains_its_speed_by_friction_and_stays)
{
    for (int i = 0; i < 24; ++i) {
        belt b = {.dims = i % 2 ? 3 : 2,
                  .friction = i / 2 % 3 * 0.3 + 0.2,
                  .speed = i / 6 % 2 ? 3.0 : -1.0,
                  .turn = i % 2 && i >= 12 ? 0.7 : 0.0,
                  .dt = i / 12 ? 1.0 / 240.0 : 1.0 / 60.0,
                  .substeps = 4};
        mover *m = make_belt(&b);
        double reached = fabs(b.speed) / (b.friction * g), h = b.dt / b.substeps;
        double direction[2] = {cos(b.turn), sin(b.turn)};
        for (int sample = 1; sample <= 10; ++sample) {
            mover_run(m, (uint32_t)(0.2 * reached / b.dt) + 1);
            double time = m->last.time, speed = fmin(b.friction * g * time, fabs(b.speed));
            const double *v = m->states[1].velocity;
            for (int k = 0; k < 2; ++k) {
                double expected = copysign(speed, b.speed) * direction[k];
                expected = b.dims == 2 && k == 1 ? 0.0 : expected;
                if (!(fabs(v[k] - expected) < 1.5 * g * h))
                    fail_msg("%uD, friction %g, after %g s: %g m/s, not %g", b.dims, b.friction,
                             time, v[k], expected);
            }
        }
        assert_close(hypot(m->states[1].velocity[0], m->states[1].velocity[1]), fabs(b.speed),
                     1e-4 * fabs(b.speed));
    }
}

// A box whose own surface moves drives the other way, as a tank does, and turned with its own axes.
TEST(a_body_with_tracks_drives_itself)
{
    for (int turned = 0; turned < 2; ++turned) {
        belt b = {.dims = 3,
                  .friction = 0.8,
                  .speed = 2,
                  .turn = turned ? 1.2 : 0.0,
                  .carried = true,
                  .dt = 1.0 / 60.0,
                  .substeps = 4};
        mover *m = make_belt(&b);
        mover_run(m, 120);
        assert_close(m->states[1].velocity[0], -2.0 * cos(b.turn), 5e-3);
        assert_close(m->states[1].velocity[1], -2.0 * sin(b.turn), 5e-3);
    }
}

// A wall holds the box: the belt slides beneath with mu m g, and the box stays.
TEST(a_box_against_a_stop_stays)
{
    belt b = {.dims = 3, .friction = 0.5, .speed = 2, .dt = 1.0 / 60.0, .substeps = 4};
    mover *m = make_belt(&b);
    mover_add_fixed(m, 1.0, 0, 1, 0.5, 2, 1);
    mover_run(m, 120);
    assert_close(m->states[1].centre[0], 0.0, 0.01);
    assert_close(m->states[1].velocity[0], 0.0, 1e-3);
}

// A ball on a belt: its surface takes the belt's speed, so that 2/7 of it is left to the centre.
TEST(a_ball_on_a_belt_rolls_on_the_spot_in_part)
{
    belt b = {.dims = 3, .friction = 0.5, .speed = 2, .dt = 1.0 / 240.0, .substeps = 4};
    mover *m = make_belt(&b);
    for (int k = 0; k < 3; ++k)
        m->poses[1].half_extents[k] = 0.0f;
    m->bodies[1].radius = 0.25f;
    mover_run(m, 240);
    assert_close(m->states[1].velocity[0], 2.0 * 2.0 / 7.0, 0.01);
    assert_close(m->states[1].angular_velocity[1], -2.0 * 5.0 / 7.0 / 0.25, 0.05);
}

// A command stops the belt, and the box with it.
TEST(a_command_stops_a_belt)
{
    belt b = {.dims = 3, .friction = 0.5, .speed = 2, .dt = 1.0 / 60.0, .substeps = 4};
    mover *m = make_belt(&b);
    mover_run(m, 60);
    assert_close(m->states[1].velocity[0], 2.0, 1e-3);
    duet_body still = duet_default_body();
    duet_body_list floor = {.first = 0, .n = 1};
    must(duet_motion_set_bodies(m->motion, floor, DUET_BODY_SURFACE_VELOCITY, &still, ERR));
    mover_run(m, 60);
    assert_close(m->states[1].velocity[0], 0.0, 1e-3);
}

// A file of a motion on a belt goes on bit for bit, in double as well.
TEST(a_loaded_belt_runs_on)
{
    for (int doubles = 0; doubles < 2; ++doubles) {
        belt b = {
            .dims = 3, .friction = 0.5, .speed = 2, .turn = 0.3, .dt = 1.0 / 60.0, .substeps = 4};
        mover *m = make_belt(&b), *loaded = make_belt(&b);
        m->def.doubles = loaded->def.doubles = doubles == 1;
        mover_run(m, 10);
        mover_run(loaded, 0);
        must(duet_motion_save(m->motion, "belt", ERR));
        must(duet_motion_load(loaded->motion, "belt", ERR));
        mover_run_alike(m, loaded, 30);
    }
}
