// SPDX-License-Identifier: MIT
// Rays, points, boxes and sweeps against a ground of triangles: all triangles in long double, and
// in whole numbers where things only touch.
#include "support/ground_truth.h"
#include "support/mover.h"
#include "support/shape.h"
#include "support/test.h"

#include "support/devices.h"
#include "support/trees.h"

enum { TRIANGLES = 300 };

// Triangles in all directions, at places that no float holds.
static shape *draw_soup(rng *r)
{
    shape *s = shape_new();
    const double origin[3] = {0.3, -0.1, 0.7};
    memcpy(s->mesh.origin, origin, sizeof origin);
    for (uint32_t i = 0; i < TRIANGLES; ++i) {
        double at[3][3];
        for (int k = 0; k < 3; ++k) {
            double middle = rng_between(r, -5, 5);
            for (int c = 0; c < 3; ++c)
                at[c][k] = middle + rng_normal(r);
        }
        shape_own_triangle(s, at);
    }
    return s;
}

static shape *shape_of(double corners[3][3])
{
    shape *s = shape_new();
    shape_own_triangle(s, corners);
    return s;
}

static duet_tree *take_soup(duet_tree *tree, const shape *s)
{
    must(duet_tree_set_mesh(tree, &s->mesh, ERR));
    return tree;
}

// ---------------------------------------------------------------- truth

static triangle triangle_of(const shape *s, uint32_t i)
{
    triangle t;
    for (int corner = 0; corner < 3; ++corner)
        for (int k = 0; k < 3; ++k)
            t.at[corner][k] = s->mesh.origin[k] + (double)s->vertices[9 * i + 3 * corner + k];
    return t;
}

static double distance_to(const triangle *t, vector p)
{
    vector corner[3];
    for (int c = 0; c < 3; ++c)
        corner[c] = (vector){(double)t->at[c][0], (double)t->at[c][1], (double)t->at[c][2]};
    return triangle_distance(p, corner);
}

static real cast(const void *ground, const duet_ray *ray)
{
    const shape *s = ground;
    real best = INFINITY;
    for (uint32_t i = 0; i < s->mesh.n_triangles; ++i) {
        triangle t = triangle_of(s, i);
        best = fminl(best, triangle_pass(&t, ray));
    }
    return best <= (real)ray->t_max ? best : INFINITY;
}

static real distance(const void *ground, const real at[3])
{
    return shape_distance(ground, (vector){(double)at[0], (double)at[1], (double)at[2]});
}

// ---------------------------------------------------------------- rays and points

TEST(rays_meet_a_mesh_where_all_its_triangles_say)
{
    rng r = rng_seed(test_seed());
    shape *s = draw_soup(&r);
    const ground_truth truth = {s, cast, distance, false, -8};
    ground_truth_check_rays(&truth, take_soup(open_tree(3, 0, NULL, 0), s), &r);
}

// The nearest are the mesh, one box, and nothing.
TEST(a_mesh_is_as_far_as_all_its_triangles_say)
{
    rng r = rng_seed(test_seed());
    shape *s = draw_soup(&r);
    const duet_pose box = {
        .centre = {9, 0, 0}, .half_extents = {1, 1, 1}, .rotation = {0, 0, 0, 1}};
    const ground_truth truth = {s, cast, distance, false, -11};
    ground_truth_check_points(&truth, take_soup(open_tree(3, 0, &box, 1), s), &r);
}

// Through a triangle from both sides, along the normal by a closed form.
TEST(a_normal_looks_at_the_ray_from_either_side)
{
    shape *s = shape_of((double[3][3]){{0, 0, 0}, {4, 0, 3}, {0, 4, 0}});
    const duet_ray rays[2] = {{{1, 1, 5}, {0, 0, -1}, 9}, {{1, 1, -5}, {0, 0, 1}, 9}};
    duet_tree *tree = take_soup(open_tree(3, 0, NULL, 0), s);
    duet_ray_query_result found =
        cast_rays(open_ray_query(tree, DUET_QUERY_CLOSEST, true), rays, 2);
    for (int i = 0; i < 2; ++i) {
        const double sign = i == 0 ? 1 : -1;
        const float *n = found.normals[i].normal;
        assert_close(found.hits[i].t, i == 0 ? 4.25 : 5.75, 1e-6);
        assert_close(n[0], -0.6 * sign, 1e-6);
        assert_close(n[1], 0, 1e-6);
        assert_close(n[2], 0.8 * sign, 1e-6);
    }
}

