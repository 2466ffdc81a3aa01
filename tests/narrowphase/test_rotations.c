// SPDX-License-Identifier: MIT
// Quaternions whose parts lie far apart, by every way into a scene.
//
// A needle along x touches a cube with its end. It is a hair away where its
// quaternion turns it at all, however little, so that the answer tells whether
// each part was kept. The truth is found in whole numbers, from the numbers
// as they were given.
#include "support/oracle.h"
#include "support/scene_file.h"
#include "support/test.h"

#include "base/text.h"

enum { COLUMNS = 10, NUMBERS = 2 * COLUMNS };

static const double cube_and_needle[NUMBERS] = {
    0, 0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 1, // and
    1, 0, 0, 0.5, 0,   0,   0, 0, 0, 1,
};

// ------------------------------------------------------------ ways in

typedef duet_scene *(*way_in)(const double row[NUMBERS], duet_error *err);

static void add_list(text *t, const double *numbers, int n)
{
    for (int i = 0; i < n; ++i)
        text_add(t, i + 1 < n ? "%.17g, " : "%.17g", numbers[i]);
}

static duet_scene *load(const char *name, text *t, duet_error *err)
{
    duet_scene *scene = scene_from_bytes(name, t->chars, t->length, NULL, 0, err);
    text_free(t);
    return scene;
}

static duet_scene *by_text(const double row[NUMBERS], duet_error *err)
{
    text t = {0};
    add_list(&t, row, COLUMNS);
    text_add(&t, "\n");
    add_list(&t, row + COLUMNS, COLUMNS);
    return load("test_rotations.csv", &t, err);
}

// Digits as C, Python and others print floats so that they read the same back.
static duet_scene *by_short_text(const double row[NUMBERS], duet_error *err)
{
    text t = {0};
    for (int i = 0; i < NUMBERS; ++i)
        text_add(&t, i % COLUMNS == COLUMNS - 1 ? "%.9g\n" : "%.9g ", row[i]);
    return load("test_rotations.txt", &t, err);
}

static void begin_array(text *t, const char *descr)
{
    text_add_bytes(t, "\x93NUMPY\1\0\x76\0", 10);
    char literal[118];
    snprintf(literal, sizeof literal, "{'descr': '%s', 'fortran_order': False, 'shape': (2, 10), }",
             descr);
    text_add(t, "%-117s\n", literal);
}

static duet_scene *by_floats(const double row[NUMBERS], duet_error *err)
{
    text t = {0};
    begin_array(&t, "<f4");
    for (int i = 0; i < NUMBERS; ++i)
        text_add_bytes(&t, (const char *)&(float){(float)row[i]}, sizeof(float));
    return load("test_rotations.npy", &t, err);
}

static duet_scene *by_doubles(const double row[NUMBERS], duet_error *err)
{
    text t = {0};
    begin_array(&t, "<f8");
    text_add_bytes(&t, (const char *)row, NUMBERS * sizeof *row);
    return load("test_rotations.npy", &t, err);
}

static duet_scene *by_lua(const double row[NUMBERS], duet_error *err)
{
    text t = {0};
    text_add(&t, "add(");
    add_list(&t, row, COLUMNS);
    text_add(&t, ")\nreturn { objects = { { centre = { ");
    add_list(&t, row + COLUMNS, 3);
    text_add(&t, " }, half_extents = { ");
    add_list(&t, row + COLUMNS + 3, 3);
    text_add(&t, " }, rotation = { ");
    add_list(&t, row + COLUMNS + 6, 4);
    text_add(&t, " } } } }");
    return load("test_rotations.lua", &t, err);
}

static duet_scene *by_poses(const double row[NUMBERS], duet_error *err)
{
    duet_pose poses[2];
    for (int i = 0; i < NUMBERS; ++i)
        ((float *)&poses[i / COLUMNS])[i % COLUMNS] = (float)row[i];
    duet_scene *scene = duet_scene_create(DUET_OBJECT_POSES, poses, 2, 3, 0, err);
    return scene ? test_keep(scene, test_duet_scene_back) : NULL;
}

static void print_needle(const double row[NUMBERS])
{
    for (int i = COLUMNS; i < NUMBERS; ++i)
        print_message("%.17g ", row[i]);
    print_message("\n");
}

// The truth, or where `may_refuse` a line that names the object.
static bool tells_the_truth(way_in way, const double row[NUMBERS], bool may_refuse)
{
    duet_error err = {0};
    duet_scene *scene = way(row, &err);
    if (!scene) {
        bool named = strstr(err.text, "object 1: q") && err.status == DUET_STATUS_BAD_OBJECT;
        if (!may_refuse || !named)
            print_message("%s\n", err.text);
        return may_refuse && named;
    }
    const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    bool answer = duet_poses_collide(&poses[0], &poses[1], 3);
    test_give_back(scene);
    return answer == oracle_rows_collide(row, row + COLUMNS);
}

// ------------------------------------------------------------ floats

// A part 0, or of any size between two powers of two.
static double any_part(rng *r, double from, double to)
{
    int power = (int)floor(rng_between(r, from, to));
    double part = ldexp(rng_between(r, rng_below(r, 2) ? 0.5 : -1, 1), power);
    return rng_below(r, 3) ? part : 0;
}

