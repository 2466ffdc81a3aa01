// SPDX-License-Identifier: MIT
// Bodies on a ground of triangles, against heights, boxes, closed forms and all triangles in
// double.
#include "support/field.h"
#include "support/real.h"
#include "support/test.h"
#include "support/trees.h"

// ---------------------------------------------------------------- meshes

// Each triangle with corners of its own, in any order, from any corner on: as a file has them.
static shape *loosened(const shape *s, rng *r)
{
    shape *loose = shape_new();
    loose->mesh.material = s->mesh.material;
    memcpy(loose->mesh.origin, s->mesh.origin, sizeof s->mesh.origin);
    uint32_t *order = test_alloc(s->mesh.n_triangles * sizeof *order);
    for (uint32_t i = 0; i < s->mesh.n_triangles; ++i)
        order[i] = i;
    for (uint32_t i = s->mesh.n_triangles; i > 1; --i) {
        uint32_t k = (uint32_t)rng_below(r, i), kept = order[k];
        order[k] = order[i - 1];
        order[i - 1] = kept;
    }
    for (uint32_t i = 0; i < s->mesh.n_triangles; ++i) {
        uint32_t turn = (uint32_t)rng_below(r, 3), own[3];
        for (uint32_t k = 0; k < 3; ++k) {
            const float *v = s->vertices + 3 * s->triangles[3 * order[i] + (k + turn) % 3];
            own[k] = shape_vertex(loose, (double)v[0], (double)v[1], (double)v[2]);
        }
        shape_triangle(loose, own[0], own[1], own[2]);
    }
    return loose;
}

static mover *on_mesh(const shape *s)
{
    return ground_mover(NULL, s ? &s->mesh : NULL);
}

// ---------------------------------------------------------------- level

// Triangles at random over a square: each is divided by a place within it, again and again.
static void divide(shape *s, rng *r, uint32_t a, uint32_t b, uint32_t c, int depth)
{
    if (depth == 0) {
        shape_triangle(s, a, b, c);
        return;
    }
    double u = rng_between(r, 0.2, 0.6), v = rng_between(r, 0.2, 0.9 - u), at[2];
    for (int k = 0; k < 2; ++k)
        at[k] = u * (double)s->vertices[3 * a + k] + v * (double)s->vertices[3 * b + k] +
                (1 - u - v) * (double)s->vertices[3 * c + k];
    uint32_t d = shape_vertex(s, at[0], at[1], 0);
    divide(s, r, a, b, d, depth - 1);
    divide(s, r, b, c, d, depth - 1);
    divide(s, r, c, a, d, depth - 1);
}

static shape *random_floor(rng *r, double half, uint32_t cells, int depth)
{
    shape *s = shape_new();
    shape_grid(s, cells + 1, 2 * half / cells, ground_flat);
    uint32_t n = s->mesh.n_triangles;
    uint32_t *old = test_alloc(3 * n * sizeof *old);
    memcpy(old, s->triangles, 3 * n * sizeof *old);
    s->mesh.n_triangles = 0;
    for (uint32_t i = 0; i < n; ++i)
        divide(s, r, old[3 * i], old[3 * i + 1], old[3 * i + 2], depth);
    return s;
}

// One big box under the same bodies is the truth.
TEST(a_level_mesh_of_any_triangles_holds_as_a_box)
{
    rng r = rng_seed(test_seed());
    shape *s = random_floor(&r, 10, 6, 3), *loose = loosened(s, &r);
    for (int k = 0; k < 3; ++k) {
        mover *m = on_mesh(k == 0 ? s : k == 1 ? loose : NULL);
        ground_add_falling(m);
        if (k == 2)
            mover_add_fixed(m, 0, 0, -1, 10, 10, 1);
        mover_run(m, 300);
        ground_assert_rest(m);
        mover_free(m);
    }
}

static void glide(const shape *s, double speed, double direction)
{
    mover *m = on_mesh(s);
    ground_glide(m, speed, direction);
    mover_free(m);
}

TEST(nothing_trips_over_a_seam_of_a_mesh)
{
    static const double speeds[] = {1, 2, 5, 10};
    rng r = rng_seed(test_seed());
    shape *s = random_floor(&r, 32, 32, 1), *loose = loosened(s, &r);
    for (int i = 0; i < 4; ++i)
        glide(i % 2 ? s : loose, speeds[i], i % 2 ? 0 : 0.3);
    glide(loose, 5, atan2(1, 1)); // along the lines that divide cells
}

