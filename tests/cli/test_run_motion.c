// SPDX-License-Identifier: MIT
// duet run --steps, as a person calls it.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/test.h"

#include "base/text_file.h"

#include <sys/stat.h>
#include <unistd.h>

#define SCENE "test_run_motion.scene.lua"
#define PICTURE "test_run_motion.png"
#define FULL "test_run_motion.full.png"
#define FRAMES "test_run_motion.frames"
#define BALL "test_run_motion.ball.lua"
#define SCRIPT "test_run_motion.script.lua"
#define RECORDING "test_run_motion.replay"

// A pile that falls, and a bullet.
static const char scene_text[] =
    "for i = 0, 7 do\n"
    "  add { centre = { i % 2 * 1.1, i // 2 % 2 * 1.1, 0.6 + i // 4 * 1.2 },\n"
    "        half_extents = { 0.5, 0.5, 0.5 } }\n"
    "end\n"
    "add { centre = { -4, 0, 1 }, half_extents = { 0.2, 0.2, 0.2 }, velocity = { 100, 0, 0 } }\n"
    "return { dims = 3, gravity = { 0, 0, -10 }, boundary = 'walls', wants = { 'contact_response' "
    "},\n"
    "         world = { lower = { -5, -5, 0 }, upper = { 5, 5, 9 } } }\n";

static void make_scene(void)
{
    test_write_file(SCENE, scene_text);
}

// Which colours the picture has says what it shows; here it is enough that it
// is a PNG whose size is that of a page with something on it.
static void assert_is_picture(const char *path)
{
    const text bytes = test_read_file(path);
    assert_true(bytes.length > 4000);
    assert_memory_equal(text_chars(&bytes), "\x89PNG\r\n", 6);
}

TEST(a_picture_and_frames_are_drawn)
{
    program p =
        program_done(program_run("run --steps 8 --picture " PICTURE " --frames " FRAMES " " SCENE));
    assert_is_picture(PICTURE);
    char path[64];
    for (int i = 0; i < 5; ++i) { // 60 steps a second and 30 pictures
        snprintf(path, sizeof path, FRAMES "/%05d.png", i);
        assert_is_picture(path);
    }
    assert_int_not_equal(access(FRAMES "/00005.png", F_OK), 0);
    assert_says(p.out, "effects:", "of the work, kernels '", "plan: the default",
                " contact_response");
}

// The column of a table's row, from 0; NAN where there is none.
static double column_of(const char *row, int column)
{
    double number = NAN;
    row = strstr(row, "  "); // behind the name
    for (int i = 0; row && i < column; ++i) {
        row += strspn(row, " ");
        row += strcspn(row, " \n");
    }
    if (!row)
        return number;
    sscanf(row, "%lf", &number);
    return number;
}

TEST(the_parts_of_a_step_add_up_to_it)
{
    program p = program_done(program_run("run --steps 8 " SCENE));
    const char *table = strstr(p.out, "ms a step ");
    assert_non_null(table);
    double ms = 0, percent = 0, step = NAN;
    int n = 0;
    for (const char *row = strchr(table, '\n') + 1; *row != '\n'; row = strchr(row, '\n') + 1) {
        ms += column_of(row, 0);
        percent += column_of(row, 1);
        ++n;
    }
    const char *end = strstr(table, " ms a step after the first");
    assert_non_null(end);
    while (end[-1] != '\n')
        --end;
    sscanf(end, "%lf", &step);
    assert_true(n > 3);
    assert_true(ms >= step - 0.0006 * (n + 1)); // each is rounded; devices overlap
    assert_true(fabs(percent - 100) <= 0.06 * n);
}

TEST(json_says_what_the_table_does)
{
    program p = program_done(program_run("run --steps 8 --json " SCENE));
    cJSON *o = json_of(p.out);
    assert_true(json_number(o, "steps") == 8);
    assert_true(json_number(o, "objects") == 9);
    json_field(json_field(o, "stages_ms"), "solve_contacts");
}

