// SPDX-License-Identifier: MIT
// Files of pairs: read, tested by `duet query`, and what it writes.
#include "support/json.h"
#include "support/test.h"

#include "base/npy.h"
#include "base/text_file.h"

#define TOUCHING "0 0 0 .5 .5 .5 0 0 0 1   1 0 0 .5 .5 .5 0 0 0 1\n"
#define APART "0,0,0,.5,.5,.5,0,0,0,1, 0,2,0,.5,.5,.5,0,0,1,0\n"

static void write_file(const char *path, const void *bytes, size_t n)
{
    must(text_write_file(path, bytes, n, ERR));
}

// ------------------------------------------------------------ reading

TEST(rows_of_text_become_two_poses_each)
{
    test_write_file("pairs.csv", "# two pairs\n" TOUCHING APART);
    duet_scene *pairs = kept(duet_scene_load_pairs("pairs.csv", ERR));
    const duet_scene_info *info = duet_scene_get_info(pairs);
    const duet_pose *poses = duet_scene_get_objects(pairs, DUET_OBJECT_POSES);
    assert_int_equal(info->n, 4);
    assert_int_equal(info->dims, 3);
    assert_true(poses[1].centre[0] == 1 && poses[3].centre[1] == 2 && poses[3].rotation[2] == 1);
    test_give_back(pairs);
    test_write_file("pairs.csv", "0 0 1 1 0  3 0 1 1 3.14159\n");
    pairs = kept(duet_scene_load_pairs("pairs.csv", ERR));
    assert_int_equal(duet_scene_get_info(pairs)->n, 2);
    assert_int_equal(duet_scene_get_info(pairs)->dims, 2);
}

// An array of shape (n, 20) as NumPy writes it.
static void write_array(const char *path, const char *descr, const void *items, size_t item_bytes,
                        uint32_t n)
{
    own(text) file = {0};
    char literal[118];
    snprintf(literal, sizeof literal,
             "{'descr': '%s', 'fortran_order': False, 'shape': (%u, 20), }", descr, n);
    text_add_bytes(&file, "\x93NUMPY\1\0\x76\0", 10);
    text_add(&file, "%-117s\n", literal);
    text_add_bytes(&file, items, 20 * n * item_bytes);
    write_file(path, file.chars, file.length);
}

TEST(doubles_are_rounded_to_the_nearest_float_and_floats_are_kept)
{
    double row[20] = {0.1, 0, 0, 1, 1, 1, 0, 0, 0, 1, 16777217, 0, 0, 1, 1, 1, 0, 0, 0, 1};
    float single[20];
    for (int i = 0; i < 20; ++i)
        single[i] = (float)row[i];
    write_array("doubles.npy", "<f8", row, 8, 1);
    write_array("floats.npy", "<f4", single, 4, 1);
    duet_scene *doubles = kept(duet_scene_load_pairs("doubles.npy", ERR));
    duet_scene *floats = kept(duet_scene_load_pairs("floats.npy", ERR));
    const duet_pose *poses = duet_scene_get_objects(doubles, DUET_OBJECT_POSES);
    assert_true(poses[0].centre[0] == 0.1f && poses[1].centre[0] == 16777216);
    assert_memory_equal(poses, duet_scene_get_objects(floats, DUET_OBJECT_POSES),
                        2 * sizeof *poses);
}

