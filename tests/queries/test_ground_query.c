// SPDX-License-Identifier: MIT
// Rays and points against a ground of heights: all triangles and walls in long double, touching
// rays to the last bit, and the ground among objects.
#include "support/ground_truth.h"
#include "support/test.h"

#include "support/devices.h"
#include "support/hits.h"
#include "support/trees.h"

enum { NX = 13, NY = 9 };

static const uint32_t shares[] = {0, DUET_SHARE_ONE / 3, DUET_SHARE_ONE};

typedef struct field {
    duet_heights heights;
    float values[NX * NY];
} field;

// Rough in the middle, and places that no float holds.
static field *draw_field(rng *r)
{
    field *f = test_alloc(sizeof *f);
    f->heights = (duet_heights){.nx = NX,
                                .ny = NY,
                                .origin = {-4.1, -3.3, 0.7},
                                .spacing = {0.7, 0.9},
                                .heights = f->values};
    for (int i = 0; i < NX * NY; ++i)
        f->values[i] = (float)rng_between(r, -1, 1);
    return f;
}

// ---------------------------------------------------------------- truth

static void place(const field *f, uint32_t i, uint32_t j, real at[3])
{
    at[0] = fma(i, f->heights.spacing[0], f->heights.origin[0]);
    at[1] = fma(j, f->heights.spacing[1], f->heights.origin[1]);
    at[2] = f->heights.origin[2] + (double)f->values[j * NX + i];
}

enum { TRIANGLES = 2 * (NX - 1) * (NY - 1) };

static triangle triangle_of(const field *f, uint32_t k)
{
    uint32_t i = k / 2 % (NX - 1), j = k / 2 / (NX - 1);
    triangle t;
    place(f, i, j, t.at[0]);
    place(f, i + 1, k % 2 ? j + 1 : j, t.at[1]);
    place(f, k % 2 ? i : i + 1, j + 1, t.at[2]);
    return t;
}

// The height over a place of the grid; NAN beside it.
static real height_at(const field *f, real x, real y)
{
    for (uint32_t k = 0; k < TRIANGLES; ++k) {
        triangle t = triangle_of(f, k);
        real e1[3], e2[3], way[3] = {x - t.at[0][0], y - t.at[0][1], 0};
        real_less(e1, t.at[1], t.at[0]);
        real_less(e2, t.at[2], t.at[0]);
        real det = e1[0] * e2[1] - e1[1] * e2[0];
        real u = (way[0] * e2[1] - way[1] * e2[0]) / det,
             v = (e1[0] * way[1] - e1[1] * way[0]) / det;
        if (u >= -1e-15L && v >= -1e-15L && u + v <= 1 + 1e-15L) // a wall's rim is rounded
            return t.at[0][2] + u * e1[2] + v * e2[2];
    }
    return NAN;
}

// How far above the ground a point is that is over it; NAN: it is beside it.
static real above(const field *f, const real at[3])
{
    return at[2] - height_at(f, at[0], at[1]);
}

static void point_at(const duet_ray *ray, real t, real at[3])
{
    for (int k = 0; k < 3; ++k)
        at[k] = (real)ray->origin[k] + t * (real)ray->direction[k];
}

// Finds where a ray passes the wall of one of four sides.
static real pass_wall(const field *f, const duet_ray *ray, int side)
{
    real corner[3], at[3];
    place(f, side == 1 ? NX - 1 : 0, side == 3 ? NY - 1 : 0, corner);
    int k = side / 2;
    real t = (corner[k] - (real)ray->origin[k]) / (real)ray->direction[k];
    if (!(t >= 0))
        return INFINITY;
    point_at(ray, t, at);
    at[k] = corner[k];
    return above(f, at) <= 0 ? t : INFINITY;
}

static real cast(const void *ground, const duet_ray *ray)
{
    const field *f = ground;
    real from[3], best = INFINITY;
    point_at(ray, 0, from);
    if (above(f, from) <= 0)
        return 0;
    for (uint32_t k = 0; k < TRIANGLES; ++k) {
        triangle t = triangle_of(f, k);
        best = fminl(best, triangle_pass(&t, ray));
    }
    for (int side = 0; side < 4; ++side)
        best = fminl(best, pass_wall(f, ray, side));
    return best <= (real)ray->t_max ? best : INFINITY;
}

