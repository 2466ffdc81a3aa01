// SPDX-License-Identifier: MIT
// Bodies on a ground of heights, against closed forms, floors and all triangles in double.
#include "support/mover.h"
#include "support/test.h"

#include "base/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double slop = 0.005;

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

static double flat(double x, double y)
{
    (void)x;
    (void)y;
    return 0;
}

static const double tilt = 0.4;

static double slope(double x, double y)
{
    (void)y;
    return -tilt * x;
}

static double bowl(double x, double y)
{
    return 0.05 * (x * x + y * y);
}

static rng drawn;

static double rough(double x, double y)
{
    (void)x;
    (void)y;
    return rng_between(&drawn, -0.6, 0.6);
}

static mover *on_ground(const field *f)
{
    mover *m = mover_new(3);
    m->def.gravity[2] = -9.81;
    m->def.slop = slop;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_CONTINUOUS;
    m->def.heights = &f->heights;
    return m;
}

// ---------------------------------------------------------------- shapes

enum { BALL, ROLLING_BALL, CAPSULE_ALONG, CAPSULE_ACROSS, ROUNDED, SHARP, SHAPES };

// A body that touches a level ground at height 0 below x, y.
static uint32_t add_shape(mover *m, int shape, double x, double y)
{
    static const double half[SHAPES][4] = {
        [BALL] = {0, 0, 0, 0.25},
        [ROLLING_BALL] = {0, 0, 0, 0.25},
        [CAPSULE_ALONG] = {0.3, 0, 0, 0.25},
        [CAPSULE_ACROSS] = {0, 0.3, 0, 0.25},
        [ROUNDED] = {0.2, 0.3, 0.1, 0.05},
        [SHARP] = {0.2, 0.3, 0.15, 0},
    };
    const double *h = half[shape];
    uint32_t id = mover_add(m, x, y, h[2] + h[3], h[0], h[1], h[2]);
    m->bodies[id].radius = (float)h[3];
    return id;
}

// ---------------------------------------------------------------- level

TEST(a_level_ground_holds_as_a_floor)
{
    field *f = malloc(sizeof *f);
    fill(f, 17, 1, flat);
    mover *m = on_ground(f);
    for (int k = 0; k < 4 * SHAPES; ++k) {
        uint32_t id = add_shape(m, k % SHAPES, -6 + 2.1 * (k % 6), -6 + 3.3 * (k / 6.0));
        m->poses[id].centre[2] += 0.3f;
        mover_turn(m, id, 0, 0, 1, 0.7 * k);
        m->bodies[id].friction = 0.5f;
    }
    mover_run(m, 300);
    for (uint32_t id = 0; id < m->n; ++id) {
        assert_close(m->states[id].centre[2], (double)m->poses[id].centre[2] - 0.3, slop);
        if (!(mover_speed(m, id) < 0.002))
            fail_msg("shape %u goes at %g m/s", id % SHAPES, mover_speed(m, id));
    }
    free(f);
}

static void glide(field *f, double speed, double direction)
{
    mover *m = on_ground(f);
    double c = cos(direction), s = sin(direction);
    for (int k = 0; k < SHAPES; ++k) {
        double along = -29, across = -5 + 2 * k;
        uint32_t id = add_shape(m, k, c * along - s * across, s * along + c * across);
        mover_turn(m, id, 0, 0, 1, direction);
        m->bodies[id].velocity[0] = (float)(c * speed);
        m->bodies[id].velocity[1] = (float)(s * speed);
        if (k == ROLLING_BALL) {
            m->bodies[id].friction = 1;
            m->bodies[id].angular_velocity[0] = (float)(-s * speed / 0.25);
            m->bodies[id].angular_velocity[1] = (float)(c * speed / 0.25);
        }
    }
    uint32_t steps = (uint32_t)(58 / speed / m->def.dt);
    for (uint32_t i = 0; i < steps; i += 4) {
        mover_run(m, 4);
        for (int k = 0; k < SHAPES; ++k) {
            const duet_state *state = &m->states[k];
            double kept = (c * state->velocity[0] + s * state->velocity[1]) / speed;
            double hop = state->centre[2] - (double)m->poses[k].centre[2];
            if (!(kept >= 0.98 && fabs(hop) <= slop))
                fail_msg("shape %d at %g m/s along %g keeps %g and hops %g after %u steps", k,
                         speed, direction, kept, hop, i);
        }
    }
}

TEST(nothing_trips_over_a_seam_of_the_ground)
{
    static const double speeds[] = {1, 2, 5, 10};
    field *f = malloc(sizeof *f);
    fill(f, 65, 1, flat);
    for (int i = 0; i < 4; ++i)
        glide(f, speeds[i], i % 2 ? 0 : 0.3);
    glide(f, 5, atan2(1, 1)); // along the lines that divide cells
    free(f);
}

