// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "support/devices.h"
#include "support/figure.h"
#include "support/hard_pairs.h"
#include "support/oracle.h"

#include "support/narrow_float.h"

#include <float.h>

// Does `check` for n pairs of each class, in 3D and in 2D; it says whether the
// fact holds.
static void for_hard_pairs(int n, bool (*check)(const hard_pair *pair, uint32_t dims))
{
    rng r = rng_seed(test_seed());
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (int i = 0; i < n; ++i) {
            uint32_t dims = i % 4 == 3 ? 2 : 3;
            hard_pair pair = c->make(&r, dims);
            if (!check(&pair, dims)) {
                hard_pair_print(&pair, dims);
                fail_msg("pair %d of '%s'", i, c->name);
            }
        }
}

// ------------------------------------------------------------ the exact test

static bool exact_is_what_the_oracle_says(const hard_pair *p, uint32_t dims)
{
    return narrow_exact(&p->a, &p->b, dims) == oracle_collide(&p->a, &p->b, dims);
}

TEST(exact_agrees_with_elimination)
{
    for_hard_pairs(40, exact_is_what_the_oracle_says);
}

TEST(pairs_that_touch_by_construction_collide)
{
    rng r = rng_seed(test_seed());
    for (const hard_class *c = hard_classes; c->name; ++c)
        for (uint32_t i = 0; c->touching && i < 2000; ++i) {
            uint32_t dims = 2 + i % 2;
            hard_pair p = c->make(&r, dims);
            assert_true(narrow_decide(&p.a, &p.b, dims));
            assert_true(narrow_exact(&p.a, &p.b, dims));
        }
}

// Otherwise a test on them shows nothing.
TEST(hard_pairs_are_hard)
{
    rng r = rng_seed(test_seed());
    for (const hard_class *c = hard_classes; c->name; ++c) {
        int collide = 0, undecided = 0;
        enum { N = 400 };
        for (int i = 0; i < N; ++i) {
            hard_pair p = c->make(&r, 3);
            collide += narrow_decide(&p.a, &p.b, 3);
            undecided += narrow_float(&p.a, &p.b, 3, true) == NARROW_UNDECIDED;
        }
        print_message("%-40s %3d %% collide, %3d %% undecided in float\n", c->name,
                      100 * collide / N, 100 * undecided / N);
        assert_true(c->touching ? collide == N : collide > N / 20 && collide < N - N / 20);
        assert_true(c->touching || undecided > N / 10);
    }
}

// ------------------------------------------------------------ bounds hold

static bool float_and_double_do_not_err(const hard_pair *p, uint32_t dims)
{
    bool truth = narrow_exact(&p->a, &p->b, dims);
    narrow_answer in_float = narrow_float(&p->a, &p->b, dims, true);
    narrow_answer in_double = narrow_double(&p->a, &p->b, dims);
    return (in_float == NARROW_UNDECIDED || (in_float == NARROW_COLLIDING) == truth) &&
           (in_double == NARROW_UNDECIDED || (in_double == NARROW_COLLIDING) == truth) &&
           narrow_decide(&p->a, &p->b, dims) == truth;
}

TEST(float_and_double_never_contradict_exact)
{
    for_hard_pairs(2000, float_and_double_do_not_err);
}

TEST(there_are_as_many_classes_as_the_document_says)
{
    int n = 0;
    while (hard_classes[n].name)
        ++n;
    assert_int_equal(n,
                     (int)figure("notes/accuracy.md", "integers agree on # classes of hard pairs"));
}

static float of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// How far 1 / x is off, by every mantissa: what is guessed from the bits, and after
// three steps, as runtime/narrowphase/sat_frame.c has them.
TEST(a_reciprocal_is_as_near_as_the_document_says)
{
    double f[2], guess_off = 0, off = 0;
    figures("notes/accuracy.md", "from a guess within # % (bits", 1, f);
    figures("notes/accuracy.md", "three Newton steps by fma leave # u, found by trying", 1, f + 1);
    for (uint32_t mantissa = 0; mantissa < 1u << 23; ++mantissa) {
        float x = of_bits(0x3F800000u + mantissa);
        float r = of_bits(0x7EF311C3u - (0x3F800000u + mantissa));
        guess_off = fmax(guess_off, fabs((double)r * x - 1));
        for (int step = 0; step < 3; ++step)
            r = fmaf(fmaf(-x, r, 1.0f), r, r);
        off = fmax(off, fabs((double)r * x - 1));
    }
    print_message("%.3f %%, then %.5f u\n", 100 * guess_off, off * 0x1p24);
    assert_true(100 * guess_off <= f[0] && 100 * guess_off > f[0] - 0.1);
    assert_true(fabs(off * 0x1p24 - f[1]) < 0.00005);
}

