// SPDX-License-Identifier: MIT
// Contacts of still rounded boxes and spheres: against the exact answer and the reference's
// separation in double, closed forms, the contacts of a motion, and boxes without radii.
#include "support/test.h"

#include "support/devices.h"
#include "support/mover.h"
#include "support/trees.h"

#include "runtime/narrowphase/rounded.h"
#include "runtime/opencl/device_pair.h"

enum { BOXES = 160, MOST_PAIRS = BOXES * BOXES / 2 };

// Every two boxes.
static uint64_t all_pairs(duet_pair *pairs)
{
    uint64_t n = 0;
    for (uint32_t a = 0; a < BOXES; ++a)
        for (uint32_t b = a + 1; b < BOXES; ++b)
            pairs[n++] = (duet_pair){a, b};
    return n;
}

// Spheres, capsules, plates and boxes, every fourth upright on whole numbers, some without a
// radius. Every fifth lies along the one before it, turned by less than a thousandth up to a tenth,
// and so near that radii decide.
static void fill(rng *r, duet_rounded_box *boxes, uint32_t dims)
{
    double edge = dims == 3 ? 2.5 : 8.0;
    for (uint32_t i = 0; i < BOXES; ++i) {
        duet_pose *p = &boxes[i].pose;
        *p = (duet_pose){.rotation = {0, 0, 0, 1}};
        boxes[i].radius = i % 9 == 0 ? 0 : (float)(0.4 * pow(0.01, rng_unit(r)));
        for (uint32_t k = 0; k < 3; ++k) {
            p->centre[k] = (float)rng_between(r, -edge, edge);
            p->half_extents[k] = k < (i * 7 + i / 5) % 4 ? (float)(0.1 * pow(12, rng_unit(r))) : 0;
        }
        for (uint32_t k = 0; i % 4 != 0 && k < 4; ++k)
            p->rotation[k] = dims == 3 || k >= 2 ? (float)rng_normal(r) : 0;
        for (uint32_t k = 0; i % 4 == 0 && k < 3; ++k) {
            p->centre[k] = roundf(p->centre[k]);
            p->half_extents[k] = roundf(p->half_extents[k] * 2) / 2;
        }
        if (i % 5 == 4) {
            double tilt = 0.2 * pow(1e-5, rng_unit(r));
            double gap = rng_between(r, -0.01, 0.01) + boxes[i].radius + p[-1].half_extents[0];
            memcpy(p->rotation, boxes[i - 1].pose.rotation, sizeof p->rotation);
            memcpy(p->centre, boxes[i - 1].pose.centre, sizeof p->centre);
            p->rotation[2] += (float)(tilt * fabs(p->rotation[3]));
            p->centre[i % dims] += (float)gap + boxes[i - 1].radius;
            if (i % 2)
                p->rotation[0] += dims == 3 ? (float)(tilt * p->rotation[3]) : 0;
        }
    }
}

static double size_of(const duet_rounded_box *a, const duet_rounded_box *b, uint32_t dims)
{
    double size = (double)a->radius + b->radius;
    for (uint32_t k = 0; k < dims; ++k)
        size += fabs((double)a->pose.centre[k] - b->pose.centre[k]) + a->pose.half_extents[k] +
                b->pose.half_extents[k];
    return size;
}

// How far a point, seen from a's centre, is outside of a body's surface.
static double out_of(const duet_rounded_box *body, const duet_pose *a, const double from_a[3],
                     uint32_t dims)
{
    duet_rounded_box at = {.pose.rotation = {0, 0, 0, 1}};
    for (uint32_t k = 0; k < dims; ++k)
        at.pose.centre[k] = (float)(a->centre[k] + from_a[k]);
    return duet_rounded_boxes_separation(body, &at, dims);
}

static uint32_t deepest_of(const duet_contact *c)
{
    uint32_t deepest = 0;
    for (uint32_t p = 1; p < c->n; ++p)
        deepest = c->points[p].separation < c->points[deepest].separation ? p : deepest;
    return deepest;
}