// ---------------------------------------------------------------- rays

static duet_ray draw_ray(rng *r)
{
    duet_ray ray = {.t_max = rng_below(r, 4) ? INFINITY : (float)rng_between(r, 0, 6)};
    for (int k = 0; k < 3; ++k) {
        ray.origin[k] = (float)rng_between(r, k == 2 ? -2 : -7, 7);
        ray.direction[k] = (float)(rng_normal(r) * (k == 2 ? 0.5 : 1));
    }
    int kind = (int)rng_below(r, 8);
    if (kind < 2) // upright, or along an axis
        ray.direction[kind] = ray.direction[kind == 0 ? 1 : 2] = 0;
    if (kind == 2)
        ray.direction[0] = ray.direction[1] = ray.direction[2] = 0;
    return ray;
}

static duet_tree *open_ground(const field *f, uint32_t share)
{
    duet_tree *tree = open_tree(3, share, NULL, 0);
    must(duet_tree_set_heights(tree, &f->heights, ERR));
    return tree;
}

TEST(rays_meet_the_ground_where_all_its_triangles_say)
{
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    const ground_truth truth = {f, cast, NULL, true, -2};
    ground_truth_check_rays(&truth, open_ground(f, 0), &r);
}

// The gradient of the height, by differences.
TEST(a_normal_is_that_of_the_slope)
{
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    duet_ray rays[200];
    for (int i = 0; i < 200; ++i)
        rays[i] =
            (duet_ray){.origin = {(float)rng_between(&r, -4, 4), (float)rng_between(&r, -3, 3), 5},
                       .direction = {0, 0, -2},
                       .t_max = INFINITY};
    duet_tree *tree = open_ground(f, 0);
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_CLOSEST, true);
    duet_ray_query_result found = cast_rays(query, rays, 200);
    for (int i = 0; i < 200; ++i) {
        real x = rays[i].origin[0], y = rays[i].origin[1], step = 1e-7L;
        real dx = height_at(f, x + step, y) - height_at(f, x - step, y);
        real dy = height_at(f, x, y + step) - height_at(f, x, y - step);
        const float *n = found.normals[i].normal;
        assert_true(fabsl((real)n[0] / (real)n[2] + dx / (2 * step)) < 1e-4L);
        assert_true(fabsl((real)n[1] / (real)n[2] + dy / (2 * step)) < 1e-4L);
    }
}

// ---------------------------------------------------------------- to the last bit

static bool meets(duet_ray_query *query, duet_ray ray)
{
    return cast_rays(query, &ray, 1).hits[0].id != DUET_NO_OBJECT;
}

// A roof of height 1 along x at y = 1, in cells of edge 1: rays over its ridge, along it, through a
// corner and down a wall.
TEST(what_only_touches_is_met)
{
    static const float roof[] = {0, 0, 0, 1, 1, 1, 0, 0, 0};
    const duet_heights heights = {.nx = 3, .ny = 3, .spacing = {1, 1}, .heights = roof};
    duet_tree *tree = open_tree(3, 0, NULL, 0);
    must(duet_tree_set_heights(tree, &heights, ERR));
    duet_ray_query *query = open_ray_query(tree, DUET_QUERY_ANY, false);
    static const duet_ray touching[] = {
        {{0.3f, -5, 1}, {0, 1, 0}, 100},        // over the ridge
        {{-5, 1, 1}, {1, 0, 0}, 100},           // along it
        {{0.3f, 3, 1}, {0.7f, -1, 0}, 2},       // ends over it, and at an angle
        {{-1, -1, 1}, {1, 1, 0}, 2},            // through a corner, where it ends
        {{1, 1, 4}, {0, 0, -3}, 1},             // down to a corner
        {{1, -1, -1}, {0, 1, 1}, 9},            // up the slope
        {{1, 1, 1}, {0, 0, 0}, 9},              // stays on a corner
        {{1, 2, -7}, {1, 0, 0}, 0},             // begins on a wall
        {{0.1f, 2, 5}, {0.2f, 0, -1}, INFINITY} // down along a wall's plane
    };
    static const int up[] = {2, 2, 2, 2, 2, 2, 2, 1, 1}; // the axis along which it is free
    for (size_t i = 0; i < sizeof touching / sizeof *touching; ++i) {
        duet_ray ray = touching[i];
        assert_true(meets(query, ray));
        ray.origin[up[i]] = nextafterf(ray.origin[up[i]], INFINITY);
        if (meets(query, ray))
            fail_msg("ray %zu is a bit beside the ground, and meets it", i);
    }
}