static bool upright_float_is_exact(const hard_pair *p, uint32_t dims)
{
    duet_pose a = p->a, b = p->b;
    memcpy(a.rotation, (float[]){0, 0, 0, 1}, sizeof a.rotation);
    memcpy(b.rotation, (float[]){0, 0, 0, -2}, sizeof b.rotation);
    bool truth = narrow_exact(&a, &b, dims);
    narrow_answer in_float = narrow_float(&a, &b, dims, false);
    bool huge = a.half_extents[0] + b.half_extents[0] > 0x1p99f;
    return (in_float == NARROW_UNDECIDED ? huge : (in_float == NARROW_COLLIDING) == truth) &&
           narrow_double(&a, &b, dims) == (truth ? NARROW_COLLIDING : NARROW_SEPARATED);
}

TEST(boxes_without_rotation_are_decided_exactly_in_float)
{
    for_hard_pairs(1000, upright_float_is_exact);
}

// The 48 quaternions that turn axes into axes: parts of one size or 0.
TEST(quarter_turns_are_decided_exactly_in_double)
{
    rng r = rng_seed(test_seed());
    int turns = 0;
    for (int code = 0; code < 81; ++code) {
        duet_pose a = cube_at(0, 0, 0, 0.5), b = a;
        int n = 0;
        for (int i = 0, rest = code; i < 4; ++i, rest /= 3) {
            a.rotation[i] = 0.7f * (float)(rest % 3 - 1);
            n += rest % 3 != 1;
        }
        if (n == 0 || n == 3)
            continue;
        ++turns;
        for (int round = 0; round < 50; ++round) {
            for (int i = 0; i < 3; ++i) {
                a.half_extents[i] = (float)rng_below(&r, 4);
                b.half_extents[i] = (float)rng_below(&r, 4);
                b.centre[i] = (float)rng_below(&r, 7);
            }
            b.centre[0] = nextafterf(b.centre[0], (float)round - 25);
            assert_int_equal(narrow_double(&a, &b, 3),
                             narrow_exact(&a, &b, 3) ? NARROW_COLLIDING : NARROW_SEPARATED);
        }
    }
    assert_int_equal(turns, 48);
}

TEST(float_leaves_few_ordinary_pairs_undecided)
{
    enum { N = 200000 };
    rng r = rng_seed(test_seed());
    int undecided = 0;
    for (int i = 0; i < N; ++i) {
        duet_pose a = random_box(&r, 2), b = random_box(&r, 2);
        undecided += narrow_float(&a, &b, 3, true) == NARROW_UNDECIDED;
    }
    print_message("%d of %d\n", undecided, N);
    double some = figure("accuracy.md", "all but about # in 100 000 pairs of random boxes");
    assert_in_range(undecided, 0.5 * some * N / 100000, 1.5 * some * N / 100000);
}

// Cubes on a floor: nearly upright, no two quite alike.
TEST(float_leaves_few_nearly_parallel_pairs_undecided)
{
    enum { N = 200000 };
    rng r = rng_seed(test_seed());
    int undecided = 0;
    for (int i = 0; i < N; ++i) {
        duet_pose a = random_box(&r, 2), b = random_box(&r, 2);
        double angle = pow(10, -rng_between(&r, 0, 9));
        for (int k = 0; k < 4; ++k) {
            a.rotation[k] = (float)(angle * rng_normal(&r)) + (k == 3);
            b.rotation[k] = (float)(angle * rng_normal(&r)) + (k == 3);
        }
        undecided += narrow_float(&a, &b, 3, true) == NARROW_UNDECIDED;
    }
    print_message("%d of %d\n", undecided, N);
    assert_true(undecided <
                figure("notes/accuracy.md", "both are below # in 100 000") * N / 100000);
}

// ------------------------------------------------------------ symmetry

static duet_pose with_turn_scaled(duet_pose pose, float by)
{
    for (int i = 0; i < 4; ++i)
        pose.rotation[i] *= by;
    return pose;
}

