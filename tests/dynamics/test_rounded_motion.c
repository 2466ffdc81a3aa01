// SPDX-License-Identifier: MIT
// Spheres, capsules and rounded boxes that move: where they touch, against the reference in
// double, and what they do, against closed forms.
#include "support/mover.h"
#include "support/test.h"

static uint32_t add_round(mover *m, double x, double y, double z, const double half[3],
                          double radius)
{
    uint32_t id = mover_add(m, x, y, z, half[0], half[1], half[2]);
    m->bodies[id].radius = (float)radius;
    return id;
}

static uint32_t add_ball(mover *m, double x, double y, double z, double radius)
{
    return add_round(m, x, y, z, (double[3]){0, 0, 0}, radius);
}

// ---------------------------------------------------------------- where they touch

static duet_rounded_box box_of(const mover *m, uint32_t id)
{
    return (duet_rounded_box){m->poses[id], m->bodies[id].radius};
}

// How far a point is outside of the surface of a body.
static double out_of(const mover *m, uint32_t id, const double point[3])
{
    duet_rounded_box box = box_of(m, id);
    duet_rounded_box at = {.pose.rotation = {0, 0, 0, 1}};
    for (uint32_t k = 0; k < m->def.dims; ++k)
        at.pose.centre[k] = (float)point[k];
    return duet_rounded_boxes_separation(&box, &at, m->def.dims);
}

static void draw_body(mover *m, rng *r)
{
    double half[3] = {0}, at[3] = {0};
    uint32_t dims = m->def.dims, kind = (uint32_t)rng_below(r, 4);
    for (uint32_t k = 0; k < 3; ++k) {
        half[k] = kind > k ? rng_between(r, 0.1, 0.8) : 0.0;
        at[k] = k < dims ? rng_between(r, -1.1, 1.1) : 0.0;
    }
    uint32_t id = add_round(m, at[0], at[1], at[2], half, rng_between(r, 0.1, 0.4));
    bool turned = rng_below(r, 4) > 0; // others have faces and edges along each other
    if (turned && dims == 2)
        mover_turn(m, id, 0, 0, 1, rng_between(r, 0, 6));
    else if (turned) {
        double x = rng_normal(r), y = rng_normal(r);
        mover_turn(m, id, x, y, rng_normal(r), rng_between(r, 0, 3));
    }
}

// A point's anchor lies halfway between the two surfaces, its separation apart along the normal.
static void assert_between(const mover *m, const duet_contact *c, uint32_t p, double bound)
{
    const double separation = c->points[p].separation;
    for (int side = -1; side <= 1; side += 2) {
        double at[3] = {0};
        for (uint32_t k = 0; k < m->def.dims; ++k)
            at[k] = m->poses[c->a].centre[k] + c->points[p].anchor[k] +
                    0.5 * side * separation * c->normal[k];
        double out = out_of(m, side < 0 ? c->a : c->b, at);
        if (!(fabs(out) < bound))
            fail_msg("%u and %u, point %u of %u: %g from the surface of %u", c->a, c->b, p, c->n,
                     out, side < 0 ? c->a : c->b);
    }
}

// The deepest point is as deep as the reference says, but for the lead that faces have. The
// axis of least depth is a choice where cores overlap, and only that they touch is asked.
static void check_contact(const mover *m, const duet_contact *c, double margin)
{
    duet_rounded_box a = box_of(m, c->a), b = box_of(m, c->b);
    double separation = duet_rounded_boxes_separation(&a, &b, m->def.dims);
    uint32_t deepest = 0;
    for (uint32_t p = 1; p < c->n; ++p)
        deepest = c->points[p].separation < c->points[deepest].separation ? p : deepest;
    double least = c->points[deepest].separation;
    double reach = (double)a.radius + b.radius;
    bool cores_overlap = separation < 0.01 - reach;
    if (cores_overlap ? !(least < 0) : !(fabs(least - separation) < margin / 8 + 1e-5))
        fail_msg("%u and %u: separation %g, %g of its %u points", c->a, c->b, separation, least,
                 c->n);
    if (!cores_overlap)
        assert_between(m, c, deepest, 0.02);
}

