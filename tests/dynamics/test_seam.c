// SPDX-License-Identifier: MIT
// Rounded bodies that glide over flush tiles: as over one long box, whose motion is the truth,
// while steps, ramps and rims stay what they are.
#include "support/mover.h"
#include "support/test.h"

enum { TILES = 60, BALL = 0, ROLLING, CAPSULE_ALONG, CAPSULE_ACROSS, ROUNDED_BOX, SHAPES };

#define LANES_SLOP 0.005

// ------------------------------------------------------------ lanes along x

// What a lane is paved with: unit tiles whose tops lie at its height, in 3D three side by side; or
// one box of that size.
typedef struct {
    double gap, uneven; // most between tiles, and below the lane's height
    bool one_box;
} paving;

// Gravity and contact response, and no objects.
static mover *lanes_new(uint32_t dims)
{
    mover *m = mover_new(dims);
    m->def.slop = LANES_SLOP;
    m->def.gravity[dims - 1] = -9.81;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    return m;
}

static uint32_t lanes_add_fixed(mover *m, const double at[3], const double half[3])
{
    uint32_t id = mover_add_fixed(m, at[0], at[1], at[2], half[0], half[1], half[2]);
    m->bodies[id].friction = 1; // only a rolling ball has some, too
    return id;
}

// Lanes lie side by side, in 2D above each other, this far from the first.
static double lanes_place(int lane)
{
    return 4.0 * lane;
}

static void lanes_add(mover *m, int lane, const paving *p, rng *r)
{
    uint32_t up = m->def.dims - 1;
    int wide = up == 2 && !p->one_box ? 1 : 0, tiles = p->one_box ? 1 : TILES;
    double half[3] = {0.5, 0.5, 0.5}, x = p->one_box ? 0.5 * (TILES - 1) : 0;
    if (p->one_box)
        half[0] = 0.5 * TILES;
    if (p->one_box && up == 2)
        half[1] = 1.5;
    for (int i = 0; i < tiles; ++i, x += 1 + p->gap * rng_between(r, 0, 1))
        for (int j = -wide; j <= wide; ++j) {
            double at[3] = {x, lanes_place(lane) + j, 0};
            at[up] = (up == 1 ? lanes_place(lane) : 0) - 0.5 - p->uneven * rng_between(r, 0, 1);
            lanes_add_fixed(m, at, half);
        }
}

// Puts a body at the begin of a lane; returns its place.
static uint32_t lanes_add_glider(mover *m, int shape, int lane, double speed)
{
    static const double halves[SHAPES][3] = {
        {0, 0, 0}, {0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0.2, 0.3, 0.1}};
    uint32_t up = m->def.dims - 1;
    double radius = shape == ROUNDED_BOX ? 0.05 : 0.25;
    double half[3] = {halves[shape][0], halves[shape][up == 1 ? 2 : 1], halves[shape][2]};
    double at[3] = {0, lanes_place(lane) + 0.1, 0};
    at[up] = (up == 1 ? lanes_place(lane) : 0) + radius + half[up];
    uint32_t id = mover_add(m, at[0], at[1], at[2], half[0], half[1], half[2]);
    m->bodies[id].radius = (float)radius;
    m->bodies[id].velocity[0] = (float)speed;
    if (shape == ROLLING) {
        m->bodies[id].friction = 1;
        m->bodies[id].angular_velocity[up == 2 ? 1 : 2] = (float)(up == 2 ? speed : -speed) * 4;
    }
    return id;
}

static void turn_vector(const double k[3], double angle, double v[3])
{
    double along = k[0] * v[0] + k[1] * v[1] + k[2] * v[2], from[3] = {v[0], v[1], v[2]};
    for (int a = 0; a < 3; ++a) {
        int b = (a + 1) % 3, c = (a + 2) % 3;
        v[a] = from[a] * cos(angle) + (k[b] * from[c] - k[c] * from[b]) * sin(angle) +
               k[a] * along * (1 - cos(angle));
    }
}

static void turn_floats(const double k[3], double angle, float v[3])
{
    double turned[3] = {v[0], v[1], v[2]};
    turn_vector(k, angle, turned);
    for (int a = 0; a < 3; ++a)
        v[a] = (float)turned[a];
}

