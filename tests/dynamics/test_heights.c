// SPDX-License-Identifier: MIT
// Bodies on a ground of heights, against closed forms, floors and all triangles in double.
#include "support/field.h"
#include "support/real.h"
#include "support/test.h"
#include "support/trees.h"

// ---------------------------------------------------------------- grounds

static const double tilt = 0.4;

static double slope(double x, double y)
{
    (void)y;
    return -tilt * x;
}

static mover *on_ground(const field *f)
{
    return ground_mover(&f->heights, NULL);
}

// ---------------------------------------------------------------- level

TEST(a_level_ground_holds_as_a_floor)
{
    field *f = field_new(17, 1, ground_flat);
    mover *m = on_ground(f);
    ground_add_falling(m);
    mover_run(m, 300);
    ground_assert_rest(m);
}

TEST(nothing_trips_over_a_seam_of_the_ground)
{
    static const double speeds[] = {1, 2, 5, 10};
    field *f = field_new(65, 1, ground_flat);
    for (int i = 0; i < 4; ++i)
        ground_glide(on_ground(f), speeds[i], i % 2 ? 0 : 0.3);
    ground_glide(on_ground(f), 5, atan2(1, 1)); // along the lines that divide cells
}

// ---------------------------------------------------------------- slopes

// a = g (sin - mu cos) down the slope, from rest; within a substep's gain of speed.
TEST(boxes_slide_down_a_slope_as_the_closed_form_says)
{
    field *f = field_new(97, 0.7, slope);
    double angle = atan(tilt), g = 9.81;
    mover *m = on_ground(f);
    double height = 0.15 / cos(angle);
    for (int k = 0; k < 4; ++k) {
        uint32_t id = ground_add(m, SHARP, -20, -9 + 6 * k);
        m->poses[id].centre[2] = (float)(tilt * 20 + height);
        mover_turn(m, id, 0, 1, 0, angle);
        m->bodies[id].friction = 0.1f * (float)k;
    }
    mover_run(m, 90);
    for (int k = 0; k < 4; ++k) {
        double expected = g * (sin(angle) - 0.1 * k * cos(angle)) * m->last.time;
        const double *v = m->states[k].velocity;
        assert_close(hypot(v[0], v[2]), expected, 0.02 * expected + g * m->def.dt / 4);
        assert_close(atan2(-v[2], v[0]), angle, 0.01);
        const double *x = m->states[k].centre;
        assert_close((x[2] + tilt * x[0]) * cos(angle), 0.15, ground_slop);
    }
}

TEST(balls_roll_down_a_slope_of_the_ground)
{
    field *f = field_new(97, 0.7, slope);
    double angle = atan(tilt);
    mover *m = on_ground(f);
    uint32_t id = ground_add(m, BALL, -20, 0.1);
    m->poses[id].centre[2] = (float)(tilt * 20 + 0.25 / cos(angle));
    m->bodies[id].friction = 1;
    mover_run(m, 120);
    const double *v = m->states[id].velocity;
    assert_close(hypot(v[0], v[2]), 5.0 / 7 * 9.81 * sin(angle) * m->last.time, 0.1);
}

// ---------------------------------------------------------------- bent

TEST(balls_come_to_rest_at_the_lowest_point_of_a_bowl)
{
    field *f = field_new(61, 0.5, ground_bowl); // a place lies at the lowest point
    mover *m = on_ground(f);
    m->def.drag = 0.8;
    for (int k = 0; k < 2; ++k) {
        m->n = 0;
        uint32_t id = ground_add(m, BALL, k ? 6 : -7, k ? 5 : 3);
        m->poses[id].centre[2] = 5;
        m->bodies[id].friction = 0.5f;
        mover_run(m, 1500);
        const double *x = m->states[id].centre;
        assert_close(hypot(x[0], x[1]), 0, 0.02);
        assert_close(x[2], 0.25, ground_slop);
        mover_restart(m);
    }
}

// ---------------------------------------------------------------- all triangles, in double

