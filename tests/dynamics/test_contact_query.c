// SPDX-License-Identifier: MIT
// Contacts of a still world. The truth is computed here in double: the axes of the boxes
// and how far both reach along them, and whether points lie on the boxes' surfaces.
#include "support/test.h"

#include "support/devices.h"
#include "support/mover.h"
#include "support/real.h"
#include "support/trees.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/opencl/device_pair.h"

// ---------------------------------------------------------------- truth

typedef struct solid {
    double centre[3], axis[3][3], halves[3];
} solid;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static solid solid_of(const duet_pose *p, uint32_t dims)
{
    const duet_pose flat = narrow_flat(p, dims);
    const block b = block_of(&flat);
    solid s;
    for (int i = 0; i < 3; ++i) {
        s.centre[i] = (double)b.centre[i];
        s.halves[i] = (double)b.half[i];
        for (int k = 0; k < 3; ++k)
            s.axis[i][k] = (double)b.axis[i][k];
    }
    return s;
}

static double reach(const solid *s, const double way[3])
{
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += fabs(dot(s->axis[i], way)) * s->halves[i];
    return sum;
}

static double separation_along(const solid *a, const solid *b, const double way[3])
{
    double length = sqrt(dot(way, way)), d[3];
    for (int k = 0; k < 3; ++k)
        d[k] = b->centre[k] - a->centre[k];
    return (fabs(dot(d, way)) - reach(a, way) - reach(b, way)) / length;
}