// ---------------------------------------------------------------- slopes

// a = g (sin - mu cos) down the slope, from rest; within a substep's gain of speed.
TEST(boxes_slide_down_a_slope_as_the_closed_form_says)
{
    field *f = malloc(sizeof *f);
    fill(f, 97, 0.7, slope);
    double angle = atan(tilt), g = 9.81;
    mover *m = on_ground(f);
    double height = 0.15 / cos(angle);
    for (int k = 0; k < 4; ++k) {
        uint32_t id = add_shape(m, SHARP, -20, -9 + 6 * k);
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
        assert_close((x[2] + tilt * x[0]) * cos(angle), 0.15, slop);
    }
    free(f);
}

TEST(balls_roll_down_a_slope_of_the_ground)
{
    field *f = malloc(sizeof *f);
    fill(f, 97, 0.7, slope);
    double angle = atan(tilt);
    mover *m = on_ground(f);
    uint32_t id = add_shape(m, BALL, -20, 0.1);
    m->poses[id].centre[2] = (float)(tilt * 20 + 0.25 / cos(angle));
    m->bodies[id].friction = 1;
    mover_run(m, 120);
    const double *v = m->states[id].velocity;
    assert_close(hypot(v[0], v[2]), 5.0 / 7 * 9.81 * sin(angle) * m->last.time, 0.1);
    free(f);
}

// ---------------------------------------------------------------- bent

TEST(balls_come_to_rest_at_the_lowest_point_of_a_bowl)
{
    field *f = malloc(sizeof *f);
    fill(f, 61, 0.5, bowl); // a place lies at the lowest point
    mover *m = on_ground(f);
    m->def.drag = 0.8;
    for (int k = 0; k < 2; ++k) {
        m->n = 0;
        uint32_t id = add_shape(m, BALL, k ? 6 : -7, k ? 5 : 3);
        m->poses[id].centre[2] = 5;
        m->bodies[id].friction = 0.5f;
        mover_run(m, 1500);
        const double *x = m->states[id].centre;
        assert_close(hypot(x[0], x[1]), 0, 0.02);
        assert_close(x[2], 0.25, slop);
        mover_restart(m);
    }
    free(f);
}

// ---------------------------------------------------------------- all triangles, in double

typedef struct vector {
    double x, y, z;
} vector;

