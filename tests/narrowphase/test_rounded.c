// SPDX-License-Identifier: MIT
// Rounded boxes against truths made in other ways: whole numbers, an enumeration of the faces
// that two nearest points lie on, and cases that touch exactly.
#include "support/devices.h"
#include "support/real.h"
#include "support/test.h"

#include "runtime/narrowphase/level.h"
#include "runtime/narrowphase/rounded.h"

enum { RANDOM_PAIRS = 1500, WHOLE_PAIRS = 40000 };

static rng begin(const char *name)
{
    uint64_t seed = test_seed();
    print_message("%s: DUET_TEST_SEED=%" PRIu64 "\n", name, seed);
    return rng_seed(seed);
}

// ------------------------------------------------------------ whole numbers

static int64_t whole(rng *r, uint32_t most)
{
    return (int64_t)rng_below(r, 2 * most + 1) - most;
}

// A box along the world's axes of small whole numbers, as far as `extents` of them.
static duet_rounded_box whole_box(rng *r, int extents)
{
    duet_rounded_box b = {.pose.rotation = {0, 0, 0, 1}, .radius = (float)rng_below(r, 12)};
    for (int k = 0; k < 3; ++k) {
        b.pose.centre[k] = (float)whole(r, 20);
        b.pose.half_extents[k] = k < extents ? (float)rng_below(r, 6) : 0.0f;
    }
    if (extents == 0) // a box without extents may be turned
        turn_at_random(&b.pose, r);
    return b;
}

static bool truth_in_whole_numbers(const duet_rounded_box *a, const duet_rounded_box *b,
                                   uint32_t dims)
{
    int64_t squared = 0, reach = (int64_t)a->radius + (int64_t)b->radius;
    for (uint32_t k = 0; k < dims; ++k) {
        int64_t way = llabs((int64_t)a->pose.centre[k] - (int64_t)b->pose.centre[k]);
        int64_t both = (int64_t)a->pose.half_extents[k] + (int64_t)b->pose.half_extents[k];
        int64_t gap = way > both ? way - both : 0;
        squared += gap * gap;
    }
    return squared <= reach * reach;
}

TEST(whole_numbers_are_decided_exactly)
{
    rng r = begin(__func__);
    int touching = 0;
    for (int i = 0; i < WHOLE_PAIRS; ++i) {
        uint32_t dims = 2 + rng_below(&r, 2);
        duet_rounded_box a = whole_box(&r, (int)rng_below(&r, 4));
        duet_rounded_box b = whole_box(&r, (int)rng_below(&r, 4));
        float scale = ldexpf(1.0f, (int)rng_below(&r, 41) - 20);
        bool truth = truth_in_whole_numbers(&a, &b, dims);
        duet_rounded_box smaller = b;
        smaller.radius -= 1;
        touching += b.radius > 0 && truth && !truth_in_whole_numbers(&a, &smaller, dims);
        duet_rounded_box *both[2] = {&a, &b};
        for (int s = 0; s < 2; ++s) {
            both[s]->radius *= scale;
            for (int k = 0; k < 3; ++k) {
                both[s]->pose.centre[k] *= scale;
                both[s]->pose.half_extents[k] *= scale;
            }
        }
        assert_int_equal(rounded_decide(&a, &b, dims), truth);
        assert_int_equal(rounded_decide(&b, &a, dims), truth);
        assert_int_not_equal(rounded_double(&a, &b, dims), NARROW_UNDECIDED);
        if (i % 8 == 0)
            assert_int_equal(rounded_exact(&a, &b, dims), truth);
    }
    assert_true(touching > WHOLE_PAIRS / 100);
}

// ------------------------------------------------------------ distances