static bool order_and_sign_do_not_count(const hard_pair *p, uint32_t dims)
{
    duet_pose minus_a = with_turn_scaled(p->a, -1), minus_b = with_turn_scaled(p->b, -1);
    bool truth = narrow_decide(&p->a, &p->b, dims);
    return narrow_decide(&p->b, &p->a, dims) == truth &&
           narrow_exact(&p->b, &p->a, dims) == narrow_exact(&p->a, &p->b, dims) &&
           narrow_decide(&minus_a, &p->b, dims) == truth &&
           narrow_double(&minus_a, &minus_b, dims) == narrow_double(&p->a, &p->b, dims) &&
           narrow_float(&minus_a, &minus_b, dims, true) == narrow_float(&p->a, &p->b, dims, true);
}

TEST(a_b_and_b_a_and_q_and_minus_q_agree)
{
    for_hard_pairs(500, order_and_sign_do_not_count);
}

TEST(a_quaternion_s_length_does_not_count)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 5000; ++i) {
        uint32_t dims = 2 + (uint32_t)i % 2;
        hard_pair p = hard_classes[i % 2 ? 0 : 2].make(&r, dims); // contact, or touching
        int power = (int)rng_below(&r, 200) - 100;
        duet_pose scaled = with_turn_scaled(p.a, ldexpf(1, power));
        assert_int_equal(narrow_decide(&scaled, &p.b, dims), narrow_decide(&p.a, &p.b, dims));
    }
}

TEST(signed_zeros_do_not_count)
{
    duet_pose a = cube_at(0, 0, 0, 0.5), b = cube_at(1, 0.0f, 0.0f, 0.5),
              c = cube_at(1, -0.0f, -0.0f, 0.5);
    assert_true(narrow_decide(&a, &b, 3));
    assert_true(narrow_decide(&a, &c, 3));
    c.rotation[0] = -0.0f;
    c.rotation[3] = -1;
    assert_int_equal(narrow_double(&a, &c, 3), NARROW_COLLIDING);
}

TEST(flat_pairs_are_alike_in_2d_and_in_3d)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 20000; ++i) {
        hard_pair p = hard_classes[0].make(&r, 2);
        bool in_2d = narrow_decide(&p.a, &p.b, 2);
        p.a.half_extents[2] = p.b.half_extents[2] = 1;
        p.a.centre[2] = p.b.centre[2] = 7;
        assert_int_equal(narrow_decide(&p.a, &p.b, 3), in_2d);
    }
}

// ------------------------------------------------------------ single cases

TEST(touching_cubes_collide_and_one_ulp_apart_do_not)
{
    duet_pose a = cube_at(1, 2, 3, 0.5), b = cube_at(2, 2, 3, 0.5);
    assert_int_equal(narrow_double(&a, &b, 3), NARROW_COLLIDING);
    assert_true(narrow_exact(&a, &b, 3));
    b.centre[0] = nextafterf(2, 3);
    assert_int_equal(narrow_double(&a, &b, 3), NARROW_SEPARATED);
    assert_false(narrow_exact(&a, &b, 3));
}

TEST(a_cube_turned_by_a_right_angle_touches_all_the_same)
{
    duet_pose a = cube_at(0, 0, 0, 0.5), b = cube_at(1, 1, 1, 0.5);
    memcpy(b.rotation, (float[]){1, 0, 0, 1}, sizeof b.rotation); // 90 degrees about x
    assert_true(narrow_decide(&a, &b, 3));
    b.centre[2] = nextafterf(1, 2);
    assert_false(narrow_decide(&a, &b, 3));
}

TEST(plates_a_hair_apart_are_separated)
{
    duet_pose a = {{0}, {20, 20, 0.02f}, {0.1f, 0.2f, 0.3f, 0.9f}};
    duet_pose b = a;
    const float q[4] = {0.1f, 0.2f, 0.3f, 0.9f};
    double norm = 0.95;
    double separation = 0.04 + 1e-4;
    b.centre[0] = (float)(separation * 2 * (q[0] * q[2] + q[3] * q[1]) / norm);
    b.centre[1] = (float)(separation * 2 * (q[1] * q[2] - q[3] * q[0]) / norm);
    b.centre[2] =
        (float)(separation * (q[3] * q[3] + q[2] * q[2] - q[0] * q[0] - q[1] * q[1]) / norm);
    assert_false(narrow_decide(&a, &b, 3));
    for (int i = 0; i < 3; ++i)
        b.centre[i] *= 0.99f;
    assert_true(narrow_decide(&a, &b, 3));
}