// Both ends of the deepest point's line along the normal lie on the two surfaces.
static void assert_between(const duet_contact *c, const duet_rounded_box *boxes, uint32_t dims,
                           double bound)
{
    const uint32_t p = deepest_of(c);
    for (int side = -1; side <= 1; side += 2) {
        double at[3] = {0};
        for (uint32_t k = 0; k < dims; ++k)
            at[k] = c->points[p].anchor[k] + 0.5 * side * c->points[p].separation * c->normal[k];
        double out = out_of(&boxes[side < 0 ? c->a : c->b], &boxes[c->a].pose, at, dims);
        if (!(fabs(out) <= bound))
            fail_msg("%u and %u in %uD: %g from the surface of %u", c->a, c->b, dims, out,
                     side < 0 ? c->a : c->b);
    }
}

// Checks what docs/accuracy.md, "Contacts", says of one with a radius.
static void assert_contact(const duet_contact *c, const duet_rounded_box *boxes, uint32_t dims,
                           float margin)
{
    const duet_rounded_box *a = &boxes[c->a], *b = &boxes[c->b];
    double e = 0x1p-17 * size_of(a, b, dims), reach = (double)a->radius + b->radius;
    double separation = duet_rounded_boxes_separation(a, b, dims);
    if (c->n == 0) {
        if (!(separation > margin))
            fail_msg("%u and %u in %uD have no point, and a separation of %g", c->a, c->b, dims,
                     separation);
        assert_true(c->normal[0] == 0 && c->normal[1] == 0 && c->normal[2] == 0);
        return;
    }
    double length = 0, least = c->points[deepest_of(c)].separation;
    for (int k = 0; k < 3; ++k)
        length += c->normal[k] * c->normal[k];
    assert_true(c->n <= (dims == 3 ? 4 : 2));
    assert_close(length, 1, 1e-5);
    if (separation > margin + 2 * e)
        fail_msg("%u and %u in %uD have %u points, and a separation of %g", c->a, c->b, dims, c->n,
                 separation);
    if (separation + reach < 0x1p-11 * size_of(a, b, dims)) // the axis is a choice
        return;
    if (!(fabs(least - separation) <= 0.125 * margin + 3 * e))
        fail_msg("%u and %u in %uD, margin %g: separation %g, %g of its %u points", c->a, c->b,
                 dims, (double)margin, separation, least, c->n);
    if (c->n != 2) // else maybe the ends of two edges, as a plane across the normal has them
        assert_between(c, boxes, dims, 0.125 * margin + 4 * e);
}

static void check_world(duet_rounded_box *boxes, uint32_t dims, float margin)
{
    static duet_pair pairs[MOST_PAIRS];
    uint64_t n = all_pairs(pairs), colliding = 0, touching = 0;
    duet_contact_query *query =
        open_contact_query(DUET_SHAPE_ROUNDED_BOXES, dims, DUET_SHARE_ONE / 3, margin);
    duet_contact_query_result found =
        find_contacts(query, DUET_OBJECT_ROUNDED_BOXES, boxes, BOXES, pairs, n);
    for (uint64_t i = 0; i < n; ++i) {
        const duet_contact *c = &found.contacts[i];
        const duet_rounded_box *a = &boxes[pairs[i].a], *b = &boxes[pairs[i].b];
        assert_true(c->a == pairs[i].a && c->b == pairs[i].b);
        touching += c->n > 0;
        if (duet_rounded_boxes_collide(a, b, dims)) {
            if (c->n == 0)
                fail_msg("%u and %u in %uD collide and have no point", c->a, c->b, dims);
            ++colliding;
        }
        if (a->radius + b->radius > 0)
            assert_contact(c, boxes, dims, margin);
    }
    assert_true(colliding > BOXES / 8 && touching >= colliding && touching < n / 2);
    assert_int_equal(found.touching, touching);
}

TEST(contacts_are_those_of_the_rounded_boxes)
{
    duet_rounded_box boxes[BOXES];
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 3; ++round)
        for (uint32_t dims = 2; dims <= 3; ++dims) {
            fill(&r, boxes, dims);
            check_world(boxes, dims, 0);
            check_world(boxes, dims, 0.05f);
        }
}

