// SPDX-License-Identifier: MIT
#include "support/devices.h"
#include "support/scene_file.h"
#include "support/test.h"

#include "base/text.h"
#include "gen/script.h"
#include "runtime/scene/scene_load.h"

#define FILE_NAME "test_scene_lua.lua"
#define TEXT_NAME "test_scene_lua.txt"

static bool limited;

static duet_scene *assert_scene(const char *chars)
{
    return must(scene_from_text(FILE_NAME, chars, ERR));
}

TEST(a_scene_says_its_world_and_cell)
{
    duet_scene *scene = assert_scene(
        "return { name = 'shed', dims = 2, world = { lower = {-1, -2}, upper = {3, 4} },"
        "         cell = 1.5, cell_fixed = true, accuracy = { false_rate = 0.02 },"
        "         objects = {{0, 0, 1, 1}} }");
    const duet_scene_info *info = duet_scene_get_info(scene);
    assert_string_equal(info->name, "shed");
    assert_int_equal(info->dims, 2);
    assert_int_equal(info->shape, DUET_SHAPE_BOUNDS);
    assert_true(info->has_world && info->cell_fixed && info->cell == 1.5f);
    assert_true(info->lower[0] == -1 && info->lower[1] == -2);
    assert_true(info->upper[0] == 3 && info->upper[1] == 4);
    duet_world_def def = duet_scene_world_def(scene, NULL);
    assert_int_equal(def.dims, 2);
    assert_int_equal(def.shape, DUET_SHAPE_BOUNDS);
    assert_true(def.has_world && def.cell_fixed && def.cell == 1.5f && !def.rotated);
    assert_true(def.has_accuracy && def.accuracy.missed == 0 && def.accuracy.false_rate == 0.02);
    assert_int_equal(def.level, DUET_LEVEL_CERTIFIED);
    assert_memory_equal(def.lower, info->lower, sizeof def.lower);
    assert_memory_equal(def.upper, info->upper, sizeof def.upper);
}

TEST(what_a_scene_leaves_out_has_a_default)
{
    duet_scene *scene = assert_scene("return {}");
    const duet_scene_info *info = duet_scene_get_info(scene);
    assert_string_equal(info->name, "test_scene_lua");
    assert_int_equal(info->n, 0);
    assert_int_equal(info->dims, 3);
    assert_false(info->has_world || info->cell_fixed || info->rotated);
    assert_true(info->cell == 0);
}

TEST(all_ways_to_write_an_object_agree)
{
    duet_scene *scene = assert_scene(
        "add(1, 2, 3, 4, 5, 6, 0, 0, 0, 1)\n"
        "add { 1, 2, 3, 4, 5, 6, 0, 0, 0, 1 }\n"
        "add { centre = {1, 2, 3}, half_extents = {4, 5, 6} }\n"
        "return { objects = { { 1, 2, 3, 4, 5, 6, 0, 0, 0, 1 },\n"
        "  { centre = {1, 2, 3}, half_extents = {4, 5, 6}, rotation = {0, 0, 0, 1} },\n"
        "  { centre = {1, 2, 3}, half_extents = {4, 5, 6}, euler = {0, 0, 0} } } }");
    const duet_pose want = {{1, 2, 3}, {4, 5, 6}, {0, 0, 0, 1}};
    assert_int_equal(duet_scene_get_info(scene)->n, 6);
    for (int i = 0; i < 6; ++i)
        assert_memory_equal(&test_poses(scene)[i], &want, sizeof want);
    scene = assert_scene(
        "add(1, 2, 3, 4, 0.5) "
        "return { objects = {{ centre = {1, 2}, half_extents = {3, 4}, angle = 0.5 }} }");
    assert_memory_equal(&test_poses(scene)[0], &test_poses(scene)[1], sizeof(duet_pose));
    scene = assert_scene("add(1, 2, 3, 4, 5, 6) add { lower = {1, 2, 3}, upper = {4, 5, 6} }"
                         "return {}");
    assert_memory_equal(&test_bounds(scene)[0], &test_bounds(scene)[1], sizeof(duet_bounds));
}

