// SPDX-License-Identifier: MIT
// Bodies on a mesh that a body without mass carries: against closed forms, against the same body as
// a box, and seen from the mesh.
#include "support/ground.h"
#include "support/shape.h"
#include "support/test.h"
#include "support/trees.h"

static const double weight = 9.81;

// ---------------------------------------------------------------- carried meshes

static shape *carried_new(void)
{
    shape *s = shape_new();
    s->mesh.carrier = 1;
    return s;
}

// A level floor of n x n cells about the carrier.
static shape *floor_of(double half, uint32_t n)
{
    shape *s = carried_new();
    shape_grid(s, n + 1, 2 * half / n, ground_flat);
    return s;
}

// A drum about the y axis, its sides inward, with bars within.
static shape *drum_of(double radius, double half, uint32_t sides)
{
    shape *c = carried_new();
    uint32_t front = shape_vertex(c, 0, -half, 0), back = shape_vertex(c, 0, half, 0);
    for (uint32_t i = 0; i < sides; ++i) {
        double angle = 2 * acos(-1.0) * i / sides, r = radius * (i % 6 == 0 ? 0.8 : 1);
        shape_vertex(c, r * cos(angle), -half, r * sin(angle));
        shape_vertex(c, r * cos(angle), half, r * sin(angle));
    }
    for (uint32_t i = 0; i < sides; ++i) {
        uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % sides);
        shape_quad(c, a, b, b + 1, a + 1);
        shape_triangle(c, front, b, a);
        shape_triangle(c, back, a + 1, b + 1);
    }
    return c;
}

// A mover on that mesh, whose first body carries it and touches nothing.
static mover *carrying(const shape *c)
{
    mover *m = ground_mover(NULL, c ? &c->mesh : NULL);
    duet_body *b = &m->bodies[mover_add(m, 0, 0, 0, 0.01, 0.01, 0.01)];
    b->mass = 0;
    b->group = b->mask = 0;
    return m;
}

static void set_velocity(mover *m, uint32_t id, double x, double y, double z)
{
    const double v[3] = {x, y, z};
    for (int k = 0; k < 3; ++k)
        m->bodies[id].velocity[k] = (float)v[k];
}

// ---------------------------------------------------------------- closed forms

// A belt of speed v takes a box along: it slides for v / (mu g), by v^2 / (2 mu g) less than the
// belt.
TEST(a_box_on_a_floor_that_goes_slides_until_it_goes_along)
{
    const double v = 2, mu = 0.5;
    shape *c = floor_of(20, 7);
    mover *m = carrying(c);
    set_velocity(m, 0, v, 0, 0);
    uint32_t id = ground_add(m, SHARP, 0.3, 0.2);
    m->bodies[id].friction = (float)mu;
    m->bodies[id].restitution = 0;
    mover_run(m, 120);
    const double slide = v * v / (2 * mu * weight);
    assert_close(m->states[id].velocity[0], v, 1e-3);
    assert_close(m->states[id].centre[0], 0.3 + 2 * v - slide, 0.02);
    assert_close(m->states[id].centre[2], (double)m->poses[id].centre[2], ground_slop);
}

// A ball on a belt of speed v slides until it rolls, at 2/7 v.
TEST(a_ball_on_a_floor_that_goes_rolls_at_two_sevenths)
{
    shape *c = floor_of(20, 7);
    mover *m = carrying(c);
    set_velocity(m, 0, 0, 1.4, 0);
    uint32_t id = ground_add(m, ROLLING_BALL, 0.3, 0.2);
    m->bodies[id].friction = 1;
    mover_run(m, 90);
    assert_close(m->states[id].velocity[1], 0.4, 0.004);
    assert_close(m->states[id].angular_velocity[0], (1.4 - 0.4) / 0.25, 0.04);
}

TEST(a_floor_that_rises_lifts_what_lies_on_it)
{
    shape *c = floor_of(8, 5);
    mover *m = carrying(c);
    set_velocity(m, 0, 0, 0, 0.75);
    for (uint32_t kind = 0; kind < GROUND_KINDS; ++kind)
        set_velocity(m, ground_add(m, kind, -5 + 2.0 * kind, 0.3), 0, 0, 0.75);
    mover_run(m, 120);
    for (uint32_t id = 1; id < m->n; ++id)
        assert_close(m->states[id].centre[2], (double)m->poses[id].centre[2] + 1.5, ground_slop);
}