// Points a few bits about the surface, of places that no float holds: exact in long double, whose
// rounding is a thousandth of a double's.
TEST(points_beside_the_surface_are_told_apart)
{
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    duet_tree *tree = open_ground(f, 0);
    duet_point_query *query = open_point_query(tree, 0);
    duet_point points[300];
    bool expected[300];
    uint32_t n = 0, in = 0;
    while (n < 300) {
        real x = (float)rng_between(&r, -4, 4), y = (float)rng_between(&r, -3, 3);
        float z = (float)height_at(f, x, y);
        for (int bits = (int)rng_below(&r, 3); bits > 0; --bits)
            z = nextafterf(z, INFINITY);
        real high = (real)z - height_at(f, x, y);
        if (fabsl(high) < 1e-17L)
            continue;
        points[n] = (duet_point){{(float)x, (float)y, z}};
        expected[n++] = high < 0;
    }
    duet_point_query_result found = seek_points(query, points, n);
    for (uint32_t i = 0; i < n; ++i)
        if (expected[i]) {
            assert_true(in < found.n_hits);
            assert_int_equal(found.hits[in].point, i);
            assert_int_equal(found.hits[in++].id, GROUND_ID);
        }
    assert_int_equal(found.n_hits, in);
    assert_true(in > 30 && in < 270);
}

// ---------------------------------------------------------------- distances

static real distance_to_segment(const real a[3], const real b[3], const real p[3])
{
    real e[3], way[3];
    real_less(e, b, a);
    real_less(way, p, a);
    real t = fminl(fmaxl(real_dot(e, way) / real_dot(e, e), 0), 1);
    for (int k = 0; k < 3; ++k)
        way[k] -= t * e[k];
    return sqrtl(real_dot(way, way));
}

static real distance_to_triangle(const triangle *t, const real p[3])
{
    real best = INFINITY, e1[3], e2[3], n[3], way[3];
    for (int k = 0; k < 3; ++k)
        best = fminl(best, distance_to_segment(t->at[k], t->at[(k + 1) % 3], p));
    real_less(e1, t->at[1], t->at[0]);
    real_less(e2, t->at[2], t->at[0]);
    real_less(way, p, t->at[0]);
    real_cross(n, e1, e2);
    real square = real_dot(n, n), out1[3], out2[3];
    real_cross(out1, way, e2);
    real_cross(out2, e1, way);
    real u = real_dot(out1, n) / square, v = real_dot(out2, n) / square;
    return u >= 0 && v >= 0 && u + v <= 1 ? fminl(best, fabsl(real_dot(way, n)) / sqrtl(square))
                                          : best;
}

// The nearest point of the wall under an edge: the distance is convex along it.
static real distance_to_wall(const real a[3], const real b[3], const real p[3])
{
    real from = 0, to = 1, best = INFINITY;
    for (int i = 0; i < 45; ++i) {
        real at[2] = {from + (to - from) / 3, to - (to - from) / 3}, far[2];
        for (int m = 0; m < 2; ++m) {
            real x = a[0] + at[m] * (b[0] - a[0]) - p[0], y = a[1] + at[m] * (b[1] - a[1]) - p[1];
            real z = fmaxl(0, p[2] - a[2] - at[m] * (b[2] - a[2]));
            far[m] = sqrtl(x * x + y * y + z * z);
            best = fminl(best, far[m]);
        }
        if (far[0] < far[1])
            to = at[1];
        else
            from = at[0];
    }
    return best;
}

