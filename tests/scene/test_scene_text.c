// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "support/locale.h"
#include "support/scene_file.h"
#include "support/test.h"

#define FILE_NAME "test_scene_text.csv"

TEST(the_columns_say_what_a_row_is)
{
    static const struct {
        const char *row;
        uint32_t dims;
        duet_shape shape;
    } kinds[] = {
        {"0,0,1,1", 2, DUET_SHAPE_BOUNDS},
        {"0,0,1,1,0.5", 2, DUET_SHAPE_POSES},
        {"0,0,0,1,1,1", 3, DUET_SHAPE_BOUNDS},
        {"0,0,0,1,1,1,0,0,0,1", 3, DUET_SHAPE_POSES},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        duet_scene *scene = must(scene_from_text(FILE_NAME, kinds[i].row, ERR));
        const duet_scene_info *info = duet_scene_get_info(scene);
        assert_string_equal(info->name, "test_scene_text");
        assert_int_equal(info->n, 1);
        assert_int_equal(info->dims, kinds[i].dims);
        assert_int_equal(info->shape, kinds[i].shape);
        assert_false(info->has_world);
    }
}

TEST(a_box_turned_in_2d_becomes_a_quaternion)
{
    duet_scene *scene = must(scene_from_text(FILE_NAME, "1 2 3 4 0.7\n1 2 3 4 0\n", ERR));
    const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    const duet_pose want = {{1, 2, 0}, {3, 4, 0}, {0, 0, (float)sin(0.35), (float)cos(0.35)}};
    assert_memory_equal(&poses[0], &want, sizeof want);
    assert_true(poses[1].rotation[2] == 0 && poses[1].rotation[3] == 1);
    assert_true(duet_scene_get_info(scene)->rotated);
}

TEST(ways_of_writing_make_no_difference)
{
    static const char *const ways[] = {
        "1,2,3,4\n5,6,7,8\n",
        "1 2 3 4\n5\t6  7 8",
        "  1 , 2 ,3, 4  \r\n5 ,6, 7,8\r\n",
        "\xEF\xBB\xBFmin_x,min_y,max_x,max_y\n1,2,3,4\n5,6,7,8\n",
        "# boxes\n\n\"min x\" \"min y\" 'max' _y\n\n1,2,3,4 # the first\n   # none\n5,6,7,8#",
        "+1,2.0,0.3e1,0x4\n5e0,.6e1,7.,8\n\n\n",
    };
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; ++i) {
        duet_scene *scene = must(scene_from_text(FILE_NAME, ways[i], ERR));
        assert_int_equal(duet_scene_get_info(scene)->n, 2);
        const duet_bounds want[] = {{{1, 2, 0}, {3, 4, 0}}, {{5, 6, 0}, {7, 8, 0}}};
        assert_memory_equal(duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS), want, sizeof want);
    }
}

TEST(a_file_without_rows_is_a_scene_without_objects)
{
    static const char *const empty[] = {"", "\n\n", "# nothing", "cx cy cz", "\xEF\xBB\xBF"};
    for (size_t i = 0; i < sizeof empty / sizeof empty[0]; ++i) {
        duet_scene *scene = must(scene_from_text(FILE_NAME, empty[i], ERR));
        assert_int_equal(duet_scene_get_info(scene)->n, 0);
    }
}

TEST(a_number_is_rounded_to_the_nearest_float)
{
    duet_scene *scene = must(
        scene_from_text(FILE_NAME, "0.1,1e-46,16777217,3.40282346e38,0.30000001192092896", ERR));
    const duet_pose *pose = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    assert_true(pose->centre[0] == 0.1f && pose->centre[1] == 0.0f);
    assert_true(pose->half_extents[0] == 16777216.0f && pose->half_extents[1] == 0x1.fffffep127f);
}