TEST(what_cannot_be_drawn_is_refused_before_the_steps)
{
    static const program_refusal wrong[] = {
        {"run --picture x.png " SCENE, 2, "--picture does nothing without --steps"},
        {"run --frames x " SCENE, 2, "--frames does nothing without --steps"},
        {"run --steps 3 --format vtu " SCENE, 2, "--format does nothing without --frames"},
        {"run --steps 1000000000 --frames x --format vtk " SCENE, 2, "--format: give png"},
        {"run --steps 1000000000 --picture x.svg " SCENE, 2, "ends with .png"},
        {"run --steps 1000000000 --json --picture no/such/x.png " SCENE, 1, "cannot be written"},
        {"run --steps 1000000000 --json --frames no/such/folder " SCENE, 1, "cannot be made"},
        {"run --steps 1000000000 --json --frames " SCENE " " SCENE, 1, SCENE "/00000.png"},
        {"run --steps 1000000000 --json --format vtu --frames " SCENE " " SCENE, 1,
         SCENE "/bodies_00000.vtu"},
    };
    program_assert_refusals("", "", wrong);
}

TEST(what_is_of_a_scene_at_rest_is_refused_with_steps)
{
    static const char *const options[] = {"--repeat 3",    "--input host",  "--ordered",
                                          "--pairs x.csv", "--check",       "--level sat6",
                                          "--missed 0",    "--false-rate 1"};
    for (size_t i = 0; i < sizeof options / sizeof *options; ++i)
        program_assert_refused(program_run("run --steps 3 %s " SCENE, options[i]), 2,
                               "and --steps do not go together");
    assert_int_not_equal(access("x.csv", F_OK), 0);
}

// A path that is no file is neither replaced nor removed.
TEST(a_full_disk_is_told_of)
{
    skip_without_device("/dev/full");
    assert_int_equal(symlink("/dev/full", FULL), 0);
    program p = program_run("run --steps 1000000000 --json --picture " FULL " " SCENE);
    struct stat info;
    assert_int_equal(stat(FULL, &info), 0);
    assert_true(S_ISCHR(info.st_mode));
    program_assert_refused(p, 1, "No space left");
}

TEST(a_recording_gives_the_same_hash_with_another_plan)
{
    program p = program_done(program_run("run --steps 8 --record " RECORDING " --share 0 " SCENE));
    const char *hash = strstr(p.out, "state hash");
    assert_non_null(hash);
    program q = program_done(
        program_run("run --steps 8 --replay " RECORDING " --share 0.5 --mode slab " SCENE));
    assert_string_equal(strstr(q.out, "state hash"), hash);
    program_assert_refused(program_run("run --steps 9 --replay " RECORDING " " SCENE), 2,
                           RECORDING " has 8 recorded steps");
    program_assert_refused(program_run("run --steps 8 --replay " SCENE " " SCENE), 1,
                           "expected \"duet commands 2\"");
    p = program_run("run --steps 8 --replay " RECORDING " falling -n 9");
    assert_int_equal(p.exit_code, 1);
    assert_says(p.err, "recorded from step 0, 9 places");
    program_assert_refused(program_run("run --replay " RECORDING " " SCENE), 2, "--replay");
}

// The first step of a scene, as a picture that the test keeps.
static text draw(const char *options, const char *scene)
{
    test_write_file(BALL, scene);
    program_done(program_run("run --steps 1 %s --picture " PICTURE " " BALL, options));
    return test_read_file(PICTURE);
}

static bool are_same(text a, text b)
{
    return a.length == b.length && memcmp(a.chars, b.chars, a.length) == 0;
}

// A scene of one ball at rest, and a recording in which another one comes, with the given radius.
static text draw_one_that_comes(double radius)
{
    static const char scene[] =
        "add { centre = { 0, 0, 0 }, half_extents = { 0, 0, 0 }, radius = 1 }\n"
        "return { dims = 3, wants = { 'contact_response' } }\n";
    static const char script[] =
        "local duet = require 'duet'\n"
        "local pair <close> = assert(duet.device_pair())\n"
        "local scene <close> = assert(duet.scene '" BALL "')\n"
        "local motion <close> = assert(pair:motion(scene))\n"
        "assert(motion:record())\n"
        "assert(motion:add_bodies({ { 1.8, 0, 0, 0.1, 0.1, 0.1, 0, 0, 0, 1 } },\n"
        "  { { 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xffffffff, 0xffffffff, %g, false, false } }))\n"
        "assert(motion:advance())\n"
        "assert(motion:save_recording '" RECORDING "')\n";
    char given[sizeof script + 16];
    snprintf(given, sizeof given, script, radius);
    test_write_file(SCRIPT, given);
    test_write_file(BALL, scene);
    program_done(program_run("lua --trust " SCRIPT));
    return draw("--replay " RECORDING, scene);
}