static real distance(const void *ground, const real p[3])
{
    const field *f = ground;
    real best = INFINITY;
    if (above(f, p) <= 0)
        return 0;
    for (uint32_t k = 0; k < TRIANGLES; ++k) {
        triangle t = triangle_of(f, k);
        best = fminl(best, distance_to_triangle(&t, p));
    }
    for (uint32_t k = 0; k < 2 * (NX - 1 + NY - 1); ++k) {
        bool along_x = k < 2 * (NX - 1);
        uint32_t i = (along_x ? k : k - 2 * (NX - 1)) / 2,
                 other = k % 2 ? (along_x ? NY : NX) - 1 : 0;
        real a[3], b[3];
        place(f, along_x ? i : other, along_x ? other : i, a);
        place(f, along_x ? i + 1 : other, along_x ? other : i + 1, b);
        best = fminl(best, distance_to_wall(a, b, p));
    }
    return best;
}

// One box beside: both are the two nearest objects, in the right order.
TEST(the_ground_is_as_far_as_all_its_triangles_say)
{
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    const duet_pose box = {
        .centre = {9, 0, 0}, .half_extents = {1, 1, 1}, .rotation = {0, 0, 0, 1}};
    duet_tree *tree = open_tree(3, 0, &box, 1);
    must(duet_tree_set_heights(tree, &f->heights, ERR));
    const ground_truth truth = {f, cast, distance, true, -4};
    ground_truth_check_points(&truth, tree, &r);
}

// ---------------------------------------------------------------- boxes