// The greatest separation of all axes, and the axis.
static double greatest_separation(const solid *a, const solid *b, int dims, double best[3])
{
    double greatest = -INFINITY;
    for (int i = 0; i < 2 * dims + (dims == 3 ? 9 : 0); ++i) {
        double way[3];
        const double *u = a->axis[i % 3], *v = b->axis[(i / 3 + 1) % 3];
        if (i < 2 * dims)
            memcpy(way, i < dims ? a->axis[i] : b->axis[i - dims], sizeof way);
        else
            for (int k = 0; k < 3; ++k)
                way[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        double length = sqrt(dot(way, way));
        if (length < 1e-9)
            continue;
        double separation = separation_along(a, b, way);
        if (separation <= greatest)
            continue;
        greatest = separation;
        for (int k = 0; k < 3; ++k)
            best[k] = way[k] / length;
    }
    return greatest;
}

static double size_of(const solid *a, const solid *b)
{
    double size = 0;
    for (int k = 0; k < 3; ++k)
        size += fabs(a->centre[k] - b->centre[k]) + a->halves[k] + b->halves[k];
    return size;
}

// How far a point, seen from `origin`, is from the surface of a box.
static double from_surface(const solid *s, const double origin[3], const double point[3], int dims)
{
    double outside = 0, inside = INFINITY;
    for (int i = 0; i < dims; ++i) {
        double to[3];
        for (int k = 0; k < 3; ++k)
            to[k] = origin[k] - s->centre[k] + point[k];
        double beyond = fabs(dot(to, s->axis[i])) - s->halves[i];
        outside = fmax(outside, beyond);
        inside = fmin(inside, -beyond);
    }
    return outside > 0 ? outside : inside;
}

// Both ends of each point's line along the normal lie on the two surfaces.
static void assert_points_join_surfaces(const duet_contact *c, const solid *a, const solid *b,
                                        int dims, double error)
{
    for (uint32_t i = 0; i < c->n; ++i) {
        double on_a[3], on_b[3], separation = c->points[i].separation;
        for (int k = 0; k < 3; ++k) {
            on_a[k] = c->points[i].anchor[k] - 0.5 * separation * c->normal[k];
            on_b[k] = c->points[i].anchor[k] + 0.5 * separation * c->normal[k];
        }
        assert_close(from_surface(a, a->centre, on_a, dims), 0, error);
        assert_close(from_surface(b, a->centre, on_b, dims), 0, error);
    }
}

typedef struct bound {
    double error;  // error of a separation along the normal
    double margin; // of the query
    double flat;   // edges so nearly parallel are not looked at
} bound;

static bound bound_of(const solid *a, const solid *b, float margin)
{
    double longest = 0;
    for (int k = 0; k < 3; ++k)
        longest = fmax(longest, fmin(2 * a->halves[k], 2 * b->halves[k]));
    return (bound){0x1p-17 * size_of(a, b), margin, 0.01 * longest};
}

// Checks what docs/accuracy.md, "Contacts", says of one.
static void assert_contact(const duet_contact *c, const solid *a, const solid *b, int dims,
                           float margin)
{
    bound e = bound_of(a, b, margin);
    double normal[3] = {c->normal[0], c->normal[1], c->normal[2]}, best[3] = {0};
    double deepest = INFINITY;
    double greatest = greatest_separation(a, b, dims, best);
    if (c->n == 0) {
        assert_true(greatest > -2 * e.error);
        assert_true(dot(normal, normal) == 0);
        return;
    }
    assert_true(c->n <= (dims == 3 ? 4 : 2));
    assert_close(dot(normal, normal), 1, 1e-5);
    double along = separation_along(a, b, normal);
    assert_true(along <= greatest + e.error);
    assert_true(along <= margin + 2 * e.error);
    if (fabs(dot(normal, best)) < 0.979)
        assert_true(along >= greatest - 0.125 * margin - 3 * e.error - e.flat);
    for (uint32_t i = 0; i < c->n; ++i) {
        deepest = fmin(deepest, c->points[i].separation);
        assert_true(c->points[i].separation <= margin + 2 * e.error);
    }
    assert_true(deepest >= along - e.error);
    double towards = 0;
    for (int k = 0; k < 3; ++k)
        towards += normal[k] * (b->centre[k] - a->centre[k]);
    assert_true(towards >= -e.error);
    assert_points_join_surfaces(c, a, b, dims, 2 * e.error);
}

// ---------------------------------------------------------------- worlds

enum { BOXES = 250 };

// Boxes have many sizes and are turned any way; every fourth stands upright on whole numbers, every
// seventh is nearly as the one before it.
static void fill(rng *r, duet_pose *poses, uint32_t dims)
{
    double edge = dims == 3 ? 3.5 : 10.0;
    for (uint32_t i = 0; i < BOXES; ++i) {
        duet_pose *p = &poses[i];
        *p = (duet_pose){.rotation = {0, 0, 0, 1}};
        for (uint32_t k = 0; k < 3; ++k) {
            p->centre[k] = (float)rng_between(r, -edge, edge);
            p->half_extents[k] = (float)(0.1 * pow(12, rng_unit(r)));
        }
        for (uint32_t k = 0; i % 4 != 0 && k < 4; ++k)
            p->rotation[k] = dims == 3 || k >= 2 ? (float)rng_normal(r) : 0;
        for (uint32_t k = 0; i % 4 == 0 && k < 3; ++k) {
            p->centre[k] = roundf(p->centre[k]);
            p->half_extents[k] = 0.5f;
        }
        if (i % 7 == 6) {
            memcpy(p->rotation, p[-1].rotation, sizeof p->rotation);
            p->rotation[2] += (float)(0.02 * rng_unit(r) * fabs(p->rotation[3]));
            p->centre[0] = p[-1].centre[0] + p[-1].half_extents[0];
            p->centre[1] = p[-1].centre[1] + p[-1].half_extents[1];
            p->centre[2] = p[-1].centre[2];
        }
    }
}

// Every two boxes, lower id first.
static duet_pair *all_pairs(uint64_t *n)
{
    duet_pair *pairs = test_alloc((size_t)BOXES * BOXES / 2 * sizeof *pairs);
    *n = 0;
    for (uint32_t a = 0; a < BOXES; ++a)
        for (uint32_t b = a + 1; b < BOXES; ++b)
            pairs[(*n)++] = (duet_pair){a, b};
    return pairs;
}

static void contacts_are_those_of_the_boxes(uint32_t dims, float margin)
{
    duet_pose poses[BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, poses, dims);
    uint64_t n, colliding = 0, points = 0;
    duet_pair *pairs = all_pairs(&n);
    duet_contact_query *query =
        open_contact_query(DUET_SHAPE_POSES, dims, DUET_SHARE_ONE / 3, margin);
    duet_contact_query_result found =
        find_contacts(query, DUET_OBJECT_POSES, poses, BOXES, pairs, n);
    uint64_t touching = 0;
    for (uint64_t i = 0; i < n; ++i) {
        const duet_contact *c = &found.contacts[i];
        assert_int_equal(c->a, pairs[i].a);
        assert_int_equal(c->b, pairs[i].b);
        solid a = solid_of(&poses[c->a], dims), b = solid_of(&poses[c->b], dims);
        assert_contact(c, &a, &b, (int)dims, margin);
        if (duet_poses_collide(&poses[c->a], &poses[c->b], dims)) {
            assert_true(c->n > 0);
            ++colliding;
        }
        touching += c->n > 0;
        points += c->n;
    }
    assert_int_equal(found.touching, touching);
    assert_true(colliding > BOXES / 2 && touching >= colliding && touching < n);
    print_message("%uD: %llu colliding of %llu, %llu points\n", dims, (unsigned long long)colliding,
                  (unsigned long long)n, (unsigned long long)points);
}

TEST(contacts_in_3d)
{
    contacts_are_those_of_the_boxes(3, 0);
    contacts_are_those_of_the_boxes(3, 0.05f);
}

TEST(contacts_in_2d)
{
    contacts_are_those_of_the_boxes(2, 0);
    contacts_are_those_of_the_boxes(2, 0.05f);
}

// ---------------------------------------------------------------- closed forms

static duet_contact contact_of(uint32_t dims, duet_pose a, duet_pose b)
{
    const duet_pose poses[2] = {a, b};
    const duet_pair pair = {0, 1};
    duet_contact_query *query = open_contact_query(DUET_SHAPE_POSES, dims, 0, 0);
    return find_contacts(query, DUET_OBJECT_POSES, poses, 2, &pair, 1).contacts[0];
}

TEST(a_box_on_a_plane_has_its_corners_at_its_depth)
{
    const duet_pose floor = cube_at(0, -8, 0, 8);
    for (int i = 0; i < 3; ++i) {
        double depth = i == 0 ? 0 : i == 1 ? 0.125 : 0.25;
        duet_contact flat = contact_of(2, floor, cube_at(3, 0.5 - depth, 0, 0.5));
        duet_contact c = contact_of(3, floor, cube_at(3, 0.5 - depth, 2, 0.5));
        assert_int_equal(c.n, 4);
        assert_int_equal(flat.n, 2);
        double corners[2] = {0, 0};
        for (uint32_t k = 0; k < 4; ++k) {
            assert_true(c.points[k].separation == -depth);
            assert_close(c.points[k].anchor[1], 8 - depth / 2, 1e-6);
            assert_close(fabs(c.points[k].anchor[0] - 3), 0.5, 1e-6);
            assert_close(fabs(c.points[k].anchor[2] - 2), 0.5, 1e-6);
            corners[0] += c.points[k].anchor[0] - 3;
            corners[1] += c.points[k].anchor[2] - 2;
            assert_true(k > 1 || flat.points[k].separation == -depth);
        }
        assert_close(corners[0], 0, 1e-6);
        assert_close(corners[1], 0, 1e-6);
        assert_true(c.normal[0] == 0 && c.normal[1] == 1 && c.normal[2] == 0);
        assert_true(flat.normal[0] == 0 && flat.normal[1] == 1);
    }
}

TEST(a_corner_in_a_plane_is_one_point)
{
    duet_pose box = cube_at(0, sqrt(3) - 0.01, 0, 1);
    const double angle = acos(1 / sqrt(3)) / 2; // its diagonal upright
    const double s = sin(angle) / sqrt(2);
    const float q[4] = {(float)-s, 0, (float)s, (float)cos(angle)};
    memcpy(box.rotation, q, sizeof q);
    duet_contact c = contact_of(3, cube_at(0, -8, 0, 8), box);
    double deepest = 1, low[3] = {0};
    for (uint32_t i = 0; i < c.n; ++i)
        if (c.points[i].separation < deepest) {
            deepest = c.points[i].separation;
            for (int k = 0; k < 3; ++k)
                low[k] = c.points[i].anchor[k];
        }
    assert_close(deepest, -0.01, 1e-5);
    assert_close(low[0], 0, 1e-5);
    assert_close(low[1], 8 - 0.005, 1e-5);
    assert_close(low[2], 0, 1e-5);
    assert_true(c.normal[1] == 1);
}

// Two beams that cross with their edges: turned by an eighth about x and about z.
TEST(edges_that_cross_are_one_point)
{
    const float s = (float)sin(acos(-1) / 8), w = (float)cos(acos(-1) / 8);
    duet_pose along_x = {{0, 0, 0}, {5, 1, 1}, {s, 0, 0, w}};
    duet_pose along_z = {{0, (float)(2 * sqrt(2) - 0.1), 0}, {1, 1, 5}, {0, 0, s, w}};
    duet_contact c = contact_of(3, along_x, along_z);
    assert_int_equal(c.n, 1);
    assert_close(c.points[0].separation, -0.1, 1e-5);
    assert_close(c.points[0].anchor[0], 0, 1e-5);
    assert_close(c.points[0].anchor[1], sqrt(2) - 0.05, 1e-5);
    assert_close(c.points[0].anchor[2], 0, 1e-5);
    assert_close(c.normal[1], 1, 1e-6);
}

// Faces, edges and corners that just touch, and boxes without extent.
TEST(what_touches_has_a_point)
{
    duet_pose poses[28];
    duet_pair pairs[54];
    uint64_t n = 0;
    for (int i = 0; i < 27; ++i)
        poses[i] = cube_at(i % 3, i / 3 % 3, i / 9, 0.5);
    poses[27] = cube_at(1, 1, 1, 0); // a point
    for (uint32_t i = 0; i < 27; ++i)
        if (i != 13)
            pairs[n++] = (duet_pair){i, 13};
    pairs[n++] = (duet_pair){13, 27};
    duet_contact_query *query = open_contact_query(DUET_SHAPE_POSES, 3, 0, 0);
    duet_contact_query_result found = find_contacts(query, DUET_OBJECT_POSES, poses, 28, pairs, n);
    for (uint64_t i = 0; i < n; ++i) {
        assert_true(found.contacts[i].n > 0);
        for (uint32_t k = 0; i + 1 < n && k < found.contacts[i].n; ++k)
            assert_true(found.contacts[i].points[k].separation == 0);
    }
    assert_true(found.contacts[n - 1].points[0].separation == -0.5f);
}

// ---------------------------------------------------------------- the same

TEST(the_other_way_round_has_the_same_points)
{
    duet_pose poses[BOXES];
    rng r = rng_seed(test_seed());
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        fill(&r, poses, dims);
        uint64_t n;
        duet_pair *pairs = all_pairs(&n);
        duet_contact_query *query = open_contact_query(DUET_SHAPE_POSES, dims, 0, 0),
                           *back = open_contact_query(DUET_SHAPE_POSES, dims, 0, 0);
        duet_contact_query_result one =
            find_contacts(query, DUET_OBJECT_POSES, poses, BOXES, pairs, n);
        for (uint64_t i = 0; i < n; ++i)
            pairs[i] = (duet_pair){pairs[i].b, pairs[i].a};
        duet_contact_query_result other =
            find_contacts(back, DUET_OBJECT_POSES, poses, BOXES, pairs, n);
        for (uint64_t i = 0; i < n; ++i) {
            const duet_contact *c = &one.contacts[i], *d = &other.contacts[i];
            assert_true(c->a == d->b && c->b == d->a && c->n == d->n);
            for (int k = 0; k < 3; ++k)
                assert_true(c->normal[k] == -d->normal[k]);
            for (uint32_t p = 0; p < c->n; ++p) {
                assert_true(c->points[p].separation == d->points[p].separation);
                for (uint32_t k = 0; k < dims; ++k) {
                    float way = poses[c->b].centre[k] - poses[c->a].centre[k];
                    assert_true(c->points[p].anchor[k] - way == d->points[p].anchor[k]);
                }
            }
        }
    }
}