// A block of friction 1 stays on its place of a table that turns slowly. Levers are those of a
// step's begin, so that it goes outward by (w dt)^2 / 2 of its distance in each step.
TEST(a_block_turns_with_its_table)
{
    const double w = 1, out = 0.5 * w * w / 3600;
    shape *c = floor_of(5, 3);
    mover *m = carrying(c);
    uint32_t id = mover_add(m, 1.5, 0, 0.1, 0.1, 0.2, 0.1);
    m->bodies[0].angular_velocity[2] = m->bodies[id].angular_velocity[2] = (float)w;
    m->bodies[id].friction = 1;
    set_velocity(m, id, 0, 1.5 * w, 0);
    mover_run(m, 180);
    double x = m->states[id].centre[0], y = m->states[id].centre[1];
    assert_close(hypot(x, y), 1.5 * exp(out * 180), 0.01);
    assert_close(atan2(y, x), 3, 0.01);
    assert_close(2 * atan2(m->states[id].rotation[2], m->states[id].rotation[3]), 3, 0.01);
}

// Above mu g it does not.
TEST(a_block_leaves_a_table_that_turns_too_fast)
{
    shape *c = floor_of(5, 3);
    for (int i = 0; i < 2; ++i) {
        mover *m = carrying(c);
        double w = i == 0 ? 1.9 : 2.6; // w^2 r of 3.6 and 6.8, on either side of mu g
        uint32_t id = mover_add(m, 1, 0, 0.1, 0.1, 0.1, 0.1);
        m->bodies[0].angular_velocity[2] = m->bodies[id].angular_velocity[2] = (float)w;
        m->bodies[id].friction = 0.5f;
        set_velocity(m, id, 0, w, 0);
        mover_run(m, 60);
        double far = hypot(m->states[id].centre[0], m->states[id].centre[1]);
        assert_true(i == 0 ? far < 1.06 : far > 1.2);
        mover_free(m);
    }
}

// A trough, a V along y: the ball stays in its middle.
TEST(a_ball_goes_along_with_its_trough)
{
    shape *c = carried_new();
    for (int i = 0; i < 2; ++i)
        for (int k = -1; k <= 1; ++k)
            shape_vertex(c, k, i ? 9 : -9, fabs((double)k));
    shape_quad(c, 0, 1, 4, 3);
    shape_quad(c, 1, 2, 5, 4);
    mover *m = carrying(c);
    set_velocity(m, 0, 1.5, 0, 0);
    uint32_t id = mover_add(m, 0, 0, 0.25 * sqrt(2), 0, 0, 0);
    m->bodies[id].radius = 0.25f;
    set_velocity(m, id, 1.5, 0, 0);
    mover_run(m, 240);
    assert_close(m->states[id].centre[0], 6, ground_slop);
    assert_close(m->states[id].centre[2], 0.25 * sqrt(2), ground_slop);
}

// ---------------------------------------------------------------- beside others

// A floor that goes away under bodies without friction leaves them where they are.
TEST(nothing_trips_over_the_seams_of_a_floor_that_goes)
{
    static const double speeds[] = {1, 2, 5, 10};
    shape *c = floor_of(32, 40);
    for (int i = 0; i < 4; ++i) {
        mover *m = carrying(c);
        double v = speeds[i], angle = 0.3 * i;
        set_velocity(m, 0, v * cos(angle), v * sin(angle), 0);
        for (uint32_t kind = 0; kind < GROUND_KINDS; ++kind)
            m->bodies[ground_add(m, kind, -5 + 2.03 * kind, 0.37 * kind)].friction = 0;
        for (int k = 0; k < 30; ++k) {
            mover_run(m, (uint32_t)(20 / v * 60 / 30));
            for (uint32_t id = 1; id < m->n; ++id) {
                double hop = m->states[id].centre[2] - (double)m->poses[id].centre[2];
                if (!(mover_speed(m, id) <= 0.02 * v && fabs(hop) <= ground_slop))
                    fail_msg("kind %u over %g m/s goes at %g and hops %g", id - 1, v,
                             mover_speed(m, id), hop);
            }
        }
        mover_free(m);
    }
}