// How far a point over or beside a triangle is inside its edge e, times the edge's length.
static real inside(const triangle *t, int e, const real p[3])
{
    const real *a = t->at[e], *b = t->at[(e + 1) % 3];
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

static real above_plane(const triangle *t, const real p[3])
{
    real e1[3], e2[3], n[3], way[3];
    real_less(e1, t->at[1], t->at[0]);
    real_less(e2, t->at[2], t->at[0]);
    real_less(way, p, t->at[0]);
    real_cross(n, e1, e2);
    return real_dot(n, way) / n[2];
}

// The corners of a face, clipped by the triangle's edges: the lowest one over its plane.
static real lowest_of_face(const triangle *t, const block *b, int axis, int side)
{
    real from[12][3], in[12], lowest = INFINITY;
    int n = 4, u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, first = side << axis;
    const int walk[4] = {first, first | u, first | u | v, first | v};
    for (int i = 0; i < 4; ++i)
        block_corner(b, walk[i], from[i]);
    for (int e = 0; e < 3; ++e) {
        for (int i = 0; i < n; ++i)
            in[i] = inside(t, e, from[i]);
        n = polygon_clip(from, n, in);
    }
    for (int i = 0; i < n; ++i)
        lowest = fminl(lowest, above_plane(t, from[i]));
    return lowest;
}

// How far the lowest place of a box is above the ground; INFINITY: it is beside it.
static real clearance(const field *f, const block *b)
{
    real lowest = INFINITY;
    for (uint32_t k = 0; k < TRIANGLES; ++k) {
        triangle t = triangle_of(f, k);
        for (int i = 0; i < 6; ++i)
            lowest = fminl(lowest, lowest_of_face(&t, b, i / 2, i % 2));
    }
    return lowest;
}

static duet_pose draw_box(rng *r, bool upright)
{
    duet_pose box = {.rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k) {
        box.centre[k] = (float)rng_between(r, k == 2 ? 0 : -6, k == 2 ? 4 : 6);
        box.half_extents[k] = (float)rng_between(r, 0.1, 1.2);
    }
    for (int k = 0; k < 4 && !upright; ++k)
        box.rotation[k] = (float)rng_normal(r);
    return box;
}

static duet_tree *open_ground_of(const field *f, duet_shape shape)
{
    duet_tree *tree =
        shape == DUET_SHAPE_BOUNDS ? open_bounds_tree(3, 0, NULL, 0) : open_tree(3, 0, NULL, 0);
    must(duet_tree_set_heights(tree, &f->heights, ERR));
    return tree;
}

static void join_some(const field *f, rng *r, bool upright)
{
    enum { BOXES = 400 };
    duet_pose boxes[BOXES];
    duet_bounds bounds[BOXES];
    uint32_t met = 0;
    for (int i = 0; i < BOXES; ++i) {
        boxes[i] = draw_box(r, upright);
        bounds[i] = bounds_of_upright(&boxes[i]);
    }
    duet_tree *tree = open_ground_of(f, upright ? DUET_SHAPE_BOUNDS : DUET_SHAPE_POSES);
    duet_box_query *query = open_box_query(tree);
    duet_box_query_result found = upright ? join_boxes(query, DUET_OBJECT_BOUNDS, bounds, BOXES)
                                          : join_boxes(query, DUET_OBJECT_POSES, boxes, BOXES);
    for (uint32_t i = 0; i < BOXES; ++i) {
        block b = block_of(&boxes[i]);
        real high = clearance(f, &b);
        if (fabsl(high) < 1e-6L)
            continue; // bounds are rounded
        bool is_hit = met < found.n_hits && found.hits[met].box == i;
        if (is_hit != (high < 0))
            fail_msg("box %u: %s, and %Lg above", i, is_hit ? "met" : "missed", high);
        met += is_hit;
    }
    assert_int_equal(met, found.n_hits);
    assert_true(met > BOXES / 8 && met < BOXES * 7 / 8);
}

TEST(boxes_meet_the_ground_if_their_lowest_place_over_it_is_below)
{
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    join_some(f, &r, true);
    join_some(f, &r, false);
}

// Over the roof of 1 along x at y = 1: a box that stands on it, on its edge, beside a wall, and one
// whose edge crosses the ridge; each a bit higher, or further out.
TEST(boxes_that_only_touch_are_met)
{
    static const float roof[] = {0, 0, 0, 1, 1, 1, 0, 0, 0};
    field f = {.heights = {.nx = 3, .ny = 3, .spacing = {1, 1}, .heights = roof}};
    duet_tree *tree = open_ground_of(&f, DUET_SHAPE_POSES);
    duet_box_query *query = open_box_query(tree);
    static const duet_pose touching[] = {
        {{0.7f, 1, 1.5f}, {0.5f, 0.25f, 0.5f}, {0, 0, 0, 1}}, // stands on the ridge
        {{0.7f, 2.5f, 0.25f}, {0.5f, 0.5f, 2}, {0, 0, 0, 1}}, // at a wall
        {{1, 1, 2}, {1, 0.5f, 0.5f}, {0, 1, 0, 1}},           // on its end
        {{1, 1, 3}, {0, 0, 2}, {0, 0, 0.3f, 1}},              // an edge that ends on it
        {{-2, 1, 0.5f}, {2, 3, 0.5f}, {0, 0, 0, 1}},          // at the wall of x = 0
        {{1, 1, 1}, {3, 0, 0}, {0, 0, 0.6f, 0.8f}},           // an edge across the ridge
    };
    static const int free_along[] = {2, 1, 2, 2, 0, 2};
    for (size_t i = 0; i < sizeof touching / sizeof *touching; ++i) {
        duet_pose box = touching[i];
        int k = free_along[i];
        if (join_boxes(query, DUET_OBJECT_POSES, &box, 1).n_hits != 1)
            fail_msg("box %zu touches, and is not met", i);
        box.centre[k] = nextafterf(box.centre[k], k == 0 ? -INFINITY : INFINITY);
        if (join_boxes(query, DUET_OBJECT_POSES, &box, 1).n_hits != 0)
            fail_msg("box %zu is a bit beside the ground, and meets it", i);
    }
}

// ---------------------------------------------------------------- sweeps

// Nowhere before, at twenty places; there; and no more when it is pushed along the normal.
static void check_sweep(const field *f, const duet_sweep *sweep, const duet_sweep_hit *hit)
{
    bool met = hit->id != DUET_NO_OBJECT;
    real last = met ? (real)hit->t : (real)sweep->t_max;
    for (int i = 0; i <= 20 && last > 0; ++i) {
        block b = block_moved(sweep, (1 - 1e-6L) * last * i / 20);
        if (clearance(f, &b) < -1e-6L)
            fail_msg("sweep %u meets the ground before %.9Lg", hit->sweep, last);
    }
    if (!met)
        return;
    block b = block_moved(sweep, last + 1e-5L); // rounding may leave it before a wall
    real high = clearance(f, &b);
    if (!(high < 5e-5L))
        fail_msg("sweep %u is %Lg above the ground at %.9Lg", hit->sweep, high, last);
    b = block_moved(sweep, last);
    real square = 0, along = 0;
    for (int k = 0; k < 3; ++k) {
        b.centre[k] += 1e-4L * (real)hit->normal[k];
        square += (real)hit->normal[k] * (real)hit->normal[k];
        along += (real)hit->normal[k] * (real)sweep->direction[k];
    }
    if (hit->t == 0)
        assert_true(square == 0);
    else if (!(fabsl(square - 1) < 1e-6L && along < 1e-6L && clearance(f, &b) > 0))
        fail_msg("sweep %u: the normal is %Lg long, %Lg along the way, and leads to %Lg",
                 hit->sweep, square, along, clearance(f, &b));
}

TEST(sweeps_meet_the_ground_there_and_not_before)
{
    enum { SWEEPS = 120 };
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    for (int upright = 0; upright < 2; ++upright) {
        duet_sweep sweeps[SWEEPS];
        duet_bounds_sweep bounds[SWEEPS];
        uint32_t met = 0;
        for (int i = 0; i < SWEEPS; ++i) {
            sweeps[i] = (duet_sweep){.box = draw_box(&r, upright), .t_max = 4};
            sweeps[i].box.centre[2] += 1;
            for (int k = 0; k < 3; ++k)
                sweeps[i].direction[k] = (float)(rng_normal(&r) - (k == 2 ? 0.5 : 0));
            bounds[i] =
                (duet_bounds_sweep){.bounds = bounds_of_upright(&sweeps[i].box), .t_max = 4};
            memcpy(bounds[i].direction, sweeps[i].direction, sizeof bounds[i].direction);
        }
        duet_tree *tree = open_ground_of(f, upright ? DUET_SHAPE_BOUNDS : DUET_SHAPE_POSES);
        duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_CLOSEST);
        duet_sweep_query_result found = upright
                                            ? run_sweeps(query, DUET_OBJECT_BOUNDS, bounds, SWEEPS)
                                            : run_sweeps(query, DUET_OBJECT_POSES, sweeps, SWEEPS);
        for (uint32_t i = 0; i < SWEEPS; ++i) {
            check_sweep(f, &sweeps[i], &found.hits[i]);
            met += found.hits[i].id != DUET_NO_OBJECT && found.hits[i].t > 0;
        }
        assert_true(met > SWEEPS / 10 && met < SWEEPS);
        test_give_back(query);
        test_give_back(tree);
    }
}

