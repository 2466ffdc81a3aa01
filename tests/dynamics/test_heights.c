// SPDX-License-Identifier: MIT
// Bodies on a ground of heights, against closed forms, floors and all triangles in double.
#include "support/ground.h"
#include "support/test.h"
#include "support/trees.h"

// ---------------------------------------------------------------- grounds

typedef struct field {
    duet_heights heights;
    float values[129 * 129];
} field;

// Heights f(x, y) at n x n places about 0.
static void fill(field *f, uint32_t n, double spacing, double (*height)(double x, double y))
{
    double half = (n - 1) * spacing / 2;
    assert_true(n <= 129);
    f->heights = (duet_heights){.nx = n,
                                .ny = n,
                                .origin = {-half, -half, 0},
                                .spacing = {spacing, spacing},
                                .heights = f->values};
    for (uint32_t i = 0; i < n * n; ++i)
        f->values[i] = (float)height(i % n * spacing - half, i / n * spacing - half);
}

static const double tilt = 0.4;

static double slope(double x, double y)
{
    (void)y;
    return -tilt * x;
}

static mover *on_ground(const field *f)
{
    mover *m = ground_mover();
    m->def.heights = &f->heights;
    return m;
}

// ---------------------------------------------------------------- level

TEST(a_level_ground_holds_as_a_floor)
{
    field *f = test_alloc(sizeof *f);
    fill(f, 17, 1, ground_flat);
    mover *m = on_ground(f);
    ground_add_falling(m);
    mover_run(m, 300);
    ground_assert_rest(m);
}

TEST(nothing_trips_over_a_seam_of_the_ground)
{
    static const double speeds[] = {1, 2, 5, 10};
    field *f = test_alloc(sizeof *f);
    fill(f, 65, 1, ground_flat);
    for (int i = 0; i < 4; ++i)
        ground_glide(on_ground(f), speeds[i], i % 2 ? 0 : 0.3);
    ground_glide(on_ground(f), 5, atan2(1, 1)); // along the lines that divide cells
}

// ---------------------------------------------------------------- slopes

// a = g (sin - mu cos) down the slope, from rest; within a substep's gain of speed.
TEST(boxes_slide_down_a_slope_as_the_closed_form_says)
{
    field *f = test_alloc(sizeof *f);
    fill(f, 97, 0.7, slope);
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
    field *f = test_alloc(sizeof *f);
    fill(f, 97, 0.7, slope);
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
    field *f = test_alloc(sizeof *f);
    fill(f, 61, 0.5, ground_bowl); // a place lies at the lowest point
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

static vector place(const field *f, uint32_t i, uint32_t j)
{
    const duet_heights *h = &f->heights;
    return (vector){h->origin[0] + i * h->spacing[0], h->origin[1] + j * h->spacing[1],
                    h->origin[2] + (double)h->heights[j * h->nx + i]};
}

static void triangle_at(const field *f, uint32_t which, vector t[3])
{
    uint32_t cell = which / 2, i = cell % (f->heights.nx - 1), j = cell / (f->heights.nx - 1);
    t[0] = place(f, i, j);
    t[1] = which % 2 ? place(f, i + 1, j + 1) : place(f, i + 1, j);
    t[2] = which % 2 ? place(f, i, j + 1) : place(f, i + 1, j + 1);
}

static uint32_t n_triangles(const field *f)
{
    return 2 * (f->heights.nx - 1) * (f->heights.ny - 1);
}

static double distance_to_ground(const field *f, vector p)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < n_triangles(f); ++i) {
        vector t[3];
        triangle_at(f, i, t);
        least = fmin(least, triangle_distance(p, t));
    }
    return least;
}

// How high a point is above the ground under it; INFINITY beside the grid.
static double above_ground(const field *f, vector p)
{
    const duet_heights *h = &f->heights;
    double x = (p.x - h->origin[0]) / h->spacing[0], y = (p.y - h->origin[1]) / h->spacing[1];
    if (x < 0 || y < 0 || x >= h->nx - 1 || y >= h->ny - 1)
        return INFINITY;
    uint32_t i = (uint32_t)x, j = (uint32_t)y;
    double u = x - i, v = y - j, a = place(f, i, j).z, d = place(f, i + 1, j + 1).z;
    double ground = u >= v ? a + u * (place(f, i + 1, j).z - a) + v * (d - place(f, i + 1, j).z)
                           : a + v * (place(f, i, j + 1).z - a) + u * (d - place(f, i, j + 1).z);
    return p.z - ground;
}