// ---------------------------------------------------------------- whole numbers

typedef struct whole {
    int64_t at[3];
} whole;

static whole whole_less(whole a, whole b)
{
    return (whole){{a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2]}};
}

static whole whole_cross(whole u, whole v)
{
    whole w;
    for (int k = 0; k < 3; ++k)
        w.at[k] = u.at[(k + 1) % 3] * v.at[(k + 2) % 3] - u.at[(k + 2) % 3] * v.at[(k + 1) % 3];
    return w;
}

static int64_t whole_dot(whole u, whole v)
{
    return u.at[0] * v.at[0] + u.at[1] * v.at[1] + u.at[2] * v.at[2];
}

static int sign_of(int64_t n)
{
    return (n > 0) - (n < 0);
}

// On which side of the line from a to b a place of their plane is, seen along the normal.
static int side_of(whole a, whole b, whole at, whole normal)
{
    return sign_of(whole_dot(normal, whole_cross(whole_less(b, a), whole_less(at, a))));
}

// Whether a place of a triangle's plane is on the triangle. Places are times a scale.
static bool is_on(const whole t[3], whole at, int64_t scale, whole normal)
{
    bool on = true;
    for (int i = 0; i < 3; ++i) {
        whole a = t[i], b = t[(i + 1) % 3];
        for (int k = 0; k < 3; ++k) {
            a.at[k] *= scale;
            b.at[k] *= scale;
        }
        on = on && side_of(a, b, at, normal) >= 0;
    }
    return on;
}

// Whether two segments in one plane meet.
static bool segments_cross(whole a, whole b, whole c, whole d, whole normal)
{
    int c_side = side_of(a, b, c, normal), d_side = side_of(a, b, d, normal);
    int a_side = side_of(c, d, a, normal), b_side = side_of(c, d, b, normal);
    if (c_side == 0 && d_side == 0) { // on one line
        bool apart = false;
        for (int k = 0; k < 3; ++k)
            apart =
                apart ||
                (a.at[k] < c.at[k] && a.at[k] < d.at[k] && b.at[k] < c.at[k] &&
                 b.at[k] < d.at[k]) ||
                (a.at[k] > c.at[k] && a.at[k] > d.at[k] && b.at[k] > c.at[k] && b.at[k] > d.at[k]);
        return !apart;
    }
    return c_side * d_side <= 0 && a_side * b_side <= 0;
}

static bool segment_meets(whole p, whole q, const whole t[3])
{
    whole normal = whole_cross(whole_less(t[1], t[0]), whole_less(t[2], t[0]));
    int64_t at_p = whole_dot(normal, whole_less(p, t[0]));
    int64_t at_q = whole_dot(normal, whole_less(q, t[0]));
    if (at_p == 0 && at_q == 0) {
        whole way = whole_less(q, p);
        bool meets = is_on(t, p, 1, normal) || is_on(t, q, 1, normal);
        for (int i = 0; i < 3 && whole_dot(way, way) > 0; ++i)
            meets = meets || segments_cross(p, q, t[i], t[(i + 1) % 3], normal);
        return meets;
    }
    if (sign_of(at_p) * sign_of(at_q) > 0)
        return false;
    int64_t scale = at_p - at_q;
    whole at;
    for (int k = 0; k < 3; ++k)
        at.at[k] = p.at[k] * -at_q + q.at[k] * at_p;
    if (scale < 0)
        for (int k = 0; k < 3; ++k)
            at.at[k] = -at.at[k];
    return is_on(t, at, scale < 0 ? -scale : scale, normal);
}