static void assert_has_contact(const mover *m, const duet_contact *contacts, uint64_t n, uint32_t a,
                               uint32_t b)
{
    duet_rounded_box one = box_of(m, a), other = box_of(m, b);
    double separation = duet_rounded_boxes_separation(&one, &other, m->def.dims);
    bool has = separation >= 0.0;
    for (uint64_t i = 0; i < n; ++i)
        has |= (contacts[i].a == a && contacts[i].b == b) ||
               (contacts[i].a == b && contacts[i].b == a);
    if (!has)
        fail_msg("%u and %u in %uD have no contact, and a separation of %g", a, b, m->def.dims,
                 separation);
}

// Without any response, so that nothing moves.
TEST(points_are_between_the_surfaces)
{
    rng r = rng_seed(test_seed());
    enum { PAIRS = 400 };
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        uint32_t touching = 0, points[5] = {0};
        for (uint32_t i = 0; i < PAIRS / 40; ++i) {
            mover *m = mover_new(dims);
            m->def.wants = DUET_EFFECT_CONTACT;
            m->def.slop = 0.005;
            for (uint32_t k = 0; k < 14; ++k)
                draw_body(m, &r);
            mover_run(m, 1);
            assert_true(duet_motion_get_effects(m->motion) & DUET_EFFECT_RADIUS);
            uint64_t n = 0;
            duet_contact *contacts = mover_contacts(m, &n);
            for (uint64_t c = 0; c < n; ++c) {
                check_contact(m, &contacts[c], 0.02);
                ++points[contacts[c].n];
            }
            for (uint32_t a = 0; a < m->n; ++a)
                for (uint32_t b = 0; b < a; ++b)
                    assert_has_contact(m, contacts, n, a, b);
            touching += (uint32_t)n;
        }
        assert_true(touching > PAIRS / 4 && points[1] > 0 && points[2] > 0);
    }
}

static duet_contact contact_of_two(const double half[3], double radius, const double other[3],
                                   double other_radius, const double apart[3])
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT;
    add_round(m, 0, 0, 0, half, radius);
    add_round(m, apart[0], apart[1], apart[2], other, other_radius);
    mover_run(m, 1);
    uint64_t n = 0;
    const duet_contact *contacts = mover_contacts(m, &n),
                       one = n == 1 ? contacts[0] : (duet_contact){.n = 0};
    return one;
}

TEST(spheres_have_one_point_capsules_two_and_faces_four)
{
    const double ball[3] = {0, 0, 0}, capsule[3] = {1, 0, 0}, box[3] = {1, 1, 0.5};
    assert_int_equal(contact_of_two(ball, 0.5, ball, 0.5, (double[3]){0.7, 0.7, 0}).n, 1);
    assert_int_equal(contact_of_two(ball, 0.5, box, 0.2, (double[3]){0.3, 0, 1.2}).n, 1);
    assert_int_equal(contact_of_two(capsule, 0.5, capsule, 0.5, (double[3]){0.4, 0.6, 0.8}).n, 2);
    assert_int_equal(contact_of_two(capsule, 0.5, capsule, 0.5, (double[3]){2.99, 0, 0}).n, 1);
    assert_int_equal(contact_of_two(capsule, 0.5, box, 0.2, (double[3]){0.3, 0, 1.2}).n, 2);
    assert_int_equal(contact_of_two(box, 0.1, box, 0.2, (double[3]){0.3, 0, 1.3}).n, 4);
    duet_contact c = contact_of_two(ball, 0.5, ball, 0.25, (double[3]){0, 0.45, 0.6});
    assert_close(c.normal[1], 0.6, 1e-6);
    assert_close(c.normal[2], 0.8, 1e-6);
    assert_close(c.points[0].separation, 0.0, 1e-6);
    assert_close(c.points[0].anchor[2], 0.4, 1e-6);
}