// Contacts end by a slack before the margin.
TEST(balls_are_as_far_from_the_ground_as_from_all_its_triangles)
{
    rng r = ground_drawn = rng_seed(test_seed());
    field *f = test_alloc(sizeof *f);
    double *least = test_alloc(MOVER_MOST * sizeof *least);
    uint32_t touching = 0;
    for (int round = 0; round < 4; ++round) {
        fill(f, 9 + 8 * (uint32_t)round, 1.0 / (1 + round), ground_rough);
        mover *m = mover_new(3);
        m->def.wants = DUET_EFFECT_CONTACT | DUET_EFFECT_RADIUS;
        m->def.slop = 0.02;
        m->def.heights = &f->heights;
        while (m->n < 300) {
            vector p = {rng_between(&r, -3.9, 3.9), rng_between(&r, -3.9, 3.9),
                        rng_between(&r, -0.6, 1.2)};
            if (!(above_ground(f, p) > 0.05))
                continue;
            uint32_t id = mover_add(m, p.x, p.y, p.z, 0, 0, 0);
            m->bodies[id].radius = (float)rng_between(&r, 0.05, 0.4);
        }
        ground_least_separations(m, least);
        for (uint32_t id = 0; id < m->n; ++id) {
            const float *c = m->poses[id].centre;
            double expected =
                distance_to_ground(f, (vector){c[0], c[1], c[2]}) - (double)m->bodies[id].radius;
            touching += least[id] < INFINITY;
            if (expected < 0.0799 || least[id] < INFINITY)
                if (!(fabs(least[id] - expected) < 0x1p-16))
                    fail_msg("round %d, ball %u: %g apart, not %g", round, id, least[id], expected);
        }
    }
    assert_true(touching > 200);
}

// ---------------------------------------------------------------- nothing falls through