TEST(balls_are_as_far_from_the_ground_as_from_all_its_triangles)
{
    rng r = ground_drawn = rng_seed(test_seed());
    uint32_t touching = 0;
    for (int round = 0; round < 4; ++round) {
        field *f = field_new(9 + 8 * (uint32_t)round, 1.0 / (1 + round), ground_rough);
        mover *m = mover_new(3);
        m->def.heights = &f->heights;
        while (m->n < 300) {
            double x = rng_between(&r, -3.9, 3.9), y = rng_between(&r, -3.9, 3.9);
            double z = rng_between(&r, -0.6, 1.2);
            if (field_above(f, x, y, z) > 0.05)
                m->bodies[mover_add(m, x, y, z, 0, 0, 0)].radius =
                    (float)rng_between(&r, 0.05, 0.4);
        }
        touching += field_assert_ball_depths(f->triangles, m);
    }
    assert_true(touching > 200);
}

// ---------------------------------------------------------------- nothing falls through

// How deep corners of a body's core, less its radius, are in the ground at most.
static double depth_of_corners(const field *f, const block *core, double radius)
{
    double depth = -INFINITY;
    for (int i = 0; i < 8; ++i) {
        real at[3];
        block_corner(core, i, at);
        const vector p = {(double)at[0], (double)at[1], (double)at[2]};
        double above = field_above(f, p.x, p.y, p.z);
        if (above < 1)
            depth = fmax(depth, radius - copysign(shape_distance(f->triangles, p), above));
    }
    return depth;
}

// How deep places of the grid are in a body at most.
static double depth_of_places(const field *f, const block *core, double radius)
{
    double deepest = -INFINITY;
    for (uint32_t i = 0; i < f->triangles->mesh.n_vertices; ++i) {
        double depth = INFINITY, square = 0;
        real way[3];
        for (int k = 0; k < 3; ++k)
            way[k] = (real)f->triangles->vertices[3 * i + k] - core->centre[k];
        for (int k = 0; k < 3; ++k) {
            double beyond = (double)(fabsl(real_dot(way, core->axis[k])) - core->half[k]);
            depth = fmin(depth, -beyond);
            square += beyond > 0 ? beyond * beyond : 0;
        }
        depth = (square > 0 ? -sqrt(square) : depth) + radius;
        deepest = fmax(deepest, depth);
    }
    return deepest;
}

// Thrown down at up to 60 m/s, among others: no centre falls below the ground, and in the end none
// lies deeper than a margin and a slop: friction holds what jams between two slopes.
TEST(nothing_falls_through)
{
    ground_drawn = rng_seed(test_seed());
    field *f = field_new(65, 0.5, ground_rough);
    mover *m = on_ground(f);
    field_assert_none_falls_through(f, m);
    for (uint32_t id = 0; id < m->n; ++id) {
        const duet_pose pose = mover_pose(m, id);
        const block core = block_of(&pose);
        double radius = (double)m->bodies[id].radius;
        double corners = depth_of_corners(f, &core, radius);
        double places = depth_of_places(f, &core, radius);
        if (!(corners < 5 * ground_slop && places < 5 * ground_slop))
            fail_msg("shape %u lies %g deep by its corners, %g by the ground's", id % GROUND_KINDS,
                     corners, places);
    }
}

// ---------------------------------------------------------------- the same bits

TEST(any_share_and_any_skin_give_the_same_bits)
{
    ground_drawn = rng_seed(3);
    field *f = field_new(65, 0.5, ground_rough);
    ground_assert_same_bits(&f->heights, NULL);
}

// ---------------------------------------------------------------- what is told and kept

TEST(the_ground_is_one_partner_in_events_and_hits)
{
    field *f = field_new(9, 1, slope);
    mover *m = on_ground(f);
    m->def.wants |= DUET_EFFECT_EVENTS;
    m->def.hit_speed = 1;
    uint32_t id = mover_add_cube(m, 0, 0, 1.5, 0.5), begins = 0, hits = 0;
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 1);
        for (uint64_t k = 0; k < m->last.n_events; ++k) {
            assert_int_equal(m->last.events[k].a, id);
            assert_int_equal(m->last.events[k].b, m->n + 6);
            begins += m->last.events[k].begins;
        }
        assert_true(m->last.n_hits <= 1 && m->last.n_stays <= 1);
        hits += m->last.n_hits > 0 && m->last.hits[0].b == m->n + 6;
    }
    assert_true(begins >= 1 && hits >= 1);
}