// Turns the whole scene, and gravity, about the origin.
static void lanes_turn(mover *m, double x, double y, double z, double angle)
{
    double scale = 1 / sqrt(x * x + y * y + z * z), k[3] = {x * scale, y * scale, z * scale};
    turn_vector(k, angle, m->def.gravity);
    for (uint32_t id = 0; id < m->n; ++id) {
        turn_floats(k, angle, m->poses[id].centre);
        turn_floats(k, angle, m->bodies[id].velocity);
        turn_floats(k, angle, m->bodies[id].angular_velocity);
        mover_turn(m, id, x, y, z, angle);
    }
}

// ---------------------------------------------------------------- rides

typedef struct {
    double kept;      // the least part of the speed
    double hop, sunk; // furthest above and below the start
} ride;

// Along the direction in which a body begins to move, and against gravity.
static void note_ride(const mover *m, uint32_t id, double speed, ride *r)
{
    const duet_state *s = &m->states[id];
    double along = 0, rise = 0, g = 0;
    for (uint32_t k = 0; k < m->def.dims; ++k) {
        along += s->velocity[k] * m->bodies[id].velocity[k] / speed;
        rise -= (s->centre[k] - m->poses[id].centre[k]) * m->def.gravity[k];
        g += m->def.gravity[k] * m->def.gravity[k];
    }
    r->kept = fmin(r->kept, along / speed);
    r->hop = fmax(r->hop, rise / sqrt(g));
    r->sunk = fmax(r->sunk, -rise / sqrt(g));
}

static void take_rides(mover *m, const uint32_t *ids, uint32_t n, double speed, double way,
                       ride *rides)
{
    uint32_t steps = (uint32_t)(way / speed / m->def.dt), chunk = speed < 4 ? 8 : 2;
    for (uint32_t k = 0; k < n; ++k)
        rides[k] = (ride){1, 0, 0};
    for (uint32_t i = 0; i < steps; i += chunk) {
        mover_run(m, chunk);
        for (uint32_t k = 0; k < n; ++k)
            note_ride(m, ids[k], speed, &rides[k]);
    }
}

// Every shape in a lane of its own.
static mover *new_lanes(uint32_t dims, const paving *p, double speed, uint32_t ids[SHAPES])
{
    rng r = rng_seed(test_seed());
    mover *m = lanes_new(dims);
    for (int k = 0; k < SHAPES; ++k)
        lanes_add(m, k, p, &r);
    for (int k = 0; k < SHAPES; ++k)
        ids[k] = lanes_add_glider(m, k, k, speed);
    return m;
}

static void assert_glide(const ride rides[SHAPES], double speed, double kept, double hop,
                         double sunk)
{
    for (int k = 0; k < SHAPES; ++k)
        if (!(rides[k].kept >= kept && rides[k].hop <= hop && rides[k].sunk <= sunk))
            fail_msg("shape %d at %g m/s keeps %g of its speed, hops %g and sinks %g", k, speed,
                     rides[k].kept, rides[k].hop, rides[k].sunk);
}

static void glide(uint32_t dims, double speed)
{
    uint32_t ids[SHAPES];
    ride rides[SHAPES];
    mover *m = new_lanes(dims, &(paving){0}, speed, ids);
    m->def.skin = speed < 4 ? 0.1 : 0; // the slow ones take long
    take_rides(m, ids, SHAPES, speed, 58, rides);
    assert_glide(rides, speed, 0.98, 0.1 * LANES_SLOP, 0.1 * LANES_SLOP);
}

TEST(nothing_trips_over_a_seam)
{
    static const double speeds[] = {1, 2, 5, 10};
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (int i = 0; i < 4; ++i)
            glide(dims, speeds[i]);
}

TEST(no_direction_is_special)
{
    for (int i = 0; i < 2; ++i) {
        uint32_t ids[SHAPES];
        ride rides[SHAPES];
        mover *m = new_lanes(3, &(paving){0}, 5, ids);
        lanes_turn(m, 1, i ? -2 : 0.3, i ? 0.5 : 0.7, i ? 2.1 : 0.6);
        take_rides(m, ids, SHAPES, 5, 58, rides);
        assert_glide(rides, 5, 0.98, 0.1 * LANES_SLOP, 0.1 * LANES_SLOP);
    }
}