// ---------------------------------------------------------------- beside heights

// The contact of a body with that direction; NULL: none.
static const duet_contact *same_contact(const duet_contact *list, uint64_t n,
                                        const duet_contact *of)
{
    for (uint64_t i = 0; i < n; ++i) {
        const float *p = list[i].normal, *q = of->normal;
        double along =
            (double)p[0] * (double)q[0] + (double)p[1] * (double)q[1] + (double)p[2] * (double)q[2];
        if (list[i].a == of->a && list[i].b == of->b && along > 1 - 1e-5)
            return &list[i];
    }
    return NULL;
}

// Contacts of fewer than four directions: of more some are left out, and which depends on the
// order.
static uint32_t count_of(const duet_contact *list, uint64_t n, uint32_t id, uint32_t ground)
{
    uint32_t count = 0;
    for (uint64_t i = 0; i < n; ++i)
        count += list[i].a == id && list[i].b == ground;
    return count;
}

static uint32_t compare_contacts(mover *m, mover *truth)
{
    uint64_t n, n_expected;
    uint32_t compared = 0;
    mover_run(m, 1);
    mover_run(truth, 1);
    const duet_contact *contacts = mover_contacts(m, &n),
                       *expected = mover_contacts(truth, &n_expected);
    for (uint64_t i = 0; i < n_expected; ++i) {
        const duet_contact *e = &expected[i];
        if (e->b != m->n + 6)
            continue;
        // Below the ground what divides it between triangles is another.
        if (!(ground_least_of(e) >= 0 && ground_least_of(e) < 2 * ground_slop))
            continue;
        if (count_of(expected, n_expected, e->a, e->b) > 3 || count_of(contacts, n, e->a, e->b) > 3)
            continue;
        const duet_contact *c = same_contact(contacts, n, e);
        if (!c)
            fail_msg("body %u has no contact along %g %g %g, %g deep", e->a, (double)e->normal[0],
                     (double)e->normal[1], (double)e->normal[2], -ground_least_of(e));
        // Which of many points are kept, and which of two directions within 0.6 degrees, depends on
        // the order.
        double bound = e->a % GROUND_KINDS <= ROLLING_BALL ? 1e-5 : ground_slop / 2;
        if (!(fabs(ground_least_of(c) - ground_least_of(e)) < bound))
            fail_msg("body %u: %g deep by %u points, not %g by %u", e->a, -ground_least_of(c), c->n,
                     -ground_least_of(e), e->n);
        ++compared;
    }
    return compared;
}

// The least height of points of a body's faces above the ground below them, less its radius.
static double least_height(const field *f, const duet_pose *p)
{
    const block b = block_of(p);
    double least = INFINITY;
    for (int i = 0; i < 5 * 5 * 5; ++i) {
        const int along[3] = {i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2};
        real at[3] = {b.centre[0], b.centre[1], b.centre[2]};
        for (int a = 0; a < 3; ++a)
            for (int k = 0; k < 3; ++k)
                at[k] += 0.5L * along[a] * b.half[a] * b.axis[a][k];
        least = fmin(least, field_above(f, (double)at[0], (double)at[1], (double)at[2]));
    }
    return least;
}

// Bodies at random that touch the ground or are just above it.
static void place_at_random(mover *m, const field *f, uint64_t seed)
{
    rng r = rng_seed(seed);
    while (m->n < 600) {
        uint32_t id = ground_add(m, m->n % GROUND_KINDS, rng_between(&r, -3.2, 3.2),
                                 rng_between(&r, -3.2, 3.2));
        mover_turn(m, id, rng_normal(&r), rng_normal(&r), rng_normal(&r), rng_between(&r, 0, 3));
        m->poses[id].centre[2] = 0;
        double radius = (double)m->bodies[id].radius, sunk = rng_between(&r, 0, 0.01);
        m->poses[id].centre[2] = (float)(radius + sunk - least_height(f, &m->poses[id]));
    }
}