// ---------------------------------------------------------------- with radii

// The distance of a core and the ground, which it does not meet: from places all over the core,
// ever nearer to the one that was nearest.
static real distance_of_core(const field *f, const block *b)
{
    real best = INFINITY, middle[3] = {0, 0, 0}, size = 1;
    for (int round = 0; round < 10; ++round, size *= 0.5L) {
        real from[3] = {middle[0], middle[1], middle[2]};
        for (int i = 0; i < 27; ++i) {
            real at[3], on[3] = {b->centre[0], b->centre[1], b->centre[2]};
            for (int k = 0; k < 3; ++k) {
                int side = (k == 0 ? i : k == 1 ? i / 3 : i / 9) % 3 - 1;
                at[k] = fminl(fmaxl(from[k] + size * side, -1), 1);
                for (int m = 0; m < 3; ++m)
                    on[m] += at[k] * b->half[k] * b->axis[k][m];
            }
            real far = distance(f, on);
            if (far < best) {
                best = far;
                memcpy(middle, at, sizeof at);
            }
        }
    }
    return best;
}

static duet_rounded_box draw_kind(rng *r, int kind)
{
    duet_rounded_box box = {draw_box(r, false), (float)rng_between(r, 0.1, 0.6)};
    for (int k = 0; k < 3; ++k)
        box.pose.half_extents[k] = kind > k ? box.pose.half_extents[k] / 2 : 0;
    return box;
}

// Spheres, capsules, plates and boxes. The truth is found from above: the search may stop too far.
TEST(rounded_boxes_meet_the_ground_if_their_cores_are_that_near)
{
    enum { BOXES = 40 };
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    duet_rounded_box boxes[BOXES];
    uint32_t met = 0;
    for (int i = 0; i < BOXES; ++i)
        boxes[i] = draw_kind(&r, i % 4);
    duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_ROUNDED_BOXES, NULL, 0);
    must(duet_tree_set_heights(tree, &f->heights, ERR));
    duet_box_query *query = open_box_query(tree);
    duet_box_query_result found = join_boxes(query, DUET_OBJECT_ROUNDED_BOXES, boxes, BOXES);
    for (uint32_t i = 0; i < BOXES; ++i) {
        block b = block_of(&boxes[i].pose);
        real far = distance_of_core(f, &b) - (real)boxes[i].radius;
        bool is_hit = met < found.n_hits && found.hits[met].box == i;
        if (is_hit ? far > 0.02L : far < -1e-9L)
            fail_msg("rounded box %u: %s, and %Lg apart", i, is_hit ? "met" : "missed", far);
        met += is_hit;
    }
    assert_int_equal(met, found.n_hits);
    assert_true(met > BOXES / 8 && met < BOXES * 7 / 8);
}