// Nothing else differs.
TEST(what_commands_bring_is_drawn_with_its_radius)
{
    text sharp = draw_one_that_comes(0.0), round = draw_one_that_comes(0.5);
    assert_true(sharp.length > 100 && round.length > 100);
    assert_false(are_same(sharp, round));
}

// A ridge, balls before and behind it, and another one.
static text draw_on_ridge(double height, double x, double y)
{
    static const char scene[] =
        "local values = {}\n"
        "for j = 0, 8 do for i = 0, 8 do\n"
        "  values[#values + 1] = (i - j == 2 or i - j == 3) and %g or 0\n"
        "end end\n"
        "local body = { half_extents = { 0, 0, 0 }, radius = 0.5, mass = 0 }\n"
        "body.centre = { 7, -7, 0.5 } add(body)\n"
        "body.centre = { -7, 7, 0.5 } add(body)\n"
        "body.radius = 0.1 body.centre = { %g, %g, 0.5 } add(body)\n"
        "return { dims = 3, wants = { 'contact' },\n"
        "         heights = { nx = 9, ny = 9, spacing = 2, origin = { -8, -8, 0 }, values = values "
        "} }\n";
    char given[sizeof scene + 64];
    snprintf(given, sizeof given, scene, height, x, y);
    return draw("", given);
}

// The eye stands at great x and small y. A greater ball would be seen by a 255th where two
// triangles meet, as Cairo smooths their edges.
TEST(hills_hide_what_is_behind_them_alone)
{
    text behind = draw_on_ridge(8, 0, -1), there = draw_on_ridge(8, 0.5, -0.5);
    text ahead = draw_on_ridge(8, 4, -5), level = draw_on_ridge(0, 0, -1);
    text level_there = draw_on_ridge(0, 0.5, -0.5);
    assert_true(are_same(behind, there));
    assert_false(are_same(behind, ahead));
    assert_false(are_same(behind, level));
    assert_false(are_same(level, level_there));
}

// An upright plate of two triangles that looks to the eye or away from it, and a ball that is
// smaller than the pieces in which the plate is drawn.
static text draw_at_plate(bool to_eye, double x)
{
    static const char scene[] =
        "local body = { half_extents = { 0, 0, 0 }, radius = 0.5, mass = 0 }\n"
        "body.centre = { 7, -7, 1 } add(body)\n"
        "body.centre = { -7, 7, 1 } add(body)\n"
        "body.radius = 0.02 body.centre = { %g, %g, 1 } add(body)\n"
        "return { dims = 3, wants = { 'contact' }, mesh = {\n"
        "  vertices = { -5, -5, 0, 5, 5, 0, 5, 5, 8, -5, -5, 8 },\n"
        "  triangles = { %s } } }\n";
    char given[sizeof scene + 64];
    snprintf(given, sizeof given, scene, x, -x, to_eye ? "0, 1, 2, 0, 2, 3" : "0, 2, 1, 0, 3, 2");
    return draw("", given);
}

TEST(a_mesh_hides_what_is_behind_its_outside_alone)
{
    text behind = draw_at_plate(true, -1.25), further = draw_at_plate(true, -1.6);
    text ahead = draw_at_plate(true, 1), from_within = draw_at_plate(false, -1.25);
    text from_within_further = draw_at_plate(false, -1.6);
    assert_true(are_same(behind, further));
    assert_false(are_same(behind, ahead));
    assert_false(are_same(behind, from_within));
    assert_false(are_same(from_within, from_within_further));
}

// Returns whether there are so many buffers. A run without one of them ends with a line.
static bool ends_without_buffer(int buffer)
{
    char variables[320];
    snprintf(variables, sizeof variables,
             "ASAN_OPTIONS=verify_asan_link_order=0 LD_PRELOAD=" TEST_WRONG " REFUSED_BUFFER=%d",
             buffer);
    program p = program_run_with(variables, "run --steps 2 " SCENE);
    if (p.exit_code == 0 && !*p.err)
        return false;
    const char *end = strchr(p.err, '\n');
    if (p.exit_code != 1 || !end || end[1] || !strstr(p.err, "CL_MEM_OBJECT_ALLOCATION_FAILURE"))
        fail_msg("without buffer %d: exit %d, '%s'", buffer, p.exit_code, p.err);
    return true;
}

TEST(a_run_ends_if_a_buffer_is_refused)
{
    int buffer = 0;
    while (ends_without_buffer(buffer))
        buffer += 5;
    assert_true(buffer > 20);
}

TEST_BEGIN(make_scene)