static vector less(vector a, vector b)
{
    return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static double dot(vector a, vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

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

// The distance from a point to a segment, squared.
static double square_to_edge(vector p, vector a, vector b)
{
    vector along = less(b, a), way = less(p, a);
    double t = fmax(0, fmin(1, dot(way, along) / dot(along, along)));
    vector apart = {way.x - t * along.x, way.y - t * along.y, way.z - t * along.z};
    return dot(apart, apart);
}

// The distance from a point to a triangle, by its plane if the foot lies in it, else by its edges.
static double distance_to(vector p, const vector t[3])
{
    vector u = less(t[1], t[0]), v = less(t[2], t[0]), w = less(p, t[0]);
    double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v);
    double det = uu * vv - uv * uv, a = (vv * wu - uv * wv) / det, b = (uu * wv - uv * wu) / det;
    if (a >= 0 && b >= 0 && a + b <= 1) {
        vector apart = {w.x - a * u.x - b * v.x, w.y - a * u.y - b * v.y, w.z - a * u.z - b * v.z};
        return sqrt(dot(apart, apart));
    }
    return sqrt(fmin(square_to_edge(p, t[0], t[1]),
                     fmin(square_to_edge(p, t[1], t[2]), square_to_edge(p, t[2], t[0]))));
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
        least = fmin(least, distance_to(p, t));
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

// The nearest contact of each ball, from what a step without response says; INFINITY: none.
static void least_separations(mover *m, double *least)
{
    duet_contact *contacts;
    uint64_t n;
    mover_run(m, 1);
    for (uint32_t id = 0; id < m->n; ++id)
        least[id] = INFINITY;
    must(duet_motion_get_contacts(m->motion, &contacts, &n, ERR));
    for (uint64_t i = 0; i < n; ++i)
        for (uint32_t k = 0; contacts[i].b == m->n + 6 && k < contacts[i].n; ++k)
            least[contacts[i].a] =
                fmin(least[contacts[i].a], (double)contacts[i].points[k].separation);
    duet_free(contacts);
}

// Contacts end by a slack before the margin.
TEST(balls_are_as_far_from_the_ground_as_from_all_its_triangles)
{
    rng r = drawn = rng_seed(test_seed());
    field *f = malloc(sizeof *f);
    double *least = malloc(MOVER_MOST * sizeof *least);
    uint32_t touching = 0;
    for (int round = 0; round < 4; ++round) {
        fill(f, 9 + 8 * (uint32_t)round, 1.0 / (1 + round), rough);
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
        least_separations(m, least);
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
    free(least);
    free(f);
}

// ---------------------------------------------------------------- nothing falls through

static void add_thrown(mover *m, rng *r, int shape)
{
    uint32_t id = add_shape(m, shape, rng_between(r, -6, 6), rng_between(r, -6, 6));
    duet_body *b = &m->bodies[id];
    m->poses[id].centre[2] = (float)rng_between(r, 2, 8);
    mover_turn(m, id, rng_normal(r), rng_normal(r), rng_normal(r), rng_between(r, 0, 3));
    b->friction = (float)rng_between(r, 0, 1);
    b->restitution = (float)rng_between(r, 0, 0.5);
    for (int k = 0; k < 3; ++k) {
        b->velocity[k] = (float)(rng_normal(r) * (k == 2 ? 20 : 2));
        b->angular_velocity[k] = (float)(rng_normal(r) * 5);
    }
}

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
        vector way = less(place(f, i % f->heights.nx, i / f->heights.nx), c);
        double depth = INFINITY, square = 0;
        for (int k = 0; k < 3; ++k) {
            double beyond = fabs(dot(way, axis[k])) - (double)m->poses[id].half_extents[k];
            depth = fmin(depth, -beyond);
            square += beyond > 0 ? beyond * beyond : 0;
        }
        depth = (square > 0 ? -sqrt(square) : depth) + (double)m->bodies[id].radius;
        deepest = fmax(deepest, depth);
    }
    return deepest;
}

// Thrown down at up to 60 m/s, among others: no centre falls below the ground, and in the end none
// lies deeper than a margin.
TEST(nothing_falls_through)
{
    rng r = drawn = rng_seed(test_seed());
    field *f = malloc(sizeof *f);
    fill(f, 65, 0.5, rough);
    mover *m = on_ground(f);
    for (int k = 0; k < 120; ++k)
        add_thrown(m, &r, k % SHAPES);
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 5);
        mover_assert_finite(m);
        for (uint32_t id = 0; id < m->n; ++id) {
            const double *c = m->states[id].centre;
            double above = above_ground(f, (vector){c[0], c[1], c[2]});
            if (!(above > -0.05)) // it may be pushed so deep by what falls on it
                fail_msg("shape %u is %g below the ground after %d steps", id % SHAPES, -above,
                         5 * (i + 1));
        }
    }
    for (uint32_t id = 0; id < m->n; ++id) {
        double corners = depth_of_corners(f, m, id), places = depth_of_places(f, m, id);
        if (!(corners < 4 * slop && places < 4 * slop))
            fail_msg("shape %u lies %g deep by its corners, %g by the ground's", id % SHAPES,
                     corners, places);
    }
    free(f);
}

// ---------------------------------------------------------------- the same bits

static uint64_t hash_of(const field *f, uint32_t share, double skin, bool sleeps)
{
    rng r = rng_seed(11);
    mover *m = on_ground(f);
    m->def.plan.share = share;
    m->def.skin = skin;
    m->def.wants |= sleeps ? DUET_EFFECT_SLEEP : 0;
    for (int k = 0; k < 60; ++k)
        add_thrown(m, &r, k % SHAPES);
    mover_run(m, 90);
    return mover_hash(m);
}

TEST(any_share_and_any_skin_give_the_same_bits)
{
    drawn = rng_seed(3);
    field *f = malloc(sizeof *f);
    fill(f, 65, 0.5, rough);
    uint64_t expected = hash_of(f, 0, 0, false);
    assert_int_equal(hash_of(f, DUET_SHARE_ONE / 2, 0, false), expected);
    assert_int_equal(hash_of(f, DUET_SHARE_ONE, 0.1, false), expected);
    assert_int_equal(hash_of(f, 0, 0.3, false), expected);
    assert_int_equal(hash_of(f, 0, 0.3, true), hash_of(f, DUET_SHARE_ONE / 3, 0.05, true));
    free(f);
}

// ---------------------------------------------------------------- what is told and kept

TEST(the_ground_is_one_partner_in_events_and_hits)
{
    field *f = malloc(sizeof *f);
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
    free(f);
}

// Thirty bodies thrown on a ground, which move for `steps`.
static mover *thrown_on(const field *f, int steps)
{
    rng r = rng_seed(5);
    mover *m = on_ground(f);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.skin = 0.1;
    for (int k = 0; k < 30; ++k)
        add_thrown(m, &r, k % SHAPES);
    if (steps > 0)
        mover_run(m, steps);
    return m;
}

