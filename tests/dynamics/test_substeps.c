// SPDX-License-Identifier: MIT
// Substeps that are left to the motion: what stands with them, and which column decides.
#include "support/figure.h"
#include "support/mover.h"
#include "support/stack.h"
#include "support/test.h"

static duet_substep_info explain(mover *m)
{
    duet_substep_info info;
    mover_run(m, 0);
    assert_true(duet_motion_explain_substeps(m->motion, &info));
    assert_int_equal(info.substeps, duet_motion_get_def(m->motion)->substeps);
    return info;
}

// ---------------------------------------------------------------- what stands

TEST(a_stack_of_50_stands)
{
    stack s = {.dims = 3, .height = 50};
    stack_assert_stands(&s, 20);
}

// Nothing has left its place by a third of its least edge.
static void assert_in_place(const mover *m, double edge)
{
    for (uint32_t i = 1; i < m->n; ++i)
        for (int k = 0; k < 3; ++k)
            if (!(fabs(m->states[i].centre[k] - (double)m->poses[i].centre[k]) < edge / 3))
                fail_msg("with %u substeps body %u of %u is at %g of axis %d, not %g",
                         duet_motion_get_def(m->motion)->substeps, i, m->n, m->states[i].centre[k],
                         k, (double)m->poses[i].centre[k]);
}

TEST(small_cubes_stacked_20_high_stand)
{
    enum { HEIGHT = 20 };
    const double edge = 0.01;
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    for (uint32_t i = 0; i < HEIGHT; ++i)
        m->bodies[mover_add_cube(m, 0, 0, (i + 0.5) * edge, edge)].friction = 0.6f;
    m->def.slop = 0.005 * edge;
    mover_run(m, 300);
    assert_in_place(m, edge);
}

TEST(a_jenga_tower_of_real_size_stands)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    for (uint32_t i = 0; i < 54; ++i) {
        double aside = 0.025 * ((int)(i % 3) - 1), z = 0.015 * (i / 3 + 0.5);
        uint32_t id = i / 3 % 2 ? mover_add(m, aside, 0, z, 0.0125, 0.0375, 0.0075)
                                : mover_add(m, 0, aside, z, 0.0375, 0.0125, 0.0075);
        m->bodies[id].friction = 0.5f;
    }
    m->def.slop = 7.5e-5;
    mover_run(m, 600);
    assert_in_place(m, 0.015);
}

// Planks over an edge: each juts out by 0.9 of what statics allows, and all lean the same way.
TEST(planks_that_jut_out_stand)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 0.5);
    double x = 0.5;
    for (int i = 0; i < 8; ++i) {
        x += 0.9 / (2 * (8 - i));
        m->bodies[mover_add(m, x - 0.5, 0, 0.1 + 0.2 * i, 0.5, 0.5, 0.1)].friction = 0.5f;
    }
    mover_run(m, 300);
    assert_in_place(m, 0.2);
}

// A tower of 20 cubes whose weight presses at `part` of half an edge off the middle of the lowest.
TEST(towers_that_lean_stand)
{
    for (double part = 0.05; part < 0.9; part += 0.2) {
        mover *m = mover_new(3);
        mover_add_floor(m, 5);
        for (uint32_t i = 0; i < 20; ++i)
            m->bodies[mover_add_cube(m, part * i / 20, 0, i + 0.5, 1)].friction = 0.5f;
        mover_run(m, 300);
        assert_in_place(m, 1);
    }
}

// ---------------------------------------------------------------- the rule

// The closed form of docs/notes/effects.md for a column of cubes.
static uint32_t expected(double layers, double edge, double g, double margin, double dt)
{
    double bend = layers * layers * layers * g / edge;
    double kept = fmax(bend / 10.0, 3.0 * layers * g / margin);
    double n = ceil(dt * sqrt(fmin(bend / 0.98, kept)) * 6.0 / (2.0 * acos(-1.0)));
    return (uint32_t)fmax(4.0, fmin(32.0, layers < 2 ? 0.0 : n));
}

TEST(the_number_follows_the_closed_form)
{
    static const double edges[] = {0.01, 0.1, 1.0, 10.0}, gravities[] = {1.6, 9.81};
    static const double steps[] = {1.0 / 240.0, 1.0 / 60.0};
    for (uint32_t i = 0; i < 4 * 4 * 2 * 2; ++i) {
        uint32_t layers = 1 + 15 * (i % 4), dims = 2 + i / 4 % 2;
        double edge = edges[i / 4 % 4], g = gravities[i / 16 % 2], dt = steps[i / 32];
        mover *m = mover_new(dims);
        m->def.dt = dt;
        m->def.slop = 0.005 * edge;
        m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
        int up = (int)(i % dims);
        m->def.gravity[up] = i % 2 ? g : -g; // whichever way is down
        for (uint32_t k = 0; k < layers; ++k) {
            double at[3] = {3, 5, dims == 3 ? 7 : 0};
            at[up] += edge * k;
            mover_add_cube(m, at[0], at[1], at[2], edge);
        }
        duet_substep_info info = explain(m);
        assert_true(info.chosen);
        assert_int_equal(info.layers, layers);
        assert_close(info.edge, edge, 1e-6 * edge);
        assert_int_equal(info.substeps, expected(layers, edge, g, 0.02 * edge, dt));
    }
}

