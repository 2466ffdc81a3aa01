// SPDX-License-Identifier: MIT
#include "support/devices.h"

#include "support/test.h"

#include "runtime/opencl/device_list.h"
#include "runtime/opencl/device_pair.h"

duet_device_pair *open_copying(bool copies)
{
    duet_device_pair *pair = kept(duet_device_pair_open(NULL, ERR));
    for (int side = 0; side < 2; ++side)
        pair->devices[side].info.host_memory &= !copies;
    return pair;
}

const duet_device_info *cuttable_cpu(void)
{
    const device_root *roots = NULL;
    uint32_t n = 0;
    device_list_roots(&roots, &n, NULL);
    for (uint32_t i = 0; i < n; ++i)
        if (roots[i].info.can_cut)
            return &roots[i].info;
    print_message("no CPU here can be cut into parts\n");
    skip();
    return NULL;
}

duet_world *create_world(const duet_world_def *def)
{
    return kept(duet_world_create(def, ERR));
}

duet_world *create_world_of(const duet_world_def *def, duet_object_kind kind, const void *objects,
                            uint32_t n)
{
    duet_world *world = create_world(def);
    must(duet_world_set_objects(world, kind, objects, n, ERR));
    return world;
}

duet_world_def devices_def(uint32_t dims)
{
    duet_world_def def = duet_default_world_def();
    def.pair = default_pair();
    def.dims = dims;
    return def;
}

void set_share(duet_world *world, uint32_t share)
{
    duet_plan plan = *duet_world_get_plan(world);
    plan.share = share;
    must(duet_world_set_plan(world, &plan, ERR));
}

void set_variants(duet_plan *plan, const char *variant)
{
    snprintf(plan->variant_a, sizeof plan->variant_a, "%s", variant);
    snprintf(plan->variant_b, sizeof plan->variant_b, "%s", variant);
}

duet_plan plan_of(duet_mode mode, uint32_t share, const char *variant_a, const char *variant_b)
{
    duet_plan plan = {.mode = mode, .share = share};
    snprintf(plan.variant_a, sizeof plan.variant_a, "%s", variant_a);
    snprintf(plan.variant_b, sizeof plan.variant_b, "%s", variant_b);
    return plan;
}

duet_result step_by(duet_world *world, const duet_plan *plan)
{
    must(duet_world_set_plan(world, plan, ERR));
    return step_world(world);
}

duet_result step_with(duet_world *world, duet_object_kind kind, const void *objects, uint32_t n)
{
    must(duet_world_set_objects(world, kind, objects, n, ERR));
    return step_world(world);
}

void assert_found(const duet_result *result, known_pairs pairs)
{
    assert_int_equal(result->pairs, pairs.n);
    assert_int_equal(duet_result_get_hash(result), pairs.hash);
}

void assert_step_finds(duet_world *world, known_pairs pairs)
{
    const duet_result result = step_world(world);
    assert_found(&result, pairs);
}

duet_result step_world(duet_world *world)
{
    duet_result result;
    must(duet_world_step(world, &result, ERR));
    return result;
}

duet_rounded_box rounded_at(double x, double y, double z, double hx, double hy, double hz,
                            double radius)
{
    return (duet_rounded_box){
        {{(float)x, (float)y, (float)z}, {(float)hx, (float)hy, (float)hz}, {0, 0, 0, 1}},
        (float)radius};
}

duet_pose cube_at(double x, double y, double z, double half)
{
    float h = (float)half;
    return (duet_pose){{(float)x, (float)y, (float)z}, {h, h, h}, {0, 0, 0, 1}};
}

duet_pose random_cube(rng *r, double from, double to)
{
    duet_pose pose = cube_at(0, 0, 0, 0.5);
    for (int k = 0; k < 3; ++k)
        pose.centre[k] = (float)rng_between(r, from, to);
    turn_at_random(&pose, r);
    return pose;
}

void turn_at_random(duet_pose *pose, rng *r)
{
    for (int k = 0; k < 4; ++k)
        pose->rotation[k] = (float)rng_normal(r);
}

duet_bounds bounds_of_upright(const duet_pose *pose)
{
    duet_bounds b;
    for (int k = 0; k < 3; ++k) {
        b.lower[k] = pose->centre[k] - pose->half_extents[k];
        b.upper[k] = pose->centre[k] + pose->half_extents[k];
    }
    return b;
}

reference_found found_by(const reference_objects *objects, reference_way way)
{
    reference_found found = {0};
    must(reference_find(objects, way, &found, ERR));
    test_keep(found.pairs, duet_free);
    return found;
}

uint64_t reference_hash(const reference_objects *objects, reference_way way, uint64_t *n)
{
    reference_found found = {0};
    must(reference_find(objects, way, &found, ERR));
    uint64_t hash = duet_pairs_hash(found.pairs, found.n);
    *n = found.n;
    duet_free(found.pairs);
    return hash;
}

known_pairs known_pairs_of_scene(const duet_scene *scene, duet_level level)
{
    duet_pair *pairs = NULL;
    known_pairs known = {0};
    must(duet_reference(scene, level, &pairs, &known.n, ERR));
    known.hash = duet_pairs_hash(pairs, known.n);
    duet_free(pairs);
    return known;
}

known_pairs known_pairs_of(duet_object_kind kind, const void *objects, uint32_t n, uint32_t dims)
{
    duet_scene *scene = must(duet_scene_create(kind, objects, n, dims, 0, ERR));
    known_pairs known = known_pairs_of_scene(scene, DUET_LEVEL_CERTIFIED);
    duet_scene_destroy(scene);
    return known;
}

bool devices_are_two(void)
{
    duet_device_pair *pair = must(duet_device_pair_open(NULL, ERR));
    bool two = !duet_device_pair_is_one(pair);
    duet_device_pair_destroy(pair);
    return two;
}

void skip_on_one_device(void)
{
    if (devices_are_two())
        return;
    print_message("the device pair is one device: there is nothing to share\n");
    skip();
}

void devices_seem_gpus(bool seem)
{
    static duet_device_info own[2];
    for (int side = 0; side < 2; ++side) {
        duet_device_info *info = &default_pair()->devices[side].info;
        if (seem && info->kind != DUET_KIND_GPU) {
            own[side] = *info;
            info->kind = DUET_KIND_GPU;
            info->host_memory = false;
        } else if (!seem && own[side].name[0]) {
            *info = own[side];
        }
    }
}