TEST(contacts_are_those_of_heights)
{
    rng r = ground_drawn = rng_seed(test_seed());
    double (*const grounds[])(double, double) = {ground_flat, ground_bowl};
    for (int i = 0; i < 2; ++i) {
        field *f = field_new(17, 0.5, grounds[i]);
        shape *loose = loosened(f->triangles, &r);
        mover *m = on_mesh(loose), *truth = on_mesh(NULL);
        truth->def.heights = &f->heights;
        truth->def.wants = m->def.wants = DUET_EFFECT_CONTACT | DUET_EFFECT_RADIUS;
        place_at_random(m, f, test_seed());
        place_at_random(truth, f, test_seed());
        assert_true(compare_contacts(m, truth) > 50);
        mover_free(m);
        mover_free(truth);
    }
}

// ---------------------------------------------------------------- all triangles, in double

// A star about a place: a ball whose places are pulled and pushed along its radii.
static void add_star(shape *s, rng *r, vector at, double radius, uint32_t n)
{
    uint32_t first = s->mesh.n_vertices;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i < (j % n ? 2 * n : 1); ++i) {
            double up = acos(-1.0) * j / n, about = acos(-1.0) * i / n;
            double far = radius * rng_between(r, 0.7, 1.3);
            shape_vertex(s, at.x + far * sin(up) * cos(about), at.y + far * sin(up) * sin(about),
                         at.z - far * cos(up));
        }
    for (uint32_t i = 0; i < 2 * n; ++i) {
        uint32_t next = (i + 1) % (2 * n), last = s->mesh.n_vertices - 1, row = first + 1;
        shape_triangle(s, first, row + next, row + i);
        for (uint32_t j = 1; j + 1 < n; ++j, row += 2 * n)
            shape_quad(s, row + i, row + next, row + 2 * n + next, row + 2 * n + i);
        shape_triangle(s, row + i, row + next, last);
    }
}

// Balls outside of stars, whose triangles look in all directions.
TEST(balls_are_as_far_from_a_mesh_as_from_all_its_triangles)
{
    rng r = rng_seed(test_seed());
    uint32_t touching = 0;
    for (int round = 0; round < 4; ++round) {
        shape *star = shape_new();
        for (int i = 0; i < 3; ++i)
            add_star(star, &r, (vector){2.8 * i - 2.8, 0, 0.5}, 1, 4 + 4 * (uint32_t)round);
        shape *loose = loosened(star, &r);
        mover *m = on_mesh(round % 2 ? star : loose);
        m->def.gravity[2] = 0;
        m->def.doubles = round == 3;
        while (m->n < 1000) {
            vector at = {rng_between(&r, -4.7, 4.7), rng_between(&r, -1.8, 1.8),
                         rng_between(&r, -1.3, 2.3)};
            double middle = 2.8 * fmax(-1, fmin(1, rint(at.x / 2.8)));
            if (hypot(hypot(at.x - middle, at.y), at.z - 0.5) < 1.31) // it may be within a star
                continue;
            uint32_t id = mover_add(m, at.x, at.y, at.z, 0, 0, 0);
            m->bodies[id].radius = (float)rng_between(&r, 0.05, 0.4);
        }
        touching += field_assert_ball_depths(star, m);
        mover_free(m);
    }
    assert_true(touching > 200);
}

// ---------------------------------------------------------------- solids