// ---------------------------------------------------------------- what they do

static mover *on_a_floor(double friction)
{
    mover *m = mover_new(3);
    uint32_t floor = mover_add_floor(m, 50);
    m->bodies[floor].friction = (float)friction;
    return m;
}

TEST(balls_rest_at_their_radius)
{
    mover *m = on_a_floor(0.5);
    m->def.wants |= DUET_EFFECT_SLEEP;
    uint32_t ball = add_ball(m, 0, 0, 0.6, 0.5);
    uint32_t capsule = add_round(m, 3, 0, 0.5, (double[3]){1, 0, 0}, 0.4);
    uint32_t box = add_round(m, 6, 0, 0.7, (double[3]){0.4, 0.3, 0.2}, 0.2);
    for (uint32_t id = 1; id < m->n; ++id)
        m->bodies[id].friction = 0.5f;
    mover_run(m, 180);
    assert_close(m->states[ball].centre[2], 0.5, 0.006);
    assert_close(m->states[capsule].centre[2], 0.4, 0.006);
    assert_close(m->states[box].centre[2], 0.4, 0.006);
    assert_close(mover_greatest_speed(m), 0.0, 1e-12); // asleep
}

// Without slip a = 5/7 g sin(slope), a capsule or disc by its own inertia.
TEST(balls_roll_down_a_slope)
{
    const double slope = 0.3, g = 9.81;
    mover *m = mover_new(3);
    uint32_t floor = mover_add_floor(m, 50);
    m->bodies[floor].friction = 1.0f;
    m->def.gravity[0] = g * sin(slope);
    m->def.gravity[2] = -g * cos(slope);
    uint32_t ball = add_ball(m, 0, 0, 0.5, 0.5);
    m->bodies[ball].friction = 1.0f;
    mover_run(m, 60);
    double v = m->states[ball].velocity[0], spin = m->states[ball].angular_velocity[1];
    assert_close(v, 5.0 / 7.0 * g * sin(slope), 0.01);
    assert_close(spin * 0.5, v, 0.01);
    assert_close(m->states[ball].centre[2], 0.5, 0.006);
    assert_close(m->states[ball].centre[0], 0.5 * v, 0.03);
}

// That a ball turns far in a step lifts it off nothing: it neither hops nor sinks.
TEST(fast_balls_roll_level)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        mover *m = mover_new(dims);
        uint32_t floor = mover_add_floor(m, 200);
        m->bodies[floor].friction = 1.0f;
        uint32_t ball = add_ball(m, 0, dims == 2 ? 0.5 : 0, 0.5, 0.5);
        m->bodies[ball].friction = 1.0f;
        m->bodies[ball].velocity[0] = 6.0f;
        m->bodies[ball].angular_velocity[dims == 2 ? 2 : 1] = dims == 2 ? -12.0f : 12.0f;
        double before = mover_total(m);
        for (int i = 0; i < 60; ++i) {
            mover_run(m, 2);
            assert_close(m->states[ball].centre[dims - 1], 0.5, 0.006);
            assert_close(m->states[ball].velocity[0], 6.0, 0.01);
        }
        assert_close(mover_total(m) / before, 1.0, 2e-3);
    }
}

TEST(bouncing_balls_come_back_to_their_height)
{
    mover *m = on_a_floor(0);
    uint32_t ball = add_ball(m, 0, 0, 2.5, 0.5);
    m->bodies[ball].restitution = 0.8f;
    m->bodies[0].restitution = 0.8f;
    double highest = 0;
    bool fell = false;
    for (int i = 0; i < 100; ++i) {
        mover_run(m, 1);
        fell = fell || m->states[ball].velocity[2] > 0;
        if (fell)
            highest = fmax(highest, m->states[ball].centre[2] - 0.5);
    }
    assert_close(highest, 0.64 * 2.0, 0.03);
}