// The table as a box that turns, tilts and goes is the truth.
TEST(bodies_on_a_carried_floor_go_as_on_a_box)
{
    shape *c = floor_of(6, 5);
    mover *m[2];
    for (int k = 0; k < 2; ++k) {
        m[k] = carrying(k == 0 ? c : NULL);
        duet_body *b = &m[k]->bodies[0];
        b->angular_velocity[0] = 0.05f;
        b->angular_velocity[2] = 0.4f;
        set_velocity(m[k], 0, 0.2, -0.1, 0.1);
        if (k == 1) { // the box lies below its body's centre
            b->group = b->mask = UINT32_MAX;
            b->friction = 0.9f;
            m[k]->poses[0] = (duet_pose){.half_extents = {6, 6, 0.5f}, .rotation = {0, 0, 0, 1}};
        }
        for (uint32_t i = 0; i < 12; ++i) {
            uint32_t id =
                ground_add(m[k], i % 2 ? SHARP : ROUNDED, -3 + i % 4 * 2.0, -2 + i / 4 * 2.0);
            m[k]->poses[id].centre[2] += k == 0 ? 0.02f : 0.52f;
            m[k]->bodies[id].friction = 0.9f;
        }
        mover_run(m[k], 150);
    }
    for (uint32_t id = 1; id < m[0]->n; ++id) {
        // The box's top is half a metre above the middle about which it turns.
        double q[4], up[3];
        memcpy(q, m[1]->states[0].rotation, sizeof q);
        up[0] = 2 * (q[0] * q[2] + q[3] * q[1]);
        up[1] = 2 * (q[1] * q[2] - q[3] * q[0]);
        up[2] = 1 - 2 * (q[0] * q[0] + q[1] * q[1]);
        for (int k = 0; k < 3; ++k)
            assert_close(m[0]->states[id].centre[k], m[1]->states[id].centre[k] - 0.5 * up[k],
                         0.05);
    }
}

// ---------------------------------------------------------------- a drum

enum { GRAINS = 160 };

static mover *grains_in(const shape *c, double speed)
{
    mover *m = carrying(c);
    m->bodies[0].angular_velocity[1] = (float)speed;
    for (uint32_t i = 0; i < GRAINS; ++i) {
        uint32_t id = mover_add(m, (i % 8 - 3.5) * 0.14, (i / 8 % 4 - 1.5) * 0.2,
                                (i / 32 - 2.0) * 0.14, 0, 0, 0);
        m->bodies[id].radius = 0.06f;
        m->bodies[id].friction = 0.6f;
    }
    return m;
}

// Grains are lifted and fall, and none leaves the drum.
TEST(a_drum_that_turns_keeps_its_grains_and_lifts_them)
{
    shape *c = drum_of(1, 0.5, 24);
    mover *m = grains_in(c, 1.5);
    double highest = -1;
    for (int i = 0; i < 20; ++i) {
        mover_run(m, 18);
        for (uint32_t id = 1; id < m->n; ++id) {
            const double *at = m->states[id].centre;
            if (!(hypot(at[0], at[2]) < 1 && fabs(at[1]) < 0.5))
                fail_msg("grain %u is at %g %g %g after %d steps", id, at[0], at[1], at[2], 18 * i);
            highest = i > 5 ? fmax(highest, at[2]) : highest;
        }
    }
    assert_true(highest > -0.2);
}

// A plate three hundred times as heavy presses balls into a floor that turns and rises, deeper than
// their centres; they come out again.
TEST(what_is_pressed_into_a_floor_that_goes_stays_on_it)
{
    shape *c = floor_of(80, 9);
    for (int turns = 0; turns < 3; ++turns) {
        mover *m = carrying(c);
        const double rise = 0.5;
        m->bodies[0].angular_velocity[2] = (float)(2 * turns);
        set_velocity(m, 0, 0, 0, rise);
        for (uint32_t i = 0; i < 10; ++i) {
            bool plate = i == 9;
            uint32_t id =
                plate ? mover_add(m, 0, 0, 0.2, 0.6, 0.6, 0.1)
                      : mover_add(m, 0.3 * (i % 3) - 0.27, 0.3 * (i / 3) - 0.3, 0.05, 0, 0, 0);
            m->bodies[id].radius = plate ? 0 : 0.05f;
            m->bodies[id].mass = plate ? 3 : 0.01f;
            m->bodies[id].friction = 0.5f;
            set_velocity(m, id, 0, 0, plate ? -3 : 0);
        }
        mover_run(m, 120);
        for (uint32_t id = 1; id < m->n; ++id)
            if (!(m->states[id].centre[2] > 2 * rise - 0.05))
                fail_msg("turning by %d rad/s: body %u is at %g %g %g", 2 * turns, id,
                         m->states[id].centre[0], m->states[id].centre[1], m->states[id].centre[2]);
        mover_free(m);
    }
}

