// SPDX-License-Identifier: MIT
#include "base/text.h"
#include "support/scene_file.h"
#include "support/test.h"

#include <float.h>

#define UNIT_CUBE                                                      \
    {                                                                  \
        .half_extents = {0.5f, 0.5f, 0.5f}, .rotation = { 0, 0, 0, 1 } \
    }

static void assert_pose_refused(const duet_pose *pose, uint32_t dims, const char *says)
{
    duet_pose poses[3] = {UNIT_CUBE, UNIT_CUBE, *pose};
    must_fail(duet_scene_create(DUET_OBJECT_POSES, poses, 3, dims, 0, ERR), DUET_STATUS_BAD_OBJECT,
              says);
}

TEST(a_bad_pose_is_refused_by_its_id)
{
    duet_pose pose = UNIT_CUBE;
    pose.centre[1] = NAN;
    assert_pose_refused(&pose, 3, "object 2: cy is nan; every number must be finite");
    pose.centre[1] = INFINITY;
    assert_pose_refused(&pose, 3, "object 2: cy is inf");
    pose = (duet_pose)UNIT_CUBE;
    pose.half_extents[2] = -FLT_TRUE_MIN;
    assert_pose_refused(&pose, 3, "hz = -1.4013e-45 is negative; a half extent is 0 or more");
    pose = (duet_pose)UNIT_CUBE;
    pose.rotation[3] = 0;
    assert_pose_refused(&pose, 3, "object 2: the quaternion is zero");
    assert_pose_refused(&pose, 2, "object 2: the quaternion is zero");
    pose.rotation[0] = NAN;
    assert_pose_refused(&pose, 3, "object 2: qx is nan");
}

TEST(bad_bounds_are_refused_by_their_id)
{
    duet_bounds bounds[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 2, 0}, {1, 1, 1}}};
    must_fail(duet_scene_create(DUET_OBJECT_BOUNDS, bounds, 2, 3, 0, ERR), DUET_STATUS_BAD_OBJECT,
              "");
    assert_string_equal(ERR->text, "object 1: min y = 2 is above max y = 1");
    bounds[1].lower[1] = -INFINITY;
    must_fail(duet_scene_create(DUET_OBJECT_BOUNDS, bounds, 2, 2, 0, ERR), DUET_STATUS_BAD_OBJECT,
              "object 1: min y is -inf");
}

