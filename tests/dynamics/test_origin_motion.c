// SPDX-License-Identifier: MIT
// What moves in origin cells moves alike everywhere, bit for bit.
#include "support/mover.h"
#include "support/test.h"

static const double far[3] = {1e7, -1e6, 1e4};

static mover *mover_in_cells(uint32_t dims, const double at[3])
{
    mover *m = mover_new(dims);
    m->def.origin_edge = 1;
    memcpy(m->def.origin, at, sizeof m->def.origin);
    m->def.gravity[dims - 1] = -9.81;
    return m;
}

// A stack that is not quite straight, on a floor.
static mover *stack_at(uint32_t dims, uint32_t height, const double at[3])
{
    mover *m = mover_in_cells(dims, at);
    m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE;
    uint32_t up = dims - 1;
    uint32_t ground = mover_add(m, 0, 0, 0, 5, 5, 5);
    m->poses[ground].half_extents[up] = 0.5f;
    m->poses[ground].centre[up] = -0.5f;
    m->bodies[ground].mass = 0;
    m->bodies[ground].friction = 0.6f;
    for (uint32_t i = 0; i < height; ++i) {
        double lean = 0.01 * (i % 3), z = i + 0.52;
        uint32_t id = mover_add_cube(m, lean, dims == 2 ? z : 0, dims == 2 ? 0 : z, 1);
        m->bodies[id].friction = 0.6f;
    }
    return m;
}

// Boxes that fly, fall and turn over many cells.
static mover *swarm_at(const double at[3], duet_integrator integrator)
{
    mover *m = mover_in_cells(3, at);
    m->def.integrator = integrator;
    m->def.drag = 0.1;
    for (int i = 0; i < 20; ++i) {
        uint32_t id = mover_add(m, 0.3 * i, -0.2 * i, 0.1 * i, 0.5, 0.25, 0.125);
        for (int k = 0; k < 3; ++k) {
            m->bodies[id].velocity[k] = (float)(i - 7 * k);
            m->bodies[id].angular_velocity[k] = 0.3f * (float)(i - 5 * k);
        }
    }
    return m;
}

static void assert_alike(const mover *here, const mover *there)
{
    for (uint32_t i = 0; i < here->n; ++i) {
        duet_state s = there->states[i];
        for (uint32_t k = 0; k < here->def.dims; ++k)
            s.centre[k] -= there->def.origin[k] - here->def.origin[k];
        assert_memory_equal(&s, &here->states[i], sizeof s);
    }
}

static void check_stack(uint32_t dims, uint32_t height, uint32_t steps)
{
    const double here[3] = {0};
    mover *near = stack_at(dims, height, here);
    mover_run(near, steps);
    for (uint32_t i = 1; i <= height; ++i)
        assert_close(near->states[i].centre[dims - 1], i - 0.5, 0.05);
    for (int k = 0; k < 3; ++k) {
        const double at[3] = {far[k], -far[k], 0};
        mover *m = stack_at(dims, height, at);
        mover_run(m, steps);
        assert_alike(near, m);
    }
}

TEST(a_stack_far_away_ends_as_the_one_at_0)
{
    check_stack(3, 10, 200);
    check_stack(2, 5, 100);
}

TEST(a_flight_far_away_is_the_one_at_0)
{
    const double here[3] = {0};
    const duet_integrator integrators[] = {DUET_INTEGRATOR_EULER, DUET_INTEGRATOR_YOSHIDA};
    for (int i = 0; i < 2; ++i) {
        mover *near = swarm_at(here, integrators[i]), *m = swarm_at(far, integrators[i]);
        mover_run(near, 120);
        mover_run(m, 120);
        assert_alike(near, m);
        assert_true(fabs(m->states[19].centre[0] - far[0]) > 10); // it left its cell
    }
}