// On a GPU a work-item takes one pair.
TEST(share_and_launch_change_no_bit)
{
    const uint32_t shares[] = {0, DUET_SHARE_ONE, DUET_SHARE_ONE / 3, 1, 0};
    enum { WAYS = sizeof shares / sizeof shares[0] };
    duet_pose poses[BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, poses, 3);
    uint64_t n;
    duet_pair *pairs = all_pairs(&n);
    duet_device_info *info = &default_pair()->devices[1].info;
    duet_device_kind kind = info->kind;
    duet_contact *first = test_alloc((size_t)n * sizeof *first);
    for (int i = 0; i < WAYS; ++i) {
        info->kind = i + 1 == WAYS ? DUET_KIND_GPU : kind;
        duet_contact_query *query = open_contact_query(DUET_SHAPE_POSES, 3, shares[i], 0.01f);
        info->kind = kind;
        duet_contact_query_result found =
            find_contacts(query, DUET_OBJECT_POSES, poses, BOXES, pairs, n);
        if (i == 0)
            memcpy(first, found.contacts, (size_t)n * sizeof *first);
        assert_memory_equal(first, found.contacts, (size_t)n * sizeof *first);
    }
}

// A world's pairs as its result has them.
TEST(the_pairs_of_a_world_have_points)
{
    duet_pose poses[BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, poses, 3);
    duet_world_def def = devices_def(3);
    def.plan.share = DUET_SHARE_ONE / 3;
    duet_world *world = create_world(&def);
    duet_result result = step_with(world, DUET_OBJECT_POSES, poses, BOXES);
    assert_true(result.spans[0].n > 0 && result.spans[1].n > 0);
    duet_contact_query *query = open_contact_query(DUET_SHAPE_POSES, 3, DUET_SHARE_DEFAULT, 0);
    duet_contact_query_result found;
    must(duet_contact_query_run(query, DUET_OBJECT_POSES, poses, BOXES, result.spans, &found, ERR));
    assert_int_equal(found.n_contacts, result.pairs);
    assert_int_equal(found.touching, result.pairs);
    for (uint64_t i = 0; i < result.pairs; ++i) {
        duet_pair p = duet_result_get_pair(&result, i);
        assert_true(found.contacts[i].a == p.a && found.contacts[i].b == p.b);
    }
}

