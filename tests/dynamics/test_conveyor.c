// SPDX-License-Identifier: MIT
// Surfaces that move, against closed forms: what lies on a belt gains speed by friction until it
// goes as the belt does.
#include "support/mover.h"
#include "support/test.h"

static const double g = 9.81;

typedef struct belt {
    uint32_t dims;
    double friction, speed, turn; // of the belt about the height, in 3D
    bool carried;                 // the box's own surface moves, and the floor stands
    double dt;
    uint32_t substeps;
} belt;

// A box at rest on a floor whose surface moves along the floor's own x axis.
static mover *make(const belt *b)
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
        mover *m = make(&b);
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
        mover *m = make(&b);
        mover_run(m, 120);
        assert_close(m->states[1].velocity[0], -2.0 * cos(b.turn), 5e-3);
        assert_close(m->states[1].velocity[1], -2.0 * sin(b.turn), 5e-3);
    }
}

// A wall holds the box: the belt slides beneath with mu m g, and the box stays.
TEST(a_box_against_a_stop_stays)
{
    belt b = {.dims = 3, .friction = 0.5, .speed = 2, .dt = 1.0 / 60.0, .substeps = 4};
    mover *m = make(&b);
    mover_add_fixed(m, 1.0, 0, 1, 0.5, 2, 1);
    mover_run(m, 120);
    assert_close(m->states[1].centre[0], 0.0, 0.01);
    assert_close(m->states[1].velocity[0], 0.0, 1e-3);
}

// A ball on a belt: its surface takes the belt's speed, so that 2/7 of it is left to the centre.
TEST(a_ball_on_a_belt_rolls_on_the_spot_in_part)
{
    belt b = {.dims = 3, .friction = 0.5, .speed = 2, .dt = 1.0 / 240.0, .substeps = 4};
    mover *m = make(&b);
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
    mover *m = make(&b);
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
        mover *m = make(&b), *loaded = make(&b);
        m->def.doubles = loaded->def.doubles = doubles == 1;
        mover_run(m, 10);
        mover_run(loaded, 0);
        must(duet_motion_save(m->motion, "belt", ERR));
        must(duet_motion_load(loaded->motion, "belt", ERR));
        mover_run(m, 30);
        mover_run(loaded, 30);
        assert_true(mover_hash(m) == mover_hash(loaded));
    }
}

TEST_MAIN(mover_open_pair, mover_close_pair)