static void make_needle(rng *r, double from, double to, double row[NUMBERS])
{
    memcpy(row, cube_and_needle, sizeof cube_and_needle);
    double *q = row + COLUMNS + 6;
    do
        for (int k = 0; k < 4; ++k)
            q[k] = any_part(r, from, to);
    while (q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0);
}

static void round_to_floats(double row[NUMBERS])
{
    double *q = row + COLUMNS + 6;
    for (int k = 0; k < 4; ++k)
        q[k] = (float)q[k];
    if (q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0)
        q[3] = 0x1p-149;
}

// Whatever float32 can hold, from 1e-45 to 3e38, is the rotation that is tested.
TEST(floats_of_any_size_are_kept_by_every_way_in)
{
    static const way_in ways[] = {by_text, by_short_text, by_floats, by_doubles, by_lua, by_poses};
    rng r = rng_seed(test_seed());
    int apart = 0;
    enum { ROUNDS = 300 };
    for (int round = 0; round < ROUNDS; ++round) {
        double row[NUMBERS];
        make_needle(&r, -151, 128, row);
        round_to_floats(row);
        apart += !oracle_rows_collide(row, row + COLUMNS);
        for (size_t w = 0; w < sizeof ways / sizeof *ways; ++w)
            if (!tells_the_truth(ways[w], row, false)) {
                print_needle(row);
                fail_msg("round %d, way %zu", round, w);
            }
    }
    assert_in_range(apart, ROUNDS / 4, ROUNDS - ROUNDS / 8);
}

TEST(the_greatest_beside_the_least_float_is_kept)
{
    double row[NUMBERS];
    memcpy(row, cube_and_needle, sizeof row);
    row[COLUMNS + 8] = 0x1p-149;
    row[COLUMNS + 9] = -0x1.fffffep127;
    assert_false(oracle_rows_collide(row, row + COLUMNS));
    assert_true(tells_the_truth(by_floats, row, false));
    assert_true(tells_the_truth(by_short_text, row, false));
    assert_true(tells_the_truth(by_poses, row, false));
}

// ------------------------------------------------------------ doubles

static double spread_of(const double q[4])
{
    double least = INFINITY, greatest = 0;
    for (int k = 0; k < 4; ++k) {
        greatest = fmax(greatest, fabs(q[k]));
        least = q[k] != 0 ? fmin(least, fabs(q[k])) : least;
    }
    return log2(greatest) - log2(least);
}

TEST(doubles_are_told_truly_or_refused)
{
    static const way_in ways[] = {by_text, by_doubles, by_lua};
    rng r = rng_seed(test_seed());
    int refused = 0;
    enum { ROUNDS = 600 };
    for (int round = 0; round < ROUNDS; ++round) {
        double row[NUMBERS], middle = rng_between(&r, -1000, 1000);
        double wide = rng_below(&r, 2) ? 140 : 400;
        make_needle(&r, fmax(middle - wide, -1073), fmin(middle + wide, 1024), row);
        double spread = spread_of(row + COLUMNS + 6);
        refused += spread > 277.01;
        for (size_t w = 0; w < sizeof ways / sizeof *ways; ++w)
            if (!tells_the_truth(ways[w], row, spread > 276.99)) {
                print_needle(row);
                fail_msg("round %d, way %zu", round, w);
            }
    }
    assert_in_range(refused, ROUNDS / 20, ROUNDS / 2);
}

// Rounding to 24 bits is all that happens to the ratio of two parts.
TEST(doubles_keep_24_bits)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 200; ++round) {
        double row[NUMBERS], middle = rng_between(&r, -900, 900);
        make_needle(&r, middle - 120, middle + 120, row);
        const double *q = row + COLUMNS + 6;
        duet_scene *scene = must(by_doubles(row, ERR));
        const float *kept = test_poses(scene)[1].rotation;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                assert_int_equal(q[i] == 0, kept[i] == 0);
                if (q[i] == 0 || q[j] == 0)
                    continue;
                double ratio = (double)kept[i] / kept[j] / (q[i] / q[j]);
                assert_true(fabs(ratio - 1) < 0x1.0001p-23);
            }
    }
}

TEST(what_cannot_be_kept_is_refused_by_its_line)
{
    scene_assert_refused("test_rotations.csv",
                         "0 0 0 1 1 1 0 0 0 1\n1 0 0 1 1 1 0 0 1e-300 1e300\n",
                         DUET_STATUS_BAD_OBJECT,
                         "test_rotations.csv:2: object 1: qz = 1e-300 vanishes beside the "
                         "quaternion's greatest part; expected a ratio of at most 1e+83");
    scene_assert_refused("test_rotations.csv", "0 0 1 1 1e-300\n", DUET_STATUS_BAD_OBJECT,
                         "test_rotations.csv:1: object 0: angle = 1e-300 is too near 0; expected "
                         "0, or 2e-83 or more");
}

// ------------------------------------------------------------ angles

TEST(an_angle_however_small_turns)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 300; ++round) {
        double angle = ldexp(rng_between(&r, 0.5, 1), -(int)rng_below(&r, 340));
        char rows[128];
        snprintf(rows, sizeof rows, "0 0 .5 .5 0\n1 0 .5 0 %.17g\n", angle);
        duet_error err = {0};
        duet_scene *scene = scene_from_text("test_rotations.csv", rows, &err);
        assert_int_equal(scene != NULL, angle >= 0x1p-275);
        if (scene) {
            const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
            assert_false(duet_poses_collide(&poses[0], &poses[1], 2));
        }
    }
}