TEST(a_wrong_line_is_named)
{
    static const struct {
        const char *chars;
        duet_status status;
        const char *says;
    } wrong[] = {
        {"1,2,3,4\n1,2,3,4,5,6,7\n", DUET_STATUS_BAD_INPUT,
         FILE_NAME ":2: object 1 has 7 numbers, where those before it have 4"},
        {"0,0,0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,0,0,1,1\n", DUET_STATUS_BAD_INPUT,
         FILE_NAME ":2: object 1 has 11 numbers, where those before it have 10"},
        {"0,0,0,0,0,0,0,0,0,1,-1\n", DUET_STATUS_BAD_OBJECT,
         FILE_NAME ":1: object 0: radius = -1 is negative; a radius is 0 or more"},
        {"0,0,0,0,0,1,1\n0,0,0,0,0,1,nan\n", DUET_STATUS_BAD_OBJECT,
         FILE_NAME ":2: object 1: radius is nan"},
        {"0,0,0,0,0,1,1e39\n", DUET_STATUS_BAD_OBJECT,
         FILE_NAME ":1: object 0: radius = 1e+39 does not fit a 32-bit float"},
        {"1,2,3,4,5,6,7,8\n", DUET_STATUS_BAD_INPUT,
         FILE_NAME ":1: object 0 has 8 numbers; it must have 4, 5, 6, 7, 10 or 11"},
        {"1 2 3 4 5 6 7 8 9 10 11 12 13", DUET_STATUS_BAD_INPUT, ":1: object 0 has 13 numbers"},
        {"7", DUET_STATUS_BAD_INPUT, ":1: object 0 has 1 numbers"},
        {"\n\n1,2,x,4", DUET_STATUS_BAD_INPUT, ":3: column 3: 'x' is not a number"},
        {"1,2,3,4\na b c d", DUET_STATUS_BAD_INPUT, ":2: column 1: 'a' is not a number"},
        {"a b c d\na b c d", DUET_STATUS_BAD_INPUT, ":2: column 1: 'a' is not a number"},
        {"1.5.2,2,3,4", DUET_STATUS_BAD_INPUT, ":1: column 1: '1.5.2' is not a number"},
        {"1;2;3;4", DUET_STATUS_BAD_INPUT, ":1: column 1: '1;2;3;4' is not a number"},
        {"1,,3,4", DUET_STATUS_BAD_INPUT, ":1: column 2 is empty"},
        {"0,5 0 0 1 1 1", DUET_STATUS_BAD_INPUT,
         FILE_NAME ":1: a blank after column 2, where commas separate those before it; expected "
                   "only blanks, or a comma between any two, and decimal points"},
        {"1 2 3 4\n0 0 1,5 1", DUET_STATUS_BAD_INPUT, ":2: a comma after column 3, where blanks"},
        {"0, 0, 1 1", DUET_STATUS_BAD_INPUT, ":1: a blank after column 3, where commas"},
        {"1,2,3,4,\n", DUET_STATUS_BAD_INPUT, ":1: column 5 is empty"},
        {",1,2,3", DUET_STATUS_BAD_INPUT, ":1: column 1 is empty"},
        {"1,2,\x01z,4", DUET_STATUS_BAD_INPUT, ":1: column 3: '?z' is not a number"},
        {"0,0,1,1\n0,nan,1,1", DUET_STATUS_BAD_OBJECT, ":2: object 1: min y is nan"},
        {"0,0,1,1\n0,0,inf,1", DUET_STATUS_BAD_OBJECT, ":2: object 1: max x is inf"},
        {"0,0,1,1,0\n0,nan,1,1,0", DUET_STATUS_BAD_OBJECT, ":2: object 1: cy is nan"},
        {"0,0,1,1,-inf", DUET_STATUS_BAD_OBJECT, ":1: object 0: angle is -inf"},
        {"1e999,0,1,1,0", DUET_STATUS_BAD_OBJECT, ":1: object 0: cx is inf"},
        {"0,1e39,1,1,0", DUET_STATUS_BAD_OBJECT, "cy = 1e+39 does not fit a 32-bit float"},
        {"0,0,1,-1e-60,0", DUET_STATUS_BAD_OBJECT, "hy = -1e-60 is negative"},
        {"0,0,0,1,1,1,0,0,0,0", DUET_STATUS_BAD_OBJECT, ":1: object 0: the quaternion is zero"},
        {"0,0,0,1,-1,1", DUET_STATUS_BAD_OBJECT, ":1: object 0: min y = 0 is above max y = -1"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        scene_assert_refused(FILE_NAME, wrong[i].chars, wrong[i].status, wrong[i].says);
}

TEST(bytes_are_not_read_as_text)
{
    must_fail(scene_from_bytes(FILE_NAME, "1 2 3 4\n\0 1", 11, NULL, 0, ERR), DUET_STATUS_BAD_INPUT,
              "byte 8 is NUL");
}

TEST(a_missing_file_and_a_folder_are_named)
{
    must_fail(duet_scene_load("no/such/boxes.csv", NULL, 0, ERR), DUET_STATUS_NOT_FOUND,
              "no/such/boxes.csv");
    must_fail(duet_scene_load("/", NULL, 0, ERR), DUET_STATUS_IO_FAILED, "");
}

TEST(data_have_no_parameters)
{
    const duet_setting setting = {"n", "10"};
    must_fail(scene_from_bytes(FILE_NAME, "0 0 1 1", 7, &setting, 1, ERR), DUET_STATUS_BAD_ARGUMENT,
              "'n' cannot be chosen, since this is data and no .lua scene");
}

// Another language's decimal comma must not reach the numbers.
TEST(the_language_of_the_application_does_not_matter)
{
    test_make_comma_locale();
    test_speak_with_comma(true);
    const duet_scene *scene = scene_from_text(FILE_NAME, "0.5,0.5,1.5,1.5", ERR);
    test_speak_with_comma(false);
    assert_non_null(scene);
    assert_true(test_bounds(scene)->upper[1] == 1.5f);
}

#define SAMPLE "cx cy hx hy angle\n0.25, -1e3, 0.5, 0.5, 0.785\r\n# two\n-7 8 1 2 3\n"

// A beginning of the file, and the file with bytes changed, either make a scene
// of checked objects or are refused with one line.
static void assert_scene_or_line(const char *bytes, size_t n)
{
    duet_error err = {0};
    duet_scene *scene = scene_from_bytes(FILE_NAME, bytes, n, NULL, 0, &err);
    assert_true((scene != NULL) == (err.status == DUET_STATUS_OK));
    assert_true(scene || (err.text[0] && !strchr(err.text, '\n')));
    for (uint32_t i = 0; scene && i < duet_scene_get_info(scene)->n; ++i)
        if (duet_scene_get_objects(scene, DUET_OBJECT_POSES))
            assert_true(isfinite(test_poses(scene)[i].centre[0]));
}

TEST(every_beginning_of_a_file_is_read_or_refused)
{
    for (size_t n = 0; n <= strlen(SAMPLE); ++n)
        assert_scene_or_line(SAMPLE, n);
}

TEST(changed_bytes_are_read_or_refused)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 3000; ++round) {
        char bytes[] = SAMPLE;
        for (uint32_t k = 1 + rng_below(&r, 4); k > 0; --k)
            bytes[rng_below(&r, sizeof bytes - 1)] = (char)rng_below(&r, 256);
        assert_scene_or_line(bytes, sizeof bytes - 1);
    }
}