// Balls, capsules and rounded boxes that fall on each other, over many cells.
static mover *round_pile_at(uint32_t dims, const double at[3])
{
    mover *m = stack_at(dims, 0, at);
    m->bodies[0].radius = 0.25f;
    m->poses[0].half_extents[0] = 60; // a ball that rolls away stays on it
    m->poses[0].half_extents[1] = dims == 3 ? 60 : 0.5f;
    for (int i = 0; i < 12; ++i) {
        double half = 0.3 * (i % 3), z = 1.2 * i + 1.1, x = 0.1 * (i % 4);
        uint32_t id = mover_add(m, x, dims == 2 ? z : 0.05 * i, dims == 2 ? 0 : z, half,
                                i % 3 == 2 ? 0.2 : 0, i % 3 == 2 ? 0.3 : 0);
        m->bodies[id].radius = 0.25f + 0.05f * (float)(i % 2);
        m->bodies[id].friction = 0.5f;
    }
    return m;
}

TEST(round_bodies_far_away_fall_as_those_at_0)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        const double here[3] = {0}, at[3] = {far[0], far[1], dims == 3 ? far[2] : 0};
        mover *near = round_pile_at(dims, here), *m = round_pile_at(dims, at);
        mover *plain = round_pile_at(dims, here);
        plain->def.origin_edge = 0;
        mover_run(near, 150);
        mover_run(m, 150);
        mover_run(plain, 30);
        assert_alike(near, m);
        mover_restart(near);
        mover_run(near, 30);
        for (uint32_t i = 1; i < near->n; ++i) {
            assert_close(near->states[i].centre[dims - 1], plain->states[i].centre[dims - 1], 1e-3);
            assert_true(m->states[i].centre[dims - 1] > at[dims - 1] + 0.25 + 0.2); // on the floor
        }
    }
}

// Without a rotation, an angular velocity or a drag the way is known.
TEST(a_fall_far_away_follows_its_parabola)
{
    mover *m = mover_in_cells(3, far);
    m->def.integrator = DUET_INTEGRATOR_VERLET;
    uint32_t id = mover_add_cube(m, 0.5, 0.25, 0, 1);
    m->bodies[id].velocity[0] = 3;
    mover_run(m, 120);
    assert_close(m->states[id].centre[0], far[0] + 0.5 + 6, 1e-4);
    assert_close(m->states[id].centre[2], far[2] - 0.5 * 9.81 * 4, 1e-3);
    assert_true(m->states[id].centre[1] == far[1] + 0.25);
}

TEST(a_loaded_motion_is_in_the_saved_one_s_cells)
{
    const char *path = "test_origin_motion.saved";
    mover *saved = stack_at(3, 4, far), *loaded = stack_at(3, 4, far);
    mover_run(saved, 30);
    must(duet_motion_save(saved->motion, path, ERR));
    mover_run(loaded, 1);
    must(duet_motion_load(loaded->motion, path, ERR));
    assert_true(mover_hash(saved) == mover_hash(loaded));
    mover_run_alike(saved, loaded, 30);
    loaded = stack_at(3, 4, far);
    loaded->def.origin_edge = 2;
    mover_run(loaded, 1);
    must_fail(duet_motion_load(loaded->motion, path, ERR), DUET_STATUS_BAD_INPUT, "");
}

static void refuse(const mover *m, const char *words)
{
    must_fail(duet_motion_create(&m->def, m->poses, m->bodies, m->n, ERR), DUET_STATUS_BAD_ARGUMENT,
              words);
}

TEST(a_motion_says_what_origin_cells_do_not_go_with)
{
    mover *m = stack_at(3, 1, far);
    m->def.pair = default_pair();
    m->def.origin_edge = 0.3f;
    refuse(m, "power of two");
    m->def.origin_edge = 1;
    m->def.doubles = true;
    refuse(m, "doubles = false");
    m->def.doubles = false;
    m->def.attraction = 1;
    refuse(m, "know no origin cells");
}

TEST(explain_names_the_cells_and_their_bytes)
{
    for (int with = 0; with < 2; ++with) {
        mover *m = stack_at(3, 1, (double[]){0, 0, 0});
        m->def.origin_edge = (float)with;
        mover_run(m, 1);
        duet_effect_info info;
        bool found = false;
        for (uint32_t i = 0; duet_motion_explain(m->motion, i, &info); ++i) {
            if (strcmp(info.name, "origin") != 0)
                continue;
            found = true;
            assert_int_equal(info.active, with);
            assert_int_equal(info.bytes, with ? 16 : 0);
        }
        assert_true(found);
    }
}