// Off centre: the momenta along the line of centres change hands, the others stay.
TEST(elastic_spheres_exchange_momenta)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    uint32_t a = add_ball(m, -2, 0, 0, 0.5), b = add_ball(m, 0, 0.6, 0, 0.5);
    m->bodies[a].restitution = m->bodies[b].restitution = 1.0f;
    m->bodies[a].velocity[0] = 3.0f;
    double before = mover_total(m);
    mover_run(m, 60);
    // centres 1 apart, 0.6 of it aside: the line has the direction 0.8, 0.6
    assert_close(m->states[b].velocity[0], 3 * 0.8 * 0.8, 0.05);
    assert_close(m->states[b].velocity[1], 3 * 0.8 * 0.6, 0.05);
    assert_close(m->states[a].velocity[0] + m->states[b].velocity[0], 3.0, 1e-5);
    assert_close(m->states[a].velocity[1] + m->states[b].velocity[1], 0.0, 1e-5);
    assert_close(mover_total(m) / before, 1.0, 1e-4);
}

// Fast ones are followed on their way: neither past a thin wall nor held where they miss.
TEST(fast_balls_meet_what_is_in_their_way)
{
    for (int misses = 0; misses < 2; ++misses) {
        mover *m = mover_new(3);
        m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
        mover_add_fixed(m, 10, 0, 0, 0.02, 2, 2);
        // past the wall's corner, within its bounds but not within the radius of it
        double aside = misses ? 2 + 0.1 * 0.8 : 0.3;
        uint32_t ball = add_ball(m, 0, aside, aside, 0.1);
        m->bodies[ball].velocity[0] = 900.0f;
        double furthest = -1e30;
        for (int i = 0; i < 6; ++i) {
            mover_run(m, 1);
            furthest = fmax(furthest, m->states[ball].centre[0]);
        }
        assert_true(duet_motion_get_effects(m->motion) & DUET_EFFECT_CONTINUOUS);
        if (misses)
            assert_close(m->states[ball].velocity[0], 900.0, 1e-3);
        else if (!(furthest < 10 && fabs(m->states[ball].velocity[0]) < 900))
            fail_msg("the ball comes to %g", furthest);
    }
}

// Boxes, and capsules across each other.
TEST(round_stacks_stand)
{
    for (int crossed = 0; crossed < 2; ++crossed) {
        mover *m = on_a_floor(0.6);
        const double box[3] = {0.4, 0.4, 0.4}, capsule[3] = {1, 0, 0};
        for (int i = 0; i < 10; ++i) {
            uint32_t id = add_round(m, 0, 0, 0.5 + i, crossed ? capsule : box, crossed ? 0.5 : 0.1);
            m->bodies[id].friction = 0.6f;
            if (crossed && i % 2)
                mover_turn(m, id, 0, 0, 1, 1.5707963);
        }
        mover_run(m, 300);
        assert_close(m->states[10].centre[2], 9.5, 0.03);
        assert_close(m->states[10].centre[0], 0, 0.01);
        assert_true(mover_greatest_speed(m) < 0.005);
    }
}

TEST(piles_come_to_rest)
{
    mover *m = mover_new(3);
    mover_add_pile(m, 40);
    m->def.wants |= DUET_EFFECT_SLEEP;
    for (uint32_t i = 0; i < m->n; ++i) {
        float *h = m->poses[i].half_extents;
        m->bodies[i].radius = i % 3 ? 0.25f : 0.1f;
        if (i % 3)
            h[1] = h[2] = 0; // a capsule
        if (i % 3 == 2)
            h[0] = 0; // a sphere
    }
    double before = mover_total(m);
    for (int i = 0; i < 10; ++i) {
        mover_run(m, 60);
        mover_assert_finite(m);
        if (!(mover_total(m) <= before))
            fail_msg("energy %g after second %d, %g before it", mover_total(m), i, before);
        before = mover_total(m) + 1e-4 * fabs(before);
    }
    for (uint32_t id = 0; id < m->n; ++id)
        for (int k = 0; k < 3; ++k) {
            const double *c = m->states[id].centre;
            assert_true(c[k] > 0.05 && c[k] < (k < 2 ? 5.95 : 40));
        }
    assert_true(mover_greatest_speed(m) < 0.3);
}