// A ball's centre is its radius from the ground where it touches, and further away before.
TEST(balls_meet_the_ground_a_radius_away)
{
    enum { SWEEPS = 200 };
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    duet_sphere_sweep sweeps[SWEEPS];
    uint32_t met = 0;
    for (int i = 0; i < SWEEPS; ++i) {
        sweeps[i] =
            (duet_sphere_sweep){.sphere = {.radius = (float)rng_between(&r, 0.1, 1)}, .t_max = 6};
        for (int k = 0; k < 3; ++k) {
            sweeps[i].sphere.centre[k] = (float)rng_between(&r, k == 2 ? 1 : -7, k == 2 ? 5 : 7);
            sweeps[i].direction[k] = (float)(rng_normal(&r) - (k == 2 ? 0.5 : 0));
        }
    }
    duet_tree *tree = open_rounded_tree(3, 0, DUET_OBJECT_SPHERES, NULL, 0);
    must(duet_tree_set_heights(tree, &f->heights, ERR));
    duet_sweep_query *query = open_sweep_query(tree, DUET_QUERY_CLOSEST);
    duet_sweep_query_result found = run_sweeps(query, DUET_OBJECT_SPHERES, sweeps, SWEEPS);
    for (uint32_t i = 0; i < SWEEPS; ++i) {
        const duet_sweep_hit *hit = &found.hits[i];
        bool is_hit = hit->id != DUET_NO_OBJECT;
        real last = is_hit ? (real)hit->t : 6, at[3], square = 0;
        for (int n = 0; n <= 15; ++n) {
            for (int k = 0; k < 3; ++k)
                at[k] =
                    (real)sweeps[i].sphere.centre[k] + last * n / 15 * (real)sweeps[i].direction[k];
            if (distance(f, at) < (real)sweeps[i].sphere.radius - 1e-5L && last > 0)
                fail_msg("ball %u meets the ground before %.9Lg", i, last);
        }
        if (!is_hit || hit->t == 0)
            continue;
        ++met;
        if (!(fabsl(distance(f, at) - (real)sweeps[i].sphere.radius) < 1e-5L))
            fail_msg("ball %u is %.9Lg from the ground, not its radius", i, distance(f, at));
        for (int k = 0; k < 3; ++k) {
            at[k] -= (real)sweeps[i].sphere.radius * (real)hit->normal[k];
            square += (real)hit->normal[k] * (real)hit->normal[k];
        }
        // A radius along the normal from the centre is the nearest place of the ground.
        assert_true(fabsl(square - 1) < 1e-6L && distance(f, at) < 2e-5L);
    }
    assert_true(met > SWEEPS / 8);
}

// ---------------------------------------------------------------- among objects

static duet_tree *open_crowd(const field *f, uint32_t share, bool ground)
{
    rng r = rng_seed(9);
    duet_pose boxes[60];
    for (int i = 0; i < 60; ++i) {
        boxes[i] = (duet_pose){.half_extents = {0.3f, 0.2f, 0.5f}};
        for (int k = 0; k < 3; ++k)
            boxes[i].centre[k] = (float)rng_between(&r, k == 2 ? 0 : -4, 4);
        turn_at_random(&boxes[i], &r);
    }
    duet_tree *tree = open_tree(3, share, boxes, 60);
    must(duet_tree_set_heights(tree, ground ? &f->heights : NULL, ERR));
    return tree;
}

static int by_place(const duet_ray_hit *a, const duet_ray_hit *b)
{
    if (a->ray != b->ray)
        return a->ray < b->ray ? -1 : 1;
    return a->t != b->t ? (a->t < b->t ? -1 : 1) : (a->id > b->id) - (a->id < b->id);
}