TEST(wrong_files_are_refused_with_pair_and_pose)
{
    static const refusal wrong[] = {
        {TOUCHING "0 0 0 1 1 1 0 0 0 1  0 0 0 1 -1 1 0 0 0 1\n",
         "pairs.csv:2: pair 1, second pose: hy = -1 is negative; a half extent is 0 or more"},
        {"nan 0 0 1 1 1 0 0 0 1  0 0 0 1 1 1 0 0 0 1\n",
         "pairs.csv:1: pair 0, first pose: cx is nan; every number must be finite"},
        {"0 0 0 1 1 1 0 0 0 0  0 0 0 1 1 1 0 0 0 1\n",
         "pairs.csv:1: pair 0, first pose: the quaternion is zero; 0 0 0 1 is no rotation"},
        {"1 2 3 4 5 6 7 8 9 10 11 12\n",
         "pairs.csv:1: pair 0 has 12 numbers; it must have 20, or 10 in 2D"},
        {"hello world\n", "pairs.csv:1: column 1: 'hello' is not a number"},
        {TOUCHING "0 0 1 1 0 0 0 1 1 0\n",
         "pairs.csv:2: pair 1 has 10 numbers, where those before it have 20"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        test_write_file("pairs.csv", wrong[i].given);
        must_fail(duet_scene_load_pairs("pairs.csv", ERR), ANY_FAILURE, "");
        assert_string_equal(ERR->text, wrong[i].says);
    }
    remove("pairs.csv");
    test_write_file("pairs.lua", "return {}");
    must_fail(duet_scene_load_pairs("pairs.lua", ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "pairs.lua: pairs are read from .npy or text");
}

// A header alone says how many there are.
TEST(too_many_pairs_are_called_pairs)
{
    own(text) t = {0};
    text_add(&t, "%-117s\n",
             "{'descr': '<f4', 'fortran_order': False, 'shape': (4294967293, 20), }");
    FILE *file = fopen("many.npy", "wb");
    assert_int_equal(fwrite("\x93NUMPY\1\0\x76\0", 1, 10, file), 10);
    assert_int_equal(fwrite(t.chars, 1, t.length, file), t.length);
    fclose(file);
    must_fail(duet_scene_load_pairs("many.npy", ERR), DUET_STATUS_TOO_MANY,
              "many.npy: 4294967293 pairs; a file of pairs holds at most 2147483646");
}

// ------------------------------------------------------------ writing

TEST(arrays_are_written_as_numpy_reads_them)
{
    const uint8_t answers[3] = {1, 0, 1};
    must(npy_write("answers.npy", NPY_UINT8, answers, 3, ERR));
    text bytes = test_read_file("answers.npy");
    assert_int_equal(bytes.length, 128 + 3);
    assert_memory_equal(bytes.chars, "\x93NUMPY\1\0\x76\0", 10);
    static const char literal[] = "{'descr': '|u1', 'fortran_order': False, 'shape': (3,), } ";
    assert_memory_equal(bytes.chars + 10, literal, sizeof literal - 1);
    assert_int_equal(bytes.chars[127], '\n');
    assert_memory_equal(bytes.chars + 128, answers, 3);
    const double separations[2] = {0.5, -1e300};
    must(npy_write("answers.npy", NPY_FLOAT64, separations, 2, ERR));
    const text again = test_read_file("answers.npy");
    assert_int_equal(again.length, 128 + 16);
    assert_memory_equal(again.chars + 128, separations, 16);
    remove("answers.npy");
    must_fail(npy_write("no/such/folder/v.npy", NPY_UINT8, answers, 3, ERR), DUET_STATUS_IO_FAILED,
              "no/such/folder/v.npy: cannot be written");
}

// ------------------------------------------------------------ the program

#define CACHED "DUET_CACHE=test_pairs.cache" // many runs, few kernels

TEST(the_program_tests_a_file_at_every_level)
{
    test_write_file("pairs.csv", TOUCHING APART TOUCHING);
    for (int l = 0; l < DUET_LEVELS; ++l) {
        cJSON *o = json_of_run_with(CACHED, "query pairs.csv --json --share 1/3 --level %s",
                                    duet_level_get_info((duet_level)l)->name);
        assert_true(json_number(o, "n") == 3 && json_number(o, "colliding") == 2);
        assert_true(json_number(o, "undecided") == (l == DUET_LEVEL_CERTIFIED ? 2 : 0));
        assert_true(json_number(o, "seconds") >= 0);
    }
}

static void assert_file(const char *path, const char *expected)
{
    const text bytes = test_read_file(path);
    assert_string_equal(text_chars(&bytes), expected);
}

TEST(the_program_writes_answers_and_separations)
{
    test_write_file("pairs.csv", TOUCHING APART);
    static const char *const outs[] = {"answers.csv", "answers.npy"};
    for (int i = 0; i < 2; ++i) {
        program p =
            program_done(program_run_with(CACHED, "query pairs.csv --separations -o %s", outs[i]));
        assert_string_equal(p.err, "");
    }
    assert_file("answers.csv", "1,0\n0,1\n");
    assert_memory_equal(test_read_file("answers.npy").chars + 128, "\1\0", 2);
    const text separations = test_read_file("answers.separations.npy");
    assert_memory_equal(separations.chars + 128, ((const double[2]){0, 1}), 16);
}

TEST(wrong_usage_is_told)
{
    test_write_file("pairs.csv", TOUCHING);
    static const program_refusal wrong[] = {
        {"query", 2, "PAIRS.npy|FILE"},
        {"query pairs.csv --separations", 2, "--separations does nothing without --output"},
        {"query pairs.csv --device pocl:0 --share 0.5", 2,
         "--share and --device do not go together"},
        {"query pairs.csv --level exact", 2, "the levels are certified, aabb"},
        {"query pairs.csv --device abacus:0", 2, "no device 'abacus:0'"},
        {"query none.npy", 1, "none.npy: No such file"},
        {"query pairs.csv -o no/such/v.npy", 1, "no/such/v.npy: cannot be written"},
    };
    program_assert_refusals("", "", wrong);
}