static void add_cuboid(shape *s, vector at, vector half)
{
    static const uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                          {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                          {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    uint32_t first = s->mesh.n_vertices;
    for (int i = 0; i < 8; ++i)
        shape_vertex(s, at.x + (i & 1 ? half.x : -half.x), at.y + (i & 2 ? half.y : -half.y),
                     at.z + (i & 4 ? half.z : -half.z));
    for (int i = 0; i < 12; ++i)
        shape_triangle(s, first + faces[i][0], first + faces[i][1], first + faces[i][2]);
}

// Planks over the edges of a step, balls that roll against it and over its rim: a mesh holds, stops
// and lets fall what two boxes do.
TEST(a_step_of_triangles_is_one_of_boxes)
{
    shape *s = shape_new();
    add_cuboid(s, (vector){0, 0, -1}, (vector){9, 9, 1});
    add_cuboid(s, (vector){0, 0, 0.25}, (vector){2, 2, 0.25});
    duet_state states[2][16];
    for (int k = 0; k < 2; ++k) {
        mover *m = on_mesh(k == 0 ? s : NULL);
        for (int i = 0; i < 4; ++i) { // planks: two hold on the step, two tip over its edge
            mover_add(m, i % 2 ? 1.8 : -2.3, i < 2 ? -1 : 1, 0.6, 0.8, 0.3, 0.1);
        }
        for (int i = 0; i < 4; ++i) { // balls: two against the step, two over its edge
            uint32_t id =
                mover_add(m, i % 2 ? 4 : 0, i < 2 ? -0.4 : 0.4, i % 2 ? 0.3 : 0.8, 0, 0, 0);
            m->bodies[id].radius = 0.3f;
            m->bodies[id].velocity[0] = i % 2 ? -2 : 2;
        }
        uint32_t n = m->n;
        if (k == 1) {
            mover_add(m, 0, 0, -1, 9, 9, 1);
            mover_add(m, 0, 0, 0.25, 2, 2, 0.25);
        }
        for (uint32_t id = 0; id < m->n; ++id)
            m->bodies[id].friction = 0.5f; // with the mesh bodies have their own
        for (uint32_t id = n; id < m->n; ++id)
            m->bodies[id].mass = 0;
        mover_run(m, 150);
        memcpy(states[k], m->states, n * sizeof *m->states);
        mover_free(m);
    }
    for (int id = 0; id < 8; ++id)
        for (int k = 0; k < 3; ++k)
            if (!(fabs(states[0][id].centre[k] - states[1][id].centre[k]) < 0.02))
                fail_msg("body %d: %c is %g, not %g", id, "xyz"[k], states[0][id].centre[k],
                         states[1][id].centre[k]);
}

// ---------------------------------------------------------------- nothing falls through

// Thrown down at up to 60 m/s, among others: no centre falls below a ground that is one triangle
// thick.
TEST(nothing_falls_through_a_mesh)
{
    ground_drawn = rng_seed(test_seed());
    field *f = field_new(65, 0.5, ground_rough);
    field_assert_none_falls_through(f, on_mesh(f->triangles));
}

// A box of triangles that look inward: nothing leaves it.
TEST(a_hollow_holds_what_is_in_it)
{
    rng r = rng_seed(test_seed());
    shape *s = shape_new();
    add_cuboid(s, (vector){0, 0, 0}, (vector){3, 3, 3});
    for (uint32_t i = 0; i < s->mesh.n_triangles; ++i) {
        uint32_t *t = s->triangles + 3 * i, kept = t[1];
        t[1] = t[2];
        t[2] = kept;
    }
    mover *m = on_mesh(s);
    for (int k = 0; k < 60; ++k) {
        ground_add_thrown(m, &r, k % GROUND_KINDS);
        for (int axis = 0; axis < 3; ++axis)
            m->poses[k].centre[axis] = (float)rng_between(&r, -2.4, 2.4);
    }
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 5);
        mover_assert_finite(m);
        for (uint32_t id = 0; id < m->n; ++id)
            for (int axis = 0; axis < 3; ++axis)
                if (!(fabs(m->states[id].centre[axis]) < 3))
                    fail_msg("kind %u has its %c at %g after %d steps", id % GROUND_KINDS,
                             "xyz"[axis], m -> states[id].centre[axis], 5 * (i + 1));
    }
}

static void add_plates(mover *m, int n, double half, double mass, double speed)
{
    for (int i = 0; i < n; ++i) {
        uint32_t id = mover_add(m, 0, 0, 0.201 + 0.21 * i, half, half, 0.1);
        m->bodies[id].mass = (float)mass;
        m->bodies[id].velocity[2] = (float)-speed;
        m->bodies[id].friction = 0.5f;
    }
}

static uint32_t add_light_ball(mover *m, double x, double y)
{
    uint32_t id = mover_add(m, x, y, 0.05, 0, 0, 0);
    m->bodies[id].radius = 0.05f;
    m->bodies[id].mass = 0.01f;
    m->bodies[id].friction = 0.5f;
    return id;
}

