// SPDX-License-Identifier: MIT
// Free flight: closed forms, the order of each integrator, and what it keeps.
#include "support/figure.h"
#include "support/mover.h"
#include "support/test.h"

static double norm(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// ---------------------------------------------------------------- order

// A mass on an eccentric orbit, half a period on: how far it is from where
// Kepler's ellipse has it.
static double orbit_error(duet_integrator integrator, uint32_t steps)
{
    mover *m = mover_new(2);
    const double period = 2.0 * 3.14159265358979323846;
    const double eccentricity = 0.2; // semi-major axis 1, attraction 1
    m->def.doubles = true;
    m->def.integrator = integrator;
    m->def.attraction = 1.0;
    m->def.substeps = 1;
    m->def.dt = 0.5 * period / steps;
    uint32_t id = mover_add_cube(m, 1.0 - 0.2f, 0, 0, 0.01);
    float speed = (float)sqrt((1.0 + eccentricity) / (1.0 - eccentricity));
    m->bodies[id].velocity[1] = speed;
    // the orbit that the rounded speed and place have
    double r0 = m->poses[id].centre[0];
    double axis = 1.0 / (2.0 / r0 - (double)speed * speed);
    m->def.dt = period / 2 * axis * sqrt(axis) / steps;
    mover_run(m, steps);
    return hypot(m->states[id].centre[0] - (r0 - 2.0 * axis), m->states[id].centre[1]);
}

static void assert_order(duet_integrator integrator, double order, uint32_t steps)
{
    double slope = log2(orbit_error(integrator, steps) / orbit_error(integrator, 2 * steps));
    if (fabs(slope - order) > 0.15)
        fail_msg("slope %g where the order is %g", slope, order);
}

TEST(errors_follow_the_integrators_order)
{
    assert_order(DUET_INTEGRATOR_EULER, 1.0, 4000);
    assert_order(DUET_INTEGRATOR_VERLET, 2.0, 500);
    assert_order(DUET_INTEGRATOR_YOSHIDA, 4.0, 200);
}

TEST(verlet_is_exact_in_uniform_gravity)
{
    mover *m = mover_new(3);
    m->def.doubles = true;
    m->def.integrator = DUET_INTEGRATOR_VERLET;
    m->def.gravity[2] = -9.81;
    uint32_t id = mover_add_cube(m, 0, 0, 0, 1);
    m->bodies[id].velocity[0] = 3.0f;
    m->bodies[id].velocity[2] = 7.0f;
    mover_run(m, 120);
    assert_close(m->states[id].centre[0], 3.0 * 2.0, 1e-12);
    assert_close(m->states[id].centre[2], 7.0 * 2.0 - 0.5 * 9.81 * 4.0, 1e-12);
}

TEST(drag_decays_exponentially)
{
    mover *m = mover_new(3);
    m->def.doubles = true;
    m->def.drag = 0.5;
    uint32_t id = mover_add_cube(m, 0, 0, 0, 1);
    m->bodies[id].velocity[1] = 2.0f;
    m->bodies[id].angular_velocity[2] = 1.0f;
    mover_run(m, 60);
    assert_close(m->states[id].velocity[1], 2.0 * exp(-0.5), 1e-12);
    assert_close(m->states[id].angular_velocity[2], exp(-0.5), 1e-12);
}

// ---------------------------------------------------------------- orbits

TEST(an_orbit_keeps_its_energy)
{
    mover *m = mover_new(2);
    m->def.doubles = true;
    m->def.integrator = DUET_INTEGRATOR_YOSHIDA;
    m->def.attraction = 1.0;
    m->def.dt = 0.05;
    m->def.substeps = 1;
    uint32_t id = mover_add_cube(m, 1, 0, 0, 0.01);
    m->bodies[id].velocity[1] = 1.1f;
    double before = mover_total(m);
    mover_run(m, 20000);
    assert_close(mover_total(m), before, 1e-5);
}

// ---------------------------------------------------------------- rotation

// A box with three different sides turns over about its middle axis: energy
// and angular momentum stay, for long.
TEST(a_turning_box_keeps_energy_and_momentum)
{
    for (int doubles = 0; doubles < 2; ++doubles) {
        mover *m = mover_new(3);
        m->def.doubles = doubles;
        m->def.dt = 0.01;
        m->def.substeps = 50;
        uint32_t id = mover_add(m, 0, 0, 0, 0.5, 0.3, 0.1);
        m->bodies[id].angular_velocity[1] = 5.0f;
        m->bodies[id].angular_velocity[0] = 0.01f;
        duet_energy before = mover_energy(m);
        mover_run(m, 2000); // 100 000 substeps
        duet_energy after = mover_energy(m);
        double bound = doubles ? 1e-4 : 1e-3;
        assert_close(after.turning / before.turning, 1.0, bound);
        assert_true(fabs(norm(after.angular) / norm(before.angular) - 1.0) <
                    (doubles ? 1e-9 : 1e-3));
        for (int k = 0; k < 3; ++k)
            assert_close(after.angular[k] / norm(before.angular),
                         before.angular[k] / norm(before.angular), doubles ? 1e-9 : 2e-3);
    }
}

// 4 K(k) by the arithmetic-geometric mean.
static double four_k(double k2)
{
    double a = 1.0, b = sqrt(1.0 - k2);
    for (int i = 0; i < 40; ++i) {
        double mean = 0.5 * (a + b);
        b = sqrt(a * b);
        a = mean;
    }
    return 2.0 * 3.14159265358979323846 / a;
}

// Dzhanibekov's effect: the spin about the middle axis changes its sign with a
// period that Jacobi's elliptic functions give.
TEST(the_flips_come_with_the_elliptic_period)
{
    mover *m = mover_new(3);
    m->def.doubles = true;
    m->def.dt = 0.001;
    m->def.substeps = 2;
    uint32_t id = mover_add(m, 0, 0, 0, 0.5, 0.3, 0.1);
    float *spin = m->bodies[id].angular_velocity;
    spin[0] = 0.1f;
    spin[1] = 5.0f;
    double a = 0.5 * 0.5, b = 0.3 * 0.3, c = 0.1f * 0.1;
    double i1 = (b + c) / 3, i2 = (a + c) / 3, i3 = (a + b) / 3; // x least, z greatest
    double e2 = i1 * spin[0] * spin[0] + i2 * spin[1] * spin[1];
    double l2 = i1 * i1 * spin[0] * spin[0] + i2 * i2 * spin[1] * spin[1];
    // Landau and Lifshitz, section 37, with I3 > I2 > I1 and L^2 > 2 E I2 or not
    bool over = l2 > e2 * i2;
    double k2 = over ? (i2 - i1) * (e2 * i3 - l2) / ((i3 - i2) * (l2 - e2 * i1))
                     : (i3 - i2) * (l2 - e2 * i1) / ((i2 - i1) * (e2 * i3 - l2));
    double rate = over ? sqrt((i3 - i2) * (l2 - e2 * i1) / (i1 * i2 * i3))
                       : sqrt((i2 - i1) * (e2 * i3 - l2) / (i1 * i2 * i3));
    double period = four_k(k2) / rate;
    double last = 1.0, first_flip = 0.0, third_flip = 0.0;
    int flips = 0;
    for (int step = 1; flips < 3 && step < 60000; ++step) {
        mover_run(m, 1);
        const double *q = m->states[id].rotation;
        const double *w = m->states[id].angular_velocity;
        // along the box's y
        double along = w[0] * 2 * (q[0] * q[1] - q[3] * q[2]) +
                       w[1] * (1 - 2 * (q[0] * q[0] + q[2] * q[2])) +
                       w[2] * 2 * (q[1] * q[2] + q[3] * q[0]);
        if (along * last < 0.0) {
            ++flips;
            first_flip = flips == 1 ? step : first_flip;
            third_flip = step;
        }
        last = along;
    }
    assert_int_equal(flips, 3);
    double measured = (third_flip - first_flip) * m->def.dt;
    double part = figure("notes/effects.md", "Jacobi's elliptic functions give, within # %") / 100;
    if (fabs(measured / period - 1.0) > part)
        fail_msg("a period of %g, where Jacobi's functions have %g", measured, period);
}

TEST(a_thin_plate_spins_without_gain)
{
    mover *m = mover_new(3);
    uint32_t id = mover_add(m, 0, 0, 0, 1, 1, 1e-3);
    m->bodies[id].angular_velocity[0] = 70.0f;
    m->bodies[id].angular_velocity[2] = 70.0f;
    double before = mover_energy(m).turning;
    for (int round = 0; round < 20; ++round) {
        mover_run(m, 60);
        const double *q = m->states[id].rotation;
        double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        assert_close(length, 1.0, 1e-6);
        assert_true(mover_energy(m).turning < before * 1.001);
    }
}

TEST(a_cube_turns_steadily)
{
    mover *m = mover_new(3);
    m->def.doubles = true;
    uint32_t id = mover_add_cube(m, 0, 0, 0, 1);
    m->bodies[id].angular_velocity[2] = 3.0f;
    mover_run(m, 60);
    assert_close(m->states[id].rotation[2], sin(1.5), 1e-12);
    assert_close(m->states[id].rotation[3], cos(1.5), 1e-12);
}

// ---------------------------------------------------------------- bounds

TEST(walls_are_mirrors_without_response)
{
    mover *m = mover_new(2);
    m->def.boundary = DUET_BOUNDARY_WALLS;
    m->def.upper[0] = m->def.upper[1] = 10.0;
    uint32_t id = mover_add_cube(m, 5, 5, 0, 1);
    m->bodies[id].velocity[0] = 7.0f;
    m->bodies[id].velocity[1] = -3.0f;
    double before = mover_energy(m).kinetic;
    for (int k = 0; k < 600; ++k) {
        mover_run(m, 1);
        for (int axis = 0; axis < 2; ++axis)
            assert_in_range((int)(1000 * m->states[id].centre[axis]), 499, 9501);
    }
    assert_true(mover_energy(m).kinetic == before);
}

TEST(a_periodic_world_comes_round)
{
    mover *m = mover_new(3);
    m->def.doubles = true;
    m->def.boundary = DUET_BOUNDARY_PERIODIC;
    for (int k = 0; k < 3; ++k)
        m->def.upper[k] = 4.0;
    m->def.dt = 0.125;
    m->def.substeps = 1;
    uint32_t id = mover_add_cube(m, 1, 1, 1, 1);
    m->bodies[id].velocity[0] = 4.0f;
    m->bodies[id].velocity[1] = -8.0f;
    mover_run(m, 8);
    for (int k = 0; k < 3; ++k)
        assert_close(m->states[id].centre[k], 1.0, 1e-12);
}

// ---------------------------------------------------------------- nothing

TEST(a_step_of_no_time_changes_nothing)
{
    mover *m = mover_new(3);
    m->def.dt = 0.0;
    m->def.gravity[2] = -9.81;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    uint32_t id = mover_add_cube(m, 0, 0, 0, 1);
    m->bodies[id].velocity[0] = 1.0f;
    uint64_t before = mover_hash(m);
    mover_run(m, 10);
    assert_true(mover_hash(m) == before);
}

// A million steps of a world in which nothing happens take no launch.
TEST(a_million_empty_steps_change_nothing)
{
    mover *m = mover_new(3);
    for (int i = 0; i < 10; ++i)
        mover_add_cube(m, 3 * i, 0, 0, 1);
    uint64_t before = mover_hash(m);
    mover_run(m, 1000000);
    assert_int_equal(duet_motion_get_effects(m->motion), 0);
    assert_true(mover_hash(m) == before);
    assert_int_equal(m->last.step, 1000000);
}

static void assert_refused(mover *m, duet_status status, const char *says)
{
    must_fail(duet_motion_create(&m->def, m->poses, m->bodies, m->n, ERR), status, says);
}

TEST(wrong_numbers_are_refused)
{
    mover *m = mover_new(3);
    mover_add_cube(m, 0, 0, 0, 1);
    mover_add_cube(m, 3, 0, 0, 1);
    m->def.dt = -1.0;
    assert_refused(m, DUET_STATUS_BAD_ARGUMENT, "dt is -1");
    m->def.dt = NAN;
    assert_refused(m, DUET_STATUS_BAD_ARGUMENT, "dt is");
    m->def.dt = 0.1;
    m->def.substeps = 1001;
    assert_refused(m, DUET_STATUS_BAD_ARGUMENT, "substeps is 1001");
    m->def.substeps = 1;
    m->def.gravity[1] = INFINITY;
    assert_refused(m, DUET_STATUS_BAD_ARGUMENT, "y of gravity");
    m->def.gravity[1] = 0.0;
    m->bodies[1].mass = -1.0f;
    assert_refused(m, DUET_STATUS_BAD_OBJECT, "object 1 of 2: the mass");
    m->bodies[1].mass = 1.0f;
    m->bodies[0].velocity[2] = NAN;
    assert_refused(m, DUET_STATUS_BAD_OBJECT, "object 0 of 2: a velocity");
    m->bodies[0].velocity[2] = 0.0f;
    m->poses[1].half_extents[0] = -1.0f;
    assert_refused(m, DUET_STATUS_BAD_OBJECT, "object 1 of 2: a half extent");
    m->poses[1].half_extents[0] = 1.0f;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    m->def.integrator = DUET_INTEGRATOR_VERLET;
    assert_refused(m, DUET_STATUS_BAD_ARGUMENT, "integrator euler");
}