// ---------------------------------------------------------------- how they turn

static double turning_energy(uint32_t dims, const double half[3], double radius, int axis)
{
    mover *m = mover_new(dims);
    uint32_t id = add_round(m, 0, 0, 0, half, radius);
    m->bodies[id].mass = 3.0f;
    m->bodies[id].angular_velocity[axis] = 2.0f;
    double turning = mover_energy(m).turning;
    return turning / (0.5 * 2 * 2 * 3); // the inertia, a mass
}

// A ball, a disc; a capsule is a cylinder and a ball in two halves.
TEST(inertias_are_the_closed_forms)
{
    const double r = 0.5, h = 0.7, pi = 3.14159265358979323846;
    const double none[3] = {0, 0, 0}, capsule[3] = {h, 0, 0};
    assert_close(turning_energy(3, none, r, 1), 0.4 * r * r, 1e-7);
    assert_close(turning_energy(2, none, r, 2), 0.5 * r * r, 1e-7);
    double rod = pi * r * r * 2 * h, ball = 4 * pi * r * r * r / 3, all = rod + ball;
    double along = (rod * r * r / 2 + ball * 0.4 * r * r) / all;
    double across =
        (rod * (h * h / 3 + r * r / 4) + ball * (0.4 * r * r + h * h + 2 * h * 3 * r / 8)) / all;
    assert_close(turning_energy(3, capsule, r, 0), along, 1e-6);
    assert_close(turning_energy(3, capsule, r, 2), across, 1e-6);
    // hardly round: as the box
    assert_close(turning_energy(3, (double[3]){1, 0.5, 0.2}, 1e-6, 2), (1 + 0.25) / 3, 1e-5);
    assert_close(turning_energy(2, (double[3]){1, 0.5, 0}, 1e-6, 2), (1 + 0.25) / 3, 1e-5);
}

// ---------------------------------------------------------------- with the rest

TEST(hits_and_sensors_are_told)
{
    mover *m = on_a_floor(0.5);
    m->def.hit_speed = 1;
    uint32_t ball = add_ball(m, 0.3, 0, 1.5, 0.5), sensor = add_ball(m, 0.3, 0, 1, 0.2);
    m->bodies[sensor].sensor = true;
    m->bodies[sensor].mass = 0;
    bool hit = false, sensed = false;
    for (int i = 0; i < 60 && !hit; ++i) {
        mover_run(m, 1);
        for (uint64_t k = 0; k < m->last.n_events; ++k)
            sensed |= m->last.events[k].b == sensor && m->last.events[k].begins;
        if (m->last.n_hits == 0)
            continue;
        hit = true;
        assert_int_equal(m->last.hits[0].b, ball);
        assert_close(m->last.hits[0].normal[2], 1.0, 1e-6);
        assert_close(m->last.hits[0].point[0], 0.3, 0.01);
        assert_close(m->last.hits[0].point[2], 0.0, 0.05);
        assert_close(m->last.hits[0].speed, sqrt(2 * 9.81), 0.2);
    }
    assert_true(hit && sensed);
}

static mover *two_on_a_floor(void)
{
    mover *m = on_a_floor(0.5);
    m->def.wants |= DUET_EFFECT_FORCES;
    add_ball(m, 0, 0, 2, 0.5);
    add_round(m, 0.3, 0.2, 3.2, (double[3]){0.6, 0, 0}, 0.3);
    return m;
}

static void advance(duet_motion *motion, uint32_t steps)
{
    duet_motion_result result;
    for (uint32_t i = 0; i < steps; ++i)
        must(duet_motion_advance(motion, &result, ERR));
}