// Capsules that cross at angles down to where float sees none, a hair apart or in each other.
TEST(edges_that_are_nearly_parallel_touch_where_they_cross)
{
    duet_rounded_box boxes[BOXES];
    rng r = rng_seed(test_seed());
    for (uint32_t i = 0; i < BOXES; i += 2) {
        float radius = (float)pow(1e-5, rng_unit(&r)) * 0.25f;
        double angle = pow(1e-7, rng_unit(&r)), over = 1e-6 * pow(1e3, rng_unit(&r));
        boxes[i] = (duet_rounded_box){{{(float)(4 * i), 0, 0}, {1, 0, 0}, {0, 0, 0, 1}}, radius};
        boxes[i + 1] = boxes[i];
        boxes[i + 1].pose.centre[2] += 2 * radius - (float)(i % 4 == 0 ? over : -over);
        boxes[i + 1].pose.rotation[2] = (float)(angle / 2);
        boxes[i + 1].pose.half_extents[0] = (float)rng_between(&r, 0.5, 2);
    }
    check_world(boxes, 3, 0);
}

// ---------------------------------------------------------------- closed forms

static duet_contact contact_of(duet_rounded_box a, duet_rounded_box b, float margin)
{
    const duet_rounded_box boxes[2] = {a, b};
    const duet_pair pair = {0, 1};
    duet_contact_query *query = open_contact_query(DUET_SHAPE_ROUNDED_BOXES, 3, 0, margin);
    duet_contact c =
        find_contacts(query, DUET_OBJECT_ROUNDED_BOXES, boxes, 2, &pair, 1).contacts[0];
    return c;
}

static void assert_vector(const float v[3], double x, double y, double z)
{
    assert_close(v[0], x, 1e-5);
    assert_close(v[1], y, 1e-5);
    assert_close(v[2], z, 1e-5);
}

TEST(closed_forms_hold)
{
    // Two spheres 3 4 0 apart, 5 away from each other.
    duet_contact c =
        contact_of(rounded_at(0, 0, 0, 0, 0, 0, 2), rounded_at(3, 4, 0, 0, 0, 0, 4), 0);
    assert_true(c.n == 1);
    assert_vector(c.normal, 0.6, 0.8, 0);
    assert_close(c.points[0].separation, -1, 1e-5);
    assert_vector(c.points[0].anchor, 0.6 * 1.5, 0.8 * 1.5, 0);
    // A sphere above the face of a rounded plate, apart by less than the margin.
    c = contact_of(rounded_at(0, 0, 0, 4, 0.5, 4, 0.25), rounded_at(1, 2, -1, 0, 0, 0, 1.125),
                   0.25f);
    assert_true(c.n == 1);
    assert_vector(c.normal, 0, 1, 0);
    assert_close(c.points[0].separation, 0.125, 1e-5);
    assert_vector(c.points[0].anchor, 1, 0.8125, -1);
    // The same one off the plate's edge, and off its corner.
    c = contact_of(rounded_at(0, 0, 0, 4, 0.5, 4, 0.25), rounded_at(4.6, 1.3, 0, 0, 0, 0, 1), 0);
    assert_true(c.n == 1);
    assert_vector(c.normal, 0.6, 0.8, 0);
    assert_close(c.points[0].separation, -0.25, 1e-5);
    c = contact_of(rounded_at(0, 0, 0, 1, 1, 1, 0.25), rounded_at(1.5, 1.5, 1.5, 0, 0, 0, 0.75), 0);
    assert_true(c.n == 1);
    assert_vector(c.normal, sqrt(1.0 / 3), sqrt(1.0 / 3), sqrt(1.0 / 3));
    assert_close(c.points[0].separation, sqrt(0.75) - 1, 1e-5);
    // Capsules across each other, and side by side, which share 3 of their length.
    c = contact_of(rounded_at(0, 0, 0, 3, 0, 0, 0.5), rounded_at(1, 0.75, 2, 0, 0, 3, 0.5), 0);
    assert_true(c.n == 1);
    assert_vector(c.normal, 0, 1, 0);
    assert_vector(c.points[0].anchor, 1, 0.375, 0);
    c = contact_of(rounded_at(0, 0, 0, 2, 0, 0, 0.5), rounded_at(1, 0.75, 0, 2, 0, 0, 0.5), 0);
    assert_true(c.n == 2);
    assert_vector(c.normal, 0, 1, 0);
    assert_close(c.points[0].separation, -0.25, 1e-5);
    assert_close(fabs(c.points[0].anchor[0] - c.points[1].anchor[0]), 3, 1e-5);
    // A rounded cube on a plate has its core's four corners.
    c = contact_of(rounded_at(0, 0, 0, 4, 0.5, 4, 0), rounded_at(0, 1.5, 0, 0.5, 0.5, 0.5, 0.625),
                   0);
    assert_true(c.n == 4);
    for (int k = 0; k < 4; ++k) {
        assert_close(c.points[k].separation, -0.125, 1e-5);
        assert_close(fabs(c.points[k].anchor[0]), 0.5, 1e-5);
    }
}