// Least squares of `from` + the free columns, by Gauss's elimination of the normal equations.
// False where they are not independent.
static bool solve(int n, real column[6][3], const real from[3], real value[6])
{
    real m[6][7];
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j)
            m[i][j] = column[i][0] * column[j][0] + column[i][1] * column[j][1] +
                      column[i][2] * column[j][2];
        m[i][n] = -(column[i][0] * from[0] + column[i][1] * from[1] + column[i][2] * from[2]);
    }
    for (int c = 0; c < n; ++c) {
        int pivot = c;
        for (int i = c + 1; i < n; ++i)
            pivot = fabsl(m[i][c]) > fabsl(m[pivot][c]) ? i : pivot;
        if (fabsl(m[pivot][c]) < 1e-12L)
            return false;
        for (int k = 0; k <= n; ++k) {
            real kept = m[c][k];
            m[c][k] = m[pivot][k];
            m[pivot][k] = kept;
        }
        for (int i = 0; i < n; ++i) {
            real times = i == c ? 0 : m[i][c] / m[c][c];
            for (int k = c; k <= n; ++k)
                m[i][k] -= times * m[c][k];
        }
    }
    for (int i = 0; i < n; ++i)
        value[i] = m[i][n] / m[i][i];
    return true;
}

// The distance of two boxes: each part of either's nearest point is at one end, at the other, or
// between them, and then the gap is least in it. All 3^6 cases are tried.
static real distance_of(const duet_pose *a, const duet_pose *b)
{
    real axis_a[3][3], axis_b[3][3], least = HUGE_VALL;
    real_axes(axis_a, a->rotation);
    real_axes(axis_b, b->rotation);
    for (int set = 0; set < 729; ++set) {
        real from[3], column[6][3], value[6], extent[6];
        int n = 0;
        for (int k = 0; k < 3; ++k)
            from[k] = (real)b->centre[k] - a->centre[k];
        for (int e = 0, rest = set; e < 6; ++e, rest /= 3) {
            const real *axis = e < 3 ? axis_a[e] : axis_b[e - 3];
            real half = e < 3 ? a->half_extents[e] : b->half_extents[e - 3];
            real end = rest % 3 == 1 ? half : -half;
            for (int k = 0; k < 3; ++k) {
                if (rest % 3 == 0)
                    column[n][k] = axis[k];
                else
                    from[k] += end * axis[k];
            }
            extent[n] = half;
            n += rest % 3 == 0;
        }
        if (n > 3 || !solve(n, column, from, value))
            continue; // more than three directions: a case with fewer has the same distance
        bool inside = true;
        for (int i = 0; i < n; ++i) {
            inside = inside && fabsl(value[i]) <= extent[i];
            for (int k = 0; k < 3; ++k)
                from[k] += value[i] * column[i][k];
        }
        real length = sqrtl(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
        if (inside && length < least)
            least = length;
    }
    return least;
}

// Any core: a point, a line, a plate or a box, seldom thin, turned at random or nearly alike.
static duet_rounded_box random_box(rng *r, const duet_rounded_box *like)
{
    duet_rounded_box b = {.radius = (float)rng_between(r, 0, 0.5)};
    for (int k = 0; k < 3; ++k) {
        b.pose.centre[k] = (float)rng_between(r, -1.2, 1.2);
        b.pose.half_extents[k] = rng_below(r, 3) ? (float)rng_between(r, 0, 0.6) : 0.0f;
    }
    turn_at_random(&b.pose, r);
    if (like && rng_below(r, 3) == 0)
        for (int k = 0; k < 4; ++k)
            b.pose.rotation[k] =
                like->pose.rotation[k] + (float)(1e-3 * (rng_below(r, 2) ? rng_normal(r) : 0));
    return b;
}

static duet_rounded_box flat_of(duet_rounded_box b, uint32_t dims)
{
    b.pose = narrow_flat(&b.pose, dims);
    return b;
}

TEST(distances_are_those_of_all_faces)
{
    rng r = begin(__func__);
    int near = 0, exact = 0;
    for (int i = 0; i < RANDOM_PAIRS; ++i) {
        uint32_t dims = i % 4 ? 3 : 2;
        duet_rounded_box a = random_box(&r, NULL), b = random_box(&r, &a);
        duet_rounded_box flat_a = flat_of(a, dims), flat_b = flat_of(b, dims);
        if (narrow_decide(&flat_a.pose, &flat_b.pose, dims)) {
            assert_true(rounded_decide(&a, &b, dims));
            assert_true(rounded_exact(&a, &b, dims));
            continue;
        }
        real distance = distance_of(&flat_a.pose, &flat_b.pose);
        // One pair of radii at random, and some from far to near of touching.
        for (int power = 0; power <= 50; power += 10) {
            real reach = power == 0 ? (real)a.radius + b.radius
                                    : distance + (rng_below(&r, 2) ? 1 : -1) * ldexpl(1, -power);
            a.radius = reach > 0 ? (float)(reach * rng_between(&r, 0, 1)) : 0.0f;
            b.radius = (float)(reach - a.radius);
            b.radius = b.radius > 0 ? b.radius : 0.0f;
            real clear = distance - ((real)a.radius + b.radius);
            if (fabsl(clear) < 1e-16L)
                continue;
            near += fabsl(clear) < 1e-7L;
            assert_int_equal(rounded_decide(&a, &b, dims), clear < 0);
            assert_int_equal(rounded_decide(&b, &a, dims), clear < 0);
            narrow_answer quick = rounded_double(&a, &b, dims);
            assert_true(quick == NARROW_UNDECIDED || (quick == NARROW_COLLIDING) == (clear < 0));
            if (power % 20 == 0 || quick == NARROW_UNDECIDED) {
                assert_int_equal(rounded_exact(&a, &b, dims), clear < 0);
                ++exact;
            }
        }
        assert_float_equal(duet_rounded_boxes_separation(&a, &b, dims),
                           (double)(distance - ((real)a.radius + b.radius)), 1e-6);
    }
    assert_true(near > RANDOM_PAIRS / 4 && exact > RANDOM_PAIRS);
}

// ------------------------------------------------------------ touching

typedef struct touching {
    const char *what;
    uint32_t dims;
    duet_rounded_box a, b;
} touching;

// Cosine 3/5, sine 4/5 about z.
#define TURNED     \
    {              \
        0, 0, 1, 2 \
    }
#define STRAIGHT   \
    {              \
        0, 0, 0, 1 \
    }

#define CASE(what, dims, ...)   \
    {                           \
        what, dims, __VA_ARGS__ \
    }

static const touching cases[] = {
    CASE("spheres along 2 3 6", 3, {{{0, 0, 0}, {0, 0, 0}, STRAIGHT}, 3},
         {{{2, 3, 6}, {0, 0, 0}, STRAIGHT}, 4}),
    CASE("discs along 3 4", 2, {{{0, 0, 0}, {0, 0, 0}, STRAIGHT}, 1},
         {{{3, 4, 9}, {0, 0, 0}, STRAIGHT}, 4}),
    CASE("a corner of a turned box, and a sphere 2 3 6 from it", 3,
         {{{0, 0, 0}, {5, 5, 5}, TURNED}, 0}, {{{-1 + 2, 7 + 6, 5 + 3}, {0, 0, 0}, STRAIGHT}, 7}),
    CASE("a corner of a turned rounded box, in 2D", 2, {{{0, 0, 0}, {5, 5, 0}, TURNED}, 2},
         {{{-1 - 3, 7 + 4, 0}, {0, 0, 0}, STRAIGHT}, 3}),
    CASE("crossing capsules, one above the other", 3, {{{0, 0, 0}, {8, 0, 0}, STRAIGHT}, 1},
         {{{1, 2, 3}, {5, 0, 0}, TURNED}, 2}),
    CASE("parallel turned capsules side by side: 10 across 3/5 4/5", 3,
         {{{0, 0, 0}, {7, 0, 0}, TURNED}, 4}, {{{-8, 6, 0}, {9, 0, 0}, TURNED}, 6}),
    CASE("a face of a turned box, and a sphere", 3, {{{0, 0, 0}, {10, 1, 1}, TURNED}, 0},
         {{{-4, 3, 0}, {0, 0, 0}, STRAIGHT}, 4}),
    CASE("faces of turned rounded boxes", 3, {{{0, 0, 0}, {3, 1, 2}, TURNED}, 1},
         {{{-8, 6, 0}, {2, 3, 1}, TURNED}, 5}),
};

TEST(what_touches_collides_and_an_ulp_less_does_not)
{
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        touching t = cases[i];
        if (!rounded_decide(&t.a, &t.b, t.dims) || !rounded_exact(&t.b, &t.a, t.dims))
            fail_msg("%s: they touch", t.what);
        t.b.radius = nextafterf(t.b.radius, 0);
        if (rounded_decide(&t.a, &t.b, t.dims) || rounded_exact(&t.b, &t.a, t.dims))
            fail_msg("%s: with an ulp less they do not touch", t.what);
    }
}