// ---------------------------------------------------------------- from step to step

// Against a matrix of the pairs, two steps of a world whose boxes move.
TEST(a_delta_is_what_two_steps_differ_by)
{
    duet_pose poses[BOXES];
    static bool was[BOXES][BOXES], is[BOXES][BOXES];
    rng r = rng_seed(test_seed());
    fill(&r, poses, 3);
    duet_world_def def = devices_def(3);
    duet_world *world = create_world(&def);
    duet_pair_delta *delta = must(duet_pair_delta_create(ERR));
    uint64_t told[3] = {0};
    memset(was, 0, sizeof was);
    for (int step = 0; step < 6; ++step) {
        duet_result result;
        duet_pair_delta_result found;
        duet_plan plan = *duet_world_get_plan(world);
        plan.share = step % 2 ? DUET_SHARE_ONE / 2 : 0;
        must(duet_world_set_plan(world, &plan, ERR));
        must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, BOXES, ERR));
        must(duet_world_step(world, &result, ERR));
        must(duet_pair_delta_update(delta, result.spans, &found, ERR));
        memset(is, 0, sizeof is);
        for (uint64_t i = 0; i < result.pairs; ++i)
            is[duet_result_get_pair(&result, i).a][duet_result_get_pair(&result, i).b] = true;
        uint64_t event = 0, stay = 0;
        for (uint32_t a = 0; a < BOXES; ++a)
            for (uint32_t b = 0; b < BOXES; ++b) {
                if (was[a][b] && is[a][b]) {
                    assert_true(stay < found.n_stays && found.stays[stay].a == a &&
                                found.stays[stay].b == b);
                    ++stay;
                } else if (was[a][b] || is[a][b]) {
                    assert_true(event < found.n_events);
                    const duet_event *e = &found.events[event++];
                    assert_true(e->a == a && e->b == b && e->begins == is[a][b]);
                    ++told[is[a][b]];
                }
            }
        assert_true(event == found.n_events && stay == found.n_stays);
        told[2] += stay;
        memcpy(was, is, sizeof was);
        for (uint32_t i = 0; i < BOXES; ++i)
            poses[i].centre[i % 3] += (float)rng_between(&r, -0.5, 0.5);
    }
    assert_true(told[0] > BOXES && told[1] > BOXES && told[2] > BOXES);
    duet_pair_delta_destroy(delta);
}