static uint64_t grain_hash(const shape *c, uint32_t share, double skin, bool sleeps)
{
    mover *m = grains_in(c, -2);
    m->def.plan.share = share;
    m->def.skin = skin;
    m->def.wants |= sleeps ? DUET_EFFECT_SLEEP : 0;
    mover_run(m, 80);
    uint64_t hash = mover_hash(m);
    mover_free(m);
    return hash;
}

TEST(any_share_and_any_skin_give_the_same_bits)
{
    shape *c = drum_of(1, 0.5, 24);
    uint64_t expected = grain_hash(c, 0, 0, false);
    assert_int_equal(grain_hash(c, DUET_SHARE_ONE / 2, 0, false), expected);
    assert_int_equal(grain_hash(c, DUET_SHARE_ONE, 0.05, false), expected);
    assert_int_equal(grain_hash(c, 0, 0.2, false), expected);
    assert_int_equal(grain_hash(c, 0, 0.2, true), grain_hash(c, DUET_SHARE_ONE / 3, 0.02, true));
}

// ---------------------------------------------------------------- rest, targets, events

static const duet_body_list the_carrier = {.first = 0, .n = 1};

static void turn_carrier(mover *m, double speed)
{
    const duet_body b = {.angular_velocity = {0, 0, (float)speed}};
    must(duet_motion_set_bodies(m->motion, the_carrier, DUET_BODY_ANGULAR_VELOCITY, &b, ERR));
}

static bool sleeps(mover *m, uint32_t id)
{
    uint8_t *asleep = test_alloc(m->n);
    must(duet_motion_get_asleep(m->motion, asleep, ERR));
    bool is = asleep[id];
    return is;
}

TEST(a_carrier_that_starts_wakes_what_sleeps_on_the_mesh)
{
    shape *c = floor_of(5, 3);
    mover *m = carrying(c);
    m->def.wants |= DUET_EFFECT_SLEEP;
    uint32_t id = mover_add(m, 1, 0, 0.1, 0.1, 0.1, 0.1);
    m->bodies[id].friction = 1;
    mover_run(m, 120);
    assert_true(sleeps(m, id));
    turn_carrier(m, 0.5);
    mover_run(m, 60);
    assert_false(sleeps(m, id));
    assert_close(atan2(m->states[id].centre[1], m->states[id].centre[0]), 0.5, 0.02);
    turn_carrier(m, 0);
    mover_run(m, 120);
    assert_true(sleeps(m, id));
}

// Targets that go to and fro: a block with friction is where the table is.
static void aim(mover *m, double x)
{
    const duet_transform target = {.centre = {x, 0, 0}, .rotation = {0, 0, 0, 1}};
    must(duet_motion_set_targets(m->motion, the_carrier, &target, ERR));
}

TEST(a_mesh_goes_to_its_carriers_targets)
{
    shape *c = floor_of(5, 3);
    mover *m = carrying(c);
    uint32_t id = mover_add(m, 1, 0, 0.1, 0.1, 0.1, 0.1);
    m->bodies[id].friction = 1;
    mover_run(m, 1);
    for (int i = 1; i <= 120; ++i) {
        aim(m, 0.3 * (1 - cos(i / 60.0)));
        mover_run(m, 1);
    }
    assert_close(m->states[id].centre[0], 1 + 0.3 * (1 - cos(2.0)), 0.01);
}

// It brakes what slid on it, also if most bodies sleep elsewhere.
TEST(a_mesh_whose_carrier_is_disabled_stands_still)
{
    shape *c = floor_of(5, 3);
    mover *m = carrying(c);
    m->def.wants |= DUET_EFFECT_SLEEP;
    uint32_t id = mover_add(m, 1, 0, 0.1, 0.1, 0.1, 0.1);
    m->bodies[id].friction = 0.5f;
    mover_add_fixed(m, 30, 0, -1, 10, 10, 1);
    for (int i = 0; i < 20; ++i)
        mover_add(m, 22 + i, 0, 0.1, 0.1, 0.1, 0.1);
    mover_run(m, 120);
    for (int i = 1; i <= 5; ++i) {
        aim(m, 0.02 * i);
        mover_run(m, 1);
    }
    const double before = m->states[id].velocity[0], braked = 0.5 * weight / 60;
    assert_close(before, 5 * braked, 0.5 * braked);
    must(duet_motion_disable_bodies(m->motion, the_carrier, ERR));
    for (int i = 1; i <= 4; ++i) {
        mover_run(m, 1);
        assert_close(m->states[id].velocity[0], before - i * braked, 0.2 * braked);
    }
}