// Loads into the motion itself, and into one whose ground is another until then.
TEST(a_saved_motion_takes_its_ground_along_bit_for_bit)
{
    ground_drawn = rng_seed(5);
    field *f = field_new(65, 0.5, ground_rough), *other = field_new(9, 1, slope);
    mover *m = ground_throw(on_ground(f), 100), *n = ground_throw(on_ground(other), 3);
    ground_assert_saved(m, n);
    const duet_heights *h = duet_motion_get_def(n->motion)->heights;
    assert_true(h->nx == 65 && h->ny == 65 && h->spacing[1] == 0.5 && h->origin[0] == -16);
    assert_memory_equal(h->heights, f->values, 65 * 65 * sizeof *f->values);
}

// The last replayed step compares the hash.
TEST(a_recording_is_for_the_ground_that_it_was_made_on)
{
    ground_drawn = rng_seed(5);
    field *f = field_new(65, 0.5, ground_rough);
    mover *m = ground_throw(on_ground(f), 1);
    ground_assert_recorded(m);
    f->values[2000] += 0x1p-10f;
    mover *n = ground_throw(on_ground(f), 1);
    must_fail(ground_replay(n, ERR), DUET_STATUS_BAD_INPUT,
              "recorded on a ground; the motion has another");
    f->values[2000] -= 0x1p-10f;
}

// ---------------------------------------------------------------- queries

static duet_ray_hit cast_down(duet_tree *tree, float x, float y)
{
    const duet_ray down = {.origin = {x, y, 9}, .direction = {0, 0, -1}, .t_max = INFINITY};
    return cast_rays(open_ray_query(tree, DUET_QUERY_CLOSEST, false), &down, 1).hits[0];
}

// The id of rays' hits is that of events.
TEST(a_tree_takes_a_motion_with_its_ground_and_without)
{
    field *f = field_new(9, 1, slope);
    mover *m = on_ground(f), *none = mover_new(3);
    none->def.wants |= DUET_EFFECT_CONTACT_RESPONSE;
    mover_add_cube(m, 0, 0, 3, 0.5);
    mover_add_cube(none, 0, 0, 3, 0.5);
    mover_run(m, 1);
    mover_run(none, 1);
    duet_tree *tree = mover_tree(m);
    duet_ray_hit hit = cast_down(tree, 2, 1);
    assert_int_equal(hit.id, m->n + 6);
    assert_close((double)hit.t, 9 + 2 * tilt, 1e-6);
    assert_int_equal(cast_down(tree, 0, 0).id, 0);
    must(duet_tree_set_motion(tree, none->motion, ERR));
    assert_int_equal(cast_down(tree, 2, 1).id, DUET_NO_OBJECT);
}

// ---------------------------------------------------------------- hostile grounds

TEST(grounds_that_no_motion_can_have_are_refused_in_a_line)
{
    field *f = field_new(5, 1, ground_flat);
    mover *m = on_ground(f);
    mover_add_cube(m, 0, 0, 1, 1);
    static const uint32_t sizes[][2] = {
        {0, 0}, {1, 5}, {5, 1}, {UINT32_MAX, UINT32_MAX}, {1u << 16, 1u << 16}, {1u << 25, 3}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        duet_heights h = f->heights;
        h.nx = sizes[i][0];
        h.ny = sizes[i][1];
        ground_assert_refused(m, &h, NULL, "heights; expected 2 or more along each axis");
    }
    static const double spacings[] = {0, -1, NAN, INFINITY, 1e-30};
    for (size_t i = 0; i < sizeof spacings / sizeof *spacings; ++i) {
        duet_heights h = f->heights;
        h.spacing[1] = spacings[i];
        ground_assert_refused(m, &h, NULL, "the ground's spacing along y");
        h = f->heights;
        h.origin[0] = i < 2 ? NAN : INFINITY;
        ground_assert_refused(m, &h, NULL, "x of the ground's origin");
    }
    f->values[7] = NAN;
    ground_assert_refused(m, &f->heights, NULL, "height 2, 1 of the ground is nan");
    f->values[7] = -INFINITY;
    ground_assert_refused(m, &f->heights, NULL, "height 2, 1 of the ground is -inf");
    duet_heights none = f->heights;
    none.heights = NULL;
    ground_assert_refused(m, &none, NULL, "the ground's heights are NULL");
    m->def.dims = 2;
    ground_assert_refused(m, &f->heights, NULL, "heights and meshes are for motions in 3D");
}