// ---------------------------------------------------------------- rotations

// M(q)/|q|^2
static void quaternion_to_matrix(const float q[4], double m[3][3])
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    double s = 2 / (x * x + y * y + z * z + w * w);
    const double r[3][3] = {
        {1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
        {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)},
        {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)},
    };
    memcpy(m, r, sizeof r);
}

static void multiply(double a[3][3], double b[3][3], double product[3][3])
{
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            product[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k] + a[i][2] * b[2][k];
}

// Rx Ry Rz with the matrices of the paper's figure 4.
static void euler_to_matrix(double phi, double theta, double psi, double m[3][3])
{
    double rx[3][3] = {{1, 0, 0}, {0, cos(phi), -sin(phi)}, {0, sin(phi), cos(phi)}};
    double ry[3][3] = {{cos(theta), 0, sin(theta)}, {0, 1, 0}, {-sin(theta), 0, cos(theta)}};
    double rz[3][3] = {{cos(psi), -sin(psi), 0}, {sin(psi), cos(psi), 0}, {0, 0, 1}};
    double xy[3][3];
    multiply(rx, ry, xy);
    multiply(xy, rz, m);
}

static void assert_matrices_near(double a[3][3], double b[3][3])
{
    for (int i = 0; i < 9; ++i)
        assert_true(fabs(a[i / 3][i % 3] - b[i / 3][i % 3]) < 1e-6);
}

static void assert_euler_is_the_papers(double phi, double theta, double psi)
{
    char chars[160];
    snprintf(chars, sizeof chars, "add(0,0,0, 1,1,1, euler(%.17g, %.17g, %.17g)) return {}", phi,
             theta, psi);
    duet_scene *scene = assert_scene(chars);
    double of_scene[3][3];
    double of_paper[3][3];
    quaternion_to_matrix(test_poses(scene)->rotation, of_scene);
    euler_to_matrix(phi, theta, psi, of_paper);
    assert_matrices_near(of_scene, of_paper);
}

TEST(euler_angles_turn_in_the_papers_order)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 200; ++round)
        assert_euler_is_the_papers(rng_between(&r, -7, 7), rng_between(&r, -7, 7),
                                   rng_between(&r, -7, 7));
}

// With theta a quarter turn, phi and psi turn about the same axis: the angles
// are ambiguous, but the rotation is not.
TEST(a_gimbal_lock_is_a_rotation_as_any_other)
{
    const double quarter = acos(0);
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 100; ++round) {
        double phi = rng_between(&r, -3, 3);
        double psi = rng_between(&r, -3, 3);
        assert_euler_is_the_papers(phi, quarter, psi);
        assert_euler_is_the_papers(phi, -quarter, psi);
        double one[3][3];
        double other[3][3];
        euler_to_matrix(phi, quarter, psi, one);
        euler_to_matrix(phi + 0.25, quarter, psi - 0.25, other);
        assert_matrices_near(one, other);
    }
}

// ------------------------------------------------------------------- errors