static bool is_within(whole at, whole lower, whole upper)
{
    bool within = true;
    for (int k = 0; k < 3; ++k)
        within = within && at.at[k] >= lower.at[k] && at.at[k] <= upper.at[k];
    return within;
}

// Twelve edges of the box and the triangle, three edges of the triangle and six faces of the box,
// or one lies in the other.
static bool box_meets(whole lower, whole upper, const whole t[3])
{
    bool meets = false;
    for (int i = 0; i < 3; ++i)
        meets = meets || is_within(t[i], lower, upper);
    for (int edge = 0; edge < 12 && !meets; ++edge) {
        int k = edge / 4;
        whole p = lower, q;
        p.at[(k + 1) % 3] = edge & 1 ? upper.at[(k + 1) % 3] : lower.at[(k + 1) % 3];
        p.at[(k + 2) % 3] = edge & 2 ? upper.at[(k + 2) % 3] : lower.at[(k + 2) % 3];
        q = p;
        q.at[k] = upper.at[k];
        meets = segment_meets(p, q, t);
    }
    for (int half = 0; half < 12 && !meets; ++half) {
        whole face[3] = {lower, lower, upper};
        int k = half / 4, u = (k + 1) % 3, v = (k + 2) % 3;
        for (int i = 0; i < 3; ++i)
            face[i].at[k] = half & 1 ? upper.at[k] : lower.at[k];
        face[1].at[half & 2 ? u : v] = upper.at[half & 2 ? u : v];
        if (lower.at[u] == upper.at[u] || lower.at[v] == upper.at[v])
            continue; // its edges are all of it
        for (int i = 0; i < 3; ++i)
            meets = meets || segment_meets(t[i], t[(i + 1) % 3], face);
    }
    return meets;
}

static whole draw_whole(rng *r, int64_t most)
{
    whole w;
    for (int k = 0; k < 3; ++k)
        w.at[k] = (int64_t)rng_below(r, (uint64_t)(2 * most + 1)) - most;
    return w;
}

static void draw_triangle(rng *r, whole t[3])
{
    whole normal = {{0, 0, 0}};
    while (whole_dot(normal, normal) == 0) {
        for (int i = 0; i < 3; ++i)
            t[i] = draw_whole(r, 3);
        if (rng_below(r, 3) == 0) // in a plane with much else
            for (int i = 0; i < 3; ++i)
                t[i].at[2] = 0;
        normal = whole_cross(whole_less(t[1], t[0]), whole_less(t[2], t[0]));
    }
}

static shape *shape_of_whole(const whole t[3])
{
    double at[3][3];
    for (int i = 0; i < 9; ++i)
        at[i / 3][i % 3] = (double)t[i / 3].at[i % 3];
    return shape_of(at);
}

static void set_floats(float to[3], whole from)
{
    for (int k = 0; k < 3; ++k)
        to[k] = (float)from.at[k];
}

// Rays that end, and points: half of them in planes, on edges or through corners.
TEST(rays_and_points_of_whole_numbers_meet_exactly)
{
    enum { EACH = 60 };
    rng r = rng_seed(test_seed());
    uint32_t met = 0, points_met = 0;
    duet_tree *tree = open_tree(3, 0, NULL, 0);
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_ANY, false);
    duet_point_query *contains = open_point_query(tree, 0);
    for (int round = 0; round < 60; ++round) {
        whole t[3], p[EACH], q[EACH];
        duet_ray rays[EACH];
        duet_point points[EACH];
        draw_triangle(&r, t);
        shape *s = shape_of_whole(t);
        take_soup(tree, s);
        for (int i = 0; i < EACH; ++i) {
            p[i] = draw_whole(&r, 3);
            q[i] = draw_whole(&r, 3);
            rays[i].t_max = 1;
            set_floats(rays[i].origin, p[i]);
            set_floats(rays[i].direction, whole_less(q[i], p[i]));
            set_floats(points[i].at, p[i]);
        }
        duet_ray_query_result found = cast_rays(query, rays, EACH);
        duet_point_query_result in = seek_points(contains, points, EACH);
        for (uint32_t i = 0, at = 0; i < EACH; ++i) {
            bool is_hit = found.hits[i].id != DUET_NO_OBJECT;
            bool is_in = at < in.n_hits && in.hits[at].point == i;
            assert_true(is_hit == segment_meets(p[i], q[i], t));
            assert_true(is_in == segment_meets(p[i], p[i], t));
            met += is_hit;
            at += is_in;
            points_met += is_in;
        }
    }
    assert_true(met > 300 && points_met > 20);
}