// Plates fall on balls and press them into the floor, by their radius in a step, and deeper than
// their centres.
TEST(what_is_pressed_into_a_mesh_stays_on_it)
{
    static const struct {
        int plates;
        double mass, speed;
    } cases[] = {{2, 1, 3}, {1, 3, 3}, {1, 10, 3}, {1, 30, 5}, {2, 3, 9}};
    rng r = rng_seed(test_seed());
    shape *s = shape_new();
    shape_grid(s, 9, 20, ground_flat);
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        mover *m = on_mesh(s);
        for (int i = 0; i < 9; ++i)
            add_light_ball(m, 0.3 * (i % 3 - 1) + rng_between(&r, 0, 0.03),
                           0.3 * (i / 3 - 1) + rng_between(&r, 0, 0.03));
        add_plates(m, cases[c].plates, 0.6, cases[c].mass, cases[c].speed);
        mover_run(m, 120);
        for (uint32_t id = 0; id < m->n; ++id)
            if (!(m->states[id].centre[2] > -0.05))
                fail_msg("plates of %g kg at %g m/s: body %u is at %g %g %g", cases[c].mass,
                         cases[c].speed, id, m->states[id].centre[0], m->states[id].centre[1],
                         m->states[id].centre[2]);
        mover_free(m);
    }
}

// A ridge along y, 0.25 high, on a floor.
static shape *ridge_of(double half_width)
{
    const double across[5] = {-8, -half_width, 0, half_width, 8};
    shape *s = shape_new();
    for (int j = 0; j < 13; ++j)
        for (int i = 0; i < 5; ++i)
            shape_vertex(s, across[i], 0.5 * (j - 6), i == 2 ? 0 : -0.25);
    for (uint32_t a = 0; a < 60; ++a)
        if (a % 5 < 4)
            shape_quad(s, a, a + 1, a + 6, a + 5);
    return s;
}

// Balls that a plate presses on its edge come behind both of its sides at once, and leave by one of
// them.
TEST(what_is_pressed_onto_a_ridge_comes_off_it)
{
    static const double half_widths[] = {0.02, 0.05, 0.1, 0.2}, masses[] = {0.3, 1, 3, 10};
    for (int c = 0; c < 16; ++c) {
        shape *s = ridge_of(half_widths[c % 4]);
        mover *m = on_mesh(s);
        for (int i = 0; i < 9; ++i)
            add_light_ball(m, 0.002 * (i - 4) + 0.001, 0.25 * (i - 4));
        add_plates(m, 1, 1.2, 9 * masses[c / 4], 3);
        m->bodies[9].fixed_rotation = true;
        mover_run(m, 60);
        for (uint32_t id = 0; id < 9; ++id)
            if (!(m->states[id].centre[2] > -0.25))
                fail_msg("a ridge %g wide, %g kg: ball %u is at %g %g %g", 2 * half_widths[c % 4],
                         masses[c / 4], id, m->states[id].centre[0], m->states[id].centre[1],
                         m->states[id].centre[2]);
        mover_free(m);
    }
}

// Bodies of all shapes under plates on rough ground.
TEST(what_is_pressed_into_rough_ground_comes_out)
{
    rng r = ground_drawn = rng_seed(test_seed());
    for (int round = 0; round < 6; ++round) {
        field *f = field_new(65, 0.4, ground_rough);
        mover *m = on_mesh(f->triangles);
        for (uint32_t k = 0; k < 16; ++k) {
            uint32_t id = ground_add(m, k % GROUND_KINDS, 0.6 * (k % 4 - 1.5), 0.6 * (k / 4 - 1.5));
            m->poses[id].centre[2] += 0.5f;
            m->bodies[id].mass = 0.01f;
        }
        add_plates(m, 1 + round % 2, 1.6, pow(10, rng_between(&r, -1, 1)), rng_between(&r, 1, 5));
        for (uint32_t id = 16; id < m->n; ++id)
            m->poses[id].centre[2] += 1.2f;
        mover_run(m, 120);
        for (uint32_t id = 0; id < 16; ++id) {
            const double *c = m->states[id].centre;
            double above = field_above(f, c[0], c[1], c[2]);
            if (!(above > -0.1))
                fail_msg("kind %u is %g below the ground", id % GROUND_KINDS, -above);
        }
        mover_free(m);
    }
}