// Spins and heights stay within what the long box does to them.
TEST(tiles_are_as_one_long_box)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        uint32_t ids[SHAPES], others[SHAPES];
        mover *tiles = new_lanes(dims, &(paving){0}, 5, ids);
        mover *box = new_lanes(dims, &(paving){.one_box = true}, 5, others);
        for (int i = 0; i < 60; ++i) {
            mover_run(tiles, 10);
            mover_run(box, 10);
            for (int k = 0; k < SHAPES; ++k) {
                const duet_state *a = &tiles->states[ids[k]], *b = &box->states[others[k]];
                for (uint32_t j = 0; j < 3; ++j) {
                    assert_close(a->velocity[j], b->velocity[j], 0.05);
                    assert_close(a->angular_velocity[j], b->angular_velocity[j], 0.05);
                }
                assert_close(a->centre[dims - 1], b->centre[dims - 1], 0.1 * LANES_SLOP);
            }
        }
    }
}

// Rounded by less than a slop and not at all: cores lie in the tiles.
TEST(sharp_boxes_glide_too)
{
    static const double radii[SHAPES] = {0, 0.001, 0.003, 0.006, 0.02};
    rng r = rng_seed(1);
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (double speed = 2; speed < 11; speed *= 2) {
            uint32_t ids[SHAPES];
            ride rides[SHAPES];
            mover *m = lanes_new(dims);
            for (int k = 0; k < SHAPES; ++k) {
                lanes_add(m, k, &(paving){0}, &r);
                ids[k] = lanes_add_glider(m, ROUNDED_BOX, k, speed);
                m->poses[ids[k]].centre[dims - 1] += (float)(radii[k] - 0.05);
                m->bodies[ids[k]].radius = (float)radii[k];
            }
            take_rides(m, ids, SHAPES, speed, 58, rides);
            assert_glide(rides, speed, 0.98, 0.1 * LANES_SLOP, 0.1 * LANES_SLOP);
        }
}

// Thrown at tiles they glide on, and are stopped by none that the step would have led them into.
TEST(thrown_bodies_glide_on)
{
    for (double speed = 20; speed < 200; speed *= 2) {
        uint32_t ids[SHAPES];
        mover *m = new_lanes(3, &(paving){0}, speed, ids);
        for (int k = 0; k < SHAPES; ++k) {
            m->poses[ids[k]].centre[2] += 1;
            m->bodies[ids[k]].velocity[2] = (float)(-0.2 * speed);
            m->bodies[ids[k]].angular_velocity[1] = 0;
            m->bodies[ids[k]].friction = 0;
        }
        mover_run(m, (uint32_t)(40 / speed / m->def.dt));
        for (int k = 0; k < SHAPES; ++k) {
            assert_close(m->states[ids[k]].velocity[0], speed, 0.01 * speed);
            assert_close(m->states[ids[k]].centre[2], m->poses[ids[k]].centre[2] - 1, LANES_SLOP);
        }
    }
}

// ---------------------------------------------------------------- within a slop, and above
// it

TEST(gaps_and_heights_below_a_slop_are_none)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        uint32_t ids[SHAPES];
        ride rides[SHAPES];
        mover *m = new_lanes(dims, &(paving){.gap = 0.95 * LANES_SLOP}, 5, ids);
        take_rides(m, ids, SHAPES, 5, 55, rides);
        assert_glide(rides, 5, 0.98, LANES_SLOP, LANES_SLOP);
        m = new_lanes(dims, &(paving){.uneven = 0.95 * LANES_SLOP}, 5, ids);
        take_rides(m, ids, SHAPES, 5, 55, rides);
        assert_glide(rides, 5, 0.95, LANES_SLOP, 2 * LANES_SLOP);
    }
}

// Tiles, or one long box, and after them tiles or a box whose top is `rise` higher.
static ride ride_to_step(bool tiles, double rise, double speed)
{
    rng r = rng_seed(1);
    ride found;
    mover *m = lanes_new(3);
    lanes_add(m, 0, &(paving){.one_box = !tiles}, &r);
    uint32_t low = m->n;
    lanes_add(m, 0, &(paving){.one_box = !tiles}, &r);
    for (uint32_t id = low; id < m->n; ++id) {
        m->poses[id].centre[0] += TILES;
        m->poses[id].centre[2] += (float)rise;
    }
    uint32_t ball = lanes_add_glider(m, 0, 0, speed);
    m->poses[ball].centre[0] = TILES - 2;
    take_rides(m, &ball, 1, speed, 8, &found);
    return found;
}