TEST(the_document_lists_what_is_chosen)
{
    static const double heights[] = {10, 20, 50, 80}, edges[] = {10, 1, 0.1, 0.05, 0.01};
    for (int i = 0; i < 5; ++i) {
        char row[64];
        double listed[4];
        snprintf(row, sizeof row, "| %g | # | # | # | # |", edges[i]);
        figures("effects.md", row, 4, listed);
        for (int k = 0; k < 4; ++k)
            assert_int_equal(listed[k],
                             expected(heights[k], edges[i], 9.81, 0.02 * edges[i], 1.0 / 60.0));
    }
}

TEST(a_scene_that_says_its_substeps_keeps_them)
{
    mover *m = mover_new(3);
    m->def.substeps = 3;
    mover_add_floor(m, 5);
    for (uint32_t i = 0; i < 50; ++i)
        mover_add_rough_cube(m, 0, 0, i + 0.5);
    duet_substep_info info = explain(m);
    assert_false(info.chosen);
    assert_int_equal(info.substeps, 3);
}

TEST(what_falls_has_four)
{
    mover *m = mover_new(3);
    mover_add_pile(m, 300);
    assert_int_equal(explain(m).substeps, 4);
}

// Nor do sensors, or boxes without mass.
TEST(what_does_not_stand_is_no_column)
{
    for (int way = 0; way < 3; ++way) {
        mover *m = mover_new(3);
        mover_add_floor(m, 5);
        for (uint32_t i = 0; i < 50; ++i) {
            uint32_t id = mover_add_rough_cube(m, 0, 0, way == 0 ? 1.03 * i + 0.5 : i + 0.5);
            m->bodies[id].sensor = way == 1;
            m->bodies[id].mass = way == 2 ? 0.0f : 1.0f;
        }
        mover_add_rough_cube(m, 3, 0, 0.5); // which falls by gravity
        duet_substep_info info = explain(m);
        assert_int_equal(info.layers, 1);
        assert_int_equal(info.substeps, 4);
    }
}

TEST(spheres_and_turned_boxes_stand_too)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    for (uint32_t i = 0; i < 30; ++i) {
        uint32_t id = mover_add(m, 0, 0, i + 0.5, 0, 0, 0);
        m->bodies[id].radius = 0.5f;
    }
    assert_int_equal(explain(m).layers, 30);
    mover_restart(m);
    for (uint32_t i = 1; i < m->n; ++i) {
        mover_turn(m, i, 0, 0, 1, 0.3 * i);
        m->poses[i].half_extents[0] = m->poses[i].half_extents[1] = m->poses[i].half_extents[2] =
            0.5f;
        m->bodies[i].radius = 0.0f;
    }
    assert_int_equal(explain(m).layers, 30);
}

TEST(a_column_is_seen_in_its_origin_cells)
{
    mover *m = mover_new(3);
    m->def.origin_edge = 1.0f;
    m->def.origin[0] = 1e7;
    mover_add_floor(m, 5);
    for (uint32_t i = 0; i < 50; ++i)
        mover_add_rough_cube(m, 0, 0, i + 0.5);
    assert_int_equal(explain(m).layers, 50);
}

// ---------------------------------------------------------------- against every pair

static bool rests_on(const mover *m, uint32_t upper, uint32_t lower)
{
    const duet_pose *a = &m->poses[upper], *b = &m->poses[lower];
    double gap = (double)a->centre[2] - (double)b->centre[2] -
                 ((double)a->half_extents[2] + (double)b->half_extents[2]);
    bool over = true;
    for (int k = 0; k < 2; ++k)
        over = over && fabs((double)a->centre[k] - (double)b->centre[k]) <
                           (double)a->half_extents[k] + (double)b->half_extents[k];
    return over && fabs(gap) < 0.01;
}

// A brick and all that it bears: the mass, its moment along x, the most bricks on each other.
typedef struct pressing {
    double mass, moment;
    uint32_t layers;
} pressing;

typedef struct span {
    double from, to;
} span;

static span shared(const mover *m, uint32_t i, uint32_t k, int axis)
{
    const duet_pose *a = &m->poses[i], *b = &m->poses[k];
    return (span){fmax((double)a->centre[axis] - (double)a->half_extents[axis],
                       (double)b->centre[axis] - (double)b->half_extents[axis]),
                  fmin((double)a->centre[axis] + (double)a->half_extents[axis],
                       (double)b->centre[axis] + (double)b->half_extents[axis])};
}