// Every hit is one on a box, as without the ground, or one on the ground, as without boxes.
TEST(the_ground_is_one_more_object)
{
    rng r = rng_seed(test_seed());
    field *f = draw_field(&r);
    duet_ray rays[500];
    for (int i = 0; i < 500; ++i)
        rays[i] = draw_ray(&r);
    for (size_t s = 0; s < sizeof shares / sizeof *shares; ++s) {
        duet_tree *trees[] = {open_crowd(f, shares[s], true), open_crowd(f, shares[s], false),
                              open_ground(f, shares[s])};
        duet_ray_query *query[3], *closest, *any;
        duet_ray_query_result found[3];
        for (int i = 0; i < 3; ++i) {
            query[i] = open_ray_query(trees[i], DUET_QUERY_EVERY, true);
            found[i] = cast_rays(query[i], rays, 500);
        }
        assert_true(found[1].n_hits > 20 && found[2].n_hits > 20);
        assert_int_equal(found[0].n_hits, found[1].n_hits + found[2].n_hits);
        uint64_t box = 0, ground = 0;
        for (uint64_t i = 0; i < found[0].n_hits; ++i) {
            const duet_ray_hit *hit = &found[0].hits[i];
            bool is_ground = hit->id == 66;
            const duet_ray_hit *same = is_ground ? &found[2].hits[ground] : &found[1].hits[box];
            const duet_ray_normal *normal =
                is_ground ? &found[2].normals[ground++] : &found[1].normals[box++];
            assert_true(hit->ray == same->ray && hit->t == same->t);
            assert_memory_equal(&found[0].normals[i], normal, sizeof *normal);
            assert_true(is_ground || hit->id == same->id);
            assert_true(i == 0 || by_place(hit - 1, hit) < 0);
        }
        closest = open_ray_query(trees[0], DUET_QUERY_CLOSEST, false);
        any = open_ray_query(trees[0], DUET_QUERY_ANY, false);
        duet_ray_query_result first = cast_rays(closest, rays, 500),
                              some = cast_rays(any, rays, 500);
        hit_list hits = HITS(found[0], 67);
        for (uint32_t i = 0; i < 500; ++i) {
            const duet_ray_hit none = {i, DUET_NO_OBJECT, INFINITY}, *nearest = take_hits(&hits, i);
            assert_int_equal(some.hits[i].id, nearest ? 0 : DUET_NO_OBJECT);
            assert_memory_equal(&first.hits[i], nearest ? nearest : &none, sizeof none);
        }
        test_give_back(closest);
        test_give_back(any);
        for (int i = 0; i < 3; ++i) {
            test_give_back(query[i]);
            test_give_back(trees[i]);
        }
    }
}

TEST(a_filter_of_nothing_finds_no_ground_and_bad_grounds_are_refused)
{
    rng r = rng_seed(3);
    field *f = draw_field(&r);
    duet_tree *tree = open_ground(f, 0), *flat = open_tree(2, 0, NULL, 0);
    duet_ray_query_def def = duet_default_ray_query_def();
    const duet_ray down = {.origin = {2, 1, 9}, .direction = {0, 0, -1}, .t_max = INFINITY};
    duet_filter filter = {1, 0};
    def.tree = tree;
    def.filter = &filter;
    for (int i = 0; i < 2; ++i) {
        filter.mask = (uint32_t)i;
        duet_ray_query *query = must(duet_ray_query_create(&def, ERR));
        assert_true(meets(query, down) == (i == 1));
        duet_ray_query_destroy(query);
    }
    must_fail(duet_tree_set_heights(flat, &f->heights, ERR), DUET_STATUS_BAD_ARGUMENT,
              "heights are for trees in 3D");
    f->values[5] = NAN;
    must_fail(duet_tree_set_heights(tree, &f->heights, ERR), DUET_STATUS_BAD_ARGUMENT,
              "height 5, 0 of the ground is nan");
    f->values[5] = 0;
    f->heights.origin[1] = 1e30;
    must_fail(duet_tree_set_heights(tree, &f->heights, ERR), DUET_STATUS_BAD_ARGUMENT,
              "the ground's origin is 1e+30 along y");
}