// The floor comes up at 2 m/s under a body that floats.
TEST(a_hit_has_the_speed_of_the_mesh)
{
    shape *c = floor_of(5, 3);
    mover *m = carrying(c);
    m->def.gravity[2] = 0;
    m->def.hit_speed = 0.5;
    m->def.wants |= DUET_EFFECT_EVENTS;
    set_velocity(m, 0, 0, 0, 2);
    uint32_t id = mover_add(m, 1, 0.2, 0.3, 0.1, 0.1, 0.1), hits = 0;
    for (int i = 0; i < 30; ++i) {
        mover_run(m, 1);
        for (uint64_t k = 0; k < m->last.n_hits; ++k) {
            assert_int_equal(m->last.hits[k].a, id);
            assert_int_equal(m->last.hits[k].b, m->n + 6);
            assert_close((double)m->last.hits[k].speed, 2, 1e-3);
            ++hits;
        }
    }
    assert_int_equal(hits, 1);
    assert_close(m->states[id].velocity[2], 2, 1e-3);
}

// ---------------------------------------------------------------- kept, asked

static mover *turning(const shape *c, uint32_t steps)
{
    mover *m = grains_in(c, 1);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.skin = 0.05;
    mover_run(m, steps);
    return m;
}

TEST(a_saved_motion_and_a_recording_go_on_bit_for_bit)
{
    shape *c = drum_of(1, 0.5, 24);
    mover *m = turning(c, 50), *other = turning(c, 3);
    ground_assert_saved(m, other);
    ground_assert_recorded(m);
    c->mesh.carrier = 2;
    mover *n = carrying(c);
    mover_add(n, 2, 0, 0, 0.1, 0.1, 0.1);
    n->bodies[1].mass = 0;
    mover_run(n, 1);
    must_fail(ground_replay(n, ERR), DUET_STATUS_BAD_INPUT, "");
    must_fail(duet_motion_load(n->motion, "begin", ERR), DUET_STATUS_BAD_INPUT, "");
}

TEST(a_tree_has_the_mesh_where_it_is)
{
    shape *c = floor_of(2, 1);
    mover *m = carrying(c);
    const double turn = acos(-1.0) / 2; // in a second, about x: the floor is upright then
    m->bodies[0].angular_velocity[0] = (float)turn;
    set_velocity(m, 0, 0, 0.5, 1);
    mover_run(m, 60);
    const duet_ray along = {.origin = {1, -6, 1}, .direction = {0, 1, 0}, .t_max = 20};
    duet_ray_query_result found =
        cast_rays(open_ray_query(mover_tree(m), DUET_QUERY_CLOSEST, true), &along, 1);
    assert_int_equal(found.hits[0].id, m->n + 6);
    assert_close((double)found.hits[0].t, 6.5, 1e-3);
    assert_close((double)found.normals[0].normal[1], -1, 1e-3);
}

// ---------------------------------------------------------------- refused

static void refuse(const mover *m, const char *says)
{
    must_fail(duet_motion_create(&m->def, m->poses, m->bodies, m->n, ERR), DUET_STATUS_BAD_ARGUMENT,
              says);
}

TEST(carriers_that_no_mesh_can_have_are_refused)
{
    shape *c = floor_of(2, 1);
    mover *m = carrying(c);
    c->mesh.carrier = 2;
    refuse(m, "the mesh's carrier is body 1; expected one of 1 bodies");
    c->mesh.carrier = 1;
    m->bodies[0].mass = 1;
    refuse(m, "body 0, the mesh's carrier, has the mass 1");
    m->bodies[0].mass = 0;
    m->bodies[0].radius = 0.5f;
    refuse(m, "and the radius 0.5; expected 0");
    m->bodies[0].radius = 0;
    mover_run(m, 1);
    must_fail(duet_motion_remove_bodies(m->motion, the_carrier, ERR), DUET_STATUS_BAD_ARGUMENT,
              "body 0 of 1 carries the mesh");
}