// As after one long box, whose edge a ball meets as any other; and what is as high as its centre is
// a wall.
TEST(steps_stop_and_lift)
{
    assert_close(ride_to_step(true, 0.3, 5).kept, 0, 0.02);
    for (double rise = 2.5 * LANES_SLOP; rise < 0.1; rise *= 2) {
        ride over = ride_to_step(true, rise, 5), truth = ride_to_step(false, rise, 5);
        assert_close(over.kept, truth.kept, 0.01);
        assert_close(over.hop, truth.hop, 0.01 * truth.hop);
        assert_true(over.kept < 0.97 && over.hop > 2 * rise);
    }
    ride over = ride_to_step(true, 0.9 * LANES_SLOP, 5);
    assert_true(over.kept > 0.995 && over.hop < 1.5 * LANES_SLOP);
}

// Up a ramp of tiles, onto a table of tiles: what energy allows, and not more.
TEST(ramps_lift)
{
    const double slope = 0.2, half[3] = {0.5, 0.5, 0.5};
    for (int shape = 0; shape < 2; ++shape) { // one that glides and one that rolls
        rng r = rng_seed(1);
        mover *m = lanes_new(3);
        lanes_add(m, 0, &(paving){0}, &r);
        for (int i = 0; i < 5; ++i) {
            double along = i + 0.5, x = 9.5 + along * cos(slope) + 0.5 * sin(slope);
            double at[3] = {x, 0, along * sin(slope) - 0.5 * cos(slope)};
            mover_turn(m, lanes_add_fixed(m, at, half), 0, 1, 0, -slope);
        }
        for (int i = 0; i < 20; ++i) {
            double at[3] = {9.5 + 5 * cos(slope) + i + 0.5, 0, 5 * sin(slope) - 0.5};
            lanes_add_fixed(m, at, half);
        }
        for (uint32_t id = 3 * TILES; id < m->n; ++id)
            m->bodies[id].friction = 1;
        uint32_t ball = lanes_add_glider(m, shape, 0, 8);
        mover_run(m, 150);
        double rise = 5 * sin(slope), inertia = shape == ROLLING ? 1.4 : 1;
        // an angle in the way takes the part of the velocity that is towards it
        double lost = 1 - cos(slope) * cos(slope);
        double v2 = 64 * (1 - lost) - 2 * 9.81 * rise / inertia;
        assert_close(m->states[ball].centre[2], rise + 0.25, LANES_SLOP);
        assert_close(m->states[ball].velocity[0], sqrt(v2), 0.2);
    }
}

// A capsule across the lane leaves the last tile, and turns over its edge.
TEST(bodies_fall_off_the_last_tile)
{
    rng r = rng_seed(1);
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        mover *m = lanes_new(dims);
        uint32_t ids[SHAPES];
        for (int k = 0; k < SHAPES; ++k)
            lanes_add(m, k, &(paving){0}, &r);
        for (int k = 0; k < SHAPES; ++k) {
            ids[k] = lanes_add_glider(m, k, k, 0.5);
            m->poses[ids[k]].centre[0] = TILES - 0.6f;
        }
        mover_run(m, 90);
        for (int k = 0; k < SHAPES; ++k)
            assert_true(m->states[ids[k]].centre[dims - 1] <
                        m->poses[ids[k]].centre[dims - 1] - 0.3);
    }
}

// ---------------------------------------------------------------- at rest, and everywhere

// Over the corner of four tiles, over seams, and beside them by all that rounding can make of it.
TEST(bodies_rest_on_seams)
{
    static const double beside[] = {0, 1e-7, -1e-7, 1e-5, 3e-4, -3e-4, 1e-3, 4e-3};
    rng r = rng_seed(1);
    mover *m = lanes_new(3);
    m->def.wants |= DUET_EFFECT_SLEEP;
    for (int k = 0; k < SHAPES; ++k)
        lanes_add(m, k, &(paving){0}, &r);
    uint32_t first = m->n;
    for (int k = 0; k < SHAPES; ++k)
        for (int i = 0; i < 16; ++i) {
            uint32_t id = lanes_add_glider(m, k, k, 0);
            m->poses[id].centre[0] = (float)(2.5 + 2 * i + beside[i % 8]);
            m->poses[id].centre[1] =
                (float)(lanes_place(k) + (i < 8 ? 0.5 - beside[7 - i % 8] : 0));
        }
    mover_run(m, 120);
    for (uint32_t id = first; id < m->n; ++id)
        for (uint32_t k = 0; k < 3; ++k)
            assert_close(m->states[id].centre[k], m->poses[id].centre[k],
                         k < 2 ? 1e-3 : LANES_SLOP);
    assert_close(mover_greatest_speed(m), 0, 1e-12); // asleep
}