// 2^-60 of their sizes from touching, on either side.
TEST(what_double_does_not_see_is_seen)
{
    duet_rounded_box ball = {{{0, 0, 0}, {0, 0, 0}, STRAIGHT}, 1};
    duet_rounded_box other = {{{1, 0x1p-30f, 0}, {0, 0, 0}, STRAIGHT}, 0};
    assert_false(rounded_decide(&ball, &other, 3));
    other.radius = 0x1p-60f;
    assert_true(rounded_decide(&ball, &other, 3));
    for (int side = -1; side <= 1; side += 2) {
        duet_rounded_box box = {{{(float)side * 0x1p-60f, 0, 0}, {10, 1, 1}, TURNED}, 0};
        duet_rounded_box sphere = {{{-4, 3, 0}, {0, 0, 0}, STRAIGHT}, 4};
        assert_int_equal(rounded_double(&box, &sphere, 3), NARROW_UNDECIDED);
        assert_int_equal(rounded_decide(&box, &sphere, 3), side < 0);
    }
}

TEST(a_box_without_a_radius_is_a_box)
{
    rng r = begin(__func__);
    for (int i = 0; i < RANDOM_PAIRS; ++i) {
        duet_rounded_box a = random_box(&r, NULL), b = random_box(&r, &a);
        a.radius = b.radius = 0;
        assert_int_equal(rounded_decide(&a, &b, 3), narrow_decide(&a.pose, &b.pose, 3));
        if (i % 10 == 0)
            assert_int_equal(rounded_exact(&a, &b, 3), narrow_exact(&a.pose, &b.pose, 3));
    }
}