// ---------------------------------------------------------------- the same

// Lengths and places of no other pair count, nor does who computes it, nor the order of the two.
TEST(shares_launches_and_order_change_no_bit)
{
    static duet_pair pairs[MOST_PAIRS];
    duet_rounded_box boxes[BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, boxes, 3);
    uint64_t n = all_pairs(pairs);
    duet_contact *first = test_alloc((size_t)n * sizeof *first);
    duet_device_info *info = &default_pair()->devices[1].info;
    duet_device_kind kind = info->kind;
    for (int way = 0; way < 3; ++way) {
        info->kind = way == 2 ? DUET_KIND_GPU : kind;
        duet_contact_query *query = open_contact_query(DUET_SHAPE_ROUNDED_BOXES, 3,
                                                       way == 1 ? DUET_SHARE_ONE / 3 : 0, 0.05f);
        info->kind = kind;
        duet_contact_query_result found =
            find_contacts(query, DUET_OBJECT_ROUNDED_BOXES, boxes, BOXES, pairs, n);
        if (way == 0)
            memcpy(first, found.contacts, (size_t)n * sizeof *first);
        assert_memory_equal(first, found.contacts, (size_t)n * sizeof *first);
    }
    for (uint64_t i = 0; i < n; ++i)
        pairs[i] = (duet_pair){pairs[i].b, pairs[i].a};
    duet_contact_query *back = open_contact_query(DUET_SHAPE_ROUNDED_BOXES, 3, 0, 0.05f);
    duet_contact_query_result found =
        find_contacts(back, DUET_OBJECT_ROUNDED_BOXES, boxes, BOXES, pairs, n);
    for (uint64_t i = 0; i < n; ++i) {
        assert_int_equal(found.contacts[i].n, first[i].n);
        for (int k = 0; k < 3; ++k)
            assert_true(found.contacts[i].normal[k] == -first[i].normal[k]);
        for (uint32_t p = 0; p < first[i].n; ++p)
            assert_true(found.contacts[i].points[p].separation == first[i].points[p].separation);
    }
}

// Rounded boxes have the contacts of what else they are, by another share.
static void assert_same_contacts(const duet_rounded_box *boxes, duet_shape shape,
                                 duet_object_kind kind, const void *objects, float margin)
{
    static duet_pair pairs[MOST_PAIRS];
    uint64_t n = all_pairs(pairs);
    duet_contact_query *rounded = open_contact_query(DUET_SHAPE_ROUNDED_BOXES, 3, 0, margin);
    duet_contact_query *other = open_contact_query(shape, 3, DUET_SHARE_ONE / 3, margin);
    duet_contact_query_result a =
        find_contacts(rounded, DUET_OBJECT_ROUNDED_BOXES, boxes, BOXES, pairs, n);
    duet_contact_query_result b = find_contacts(other, kind, objects, BOXES, pairs, n);
    assert_true(a.touching > BOXES / 4);
    assert_memory_equal(a.contacts, b.contacts, (size_t)n * sizeof *a.contacts);
}

TEST(boxes_without_radii_have_the_contacts_of_poses)
{
    duet_rounded_box boxes[BOXES];
    duet_pose poses[BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, boxes, 3);
    for (uint32_t i = 0; i < BOXES; ++i) {
        boxes[i].radius = 0;
        poses[i] = boxes[i].pose;
    }
    assert_same_contacts(boxes, DUET_SHAPE_POSES, DUET_OBJECT_POSES, poses, 0.05f);
}

TEST(spheres_have_the_contacts_of_rounded_boxes)
{
    duet_rounded_box boxes[BOXES];
    duet_sphere spheres[BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, boxes, 3);
    for (uint32_t i = 0; i < BOXES; ++i) {
        memcpy(spheres[i].centre, boxes[i].pose.centre, sizeof spheres[i].centre);
        spheres[i].radius = boxes[i].radius * 2;
        boxes[i] = rounded_of_sphere(&spheres[i]);
    }
    assert_same_contacts(boxes, DUET_SHAPE_SPHERES, DUET_OBJECT_SPHERES, spheres, 0);
}