TEST(a_point_on_a_face_collides_and_off_it_does_not)
{
    duet_pose box = {{0}, {25, 50, 75}, {1, 2, 2, 4}}; // axes are whole 25ths
    duet_pose point = {{0}, {0}, {0.3f, -0.1f, 0.2f, 0.7f}};
    const float axis[3] = {9, 20, -12}; // 25 times edge 0
    memcpy(point.centre, axis, sizeof axis);
    assert_true(narrow_decide(&box, &point, 3));
    point.centre[0] = nextafterf(9, 10);
    assert_false(narrow_decide(&box, &point, 3));
    point.centre[0] = nextafterf(9, 8);
    assert_true(narrow_decide(&box, &point, 3));
}

TEST(coplanar_rectangles_touch_along_an_edge)
{
    duet_pose a = {{0}, {1, 2, 0}, {0, 0, 0, 1}}, b = {{2, 0, 0}, {1, 2, 0}, {0, 0, 0, 1}};
    assert_true(narrow_decide(&a, &b, 3));
    b.centre[2] = FLT_TRUE_MIN;
    assert_false(narrow_decide(&a, &b, 3));
    b.centre[2] = 0;
    b.centre[0] = nextafterf(2, 3);
    assert_false(narrow_decide(&a, &b, 3));
}

// A cube about a face diagonal, a corner passing the other's face: it collides
// from one angle on to another, without flicker between.
TEST(a_turning_cube_enters_and_leaves_once)
{
    duet_pose fixed = cube_at(0, 0, 0, 0.5), turning = cube_at(0, 0, 1.3f, 0.5);
    int changes = 0;
    bool before = false;
    for (int i = 0; i <= 100000; ++i) {
        double angle = 3.14159265358979 / 4 * i / 100000; // half of the turn
        double along = sin(angle) / sqrt(2);
        memcpy(turning.rotation, (float[]){(float)along, (float)along, 0, (float)cos(angle)},
               sizeof turning.rotation);
        bool collide = narrow_decide(&fixed, &turning, 3);
        changes += collide != before;
        before = collide;
    }
    assert_int_equal(changes, 2);
}

TEST(coordinates_near_the_greatest_float_are_no_trouble)
{
    duet_pose a = cube_at(-FLT_MAX, 0, 0, 0.5), b = cube_at(FLT_MAX, 0, 0, 0.5);
    assert_false(narrow_decide(&a, &b, 3));
    a.half_extents[0] = FLT_MAX;
    assert_false(narrow_decide(&a, &b, 3));
    b.half_extents[0] = FLT_MAX;
    assert_true(narrow_decide(&a, &b, 3)); // they touch in 0
    memcpy(b.rotation, (float[]){1, 0, 0, 1}, sizeof b.rotation);
    assert_true(narrow_decide(&a, &b, 3));
    assert_int_equal(narrow_float(&a, &b, 3, true), NARROW_UNDECIDED);
    assert_int_equal(narrow_float(&a, &b, 3, false), NARROW_UNDECIDED);
}

TEST(a_pose_that_is_no_box_collides_with_nothing)
{
    duet_pose good = cube_at(0, 0, 0, 0.5);
    duet_pose bad[] = {good, good, good, good, good};
    bad[0].centre[0] = NAN;
    bad[1].half_extents[1] = -1;
    bad[2].rotation[3] = 0;
    bad[3].rotation[1] = NAN;
    bad[4].centre[2] = INFINITY;
    for (int i = 0; i < 5; ++i) {
        assert_false(duet_poses_collide(&good, &bad[i], 3));
        assert_false(narrow_exact(&bad[i], &good, 3));
        assert_int_not_equal(narrow_float(&good, &bad[i], 3, true), NARROW_COLLIDING);
    }
    assert_true(duet_poses_collide(&good, &bad[4], 2));
}

TEST(bounds_that_touch_collide)
{
    duet_bounds a = {{0, 0, 0}, {1, 1, 1}}, b = {{1, 1, 1}, {2, 2, 2}};
    assert_true(narrow_bounds(&a, &b, 3));
    b.lower[2] = nextafterf(1, 2);
    assert_false(narrow_bounds(&a, &b, 3));
    assert_false(narrow_bounds(&b, &a, 3));
    assert_true(narrow_bounds(&a, &b, 2));
}