// aabb and sphere miss none; the others are exact.
TEST(levels_keep_their_promises)
{
    rng r = begin(__func__);
    int more = 0;
    for (int i = 0; i < RANDOM_PAIRS; ++i) {
        duet_rounded_box a = random_box(&r, NULL), b = random_box(&r, &a);
        bool truth = rounded_decide(&a, &b, 3);
        for (int l = 0; l < DUET_LEVELS; ++l) {
            duet_level level = (duet_level)l;
            bool found = level_collide_rounded(level, &a, &b, 3, true);
            bool loose = level == DUET_LEVEL_AABB || level == DUET_LEVEL_SPHERE;
            assert_true(loose ? found || !truth : found == truth);
            more += found && !truth;
        }
    }
    assert_true(more > RANDOM_PAIRS / 10);
}

TEST(what_is_no_rounded_box_collides_with_nothing)
{
    const float bad[] = {-1.0f, NAN, INFINITY};
    duet_rounded_box good = {{{0, 0, 0}, {1, 1, 1}, STRAIGHT}, 1};
    assert_true(duet_rounded_boxes_collide(&good, &good, 3));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        duet_rounded_box other = good;
        other.radius = bad[i];
        assert_false(duet_rounded_boxes_collide(&good, &other, 3));
        assert_false(rounded_exact(&other, &good, 3));
    }
}