// Loads into the motion itself, and into one whose ground is another until then.
TEST(a_saved_motion_takes_its_ground_along_bit_for_bit)
{
    field *f = malloc(sizeof *f), *other = malloc(sizeof *other);
    drawn = rng_seed(5);
    fill(f, 65, 0.5, rough);
    fill(other, 9, 1, slope);
    mover *m = thrown_on(f, 100), *n = thrown_on(other, 3);
    must(duet_motion_save(m->motion, "saved", ERR));
    mover_run(m, 50);
    uint64_t expected = mover_hash(m);
    must(duet_motion_load(m->motion, "saved", ERR));
    mover_run(m, 50);
    assert_int_equal(mover_hash(m), expected);
    must(duet_motion_load(n->motion, "saved", ERR));
    mover_run(n, 50);
    assert_int_equal(mover_hash(n), expected);
    const duet_heights *h = duet_motion_get_def(n->motion)->heights;
    assert_true(h->nx == 65 && h->ny == 65 && h->spacing[1] == 0.5 && h->origin[0] == -16);
    assert_memory_equal(h->heights, f->values, 65 * 65 * sizeof *f->values);
    free(f);
    free(other);
}

static duet_status replay_status(mover *m, const char *says)
{
    duet_error err = {0};
    duet_replay *replay = must(duet_replay_create("recorded", ERR));
    duet_status status = DUET_STATUS_OK;
    for (int i = 0; i < 40 && status == DUET_STATUS_OK; ++i) {
        duet_motion_result result;
        if (!duet_replay_advance(replay, m->motion, &result, &err))
            status = err.status;
    }
    if (says && (!strstr(err.text, says) || strchr(err.text, '\n')))
        fail_msg("'%s' does not say '%s' in a line", err.text, says);
    duet_replay_destroy(replay);
    return status;
}

// The last replayed step compares the hash.
TEST(a_recording_is_for_the_ground_that_it_was_made_on)
{
    field *f = malloc(sizeof *f);
    drawn = rng_seed(5);
    fill(f, 65, 0.5, rough);
    mover *m = thrown_on(f, 1);
    must(duet_motion_save(m->motion, "begin", ERR));
    must(duet_motion_record(m->motion, ERR));
    mover_run(m, 40);
    must(duet_motion_save_recording(m->motion, "recorded", ERR));
    must(duet_motion_load(m->motion, "begin", ERR));
    assert_int_equal(replay_status(m, NULL), DUET_STATUS_OK);
    f->values[2000] += 0x1p-10f;
    mover *n = thrown_on(f, 1);
    assert_int_equal(replay_status(n, "recorded on a ground; the motion has another"),
                     DUET_STATUS_BAD_INPUT);
    f->values[2000] -= 0x1p-10f;
    free(f);
}

// ---------------------------------------------------------------- queries

static duet_ray_hit cast_down(duet_tree *tree, float x, float y)
{
    duet_ray_query_def def = duet_default_ray_query_def();
    duet_ray_query_result found;
    const duet_ray down = {.origin = {x, y, 9}, .direction = {0, 0, -1}, .t_max = INFINITY};
    def.tree = tree;
    duet_ray_query *query = must(duet_ray_query_create(&def, ERR));
    must(duet_ray_query_run(query, &down, 1, &found, ERR));
    duet_ray_hit hit = found.hits[0];
    duet_ray_query_destroy(query);
    return hit;
}

// The id of rays' hits is that of events.
TEST(a_tree_takes_a_motion_with_its_ground_and_without)
{
    field *f = malloc(sizeof *f);
    fill(f, 9, 1, slope);
    mover *m = on_ground(f), *none = mover_new(3);
    none->def.wants |= DUET_EFFECT_CONTACT_RESPONSE;
    mover_add_cube(m, 0, 0, 3, 0.5);
    mover_add_cube(none, 0, 0, 3, 0.5);
    mover_run(m, 1);
    mover_run(none, 1);
    duet_tree_def def = duet_motion_tree_def(m->motion);
    duet_tree *tree = must(duet_tree_create(&def, ERR));
    must(duet_tree_set_motion(tree, m->motion, ERR));
    duet_ray_hit hit = cast_down(tree, 2, 1);
    assert_int_equal(hit.id, m->n + 6);
    assert_close((double)hit.t, 9 + 2 * tilt, 1e-6);
    assert_int_equal(cast_down(tree, 0, 0).id, 0);
    must(duet_tree_set_motion(tree, none->motion, ERR));
    assert_int_equal(cast_down(tree, 2, 1).id, DUET_NO_OBJECT);
    duet_tree_destroy(tree);
    mover_free(m);
    mover_free(none);
    free(f);
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
    field *f = malloc(sizeof *f);
    fill(f, 5, 1, flat);
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
    free(f);
}

TEST_MAIN(mover_open_pair, mover_close_pair)