// Boxes, plates, sticks and points with edges of even lengths.
TEST(boxes_of_whole_numbers_meet_exactly)
{
    enum { EACH = 60 };
    rng r = rng_seed(test_seed());
    uint32_t met = 0;
    duet_tree *poses = open_tree(3, 0, NULL, 0), *bounds = open_bounds_tree(3, 0, NULL, 0);
    duet_box_query *of_poses = open_box_query(poses), *of_bounds = open_box_query(bounds);
    for (int round = 0; round < 60; ++round) {
        whole t[3], lower[EACH], upper[EACH];
        duet_pose pose[EACH];
        duet_bounds bound[EACH];
        draw_triangle(&r, t);
        shape *s = shape_of_whole(t);
        take_soup(poses, s);
        take_soup(bounds, s);
        for (int i = 0; i < EACH; ++i) {
            lower[i] = draw_whole(&r, 3);
            for (int k = 0; k < 3; ++k) {
                upper[i].at[k] = lower[i].at[k] + (int64_t)rng_below(&r, 3);
                pose[i].centre[k] = (float)(lower[i].at[k] + upper[i].at[k]) / 2;
                pose[i].half_extents[k] = (float)(upper[i].at[k] - lower[i].at[k]) / 2;
                pose[i].rotation[k] = 0;
            }
            pose[i].rotation[3] = 1;
            set_floats(bound[i].lower, lower[i]);
            set_floats(bound[i].upper, upper[i]);
        }
        const duet_box_query_result found[2] = {
            join_boxes(of_poses, DUET_OBJECT_POSES, pose, EACH),
            join_boxes(of_bounds, DUET_OBJECT_BOUNDS, bound, EACH)};
        for (uint32_t i = 0, at[2] = {0, 0}; i < EACH; ++i) {
            bool expected = box_meets(lower[i], upper[i], t);
            for (int k = 0; k < 2; ++k) {
                bool is_hit = at[k] < found[k].n_hits && found[k].hits[at[k]].box == i;
                if (is_hit != expected)
                    fail_msg("round %d, box %u as %s: %s", round, i, k ? "bounds" : "a pose",
                             is_hit ? "met" : "missed");
                at[k] += is_hit;
            }
            met += expected;
        }
    }
    assert_true(met > 100);
}

// ---------------------------------------------------------------- boxes and sweeps

// Whether something of a triangle is in a box that is larger on all sides.
static bool reaches(const triangle *t, const block *b, real larger)
{
    real at[12][3], in[12];
    int n = 3;
    for (int c = 0; c < 3; ++c) {
        real way[3];
        real_less(way, t->at[c], b->centre);
        for (int k = 0; k < 3; ++k)
            at[c][k] = real_dot(way, b->axis[k]);
    }
    for (int face = 0; face < 6 && n > 0; ++face) {
        int k = face / 2, side = face % 2 ? 1 : -1;
        for (int i = 0; i < n; ++i)
            in[i] = b->half[k] + larger - side * at[i][k];
        n = polygon_clip(at, n, in);
    }
    return n > 0;
}

static bool any_reaches(const shape *s, const block *b, real larger)
{
    bool any = false;
    for (uint32_t i = 0; i < s->mesh.n_triangles && !any; ++i) {
        triangle t = triangle_of(s, i);
        any = reaches(&t, b, larger);
    }
    return any;
}

