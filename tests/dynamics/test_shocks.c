// SPDX-License-Identifier: MIT
// Impacts through rows of bodies that touch, against what a chain of impacts of two gives.
#include "support/mover.h"
#include "support/test.h"

enum { MOST = 16 };
static const double half = 0.25;

// Bodies of a half extent or radius in a row along x; the first `struck` come at a speed from
// `way` before the others, between which `gap` lies.
typedef struct row {
    uint32_t dims, n, struck;
    double speed, way, gap;
    float restitution;
    bool boxes, table; // on a floor with gravity, or in space
    const float *masses;
} row;

static void add_row_body(mover *m, const row *r, double x, uint32_t i)
{
    double up = r->table ? half : 0.0, h = r->boxes ? half : 0.0;
    uint32_t id = mover_add(m, x, r->dims == 2 ? up : 0, r->dims == 3 ? up : 0, h, h, h);
    m->bodies[id].radius = r->boxes ? 0.0f : (float)half;
    m->bodies[id].restitution = r->restitution;
    m->bodies[id].velocity[0] = i < r->struck ? (float)r->speed : 0.0f;
    m->bodies[id].mass = r->masses ? r->masses[i] : 1.0f;
}

static mover *make(const row *r)
{
    mover *m = mover_new(r->dims);
    m->def.slop = 0.005;
    m->def.substeps = 4;
    m->def.restitution_threshold = 0.3;
    m->def.wants |= DUET_EFFECT_SHOCKS;
    if (r->table)
        mover_add_floor(m, 100);
    double x = 0.0;
    for (uint32_t i = 0; i < r->n; ++i) {
        x += i == r->struck ? r->way : 0.0;
        add_row_body(m, r, x, i);
        x += 2 * half + (i + 1 >= r->struck ? r->gap : 0.0);
    }
    return m;
}

// The part of the speed that each body has in the end.
static void run_row(const row *r, double parts[MOST])
{
    mover *m = make(r);
    uint32_t first = r->table;
    mover_run(m, (uint32_t)(60 * r->way / r->speed) + 30);
    for (uint32_t i = 0; i < r->n; ++i)
        parts[i] = m->states[first + i].velocity[0] / r->speed;
}

// Runs rows of 3 to 10 that 1 to 3 bodies strike, and returns how far some body is from the speed
// that it should have in the end, in parts of the speed.
static double strike_rows(double from, double to)
{
    rng random = rng_seed(test_seed());
    uint64_t way = 0;
    double worst = 0.0;
    for (uint32_t n = 3; n <= 10; ++n)
        for (uint32_t struck = 1; struck < 4 && struck < n; ++struck)
            for (int kind = 0; kind < 16; ++kind, ++way) {
                row r = {.dims = kind & 1 ? 2 : 3,
                         .n = n,
                         .struck = struck,
                         .speed = rng_between(&random, from, to),
                         .way = rng_between(&random, 0.05, 0.5),
                         .gap = kind & 2 ? 1e-3 : 0.0,
                         .restitution = 1.0f,
                         .boxes = kind & 4,
                         .table = kind & 8};
                double parts[MOST], energy = 0.0;
                if (!test_takes(way, 8))
                    continue;
                run_row(&r, parts);
                for (uint32_t i = 0; i < n; ++i) {
                    energy += parts[i] * parts[i] / struck;
                    worst = fmax(worst, fabs(parts[i] - (i >= n - struck ? 1.0 : 0.0)));
                }
                if (!(fabs(energy - 1.0) < 0.02))
                    fail_msg("%u on %u, kind %d: %g of the energy", struck, n, kind, energy);
            }
    print_message("off by %.2g of the speed at most\n", worst);
    return worst;
}

// As many leave as come, with their speed, and the rest stays: equal balls or boxes that touch, or
// all but. Below 4 slops a step contacts are known before they meet.
TEST(as_many_leave_a_row_as_strike_it)
{
    assert_true(strike_rows(1.05, 1.2) < 0.002);
}

// Faster ones are first seen inside the row, and are pushed out as well.
TEST(fast_ones_go_through_a_row_too)
{
    assert_true(strike_rows(1.2, 6.0) < 0.12);
}

// After a chain of impacts of restitution e the last body has ((1 + e) / 2)^(n - 1) of the speed.
TEST(a_row_that_is_not_elastic_hands_on_its_part)
{
    for (uint32_t n = 3; n <= 8; ++n) {
        row r = {.dims = n % 2 ? 2 : 3,
                 .n = n,
                 .struck = 1,
                 .speed = 6.0,
                 .way = 0.3,
                 .restitution = 0.8f};
        double parts[MOST], sum = 0.0;
        run_row(&r, parts);
        for (uint32_t i = 0; i < n; ++i)
            sum += parts[i];
        assert_close(parts[n - 1], pow(0.9, n - 1), 0.01);
        assert_close(sum, 1.0, 1e-4);
    }
}

// Rows of any masses keep momentum and energy.
TEST(a_row_of_any_masses_keeps_its_energy)
{
    rng random = rng_seed(test_seed());
    for (int round = 0; round < 6; ++round) {
        float masses[MOST];
        for (int i = 0; i < MOST; ++i)
            masses[i] = (float)rng_between(&random, 0.5, 4.0);
        row r = {.dims = round % 2 ? 2 : 3,
                 .n = 3 + (uint32_t)round,
                 .struck = 1,
                 .speed = rng_between(&random, 1.0, 6.0),
                 .way = 0.1,
                 .restitution = 1.0f,
                 .masses = masses};
        mover *m = make(&r);
        m->def.restitution_threshold = 0.05;
        duet_energy before = mover_energy(m);
        mover_run(m, 60);
        duet_energy after = mover_energy(m);
        assert_close(after.momentum[0], before.momentum[0], 1e-4 * before.momentum[0]);
        assert_close(after.kinetic / before.kinetic, 1.0, 0.005);
    }
}