// A command that puts a body behind the mesh is no press: it falls on from there.
TEST(what_is_put_behind_a_mesh_is_not_brought_back)
{
    shape *s = shape_new();
    shape_grid(s, 9, 1, ground_flat);
    mover *m = on_mesh(s);
    uint32_t id = ground_add(m, BALL, 0.3, 0.2);
    mover_run(m, 30);
    assert_close(m->states[id].centre[2], 0.25, ground_slop);
    duet_pose below = m->poses[id];
    below.centre[2] = -1.5f;
    must(duet_motion_set_poses(m->motion, (duet_body_list){.first = id, .n = 1}, &below, ERR));
    mover_run(m, 60);
    assert_close(m->states[id].centre[2], -1.5 - 9.81 / 2, 0.1);
}

TEST(a_triangle_holds_on_one_side)
{
    shape *s = shape_new();
    shape_grid(s, 9, 1, ground_flat);
    mover *m = on_mesh(s);
    uint32_t above = ground_add(m, BALL, 1.2, 0.3), below = ground_add(m, SHARP, -1.2, 0.3);
    m->poses[below].centre[2] = -1;
    m->bodies[below].velocity[2] = 7;
    mover_run(m, 24); // at its highest point
    assert_close(m->states[above].centre[2], 0.25, ground_slop);
    assert_close(m->states[below].centre[2], -1 + 7 * 0.4 - 9.81 / 2 * 0.16, 0.05);
    mover_run(m, 120);
    assert_close(m->states[below].centre[2], 0.15, 2 * ground_slop);
}

// ---------------------------------------------------------------- the same bits, kept

TEST(any_share_and_any_skin_give_the_same_bits)
{
    ground_drawn = rng_seed(3);
    field *f = field_new(65, 0.5, ground_rough);
    ground_assert_same_bits(NULL, &f->triangles->mesh);
}

// Loads into the motion itself, and into one whose mesh is another until then.
TEST(a_saved_motion_takes_its_mesh_along_bit_for_bit)
{
    ground_drawn = rng_seed(5);
    field *f = field_new(33, 0.5, ground_rough), *other = field_new(9, 1, ground_flat);
    mover *m = ground_throw(on_mesh(f->triangles), 100);
    mover *n = ground_throw(on_mesh(other->triangles), 3);
    ground_assert_saved(m, n);
    const duet_mesh *mesh = duet_motion_get_def(n->motion)->mesh;
    assert_true(mesh->n_vertices == 33 * 33 && mesh->n_triangles == 2 * 32 * 32);
    assert_memory_equal(mesh->triangles, f->triangles->triangles, 6 * 32 * 32 * sizeof(uint32_t));
}

TEST(heights_load_no_mesh_nor_the_reverse)
{
    field *f = field_new(9, 1, ground_flat);
    mover *m = ground_throw(on_mesh(f->triangles), 0), *n = ground_throw(on_mesh(NULL), 0);
    n->def.heights = &f->heights;
    mover_run(m, 1);
    mover_run(n, 1);
    must(duet_motion_save(m->motion, "saved", ERR));
    must_fail(duet_motion_load(n->motion, "saved", ERR), DUET_STATUS_BAD_INPUT,
              "meshes: 1 in the file, 0 in the motion");
    must(duet_motion_save(n->motion, "saved", ERR));
    must_fail(duet_motion_load(m->motion, "saved", ERR), DUET_STATUS_BAD_INPUT,
              "meshes: 0 in the file, 1 in the motion");
}

TEST(a_recording_is_for_the_mesh_that_it_was_made_on)
{
    ground_drawn = rng_seed(5);
    field *f = field_new(33, 0.5, ground_rough);
    mover *m = ground_throw(on_mesh(f->triangles), 1);
    ground_assert_recorded(m);
    f->triangles->vertices[3 * 500 + 2] += 0x1p-10f;
    mover *n = ground_throw(on_mesh(f->triangles), 1);
    must_fail(ground_replay(n, ERR), DUET_STATUS_BAD_INPUT,
              "recorded on a ground; the motion has another");
}