static duet_pose draw_box(rng *r)
{
    duet_pose box;
    for (int k = 0; k < 3; ++k) {
        box.centre[k] = (float)rng_between(r, -6, 6);
        box.half_extents[k] = (float)rng_between(r, 0.05, 0.4);
    }
    turn_at_random(&box, r);
    return box;
}

TEST(boxes_meet_a_mesh_if_something_of_a_triangle_is_in_them)
{
    enum { BOXES = 400 };
    rng r = rng_seed(test_seed());
    shape *s = draw_soup(&r);
    duet_pose boxes[BOXES];
    uint32_t met = 0;
    for (int i = 0; i < BOXES; ++i)
        boxes[i] = draw_box(&r);
    duet_tree *tree = take_soup(open_tree(3, 0, NULL, 0), s);
    duet_box_query_result found = join_boxes(open_box_query(tree), DUET_OBJECT_POSES, boxes, BOXES);
    for (uint32_t i = 0; i < BOXES; ++i) {
        block b = block_of(&boxes[i]);
        bool is_hit = met < found.n_hits && found.hits[met].box == i;
        if (is_hit ? !any_reaches(s, &b, 1e-9L) : any_reaches(s, &b, -1e-9L))
            fail_msg("box %u: %s", i, is_hit ? "met" : "missed");
        met += is_hit;
    }
    assert_true(met > BOXES / 8 && met < BOXES * 7 / 8);
}

// Nowhere before, at twenty places; there; and no more of what it met when it is pushed along the
// normal.
static void check_sweep(const shape *s, const duet_sweep *sweep, const duet_sweep_hit *hit)
{
    bool met = hit->id != DUET_NO_OBJECT;
    real last = met ? (real)hit->t : (real)sweep->t_max, square = 0;
    for (int i = 0; i <= 20 && last > 0; ++i) {
        block b = block_moved(sweep, (1 - 1e-6L) * last * i / 20);
        if (any_reaches(s, &b, -1e-5L))
            fail_msg("sweep %u meets the mesh before %.9Lg", hit->sweep, last);
    }
    if (!met)
        return;
    block at = block_moved(sweep, last), pushed = at;
    if (!any_reaches(s, &at, 1e-5L))
        fail_msg("sweep %u does not meet the mesh at %.9Lg", hit->sweep, last);
    for (int k = 0; k < 3; ++k) {
        pushed.centre[k] += 1e-4L * (real)hit->normal[k];
        square += (real)hit->normal[k] * (real)hit->normal[k];
    }
    assert_true(hit->t == 0 ? square == 0 : fabsl(square - 1) < 1e-6L);
    for (uint32_t i = 0; i < s->mesh.n_triangles && hit->t > 0; ++i) {
        triangle t = triangle_of(s, i);
        if (reaches(&t, &at, 1e-5L) && reaches(&t, &pushed, 1e-5L))
            fail_msg("sweep %u: the normal does not lead from triangle %u", hit->sweep, i);
    }
}

TEST(sweeps_meet_a_mesh_there_and_not_before)
{
    enum { SWEEPS = 150 };
    rng r = rng_seed(test_seed());
    shape *s = draw_soup(&r);
    duet_sweep sweeps[SWEEPS];
    uint32_t met = 0;
    for (int i = 0; i < SWEEPS; ++i) {
        sweeps[i] = (duet_sweep){.box = draw_box(&r), .t_max = 4};
        for (int k = 0; k < 3; ++k)
            sweeps[i].direction[k] = (float)rng_normal(&r);
    }
    duet_tree *tree = take_soup(open_tree(3, 0, NULL, 0), s);
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_CLOSEST);
    duet_sweep_query_result found = run_sweeps(query, DUET_OBJECT_POSES, sweeps, SWEEPS);
    for (uint32_t i = 0; i < SWEEPS; ++i) {
        check_sweep(s, &sweeps[i], &found.hits[i]);
        met += found.hits[i].id != DUET_NO_OBJECT && found.hits[i].t > 0;
    }
    assert_true(met > SWEEPS / 10 && met < SWEEPS);
}