// A ball that falls comes up to e^2 of its height, as without the effect.
TEST(a_ball_bounces_as_high_as_ever)
{
    static const double restitutions[] = {0.3, 0.6, 0.9, 1.0};
    const double g = 9.81, drop = 3.0;
    for (int i = 0; i < 16; ++i) {
        mover *m = mover_new(i % 2 ? 3 : 2);
        uint32_t up = m->def.dims - 1;
        double e = restitutions[i / 4];
        mover_add_floor(m, 5);
        m->def.wants |= DUET_EFFECT_SHOCKS;
        m->def.substeps = i / 2 % 2 ? 4 : 1;
        double h = m->def.dt / m->def.substeps, at[3] = {0};
        at[up] = half + drop;
        uint32_t ball = mover_add(m, at[0], at[1], at[2], 0, 0, 0);
        m->bodies[ball].radius = (float)half;
        m->bodies[ball].restitution = (float)e;
        for (mover_run(m, 1); m->states[ball].velocity[up] <= 0.0;)
            mover_run(m, 1);
        double now = m->states[ball].velocity[up] - 0.5 * g * h;
        double top = m->states[ball].centre[up] - half + now * now / (2 * g);
        if (!(fabs(top - e * e * drop) < 0.5 * g * h * h + 1e-3 * drop))
            fail_msg("%uD, e = %g, h = %g: comes up to %g m, not %g", m->def.dims, e, h, top,
                     e * e * drop);
    }
}

// A ball that slides while it bounces gets 1 + e times its speed times friction along the floor,
// and the turn that belongs to it.
TEST(a_bounce_has_friction)
{
    for (int dims = 2; dims <= 3; ++dims) {
        mover *m = mover_new((uint32_t)dims);
        uint32_t up = m->def.dims - 1, floor = mover_add_floor(m, 50);
        m->def.wants |= DUET_EFFECT_SHOCKS;
        m->def.gravity[up] = 0.0;
        m->def.substeps = 4;
        double at[3] = {0};
        at[up] = half + 0.3;
        uint32_t ball = mover_add(m, at[0], at[1], at[2], 0, 0, 0);
        duet_body *b = &m->bodies[ball];
        b->radius = (float)half;
        b->restitution = 0.5f;
        b->friction = m->bodies[floor].friction = 0.2f;
        b->velocity[0] = 5.0f;
        b->velocity[up] = -4.0f;
        mover_run(m, 20);
        const duet_state *s = &m->states[ball];
        double lost = 0.2 * 1.5 * 4.0, inertia = dims == 3 ? 0.4 : 0.5;
        assert_close(s->velocity[up], 2.0, 1e-3);
        assert_close(s->velocity[0], 5.0 - lost, 1e-3);
        // Levers are those of when the step began, up to half its way too short.
        double turn = fabs(s->angular_velocity[dims == 3 ? 1 : 2]) * inertia * half / lost;
        assert_true(turn < 1.001 && turn > 1.0 - 0.5 * 4.0 * m->def.dt / half);
    }
}

static void add_tumbling(mover *m, rng *r)
{
    for (int i = 0; i < 48; ++i) {
        uint32_t id =
            mover_add(m, 1 + 2 * (i % 4), 1 + 2 * (i / 4 % 4), 1 + 2 * (i / 16), 0.3, 0.4, 0.5);
        mover_turn(m, id, rng_normal(r), rng_normal(r), rng_normal(r), rng_between(r, 0, 3));
        m->bodies[id].restitution = 1.0f;
        for (int k = 0; k < 3; ++k)
            m->bodies[id].velocity[k] = (float)rng_between(r, -2, 2);
    }
}

// Elastic boxes that tumble between walls, 600 steps: none of their energy is made.
TEST(tumbling_boxes_gain_nothing)
{
    rng r = rng_seed(test_seed());
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_SHOCKS;
    mover_wall_in(m, 0, 8.0);
    m->def.restitution_threshold = 0.0;
    add_tumbling(m, &r);
    double before = mover_energy(m).kinetic, most = 0.0, left = 0.0;
    for (int i = 0; i < 20; ++i) {
        mover_run(m, 30);
        duet_energy e = mover_energy(m);
        left = (e.kinetic + e.turning) / before;
        most = fmax(most, left);
    }
    print_message("at most %.4f of the energy, %.4f in the end\n", most, left);
    assert_true(most < 1.03 && left > 0.9);
}

static uint64_t hash_by(const char *variant)
{
    rng r = rng_seed(1);
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_SHOCKS;
    mover_wall_in(m, 0, 8.0);
    strcpy(m->def.plan.variant_b, variant);
    add_tumbling(m, &r);
    mover_run(m, 100);
    return mover_hash(m);
}

// One contact at a time, or eight side by side: the same bits.
TEST(the_bits_are_those_of_any_launch)
{
    uint64_t hash = hash_by("auto");
    assert_true(hash_by("auto solve_shocks.LANES=1 solve_shocks.PER_ITEM=1") == hash);
    assert_true(hash_by("auto solve_shocks.WG=64 solve_shocks.LANES=1 solve_contacts.LANES=1") ==
                hash);
}