// A motion keeps points up to four slops.
TEST(a_motion_has_the_same_contacts)
{
    duet_rounded_box boxes[BOXES];
    duet_pose poses[BOXES];
    duet_body bodies[BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, boxes, 3);
    for (uint32_t i = 0; i < BOXES; ++i) {
        bodies[i] = duet_default_body();
        bodies[i].radius = boxes[i].radius;
        poses[i] = boxes[i].pose;
    }
    duet_motion_def def = duet_default_motion_def();
    def.pair = default_pair();
    def.wants = DUET_EFFECT_CONTACT;
    def.slop = 0.005;
    duet_motion *motion = kept(duet_motion_create(&def, poses, bodies, BOXES, ERR));
    duet_motion_result result;
    duet_contact *moving = NULL;
    uint64_t n = 0, alike = 0, compared = 0;
    must(duet_motion_advance(motion, &result, ERR));
    must(duet_motion_get_contacts(motion, &moving, &n, ERR));
    duet_pair *pairs = test_alloc((size_t)n * sizeof *pairs);
    for (uint64_t i = 0; i < n; ++i)
        pairs[i] = (duet_pair){moving[i].a, moving[i].b};
    duet_contact_query *query = open_contact_query(DUET_SHAPE_ROUNDED_BOXES, 3, 0, 0.02f);
    duet_contact_query_result still =
        find_contacts(query, DUET_OBJECT_ROUNDED_BOXES, boxes, BOXES, pairs, n);
    for (uint64_t i = 0; i < n; ++i) {
        const duet_contact *c = &still.contacts[i], *m = &moving[i];
        double along = 0, e = 0x1p-16 * size_of(&boxes[c->a], &boxes[c->b], 3);
        if (boxes[c->a].radius + boxes[c->b].radius == 0)
            continue;
        assert_true(c->n > 0 && m->n > 0);
        for (int k = 0; k < 3; ++k)
            along += c->normal[k] * m->normal[k];
        double apart = c->points[deepest_of(c)].separation - m->points[deepest_of(m)].separation;
        assert_true(fabs(apart) < 0.01 + e || along < 0.9);
        alike += along > 0.999 && fabs(apart) < 1e-4 && c->n == m->n;
        ++compared;
    }
    print_message("%llu of %llu contacts alike\n", (unsigned long long)alike,
                  (unsigned long long)compared);
    assert_true(compared > BOXES / 4 && 10 * alike > 9 * compared);
    duet_free(moving);
}

// ---------------------------------------------------------------- refusals

TEST(what_is_no_object_of_the_shape_is_refused)
{
    duet_contact_query_result result;
    duet_rounded_box boxes[2] = {rounded_at(0, 0, 0, 1, 1, 1, 1), rounded_at(1, 0, 0, 1, 1, 1, -1)};
    const duet_sphere spheres[2] = {{{0, 0, 0}, 1}, {{1, NAN, 0}, 1}};
    const duet_pair pair = {0, 1};
    const duet_span spans[2] = {{&pair, 1}, {NULL, 0}};
    duet_contact_query *rounded = open_contact_query(DUET_SHAPE_ROUNDED_BOXES, 3, 0, 0);
    duet_contact_query *round = open_contact_query(DUET_SHAPE_SPHERES, 3, DUET_SHARE_ONE / 3, 0);
    must_fail(
        duet_contact_query_run(rounded, DUET_OBJECT_ROUNDED_BOXES, boxes, 2, spans, &result, ERR),
        DUET_STATUS_BAD_OBJECT, "");
    assert_string_equal(ERR->text,
                        "object 1 of 2 is not a number, infinite, negative or without rotation");
    must_fail(duet_contact_query_run(round, DUET_OBJECT_SPHERES, spheres, 2, spans, &result, ERR),
              DUET_STATUS_BAD_OBJECT, "");
    assert_string_equal(ERR->text,
                        "object 1 of 2 is not a number, infinite, negative or without rotation");
    must_fail(duet_contact_query_run(rounded, DUET_OBJECT_POSES, boxes, 2, spans, &result, ERR),
              DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "objects of kind 0; the query is of rounded boxes");
    duet_contact_query_def def = duet_default_contact_query_def();
    def.pair = default_pair();
    def.shape = DUET_SHAPE_BOUNDS;
    must_fail(duet_contact_query_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text,
                        "shape is 1; contacts are those of poses, rounded boxes or spheres");
}