// ---------------------------------------------------------------- with radii

// The least distance of places along a stick: it is convex against one triangle.
static double stick_distance(const shape *s, const duet_pose *stick, const float direction[3],
                             double t)
{
    block b = block_of(stick);
    double best = INFINITY;
    for (uint32_t i = 0; i < s->mesh.n_triangles; ++i) {
        triangle corners = triangle_of(s, i);
        double from = -1, to = 1;
        for (int step = 0; step < 60; ++step) {
            double far[2], along[2] = {from + (to - from) / 3, to - (to - from) / 3};
            for (int m = 0; m < 2; ++m) {
                double p[3];
                for (int k = 0; k < 3; ++k)
                    p[k] = (double)(b.centre[k] + along[m] * b.half[0] * b.axis[0][k]) +
                           t * (double)direction[k];
                far[m] = distance_to(&corners, (vector){p[0], p[1], p[2]});
                best = fmin(best, far[m]);
            }
            *(far[0] < far[1] ? &to : &from) = far[0] < far[1] ? along[1] : along[0];
        }
    }
    return best;
}

// Balls and capsules: as far from the mesh as their radius where they touch, and further before.
TEST(capsules_meet_a_mesh_a_radius_away)
{
    enum { SWEEPS = 60 };
    rng r = rng_seed(test_seed());
    shape *s = draw_soup(&r);
    duet_rounded_sweep sweeps[SWEEPS];
    duet_rounded_box boxes[SWEEPS];
    uint32_t met = 0, joins = 0;
    for (int i = 0; i < SWEEPS; ++i) {
        sweeps[i] = (duet_rounded_sweep){
            .box = {.pose = draw_box(&r), .radius = (float)rng_between(&r, 0.1, 0.4)}, .t_max = 4};
        float *half = sweeps[i].box.pose.half_extents;
        half[0] = i % 2 ? half[0] : 0;
        half[1] = half[2] = 0;
        for (int k = 0; k < 3; ++k)
            sweeps[i].direction[k] = (float)rng_normal(&r);
        boxes[i] = sweeps[i].box;
    }
    duet_tree *tree = take_soup(open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, NULL, 0), s);
    duet_box_query_result joined =
        join_boxes(open_box_query(tree), DUET_OBJECT_ROUNDED_BOXES, boxes, SWEEPS);
    duet_sweep_query_result found = run_sweeps(open_sweep_query(tree, DUET_QUERY_CLOSEST),
                                               DUET_OBJECT_ROUNDED_BOXES, sweeps, SWEEPS);
    for (uint32_t i = 0; i < SWEEPS; ++i) {
        const duet_sweep_hit *hit = &found.hits[i];
        const double radius = (double)sweeps[i].box.radius;
        bool is_hit = hit->id != DUET_NO_OBJECT;
        double last = is_hit ? (double)hit->t : 4, far = 0;
        bool is_in = joins < joined.n_hits && joined.hits[joins].box == i;
        assert_true(is_in == (is_hit && hit->t == 0));
        joins += is_in;
        for (int n = 0; n <= 10; ++n) {
            far = stick_distance(s, &sweeps[i].box.pose, sweeps[i].direction, last * n / 10);
            if (far < radius - 1e-5 && last > 0)
                fail_msg("capsule %u meets the mesh before %.9g", i, last);
        }
        if (!is_hit)
            continue;
        if (!(hit->t == 0 ? far <= radius : fabs(far - radius) < 1e-5))
            fail_msg("capsule %u is %.9g from the mesh, not its radius", i, far);
        met += hit->t > 0;
    }
    assert_true(met > SWEEPS / 8);
}