// Bodies were added from below, so that each stands on earlier ones; body 0 is the floor, which
// bears all that stands on no other.
static bool bears(const mover *m, uint32_t lower, uint32_t upper)
{
    return lower < upper && rests_on(m, upper, lower);
}

static void press(const mover *m, uint32_t upper, pressing *all)
{
    pressing *up = &all[upper];
    uint32_t n = 0;
    up->mass += m->bodies[upper].mass;
    up->moment += (double)m->bodies[upper].mass * (double)m->poses[upper].centre[0];
    up->layers += 1;
    for (uint32_t i = 0; i < upper; ++i)
        n += bears(m, i, upper);
    for (uint32_t i = 0; i < upper; ++i) {
        if (!bears(m, i, upper))
            continue;
        span s = shared(m, upper, i, 0);
        all[i].mass += up->mass / n;
        all[i].moment += n == 1 ? up->moment : up->mass / n * 0.5 * (s.from + s.to);
        all[i].layers = up->layers > all[i].layers ? up->layers : all[i].layers;
    }
}

// Substeps that the column above brick i asks for, if it leans along x; bricks are 1 high.
static double asked_by_lean(const mover *m, uint32_t i, const pressing *p)
{
    span x = {INFINITY, -INFINITY};
    double across = 0;
    for (uint32_t k = 0; k < i; ++k)
        if (bears(m, k, i)) {
            span s = shared(m, i, k, 0), y = shared(m, i, k, 1);
            x = (span){fmin(x.from, s.from), fmax(x.to, s.to)};
            across = fmax(across, 0.5 * (y.to - y.from));
        }
    double half = 0.5 * (x.to - x.from), off = fabs(p->moment / p->mass - 0.5 * (x.from + x.to));
    if (!(half > off) || off <= 0.1 * half || p->layers < 3)
        return 0;
    double n = p->layers, width = 2.0 * fmin(half - off, across);
    double asked = ceil(sqrt(n * n * n * 9.81 / 0.98) / width / 10.0 / (2.0 * acos(-1.0)));
    return asked <= 64 ? asked : 0;
}

// The most substeps that any column of bricks asks for, by every pair of bricks.
static uint32_t most_asked(const mover *m)
{
    pressing all[MOVER_MOST] = {{0}};
    uint32_t layers[MOVER_MOST];
    double edge[MOVER_MOST], most = 4;
    for (uint32_t i = 1; i < m->n; ++i) {
        double width = 2.0 * fmin(m->poses[i].half_extents[0], m->poses[i].half_extents[1]);
        layers[i] = 1;
        edge[i] = width * width;
        for (uint32_t k = 1; k < i; ++k)
            if (bears(m, k, i)) {
                layers[i] = layers[k] >= layers[i] ? layers[k] + 1 : layers[i];
                edge[i] = fmin(edge[i], edge[k]);
            }
        most = fmax(most, expected(layers[i], edge[i], 9.81, 0.02, 1.0 / 60.0));
    }
    for (uint32_t i = m->n - 1; i > 0; --i) {
        press(m, i, all);
        most = fmax(most, asked_by_lean(m, i, &all[i]));
    }
    return (uint32_t)fmin(most, 32);
}

// Walls of bricks that are laid at random, with gaps.
TEST(the_worst_column_is_that_of_all_pairs)
{
    uint64_t seed = test_seed();
    rng r = rng_seed(seed);
    for (int scene = 0; scene < 20; ++scene) {
        mover *m = mover_new(3);
        mover_add_floor(m, 30);
        m->def.slop = 0.005;
        uint32_t rows = 1 + rng_below(&r, 25);
        for (uint32_t row = 0; row < rows; ++row)
            for (double x = rng_between(&r, 0, 1); x < 10;) {
                double half = rng_between(&r, 0.3, 0.9);
                bool lies = rng_below(&r, 4) > 0;
                if (lies)
                    mover_add(m, x + half - 5, 0, row + 0.5, half, rng_between(&r, 0.4, 0.6), 0.5);
                x += 2 * half + rng_between(&r, 0, 0.2);
            }
        assert_int_equal(explain(m).substeps, most_asked(m));
    }
}

// ---------------------------------------------------------------- commands

TEST(a_def_that_leaves_its_substeps_changes_the_world)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 5);
    for (uint32_t i = 0; i < 50; ++i)
        mover_add_rough_cube(m, 0, 0, i + 0.5);
    uint32_t chosen = explain(m).substeps;
    assert_true(chosen > 4);
    m->def.gravity[2] = -1.0;
    must(duet_motion_set_def(m->motion, &m->def, ERR));
    assert_int_equal(explain(m).substeps, chosen);
    m->def.substeps = chosen + 1;
    must_fail(duet_motion_set_def(m->motion, &m->def, ERR), DUET_STATUS_BAD_ARGUMENT, "");
}