TEST(a_tree_takes_a_motion_with_its_mesh_and_without)
{
    shape *s = shape_new();
    shape_grid(s, 3, 8, ground_flat);
    s->mesh.origin[2] = -2;
    mover *m = on_mesh(s), *none = on_mesh(NULL);
    mover_add_cube(m, 0, 0, 3, 0.5);
    mover_add_cube(none, 0, 0, 3, 0.5);
    mover_run(m, 1);
    mover_run(none, 1);
    duet_tree *tree = mover_tree(m);
    duet_point_query *query = open_point_query(tree, 2);
    const duet_point at = {{0, 0, 1}};
    duet_point_query_result found = seek_points(query, &at, 1);
    assert_int_equal(found.hits[1].id, m->n + 6);
    assert_close((double)found.hits[1].distance, 3, 0);
    must(duet_tree_set_motion(tree, none->motion, ERR));
    found = seek_points(query, &at, 1);
    assert_int_equal(found.hits[1].id, DUET_NO_OBJECT);
}

TEST(a_mesh_is_one_partner_and_may_have_a_material)
{
    shape *s = shape_new();
    shape_grid(s, 9, 1, ground_flat);
    s->mesh.material = 1;
    mover *m = on_mesh(s);
    m->def.wants |= DUET_EFFECT_EVENTS;
    m->def.n_materials = 1;
    m->def.materials[1] = (duet_material){.friction = 1, .restitution = 0};
    uint32_t id = ground_add(m, SHARP, 0.3, 0.2), begins = 0;
    m->bodies[id].velocity[0] = 1;
    m->bodies[id].friction = 1;
    m->poses[id].centre[2] += 0.1f;
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 1);
        for (uint64_t k = 0; k < m->last.n_events; ++k) {
            assert_int_equal(m->last.events[k].b, m->n + 6);
            begins += m->last.events[k].begins;
        }
    }
    assert_int_equal(begins, 1);
    assert_true(mover_speed(m, id) < 0.01);
}

// ---------------------------------------------------------------- hostile meshes

TEST(meshes_that_no_motion_can_have_are_refused_in_a_line)
{
    shape *s = shape_new();
    field *f = field_new(3, 1, ground_flat);
    shape_grid(s, 3, 1, ground_flat);
    mover *m = on_mesh(s);
    mover_add_cube(m, 0, 0, 1, 1);
    const duet_mesh right = s->mesh;
    static const uint32_t counts[][2] = {{9, 0}, {9, UINT32_MAX}, {UINT32_MAX, 8}};
    for (int i = 0; i < 3; ++i) {
        s->mesh.n_vertices = counts[i][0];
        s->mesh.n_triangles = counts[i][1];
        ground_assert_refused(m, m->def.heights, &s->mesh,
                              "triangles; expected 1 to 16777216 triangles");
        s->mesh = right;
    }
    s->mesh.vertices = NULL;
    ground_assert_refused(m, m->def.heights, &s->mesh, "the mesh's vertices are NULL");
    s->mesh = right;
    s->mesh.origin[1] = NAN;
    ground_assert_refused(m, m->def.heights, &s->mesh, "y of the mesh's origin is nan");
    s->mesh = right;
    static const float wrong[] = {NAN, INFINITY, 2e12f};
    for (int i = 0; i < 3; ++i) {
        float kept = s->vertices[7];
        s->vertices[7] = wrong[i];
        ground_assert_refused(
            m, m->def.heights, &s->mesh,
            "vertex 2 of the mesh: a coordinate is not a number from -1e12 to 1e12");
        s->vertices[7] = kept;
    }
    s->triangles[5] = 9;
    ground_assert_refused(m, m->def.heights, &s->mesh,
                          "triangle 1 of the mesh has the vertex 9; expected one of 9 vertices");
    s->triangles[5] = s->triangles[4];
    ground_assert_refused(m, m->def.heights, &s->mesh,
                          "triangle 1 of the mesh: two corners are less than 1e-9 apart");
    s->triangles[3] = 0;
    s->triangles[4] = 1;
    s->triangles[5] = 2;
    ground_assert_refused(m, m->def.heights, &s->mesh,
                          "triangle 1 of the mesh: the corners lie on a line");
    s->triangles[5] = 4;
    m->def.heights = &f->heights;
    ground_assert_refused(m, m->def.heights, &s->mesh, "heights and a mesh; expected one ground");
    m->def.heights = NULL;
    s->mesh.material = 1;
    ground_assert_refused(m, m->def.heights, &s->mesh, "the ground's material is 1");
    s->mesh.material = 0;
    m->def.dims = 2;
    ground_assert_refused(m, m->def.heights, &s->mesh, "heights and meshes are for motions in 3D");
}