// From all sides, spinning, thrown from above: nothing falls through, and energy never grows.
static void throw_many(double speed)
{
    rng r = rng_seed(test_seed());
    mover *m = lanes_new(3);
    for (int k = 0; k < 8; ++k)
        for (int i = 0; i < 24; ++i)
            lanes_add_fixed(m, (double[3]){i, k * 1.0, -0.5}, (double[3]){0.5, 0.5, 0.5});
    m->def.boundary = DUET_BOUNDARY_WALLS;
    for (int k = 0; k < 3; ++k) {
        m->def.lower[k] = k < 2 ? -0.5 : -3;
        m->def.upper[k] = k == 0 ? 23.5 : k == 1 ? 7.5 : 20;
    }
    uint32_t first = m->n;
    for (int i = 0; i < 40; ++i) {
        uint32_t id = lanes_add_glider(m, i % SHAPES, 0, 0);
        m->bodies[id].friction = (float)rng_between(&r, 0, 1);
        double reach = 0.7, at[3] = {0.5 + 22 * i / 40.0, rng_between(&r, reach, 7 - reach),
                                     rng_between(&r, 0.8, 3)};
        for (int k = 0; k < 3; ++k) {
            m->poses[id].centre[k] = (float)at[k];
            m->bodies[id].velocity[k] = (float)(speed * rng_normal(&r));
            m->bodies[id].angular_velocity[k] = (float)(4 * rng_normal(&r));
        }
        mover_turn(m, id, rng_normal(&r), rng_normal(&r), 1, rng_between(&r, 0, 3));
    }
    double most = mover_total(m);
    for (int i = 0; i < 40; ++i) {
        mover_run(m, 10);
        for (uint32_t id = first; id < m->n; ++id)
            if (!(m->states[id].centre[2] > 0.04))
                fail_msg("body %u is at a height of %g after step %d", id, m->states[id].centre[2],
                         10 * i);
        assert_true(mover_total(m) < most + 1e-3 * fabs(most));
    }
}

TEST(nothing_falls_through)
{
    throw_many(6);
    throw_many(20);
}

static uint64_t hash_of_ride(uint32_t dims, duet_mode mode, uint32_t share, double skin)
{
    uint32_t ids[SHAPES];
    mover *m = new_lanes(dims, &(paving){.gap = LANES_SLOP, .uneven = LANES_SLOP}, 7, ids);
    m->def.plan.mode = mode;
    m->def.plan.share = share;
    m->def.skin = skin;
    mover_run(m, 120);
    return mover_hash(m);
}

TEST(seams_have_the_same_bits_by_any_plan)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        uint64_t expected = hash_of_ride(dims, DUET_MODE_SHARED, 0, 0);
        assert_true(hash_of_ride(dims, DUET_MODE_OWN, DUET_SHARE_ONE / 2, 0) == expected);
        assert_true(hash_of_ride(dims, DUET_MODE_SLAB, DUET_SHARE_ONE / 3, 0) == expected);
        assert_true(hash_of_ride(dims, DUET_MODE_SHARED, DUET_SHARE_ONE / 4, 0.3) == expected);
    }
}

// ---------------------------------------------------------------- what is no tile

// A sensor that lies flush in the floor carries nothing, and is touched as if there were no floor.
TEST(sensors_are_no_tiles)
{
    rng r = rng_seed(1);
    mover *m = lanes_new(3);
    lanes_add(m, 0, &(paving){0}, &r);
    uint32_t sensors[2];
    for (int k = 0; k < 2; ++k) {
        double at[3] = {k ? TILES : 20.3, k ? 0 : 0.1, -0.5};
        sensors[k] = lanes_add_fixed(m, at, (double[3]){0.5, 0.5, 0.5});
        m->bodies[sensors[k]].sensor = true;
    }
    uint32_t ball = lanes_add_glider(m, 0, 0, 5);
    m->poses[ball].centre[0] = 19;
    bool sensed = false;
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 1);
        for (uint64_t k = 0; k < m->last.n_events; ++k)
            sensed |= m->last.events[k].a == sensors[0] || m->last.events[k].b == sensors[0];
    }
    assert_true(sensed);
    mover_run(m, 460); // past the last tile, over the other sensor, and down
    assert_true(m->states[ball].centre[0] > TILES && m->states[ball].centre[2] < 0);
}