// ---------------------------------------------------------------- what is refused

static void assert_refused(const duet_pose *poses, uint32_t n, duet_pair pair, duet_status status,
                           const char *says)
{
    duet_contact_query_result result;
    const duet_span spans[2] = {{&(duet_pair){0, 1}, 1}, {&pair, 1}};
    duet_contact_query *query = open_contact_query(DUET_SHAPE_POSES, 3, 0, 0);
    must_fail(duet_contact_query_run(query, DUET_OBJECT_POSES, poses, n, spans, &result, ERR),
              status, "");
    assert_string_equal(ERR->text, says);
    find_contacts(query, DUET_OBJECT_POSES, poses, 2, &(duet_pair){0, 1}, 1); // and goes on
}

TEST(what_is_no_pair_of_boxes_is_refused)
{
    duet_pose poses[3] = {cube_at(0, 0, 0, 1), cube_at(1, 0, 0, 1), cube_at(NAN, 0, 0, 1)};
    assert_refused(poses, 3, (duet_pair){1, 3}, DUET_STATUS_BAD_ARGUMENT,
                   "pair 1 is of objects 1 and 3; expected two of 3");
    assert_refused(poses, 3, (duet_pair){1, 1}, DUET_STATUS_BAD_ARGUMENT,
                   "pair 1 is of objects 1 and 1; expected two of 3");
    assert_refused(poses, 3, (duet_pair){1, 2}, DUET_STATUS_BAD_OBJECT,
                   "object 2 of 3 is not a number, infinite, negative or without rotation");
}