TEST(recordings_and_saved_motions_have_radii)
{
    static const char recording[] = "rounded.replay", saved[] = "rounded.motion";
    uint64_t id, hash[2];
    mover *m = two_on_a_floor(), *other = two_on_a_floor(), *third = two_on_a_floor();
    mover_run(m, 0);
    mover_run(other, 0);
    mover_run(third, 0);
    duet_pose pose = {
        .centre = {0.1f, 0, 5}, .half_extents = {0.2f, 0.2f, 0}, .rotation = {0, 0, 0, 1}};
    duet_body body = duet_default_body();
    body.radius = 0.2f;
    must(duet_motion_record(m->motion, ERR));
    must(duet_motion_add_bodies(m->motion, &pose, &body, 1, &id, ERR));
    advance(m->motion, 20);
    body.radius = 0.4f;
    const duet_body_list one = {.ids = &id, .n = 1};
    must(duet_motion_set_bodies(m->motion, one, DUET_BODY_RADIUS, &body, ERR));
    advance(m->motion, 10);
    must(duet_motion_save(m->motion, saved, ERR));
    advance(m->motion, 90);
    must(duet_motion_save_recording(m->motion, recording, ERR));
    must(duet_motion_get_hash(m->motion, &hash[0], ERR));

    must(duet_motion_load(third->motion, saved, ERR));
    advance(third->motion, 90);
    must(duet_motion_get_hash(third->motion, &hash[1], ERR));
    assert_true(hash[0] == hash[1]);

    duet_replay *replay = kept(duet_replay_create(recording, ERR));
    duet_motion_result result;
    while (duet_replay_get_info(replay).steps_done < duet_replay_get_info(replay).steps)
        must(duet_replay_advance(replay, other->motion, &result, ERR));
    must(duet_motion_get_hash(other->motion, &hash[1], ERR));
    assert_true(hash[0] == hash[1]);
}

TEST(radii_need_their_effect)
{
    mover *m = on_a_floor(0.5);
    mover_add_rough_cube(m, 0, 0, 0.5);
    mover_run(m, 0);
    duet_pose pose = {.centre = {0, 0, 5}, .rotation = {0, 0, 0, 1}};
    duet_body body = duet_default_body();
    body.radius = 0.5f;
    must_fail(duet_motion_add_bodies(m->motion, &pose, &body, 1, NULL, ERR),
              DUET_STATUS_BAD_ARGUMENT, "needs the effect radius; expected the motion's wants");
    body.radius = -1;
    must_fail(duet_motion_create(&m->def, &pose, &body, 1, ERR), DUET_STATUS_BAD_OBJECT,
              "the radius must be 0 or above");
}

// Two devices, shares and modes; and a scene's objects instead of poses and bodies.
TEST(any_plan_gives_the_same_bits)
{
    duet_rounded_box boxes[60];
    rng r = rng_seed(test_seed());
    mover *m = mover_new(3);
    m->def.gravity[2] = -9.81;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    for (int i = 0; i < 60; ++i) {
        draw_body(m, &r);
        m->poses[i].centre[2] += i < 5 ? 0.0f : 0.2f * (float)i;
        boxes[i] = box_of(m, (uint32_t)i);
    }
    m->bodies[0].mass = 0;
    mover_run(m, 30);
    uint64_t expected = mover_hash(m), hash;
    static const duet_mode modes[] = {DUET_MODE_SHARED, DUET_MODE_OWN, DUET_MODE_SLAB};
    for (int k = 0; k < 3; ++k) {
        mover_restart(m);
        m->def.plan.mode = modes[k];
        m->def.plan.share = DUET_SHARE_ONE / 4 * (uint32_t)k;
        mover_run(m, 30);
        assert_true(mover_hash(m) == expected);
    }
    duet_scene *scene = kept(duet_scene_create(DUET_OBJECT_ROUNDED_BOXES, boxes, 60, 3, 0, ERR));
    duet_motion *motion = kept(duet_motion_create_from_scene(&m->def, scene, m->bodies, ERR));
    advance(motion, 30);
    must(duet_motion_get_hash(motion, &hash, ERR));
    assert_true(hash == expected);
}