TEST(a_wrong_scene_is_refused_with_its_place)
{
    static const struct {
        const char *chars;
        duet_status status;
        const char *says;
    } wrong[] = {
        {"return {\n  dims = 3\n  cell = 1\n}", DUET_STATUS_BAD_INPUT,
         FILE_NAME ":3: '}' expected"},
        {"return {\n  wrld = {}\n}", DUET_STATUS_BAD_INPUT,
         FILE_NAME
         ":2: a scene has no field 'wrld'; its fields are name, objects, dims, world, cell, "
         "cell_fixed"},
        {"return 7", DUET_STATUS_BAD_INPUT, FILE_NAME ": a scene must return a table, not number"},
        {"", DUET_STATUS_BAD_INPUT, FILE_NAME ": a scene must return a table, not nil"},
        {"return { {0, 0, 1, 1} }", DUET_STATUS_BAD_INPUT, FILE_NAME ": a scene has no field [1]"},
        {"return {\n dims = 4 }", DUET_STATUS_BAD_INPUT, ":2: dims is 4; expected 2 or 3"},
        {"add(0, 0, 1, 1) return {\n dims = 3 }", DUET_STATUS_BAD_INPUT,
         ":2: dims is 3, but the objects have 2"},
        {"return { cell = -1 }", DUET_STATUS_BAD_INPUT, ":1: cell is -1; expected an edge above 0"},
        {"return { cell = 1e39 }", DUET_STATUS_BAD_INPUT,
         ":1: cell is 1e+39; expected an edge above 0"},
        {"return { level = 'best' }", DUET_STATUS_BAD_INPUT,
         ":1: level is 'best'; expected one of "},
        {"return { accuracy = { false_rates = 1 } }", DUET_STATUS_BAD_INPUT,
         ":1: accuracy has no field 'false_rates'"},
        {"return { accuracy = { missed = -1 } }", DUET_STATUS_BAD_INPUT,
         ":1: accuracy: missed is -1; expected a part"},
        {"return { level = 'sat6',\n accuracy = {} }", DUET_STATUS_BAD_INPUT,
         ":2: a scene has a level, or an accuracy"},
        {"return { cell_fixed = 1 }", DUET_STATUS_BAD_INPUT,
         ":1: cell_fixed is 1; expected true or false"},
        {"return { name = {} }", DUET_STATUS_BAD_INPUT, ":1: name is a table; expected a string"},
        {"return { world = { low = {} } }", DUET_STATUS_BAD_INPUT, ":1: world has no field 'low'"},
        {"return { world = {\n lower = {0, 0, 0} } }", DUET_STATUS_BAD_INPUT,
         "world has one corner; expected lower and upper"},
        {"return { world = {\n lower = {0, 0} } }", DUET_STATUS_BAD_INPUT,
         ":2: world: lower is a list of 2; expected 3 finite numbers"},
        {"return { world = { lower = {0, 0, 0}, upper = {1, 1, 1/0} } }", DUET_STATUS_BAD_INPUT,
         "world: upper is a list of 3; expected 3 finite numbers"},
        {"return { world = { lower = {0, 0, 0}, upper = {1, -1, 1} } }", DUET_STATUS_BAD_INPUT,
         ":1: world's lower is above its upper"},
        {"return { objects = { a = {} } }", DUET_STATUS_BAD_INPUT,
         ":1: objects is a table; expected a list"},
        {"return { objects = 3 }", DUET_STATUS_BAD_INPUT, ":1: objects is 3; expected a list"},
        {"return { objects = { 3 } }", DUET_STATUS_BAD_INPUT, ": object 0: it must be a table"},
        {"return { objects = { {0, 0, 1, 1}, {0, 0, 1} } }", DUET_STATUS_BAD_INPUT,
         FILE_NAME ": object 1 has 3 numbers, where those before it have 4"},
        {"return { objects = { {0, 0, 1, 1, colour = 3} } }", DUET_STATUS_BAD_INPUT,
         "object 0: it must be a row of numbers, or named fields, not both"},
        {"return { objects = { {0, 0, 1, 'x'} } }", DUET_STATUS_BAD_INPUT,
         "object 0: a number is wanted"},
        {"return { objects = {\n { centre = {0, 0}, haf = {1, 1} } } }", DUET_STATUS_BAD_INPUT,
         ":2: object 0 has no field 'haf'; its fields are centre, half_extents, radius"},
        {"add { centre = {0, 0, 0}, radius = -1 }", DUET_STATUS_BAD_OBJECT,
         FILE_NAME ":1: object 0: radius = -1 is negative; a radius is 0 or more"},
        {"add { lower = {0, 0}, upper = {1, 1}, radius = 1 }", DUET_STATUS_BAD_INPUT,
         ":1: object 0: it must have centre and half_extents or radius or both"},
        {"add { centre = {0, 0, 0}, radius = 1 } return { origin = 'cell' }", DUET_STATUS_BAD_INPUT,
         "origin cells are for boxes without a radius"},
        {"return { objects = { { centre = {0, 0, 0, 0}, half_extents = {1, 1} } } }",
         DUET_STATUS_BAD_INPUT, ":1: object 0: centre is a list of 4; expected 2 or 3 numbers"},
        {"return { objects = { { centre = {0, 0, 0} } } }", DUET_STATUS_BAD_INPUT,
         "object 0: it must have centre and half"},
        {"add(0, 0, 1, 1)\nadd(0, 0, 1)", DUET_STATUS_BAD_INPUT,
         ":2: object 1 has 3 numbers, where those before it have 4"},
        {"\nadd()", DUET_STATUS_BAD_INPUT, ":2: object 0 has 0 numbers"},
        {"\nadd('x', 0, 1, 1)", DUET_STATUS_BAD_INPUT, ":2: bad argument #1 to 'add'"},
        {"\nadd { centre = {0, 0}, half_extents = {1, 1}, euler = {0, 0, 0} }",
         DUET_STATUS_BAD_INPUT, ":2: object 0: it must have centre and half"},
        {"add(0, 0, 1, 1, 0)\nadd(0, 0, -1, 1, 0)", DUET_STATUS_BAD_OBJECT,
         FILE_NAME ":2: object 1: hx = -1 is negative"},
        {"return { objects = { {0, 0, 0/0, 1} } }", DUET_STATUS_BAD_OBJECT,
         FILE_NAME ": object 0: max x is -nan"},
        {"return { objects = { { centre = {0,0,0}, half_extents = {1,1,1}, rotation = {0,0,0,0} } "
         "} }",
         DUET_STATUS_BAD_OBJECT, ": object 0: the quaternion is zero"},
        {"\nos.exit()", DUET_STATUS_BAD_INPUT, ":2: attempt to index a nil value (global 'os')"},
        {"\nparameters { n = {} }", DUET_STATUS_BAD_INPUT,
         ":2: parameter 'n': its default must be"},
        {"parameters {}\nparameters {}", DUET_STATUS_BAD_INPUT,
         ":2: parameters are declared a second time"},
        {"\neach(2, function() end)", DUET_STATUS_BAD_INPUT,
         ":2: each: 0 objects were added for i = 1; expected 1"},
        {"each(2, function(i)\nadd(0, 0, 1, 1) if i > 1 then add(0, 0, 1, 1) end end)",
         DUET_STATUS_BAD_INPUT, ":1: each: 2 objects were added for i = 2; expected 1"},
        {"each(1, function()\neach(1, add) end)", DUET_STATUS_BAD_INPUT,
         ":2: each: called by the function of another each"},
        {"\neach(-1, add)", DUET_STATUS_BAD_INPUT, ":2: bad argument #1 to 'each'"},
        {"\neach(1, 1)", DUET_STATUS_BAD_INPUT, ":2: bad argument #2 to 'each'"},
        {"each(9, function(i) add(0, 0,\n8 - i, 1) end)", DUET_STATUS_BAD_OBJECT,
         "object 8: min x = 0 is above max x = -1"},
        {"\nrandom(1).integer(2, 1)", DUET_STATUS_BAD_INPUT, ":2: bad argument #2 to 'integer'"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        scene_assert_refused(FILE_NAME, wrong[i].chars, wrong[i].status, wrong[i].says);
}

// The linker leads script_open here: what a script may take is a thousandth of what it may.
script *__wrap_script_open(const script_limits *limits, duet_error *err);
script *__real_script_open(const script_limits *limits, duet_error *err);

script *__wrap_script_open(const script_limits *limits, duet_error *err)
{
    script_limits less = *limits;
    less.instructions /= limited ? 1000 : 1;
    return __real_script_open(&less, err);
}

TEST(an_endless_scene_ends_with_its_line)
{
    limited = true;
    scene_assert_refused(FILE_NAME, "\nwhile true do add(0, 0, 1, 1) end", DUET_STATUS_BAD_INPUT,
                         FILE_NAME ":2: runs for more than");
    limited = false;
}

static bool runs_with_n(const char *chars, const char *n)
{
    const duet_setting setting = {"n", n};
    duet_error err = {0};
    limited = true;
    duet_scene *scene =
        scene_from_bytes(FILE_NAME, chars, strlen(chars), &setting, n != NULL, &err);
    limited = false;
    if (!scene && !strstr(err.text, "runs for more than"))
        fail_msg("%s", err.text);
    return scene != NULL;
}

TEST(who_asks_for_more_objects_lets_the_script_run_longer)
{
    const char *two_million = "parameters { n = 30000000 } for i = 1, 2e6 do end return {}";
    assert_false(runs_with_n(two_million, NULL));
    assert_false(runs_with_n(two_million, "1000"));
    assert_false(runs_with_n(two_million, "-30000000"));
    assert_true(runs_with_n(two_million, "3e7"));
}

// --------------------------------------------------------------- parameters

#define PARAMETERS                                                              \
    "local p = parameters { n = 2, size = 0.5, turned = false, label = 'a' }\n" \
    "for i = 1, p.n do add(i, 0, p.size, 1, p.turned and 1 or 0) end\n"         \
    "return { name = p.label }"

TEST(settings_take_the_place_of_defaults)
{
    const duet_setting settings[] = {
        {"n", "1e1"}, {"size", "3"}, {"turned", "true"}, {"label", "b c"}};
    duet_scene *scene =
        must(scene_from_bytes(FILE_NAME, PARAMETERS, strlen(PARAMETERS), settings, 4, ERR));
    const duet_scene_info *info = duet_scene_get_info(scene);
    assert_int_equal(info->n, 10);
    assert_true(info->rotated);
    assert_string_equal(info->name, "b c");
    assert_true(test_poses(scene)->half_extents[0] == 3);
}

TEST(a_wrong_setting_says_what_is_right)
{
    static const struct {
        duet_setting setting;
        const char *says;
    } wrong[] = {
        {{"m", "3"}, ":1: no parameter 'm'; the scene has label, n, size, turned"},
        {{"n", "1.5"}, ":1: parameter n is '1.5'; it must be an integer"},
        {{"n", "ten"}, ":1: parameter n is 'ten'; it must be an integer"},
        {{"n", ""}, ":1: parameter n is ''; it must be an integer"},
        {{"size", "1 2"}, ":1: parameter size is '1 2'; it must be a number"},
        {{"turned", "1"}, ":1: parameter turned is '1'; it must be true or false"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        must_fail(
            scene_from_bytes(FILE_NAME, PARAMETERS, strlen(PARAMETERS), &wrong[i].setting, 1, ERR),
            DUET_STATUS_BAD_ARGUMENT, wrong[i].says);
    must_fail(scene_from_bytes(FILE_NAME, "return {}", 9, &wrong[0].setting, 1, ERR),
              DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, FILE_NAME ": no parameter 'm'; the scene declares none");
    static const char own_error[] = "parameters { m = 1 }\nreturn 7";
    must_fail(scene_from_bytes(FILE_NAME, own_error, strlen(own_error), &wrong[0].setting, 1, ERR),
              DUET_STATUS_BAD_INPUT, "");
}

// ------------------------------------------------------------ shipped scenes

static const char *const shipped[] = {"paper", "paper2d", "clustered", "mixed", "planes", "grains"};

#define N_SHIPPED (sizeof shipped / sizeof shipped[0])

static duet_scene *load_shipped(const char *name, const char *n, const char *parameter,
                                const char *value)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s.lua", getenv("DUET_TEST_SCENES"), name);
    const duet_setting settings[] = {{"n", n}, {parameter, value}};
    duet_scene *scene = kept(duet_scene_load(path, settings, parameter ? 2 : 1, ERR));
    assert_string_equal(duet_scene_get_info(scene)->name, name);
    return scene;
}

TEST(shipped_scenes_have_as_many_objects_as_asked_for)
{
    static const char *const counts[] = {"0", "1", "2", "3", "17", "1000"};
    for (size_t i = 0; i < N_SHIPPED; ++i)
        for (size_t k = 0; k < sizeof counts / sizeof counts[0]; ++k) {
            duet_scene *scene = load_shipped(shipped[i], counts[k], NULL, NULL);
            const duet_scene_info *info = duet_scene_get_info(scene);
            assert_int_equal(info->n, strtoul(counts[k], NULL, 10));
            assert_int_equal(info->dims, strstr(shipped[i], "2d") ? 2 : 3);
            assert_int_equal(info->shape, DUET_SHAPE_POSES);
            assert_true(info->has_world);
        }
}

TEST(scenes_with_radii_have_the_shape_that_costs_least)
{
    duet_scene *scene = load_shipped("spheres", "300", NULL, NULL);
    const duet_sphere *spheres = duet_scene_get_objects(scene, DUET_OBJECT_SPHERES);
    assert_int_equal(duet_scene_get_info(scene)->shape, DUET_SHAPE_SPHERES);
    assert_int_equal(duet_scene_get_info(scene)->n, 300);
    assert_true(spheres[299].radius == 0.5f && !test_poses(scene));
    scene = load_shipped("rounded", "300", NULL, NULL);
    const duet_rounded_box *boxes = duet_scene_get_objects(scene, DUET_OBJECT_ROUNDED_BOXES);
    assert_int_equal(duet_scene_get_info(scene)->shape, DUET_SHAPE_ROUNDED_BOXES);
    assert_true(duet_scene_get_info(scene)->rotated);
    assert_true(boxes[0].radius == 0.25f && boxes[0].pose.half_extents[0] == 0.4f);
    assert_true(boxes[3].radius == 0.0f && boxes[3].pose.half_extents[2] == 0.3f);
    assert_true(!test_poses(scene) && !duet_scene_get_objects(scene, DUET_OBJECT_SPHERES));
}

// A box may stand before the first that has a radius, and behind it.
TEST(radii_may_stand_beside_none)
{
    duet_scene *scene =
        must(scene_from_text(FILE_NAME,
                             "add(1, 2, .5, .5, 0)\n"
                             "add { centre = {3, 4}, half_extents = {1, 0}, radius = 2, "
                             "angle = 1 }\n"
                             "add(5, 6, .5, .5, 1)\n"
                             "return {}",
                             ERR));
    const duet_rounded_box *boxes = duet_scene_get_objects(scene, DUET_OBJECT_ROUNDED_BOXES);
    assert_int_equal(duet_scene_get_info(scene)->n, 3);
    assert_int_equal(duet_scene_get_info(scene)->dims, 2);
    assert_true(boxes[0].radius == 0 && boxes[1].radius == 2 && boxes[2].radius == 0);
    assert_memory_equal(boxes[1].pose.rotation, boxes[2].pose.rotation,
                        sizeof boxes[1].pose.rotation);
}

TEST(shipped_scenes_turn_their_boxes_only_if_asked_to)
{
    for (size_t i = 0; i < N_SHIPPED; ++i)
        for (int rotated = 0; rotated < 2; ++rotated) {
            duet_scene *scene =
                load_shipped(shipped[i], "50", "rotated", rotated ? "true" : "false");
            assert_int_equal(duet_scene_get_info(scene)->rotated, rotated);
        }
}

TEST(shipped_scenes_open_with_what_they_are_for)
{
    for (size_t i = 0; i < N_SHIPPED; ++i) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s.lua", getenv("DUET_TEST_SCENES"), shipped[i]);
        const text t = test_read_file(path);
        assert_int_equal(strncmp(t.chars, "-- SPDX-License-Identifier: MIT\n-- ", 35), 0);
    }
}

static uint64_t count_pairs(const duet_scene *scene)
{
    return known_pairs_of_scene(scene, DUET_LEVEL_CERTIFIED).n;
}

// Unit cubes side by side touch where no coordinate of their centres differs by
// more than 1; turned by quarters they are the same cubes.
TEST(neighbours_on_planes_touch_exactly)
{
    for (int rotated = 0; rotated < 2; ++rotated) {
        duet_scene *scene = load_shipped("planes", "500", "rotated", rotated ? "true" : "false");
        const duet_pose *p = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
        uint64_t touching = 0;
        for (uint32_t i = 0; i < 500; ++i)
            for (uint32_t k = i + 1; k < 500; ++k) {
                bool apart = false;
                for (int axis = 0; axis < 3; ++axis)
                    apart |= fabsf(p[i].centre[axis] - p[k].centre[axis]) >
                             p[i].half_extents[axis] + p[k].half_extents[axis];
                touching += !apart;
            }
        assert_true(touching > 2 * 500);
        assert_true(count_pairs(scene) == touching);
    }
}

static uint64_t hash_bits(const duet_scene *scene)
{
    const uint32_t n_words = duet_scene_get_info(scene)->n * (uint32_t)(sizeof(duet_pose) / 4);
    uint64_t hash = 0xcbf29ce484222325u; // FNV-1a, word by word
    for (uint32_t i = 0; i < n_words; ++i) {
        uint32_t word;
        memcpy(&word, (const char *)duet_scene_get_objects(scene, DUET_OBJECT_POSES) + 4 * i, 4);
        hash = (hash ^ word) * 0x100000001b3u;
    }
    return hash;
}

// The figure was written down once; a scene that changes it is another scene.
TEST(the_papers_scene_is_the_same_on_every_machine)
{
    duet_scene *scene = load_shipped("paper", "1000", NULL, NULL);
    duet_scene *other = load_shipped("paper", "1000", "seed", "2");
    char shown[17];
    snprintf(shown, sizeof shown, "%016" PRIx64, hash_bits(scene));
    assert_string_equal(shown, "d9501e27c1cfb636");
    assert_true(hash_bits(scene) != hash_bits(other));
}

// ------------------------------------------------------------------- ranges

// 3 + 5 + 4 + 2 objects: what is added once, what each makes, and a list.
#define IN_PARTS                                                                                 \
    "local p = parameters { seed = 7 }\n"                                                        \
    "local function box(i, random)\n"                                                            \
    "  add { centre = { random.uniform(), i, 0 }, half_extents = { 1, 1, 1 },\n"                 \
    "        rotation = { random.quaternion() }, velocity = { i, 0, 0 } }\n"                     \
    "end\n"                                                                                      \
    "for i = 1, 3 do add(i, 0, 0, 1, 1, 1, 0, 0, 0, 1) end\n"                                    \
    "each(5, box)\n"                                                                             \
    "each(0, box)\n"                                                                             \
    "each(4, box)\n"                                                                             \
    "return { objects = { { 1, 2, 3, 1, 1, 1, 0, 0, 0, 1 }, { 3, 2, 1, 1, 1, 1, 0, 0, 0, 1 } } " \
    "}\n"

enum { IN_ALL = 14 };

static duet_scene *load_range(const char *path, uint64_t first, uint64_t end)
{
    uint64_t n = 0;
    duet_scene *scene = kept(scene_load_range(path, NULL, 0, first, end, &n, ERR));
    assert_int_equal(n, IN_ALL);
    return scene;
}

// Every range holds the objects, and the bodies, of the whole.
static void assert_ranges_hold_the_whole(const char *path, const char *chars)
{
    test_write_file(path, chars);
    duet_scene *whole = load_range(path, 0, UINT64_MAX);
    const duet_pose *all = duet_scene_get_objects(whole, DUET_OBJECT_POSES);
    const duet_body *bodies = duet_scene_get_bodies(whole);
    assert_int_equal(duet_scene_get_info(whole)->n, IN_ALL);
    for (uint32_t first = 0; first <= IN_ALL; ++first) {
        for (uint32_t end = first; end <= IN_ALL; ++end) {
            duet_scene *part = load_range(path, first, end);
            assert_int_equal(duet_scene_get_info(part)->n, end - first);
            assert_int_equal(duet_scene_get_info(part)->dims, 3);
            assert_memory_equal(duet_scene_get_objects(part, DUET_OBJECT_POSES), all + first,
                                (end - first) * sizeof *all);
            const duet_body *own = duet_scene_get_bodies(part);
            for (uint32_t i = 0; own && i < end - first; ++i)
                assert_memory_equal(&own[i], &bodies[first + i], sizeof *own);
        }
    }
}

TEST(a_range_of_a_scene_is_that_part_of_the_whole)
{
    own(text) rows = {0};
    for (int i = 0; i < IN_ALL; ++i)
        text_add(&rows, "%d 0 %d 1 1 1 0 0 %d 1\n", i, 2 * i, i % 3);
    assert_ranges_hold_the_whole(FILE_NAME, IN_PARTS);
    assert_ranges_hold_the_whole(TEXT_NAME, text_chars(&rows));
}

// The draws of a box depend on its number and its each, and on nothing else.
TEST(sources_of_each_are_independent)
{
    duet_scene *scene = assert_scene(IN_PARTS);
    const duet_pose *p = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    for (int i = 3; i < 12; ++i)
        for (int k = 3; k < i; ++k)
            assert_true(p[i].centre[0] != p[k].centre[0]);
}

// Only the kept ones of a thousand million are made.
TEST(a_range_of_a_great_scene_is_quick)
{
    uint64_t n = 0;
    const duet_setting setting = {"n", "1000000000"};
    duet_scene *scene =
        kept(scene_load_range("grains", &setting, 1, 999999990, UINT64_MAX, &n, ERR));
    assert_int_equal(n, 1000000000);
    assert_int_equal(duet_scene_get_info(scene)->n, 10);
}

// ------------------------------------------------------------- random input

#define SAMPLE                                                                \
    "local p = parameters { n = 3, seed = 1 }\n"                              \
    "local r = random(p.seed)\n"                                              \
    "for i = 1, p.n do add(r.uniform(), i, 0, 1, 1, 1, r.quaternion()) end\n" \
    "return { dims = 3, world = { lower = {0, 0, 0}, upper = {4, 4, 4} },\n"  \
    "  objects = { { centre = {1, 2, 3}, half_extents = {1, 1, 1}, euler = {1, 2, 3} } } }\n"

static void assert_scene_or_line(const char *bytes, size_t n)
{
    duet_error err = {0};
    duet_scene *scene = scene_from_bytes(FILE_NAME, bytes, n, NULL, 0, &err);
    assert_true((scene != NULL) == (err.status == DUET_STATUS_OK));
    assert_true(scene || strstr(err.text, FILE_NAME));
    assert_true(scene || !strchr(err.text, '\n'));
}

TEST(every_beginning_of_a_scene_is_read_or_refused)
{
    for (size_t n = 0; n <= strlen(SAMPLE); ++n)
        assert_scene_or_line(SAMPLE, n);
}

TEST(changed_bytes_are_read_or_refused)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 2000; ++round) {
        char bytes[] = SAMPLE;
        for (uint32_t k = 1 + rng_below(&r, 3); k > 0; --k)
            bytes[rng_below(&r, sizeof bytes - 1)] = (char)(32 + rng_below(&r, 95));
        assert_scene_or_line(bytes, sizeof bytes - 1);
    }
}