// A body's axes, in double.
static void axes_of(const duet_state *s, vector axis[3])
{
    const double *q = s->rotation, x = q[0], y = q[1], z = q[2], w = q[3];
    axis[0] = (vector){1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
    axis[1] = (vector){2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
    axis[2] = (vector){2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
}

static vector corner_of(const mover *m, uint32_t id, int which)
{
    vector axis[3], p = {m->states[id].centre[0], m->states[id].centre[1], m->states[id].centre[2]};
    axes_of(&m->states[id], axis);
    for (int k = 0; k < 3; ++k) {
        double h = (which >> k & 1 ? 1 : -1) * (double)m->poses[id].half_extents[k];
        p = (vector){p.x + h * axis[k].x, p.y + h * axis[k].y, p.z + h * axis[k].z};
    }
    return p;
}

// How deep corners of a body's core, less its radius, are in the ground at most.
static double depth_of_corners(const field *f, const mover *m, uint32_t id)
{
    double depth = -INFINITY, radius = (double)m->bodies[id].radius;
    for (int i = 0; i < 8; ++i) {
        vector p = corner_of(m, id, i);
        double above = above_ground(f, p);
        if (above < 1)
            depth = fmax(depth, radius - copysign(distance_to_ground(f, p), above));
    }
    return depth;
}

// How deep places of the grid are in a body at most.
static double depth_of_places(const field *f, const mover *m, uint32_t id)
{
    vector axis[3], c = {m->states[id].centre[0], m->states[id].centre[1], m->states[id].centre[2]};
    double deepest = -INFINITY;
    axes_of(&m->states[id], axis);
    for (uint32_t i = 0; i < f->heights.nx * f->heights.ny; ++i) {
        vector way = vector_less(place(f, i % f->heights.nx, i / f->heights.nx), c);
        double depth = INFINITY, square = 0;
        for (int k = 0; k < 3; ++k) {
            double beyond = fabs(vector_dot(way, axis[k])) - (double)m->poses[id].half_extents[k];
            depth = fmin(depth, -beyond);
            square += beyond > 0 ? beyond * beyond : 0;
        }
        depth = (square > 0 ? -sqrt(square) : depth) + (double)m->bodies[id].radius;
        deepest = fmax(deepest, depth);
    }
    return deepest;
}

// Thrown down at up to 60 m/s, among others: no centre falls below the ground, and in the end none
// lies deeper than a margin and a slop: friction holds what jams between two slopes.
TEST(nothing_falls_through)
{
    rng r = ground_drawn = rng_seed(test_seed());
    field *f = test_alloc(sizeof *f);
    fill(f, 65, 0.5, ground_rough);
    mover *m = on_ground(f);
    for (int k = 0; k < 120; ++k)
        ground_add_thrown(m, &r, k % GROUND_KINDS);
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 5);
        mover_assert_finite(m);
        for (uint32_t id = 0; id < m->n; ++id) {
            const double *c = m->states[id].centre;
            double above = above_ground(f, (vector){c[0], c[1], c[2]});
            if (!(above > -0.05)) // it may be pushed so deep by what falls on it
                fail_msg("shape %u is %g below the ground after %d steps", id % GROUND_KINDS,
                         -above, 5 * (i + 1));
        }
    }
    for (uint32_t id = 0; id < m->n; ++id) {
        double corners = depth_of_corners(f, m, id), places = depth_of_places(f, m, id);
        if (!(corners < 5 * ground_slop && places < 5 * ground_slop))
            fail_msg("shape %u lies %g deep by its corners, %g by the ground's", id % GROUND_KINDS,
                     corners, places);
    }
}

// ---------------------------------------------------------------- the same bits

TEST(any_share_and_any_skin_give_the_same_bits)
{
    ground_drawn = rng_seed(3);
    field *f = test_alloc(sizeof *f);
    fill(f, 65, 0.5, ground_rough);
    uint64_t expected = ground_hash(on_ground(f), 0, 0, false);
    assert_int_equal(ground_hash(on_ground(f), DUET_SHARE_ONE / 2, 0, false), expected);
    assert_int_equal(ground_hash(on_ground(f), DUET_SHARE_ONE, 0.1, false), expected);
    assert_int_equal(ground_hash(on_ground(f), 0, 0.3, false), expected);
    assert_int_equal(ground_hash(on_ground(f), 0, 0.3, true),
                     ground_hash(on_ground(f), DUET_SHARE_ONE / 3, 0.05, true));
}

// ---------------------------------------------------------------- what is told and kept

TEST(the_ground_is_one_partner_in_events_and_hits)
{
    field *f = test_alloc(sizeof *f);
    fill(f, 9, 1, slope);
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
    field *f = test_alloc(sizeof *f), *other = test_alloc(sizeof *other);
    ground_drawn = rng_seed(5);
    fill(f, 65, 0.5, ground_rough);
    fill(other, 9, 1, slope);
    mover *m = ground_throw(on_ground(f), 100), *n = ground_throw(on_ground(other), 3);
    ground_assert_saved(m, n);
    const duet_heights *h = duet_motion_get_def(n->motion)->heights;
    assert_true(h->nx == 65 && h->ny == 65 && h->spacing[1] == 0.5 && h->origin[0] == -16);
    assert_memory_equal(h->heights, f->values, 65 * 65 * sizeof *f->values);
}

// The last replayed step compares the hash.
TEST(a_recording_is_for_the_ground_that_it_was_made_on)
{
    field *f = test_alloc(sizeof *f);
    ground_drawn = rng_seed(5);
    fill(f, 65, 0.5, ground_rough);
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
    field *f = test_alloc(sizeof *f);
    fill(f, 9, 1, slope);
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

static void refuse(const mover *m, const duet_heights *h, const char *says)
{
    duet_motion_def def = m->def;
    def.heights = h;
    must_fail(duet_motion_create(&def, m->poses, m->bodies, m->n, ERR), DUET_STATUS_BAD_ARGUMENT,
              says);
}

TEST(grounds_that_no_motion_can_have_are_refused_in_a_line)
{
    field *f = test_alloc(sizeof *f);
    fill(f, 5, 1, ground_flat);
    mover *m = on_ground(f);
    mover_add_cube(m, 0, 0, 1, 1);
    static const uint32_t sizes[][2] = {
        {0, 0}, {1, 5}, {5, 1}, {UINT32_MAX, UINT32_MAX}, {1u << 16, 1u << 16}, {1u << 25, 3}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        duet_heights h = f->heights;
        h.nx = sizes[i][0];
        h.ny = sizes[i][1];
        refuse(m, &h, "heights; expected 2 or more along each axis");
    }
    static const double spacings[] = {0, -1, NAN, INFINITY, 1e-30};
    for (size_t i = 0; i < sizeof spacings / sizeof *spacings; ++i) {
        duet_heights h = f->heights;
        h.spacing[1] = spacings[i];
        refuse(m, &h, "the ground's spacing along y");
        h = f->heights;
        h.origin[0] = i < 2 ? NAN : INFINITY;
        refuse(m, &h, "x of the ground's origin");
    }
    f->values[7] = NAN;
    refuse(m, &f->heights, "height 2, 1 of the ground is nan");
    f->values[7] = -INFINITY;
    refuse(m, &f->heights, "height 2, 1 of the ground is -inf");
    duet_heights none = f->heights;
    none.heights = NULL;
    refuse(m, &none, "the ground's heights are NULL");
    m->def.dims = 2;
    refuse(m, &f->heights, "heights and meshes are for motions in 3D");
}

TEST_MAIN(mover_open_pair, mover_close_pair)