TEST(dims_other_than_2_and_3_are_refused)
{
    must_fail(duet_scene_create(DUET_OBJECT_POSES, NULL, 0, 4, 0, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_string_equal(ERR->text, "dims is 4; it must be 2 or 3");
    assert_null(duet_scene_create(DUET_OBJECT_BOUNDS, NULL, 0, 0, 0, NULL));
}

TEST(missing_memory_and_paths_are_refused)
{
    must_fail(duet_scene_create(DUET_OBJECT_POSES, NULL, 1, 3, 0, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_null(duet_scene_create(DUET_OBJECT_BOUNDS, NULL, 1, 3, 0, NULL));
    assert_null(duet_scene_load(NULL, NULL, 0, NULL));
    duet_scene_destroy(NULL);
}

TEST(none_and_one_and_two_objects_make_a_scene)
{
    const duet_pose poses[2] = {UNIT_CUBE, UNIT_CUBE};
    for (uint32_t n = 0; n <= 2; ++n) {
        duet_scene *scene = kept(duet_scene_create(DUET_OBJECT_POSES, poses, n, 3, 0, ERR));
        assert_int_equal(duet_scene_get_info(scene)->n, n);
        assert_non_null(duet_scene_get_objects(scene, DUET_OBJECT_POSES));
        assert_null(duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS));
    }
}

TEST(what_2d_does_not_read_is_zero_in_the_scene)
{
    const duet_pose pose = {{1, 2, NAN}, {3, 4, -1}, {NAN, INFINITY, 0, 2}};
    duet_scene *scene = kept(duet_scene_create(DUET_OBJECT_POSES, &pose, 1, 2, 0, ERR));
    const duet_pose want = {{1, 2, 0}, {3, 4, 0}, {0, 0, 0, 2}};
    assert_memory_equal(duet_scene_get_objects(scene, DUET_OBJECT_POSES), &want, sizeof want);
    assert_false(duet_scene_get_info(scene)->rotated);
    const duet_bounds box = {{1, 2, NAN}, {3, 4, -1}};
    scene = kept(duet_scene_create(DUET_OBJECT_BOUNDS, &box, 1, 2, 0, ERR));
    const duet_bounds want_box = {{1, 2, 0}, {3, 4, 0}};
    assert_memory_equal(duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS), &want_box,
                        sizeof want_box);
}

static duet_scene *scene_of_rotation(float x, float y, float z, float w)
{
    duet_pose pose = UNIT_CUBE;
    memcpy(pose.rotation, (const float[4]){x, y, z, w}, sizeof pose.rotation);
    return kept(duet_scene_create(DUET_OBJECT_POSES, &pose, 1, 3, 0, ERR));
}

TEST(a_scene_is_rotated_where_a_vector_part_is_not_zero)
{
    static const struct {
        float q[4];
        bool rotated;
    } cases[] = {
        {{0, 0, 0, 1}, false}, {{0, 0, -0.0f, -7}, false}, {{0, 0, 0, 1e-40f}, false},
        {{1, 0, 0, 0}, true},  {{0, 1e-45f, 0, 1}, true},  {{0, 0, 1e-30f, 1}, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const float *q = cases[i].q;
        duet_scene *scene = scene_of_rotation(q[0], q[1], q[2], q[3]);
        assert_int_equal(duet_scene_get_info(scene)->rotated, cases[i].rotated);
    }
}

// The scale is a power of two, so the parts keep their ratios bit for bit.
TEST(a_quaternion_of_any_length_keeps_its_rotation)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 10000; ++round) {
        int shift = (int)rng_below(&r, 220) - 110;
        float q[4];
        for (int k = 0; k < 4; ++k)
            q[k] = ldexpf((float)rng_between(&r, -1, 1), shift);
        duet_scene *scene = scene_of_rotation(q[0], q[1], q[2], q[3]);
        const float *kept = test_poses(scene)->rotation;
        float squared = 0;
        for (int k = 0; k < 4; ++k) {
            squared += kept[k] * kept[k];
            assert_true((double)kept[k] * (double)q[0] == (double)q[k] * (double)kept[0]);
        }
        assert_true(isnormal(squared));
    }
}

TEST(the_pair_hash_does_not_depend_on_order_or_spans)
{
    const duet_pair pairs[] = {{0, 1}, {1, 2}, {5, 4294967294u}};
    const duet_pair turned[] = {{5, 4294967294u}, {0, 1}, {1, 2}};
    uint64_t hash = duet_pairs_hash(pairs, 3);
    assert_true(hash == duet_pairs_hash(turned, 3));
    assert_true(hash != duet_pairs_hash(pairs, 2));
    assert_true(duet_pairs_hash(pairs, 0) == 0);
    duet_result result = {.spans = {{turned, 1}, {turned + 1, 2}}, .pairs = 3};
    assert_true(duet_result_get_hash(&result) == hash);
    for (uint64_t i = 0; i < 3; ++i) {
        duet_pair pair = duet_result_get_pair(&result, i);
        assert_memory_equal(&pair, &turned[i], sizeof pair);
    }
}

// Worked out by hand from the definition in duet.h: k = 1 for the pair (0, 1).
TEST(the_pair_hash_is_the_documented_one)
{
    const duet_pair pair = {0, 1};
    uint64_t k = 0x9E3779B97F4A7C15u;
    k ^= k >> 29;
    k *= 0xBF58476D1CE4E5B9u;
    k ^= k >> 32;
    assert_true(duet_pairs_hash(&pair, 1) == k);
}

// ---------------------------------------------------------------- what a script says of motion

TEST(a_scene_says_what_moves)
{
    duet_scene *s = must(scene_from_text(
        "moving.lua",
        "add{centre = {0, 0, 1}, half_extents = {1, 1, 1}, velocity = {1, 2, 3}, angular_velocity "
        "= {0, 0, 4}, mass = "
        "5}\n"
        "add{centre = {9, 9, 9}, half_extents = {1, 1, 1}, group = 6, fixed_rotation=true}\n"
        "return {world = {lower = {0, 0, 0}, upper = {10, 11, 12}}, boundary = 'walls',\n"
        "  gravity = {0, 0, -9}, drag = 0.5, dt = 0.01, substeps = 7, wants = {'contact_response', "
        "'events'},\n"
        "  body = {friction = 0.25, mass = 2}, integrator = 'euler', doubles = true,\n"
        "  origin = {1e6, 0, 0}, skin = 0.125}",
        ERR));
    const duet_body *b = duet_scene_get_bodies(s);
    assert_non_null(b);
    assert_true(b[0].velocity[1] == 2.0f && b[0].angular_velocity[2] == 4.0f && b[0].mass == 5.0f);
    assert_true(b[0].friction == 0.25f && b[1].friction == 0.25f); // the scene's, where not given
    assert_true(b[1].mass == 2.0f && b[1].group == 6 && b[1].fixed_rotation &&
                !b[0].fixed_rotation);
    duet_motion_def def = duet_scene_motion_def(s, NULL);
    assert_int_equal(def.dims, 3);
    assert_int_equal(def.boundary, DUET_BOUNDARY_WALLS);
    assert_int_equal(def.substeps, 7);
    assert_int_equal(def.wants, DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_EVENTS);
    assert_true(def.upper[1] == 11.0 && def.gravity[2] == -9.0 && def.drag == 0.5);
    assert_true(def.dt == 0.01 && def.doubles && def.origin[0] == 1e6 && def.skin == 0.125);
}

TEST(a_scene_has_materials)
{
    duet_scene *s = must(scene_from_text(
        "made.lua",
        "add{centre = {0, 0, 1}, half_extents = {1, 1, 1}, material = 2}\n"
        "return {body = {material = 1}, materials = {{friction = 0.5, restitution_rule = 'min'},\n"
        "  {restitution = 0.25, friction_rule = 'product'}},\n"
        "  material_pairs = {{2, 1, friction = 0.75, restitution = 1}}}",
        ERR));
    assert_int_equal(duet_scene_get_bodies(s)[0].material, 2);
    duet_motion_def def = duet_scene_motion_def(s, NULL);
    assert_int_equal(def.n_materials, 2);
    assert_true(def.materials[1].friction == 0.5f && def.materials[2].restitution == 0.25f);
    assert_int_equal(def.materials[1].friction_rule, DUET_COMBINE_GEOMETRIC_MEAN);
    assert_int_equal(def.materials[1].restitution_rule, DUET_COMBINE_MIN);
    assert_int_equal(def.materials[2].friction_rule, DUET_COMBINE_PRODUCT);
    assert_int_equal(def.materials[2].restitution_rule, DUET_COMBINE_MAX);
    assert_int_equal(def.n_material_pairs, 1);
    assert_true(def.material_pairs[0].a == 2 && def.material_pairs[0].b == 1 &&
                def.material_pairs[0].friction == 0.75f &&
                def.material_pairs[0].restitution == 1.0f);
}

TEST(a_scene_that_says_nothing_of_bodies_has_none)
{
    duet_scene *s =
        must(scene_from_text("still.lua", "add(0, 0, 0, 1, 1, 1, 0, 0, 0, 1) return {}", ERR));
    assert_null(duet_scene_get_bodies(s));
}

TEST(what_is_wrong_is_refused_with_its_name)
{
    static const refusal wrong[] = {
        {"return {boundary = 'hedge'}",
         "boundary is 'hedge'; expected one of none, walls, periodic"},
        {"return {boundary = 'walls'}", "boundary needs a world"},
        {"return {wants = {'magic'}}", "wants has 'magic', which is no effect"},
        {"return {integrator = 'rk4'}", "integrator is 'rk4'"},
        {"return {gravity = {1, 2}}", "gravity is a list of 2; expected 3 finite numbers"},
        {"return {dt = -1}", "dt is -1"},
        {"return {substeps = 1001}", "substeps is 1001"},
        {"return {body = {weight = 1}}", "body has no field 'weight'"},
        {"return {materials = {{friction = 1}, {weight = 1}}}",
         "materials, row 2 has no field 'weight'; its fields are friction, restitution, "
         "friction_rule"},
        {"return {materials = {{friction = 'low'}}}",
         "materials, row 1: friction is 'low'; expected a number"},
        {"return {materials = {\n{friction = 1},\n{friction = -1}}}",
         ":3: materials, row 2: friction is -1; expected a number from 0 to 1e6"},
        {"return {materials = {{}},\nmaterial_pairs = {{1, 1},\n{1, 2}}}",
         ":3: material_pairs, row 2: expected two of the 1 materials by their numbers"},
        {"return {materials = {{}}, material_pairs = {{1}}}",
         "material_pairs, row 1: expected two of the 1 materials by their numbers"},
        {"return {wants = {{}}}", "wants has 'a table', which is no effect"},
        {"return {materials = {7}}",
         "materials, row 1 is 7; expected a table of friction, restitution"},
        {"return {material_pairs = {{1, 2, 3}}}", "material_pairs, row 1 has no field [3]"},
        {"return {material_pairs = {{1, 99}}}",
         "row 1: [2] is 99; expected the number of a material"},
        {"return {material_pairs = {{1, 1, weight = 1}}}",
         "row 1 has no field 'weight'; its fields are [1], [2], friction"},
        {"return {material_pairs = true}",
         "material_pairs is true; expected a list of at most 120 pairs"},
        {"add{centre={0,0,0}, half_extents={1,1,1}, velocity={1}} return {}",
         "object 0: velocity is a list of 1; expected { x, y, z }"},
        {"add{centre={0,0,0}, half_extents={1,1,1}, group=-1} return {}",
         "object 0: group is -1; expected a whole number"},
        {"return {script = function(step, world) end}",
         "a scene cannot act between steps; expected the function in the def of pair:motion"},
        {"add{centre={0,0,0}, half_extents={1,1,1}, fixed_rotation=1} return {}",
         "object 0: fixed_rotation is 1; expected true or false"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        scene_assert_refused("wrong.lua", wrong[i].given, DUET_STATUS_BAD_INPUT, wrong[i].says);
}

// ---------------------------------------------------------------- the document's examples

// Reads the document's blocks ```kind ... ``` as files; returns how many.
static int read_examples(const char *document, const char *kind)
{
    char begin[16];
    char name[64];
    snprintf(begin, sizeof begin, "```%s\n", kind);
    snprintf(name, sizeof name, "test_scene_format.%s", kind);
    int n = 0;
    const char *at = document;
    while ((at = strstr(at, begin))) {
        at += strlen(begin);
        const char *end = strstr(at, "```");
        duet_scene *scene = must(scene_from_bytes(name, at, (size_t)(end - at), NULL, 0, ERR));
        assert_true(duet_scene_get_info(scene)->n > 1);
        at = end + 3;
        ++n;
    }
    return n;
}

TEST(the_documents_examples_are_read)
{
    char path[512];
    snprintf(path, sizeof path, "%s/../../docs/formats.md", getenv("DUET_TEST_SCENES"));
    const text document = test_read_file(path);
    assert_int_equal(read_examples(document.chars, "csv"), 1);
    assert_int_equal(read_examples(document.chars, "lua"), 6);
}