// Boxes with a radius and their cores at a closed form: over a floor, over its edge and its corner.
TEST(rounded_boxes_meet_a_floor_at_closed_forms)
{
    shape *s = shape_of((double[3][3]){{0, 0, 0}, {8, 0, 0}, {0, 8, 0}});
    const duet_rounded_sweep sweeps[] = {
        {{{{2, 2, 5}, {1, 0.5f, 0.25f}, {0, 0, 0, 1}}, 0.5f}, {0, 0, -1}, 9}, // down
        {{{{2, 2, -5}, {1, 0.5f, 0.25f}, {0, 0, 0, 1}}, 0.5f}, {0, 0, 1}, 9}, // up, from behind
        {{{{2, -5, 0.3f}, {1, 0.5f, 0}, {0, 0, 0, 1}}, 0.5f}, {0, 1, 0}, 9},  // to its edge
        {{{{-5, -5, 0}, {0, 0, 1}, {0, 0, 0, 1}}, 0.5f}, {1, 1, 0}, 9},       // to its corner
    };
    const double expected[] = {4.25, 4.25, 5 - 0.5 - 0.4, 5 - 0.5 / sqrt(2)};
    const double normal[][3] = {{0, 0, 1}, {0, 0, -1}, {0, -0.8, 0.6}, {-sqrt(0.5), -sqrt(0.5), 0}};
    duet_tree *tree = take_soup(open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, NULL, 0), s);
    duet_sweep_query_result found = run_sweeps(open_sweep_query(tree, DUET_QUERY_CLOSEST),
                                               DUET_OBJECT_ROUNDED_BOXES, sweeps, 4);
    for (int i = 0; i < 4; ++i) {
        assert_close(found.hits[i].t, expected[i], 1e-5);
        for (int k = 0; k < 3; ++k)
            assert_close(found.hits[i].normal[k], normal[i][k], 1e-5);
    }
}

// ---------------------------------------------------------------- a tree's ground

TEST(a_mesh_takes_the_place_of_heights_and_is_given_back)
{
    static const float flat[4] = {0, 0, 0, 0};
    const duet_heights heights = {
        .nx = 2, .ny = 2, .origin = {-9, -9, 2}, .spacing = {18, 18}, .heights = flat};
    const duet_ray down = {.origin = {0, 0, 5}, .direction = {0, 0, -1}, .t_max = 9};
    shape *s = shape_of((double[3][3]){{-9, -9, 1}, {9, -9, 1}, {0, 9, 1}});
    static const uint32_t shares[] = {0, DUET_SHARE_ONE / 3, DUET_SHARE_ONE};
    for (int i = 0; i < 3; ++i) {
        duet_tree *tree = open_tree(3, shares[i], NULL, 0);
        duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, false);
        must(duet_tree_set_heights(tree, &heights, ERR));
        assert_close(cast_rays(query, &down, 1).hits[0].t, 3, 0);
        take_soup(tree, s);
        assert_close(cast_rays(query, &down, 1).hits[0].t, 4, 0);
        must(duet_tree_set_mesh(tree, NULL, ERR));
        assert_int_equal(cast_rays(query, &down, 1).hits[0].id, DUET_NO_OBJECT);
    }
}

TEST(meshes_that_no_tree_can_have_are_refused)
{
    rng r = rng_seed(1);
    shape *s = draw_soup(&r);
    duet_tree *flat = open_tree(2, 0, NULL, 0), *tree = open_tree(3, 0, NULL, 0);
    must_fail(duet_tree_set_mesh(flat, &s->mesh, ERR), DUET_STATUS_BAD_ARGUMENT,
              "meshes are for trees in 3D");
    s->mesh.origin[1] = 1e20;
    must_fail(duet_tree_set_mesh(tree, &s->mesh, ERR), DUET_STATUS_BAD_ARGUMENT,
              "the mesh's origin is 1e+20 along y");
    s->triangles[5] = 3 * TRIANGLES;
    must_fail(duet_tree_set_mesh(tree, &s->mesh, ERR), DUET_STATUS_BAD_ARGUMENT,
              "triangle 1 of the mesh has the vertex 900");
}
