// SPDX-License-Identifier: MIT
// A scene's script says things of motion, and may not say others.
#include "support/scene_file.h"
#include "support/test.h"

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
    static const struct {
        const char *chars;
        const char *says;
    } wrong[] = {
        {"return {boundary = 'hedge'}", "boundary is 'hedge'; expected walls or periodic"},
        {"return {boundary = 'walls'}", "boundary needs a world"},
        {"return {wants = {'magic'}}", "wants has 'magic', which is no effect"},
        {"return {integrator = 'rk4'}", "integrator is 'rk4'"},
        {"return {gravity = {1, 2}}", "gravity must be 3 finite numbers"},
        {"return {dt = -1}", "dt is -1"},
        {"return {substeps = 1001}", "substeps is 1001"},
        {"return {body = {weight = 1}}", "body has no field 'weight'"},
        {"return {materials = {{friction = 1}, {weight = 1}}}",
         "materials, row 2: expected no fields but friction, restitution, friction_rule"},
        {"return {materials = {{friction = 'low'}}}",
         "row 1: expected friction and restitution as"},
        {"return {materials = {7}}", "row 1: expected a table of friction and restitution"},
        {"return {material_pairs = {{1, 2, 3}}}", "row 1: expected two materials by their numbers"},
        {"return {material_pairs = {{1, 99}}}", "row 1: expected two materials by their numbers"},
        {"return {material_pairs = {{1, 1, weight = 1}}}", "row 1: expected no fields but two"},
        {"return {material_pairs = true}", "row 0: expected a list of at most 120 pairs"},
        {"add{centre={0,0,0}, half_extents={1,1,1}, velocity={1}} return {}",
         "velocity must be 2 or 3"},
        {"add{centre={0,0,0}, half_extents={1,1,1}, group=-1} return {}",
         "group must be a whole number"},
        {"return {script = function(step, world) end}",
         "a scene cannot act between steps; expected the function in the def of pair:motion"},
        {"add{centre={0,0,0}, half_extents={1,1,1}, fixed_rotation=1} return {}",
         "fixed_rotation must be true or false"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        scene_assert_refused("wrong.lua", wrong[i].chars, DUET_STATUS_BAD_INPUT, wrong[i].says);
}

TEST_MAIN(NULL, NULL)
