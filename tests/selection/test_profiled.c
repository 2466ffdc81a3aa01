// SPDX-License-Identifier: MIT
// A world as the profile store knows it, and what an application then gets.
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/json.h"
#include "support/store.h"
#include "support/test.h"

#include "base/text_file.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/selection/profile_subject.h"

#include <sys/stat.h>

typedef struct fixture {
    duet_device_pair *pair;
    duet_world_def def;
    duet_pose *poses;
    uint32_t n;
    duet_world *world;
} fixture;

static void open_world(fixture *f)
{
    f->world = create_world_of(&f->def, DUET_OBJECT_POSES, f->poses, f->n);
}

// n unit cubes in a world of 20^3, drawn with the seed; one is `giant` wide.
static fixture make_world(uint32_t n, uint64_t seed, float giant, const char *words)
{
    fixture f = {0};
    rng r = rng_seed(seed);
    duet_pose *poses = test_alloc(n * sizeof *poses);
    for (uint32_t i = 0; i < n; ++i) {
        poses[i] = cube_at(0, 0, 0, 0.5);
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 0, 20);
    }
    if (giant > 0)
        poses[n / 2].half_extents[0] = giant / 2;
    f.pair = kept(duet_device_pair_open(NULL, ERR));
    f.def = duet_default_world_def();
    f.def.pair = f.pair;
    f.def.dims = 3;
    f.def.rotated = false;
    f.def.plan = duet_default_plan(f.pair);
    set_variants(&f.def.plan, words);
    f.def.has_world = true;
    for (int k = 0; k < 3; ++k)
        f.def.upper[k] = 20;
    f.poses = poses;
    f.n = n;
    open_world(&f);
    return f;
}

// The same world, which takes any level within the accuracy.
static void ask_for(fixture *f, duet_accuracy accuracy)
{
    test_give_back(f->world);
    f->def.has_accuracy = true;
    f->def.accuracy = accuracy;
    open_world(f);
}

static profile_subject describe(const fixture *f)
{
    profile_subject p;
    must(profile_subject_read(f->world, &p, ERR));
    return p;
}

static void key_of(const fixture *f, char key[PROFILE_SHA])
{
    profile_subject p = describe(f);
    must(profile_workload_key(&p.workload, key, ERR));
}

TEST(a_worlds_numbers_are_those_of_its_scene)
{
    fixture f = make_world(16000, test_seed(), 0, "auto");
    profile_subject p = describe(&f);
    assert_int_equal(p.workload.n, 16000);
    assert_int_equal(p.workload.dims, 3);
    assert_in_range(p.workload.cells[0], 19, 20);
    assert_true(p.workload.occ_mean > 1.9 && p.workload.occ_mean < 2.5);
    assert_true(p.workload.occ_p99 > 2.5 && p.workload.occ_p99 < 5); // 16 in eight cells
    assert_true(p.workload.size_ratio == 1);
    assert_string_equal(p.workload.shape, "poses");
    assert_string_equal(p.pair.a.device.kind,
                        f.pair->devices[0].info.kind == DUET_KIND_CPU ? "cpu" : "gpu");
    assert_int_equal(strlen(p.kernels), 64);
}

TEST(the_workload_is_the_scenes_and_not_the_draws_or_the_plans)
{
    uint64_t seed = test_seed();
    fixture a = make_world(16000, seed, 0, "auto");
    fixture b = make_world(16000, seed + 1, 0, "auto grid=hashed");
    fixture c = make_world(16000, seed, 16, "auto");
    char keys[3][PROFILE_SHA];
    key_of(&a, keys[0]);
    key_of(&b, keys[1]);
    key_of(&c, keys[2]);
    assert_string_equal(keys[0], keys[1]);
    assert_string_not_equal(keys[0], keys[2]); // a giant among them
    profile_subject p = describe(&c);
    assert_true(p.workload.size_ratio == 16);
}

// The first objects are counted when they are set, all others when somebody asks.
TEST(a_workload_is_of_the_objects_that_a_world_has)
{
    enum { N = 16000 };
    fixture f = make_world(N, test_seed(), 0, "auto");
    profile_subject set = describe(&f);
    // The objects stay as they are.
    duet_pose *poses = must(duet_world_map_objects(f.world, DUET_OBJECT_POSES, N, ERR));
    profile_subject mapped = describe(&f);
    assert_memory_equal(&set.workload, &mapped.workload, sizeof set.workload);
    poses[N / 3].half_extents[1] = 4;
    assert_true(describe(&f).workload.size_ratio == 8);
    duet_pose one = poses[0];
    must(duet_world_set_objects(f.world, DUET_OBJECT_POSES, &one, 1, ERR));
    assert_int_equal(describe(&f).workload.n, 1);
    assert_true(describe(&f).workload.size_ratio == 1);
}

TEST(a_world_without_objects_is_refused)
{
    fixture f = make_world(1, 1, 0, "auto");
    profile_subject p;
    must(duet_world_set_objects(f.world, DUET_OBJECT_POSES, NULL, 0, ERR));
    must_fail(profile_subject_read(f.world, &p, ERR), DUET_STATUS_BAD_ARGUMENT, "");
}

TEST(a_plan_survives_being_stored)
{
    duet_plan plan = plan_of(DUET_MODE_OWN, 12345, "auto sort=radix", "paper");
    profile_plan stored = profile_subject_write_plan(&plan, "sat15");
    duet_plan back;
    must(profile_subject_read_plan(&stored, &back, ERR));
    assert_int_equal(back.share, plan.share);
    assert_int_equal(back.mode, plan.mode);
    assert_string_equal(back.variant_a, plan.variant_a);
    assert_string_equal(back.variant_b, plan.variant_b);
    strcpy(stored.mode, "sideways");
    must_fail(profile_subject_read_plan(&stored, &back, ERR), DUET_STATUS_BAD_INPUT, "sideways");
}

// ------------------------------------------------------------ an application's start

// Puts a profile into the store, as a tuner would.
static void put_subject(const char *path, const profile_subject *p, const char *kernels)
{
    profile_plan plan = test_plan(0.375);
    snprintf(plan.level, sizeof plan.level, "%s", p->workload.level);
    test_store_plan(path, &p->pair, &p->workload, kernels ? kernels : p->kernels, &plan);
}

static void put_for(const char *path, duet_world *world, const char *kernels)
{
    profile_subject p;
    must(profile_subject_read(world, &p, ERR));
    put_subject(path, &p, kernels);
}

TEST(a_world_takes_its_profile_and_finds_the_same_pairs)
{
    test_folder folder = test_folder_make();
    fixture f = make_world(3000, test_seed(), 0, "auto");
    duet_result result;
    must(duet_world_step(f.world, &result, ERR));
    uint64_t hash = duet_result_get_hash(&result);
    put_for(folder.store, f.world, NULL);
    duet_profile profile;
    must(duet_world_load_profile(f.world, folder.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_EXACT);
    assert_string_equal(duet_grade_name(profile.grade), "exact");
    assert_int_equal(duet_world_get_plan(f.world)->share, 3 * DUET_SHARE_ONE / 8);
    assert_string_equal(duet_world_get_plan(f.world)->variant_b, "auto sort=radix");
    assert_true(profile.step_ms == 2 && profile.gain == 0.5 && profile.measured_s > 0);
    must(duet_world_step(f.world, &result, ERR));
    assert_true(duet_result_get_hash(&result) == hash);
}

// Stored at sat6 with two false pairs in a hundred.
// The parts of a CPU are shown as two devices that nothing but their places tells apart.
TEST(two_equal_devices_are_another_pair_than_one)
{
    test_folder folder = test_folder_make();
    fixture f = make_world(300, 8, 0, "simd");
    device *own = f.pair->devices;
    skip_on_one_device();
    const device kept = own[1];
    own[1].info = own[0].info;
    strcpy(own[0].info.selector, "pocl:0");
    strcpy(own[1].info.selector, "pocl:1");
    profile_subject two, one;
    must(profile_subject_read(f.world, &two, ERR));
    assert_string_equal(two.pair.b.part, PROFILE_SECOND);
    put_subject(folder.store, &two, two.kernels);
    own[1].id = own[0].id;
    must(profile_subject_read(f.world, &one, ERR));
    const profile_subject *const asked[] = {&one, &two};
    for (int i = 0; i < 2; ++i) {
        profile_found found;
        profile_request request = profile_subject_request(asked[i]);
        must(profile_lookup_files(folder.store, NULL, &request, &found, NULL, ERR));
        assert_int_equal(found.grade, i == 0 ? PROFILE_DEFAULT : PROFILE_EXACT);
    }
    own[1] = kept;
}

TEST(a_world_gets_no_less_than_it_asked_for)
{
    test_folder folder = test_folder_make();
    fixture f = make_world(3000, test_seed(), 0, "auto");
    duet_profile profile;
    must(duet_world_set_level(f.world, DUET_LEVEL_SAT6, ERR));
    put_for(folder.store, f.world, NULL);
    test_store_run(folder.store, "UPDATE profile SET false_rate = 0.02, true_pairs = 100");
    must(duet_world_set_level(f.world, DUET_LEVEL_CERTIFIED, ERR));
    must(duet_world_load_profile(f.world, folder.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_DEFAULT);
    ask_for(&f, (duet_accuracy){0, 0.0199});
    must(duet_world_load_profile(f.world, folder.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_DEFAULT);
    assert_int_equal(profile.level, DUET_LEVEL_CERTIFIED);
    assert_int_equal(duet_world_get_level(f.world), DUET_LEVEL_CERTIFIED);
    ask_for(&f, (duet_accuracy){0, 0.02});
    must(duet_world_load_profile(f.world, folder.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_EXACT);
    assert_int_equal(profile.level, DUET_LEVEL_SAT6);
    assert_int_equal(duet_world_get_level(f.world), DUET_LEVEL_SAT6);
    assert_true(profile.accuracy.missed == 0 && profile.accuracy.false_rate == 0.02);
    assert_int_equal(profile.true_pairs, 100);
}

TEST(an_accuracy_that_cannot_be_is_refused)
{
    fixture f = make_world(10, test_seed(), 0, "auto");
    static const duet_accuracy bad[] = {{-0.1, 0}, {1.5, 0}, {0, -1}, {0, INFINITY}, {NAN, 0}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        duet_world_def def = f.def;
        def.has_accuracy = true;
        def.accuracy = bad[i];
        must_fail(duet_world_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, "the world's accuracy");
    }
}

TEST(without_a_profile_the_plan_stays)
{
    test_folder folder = test_folder_make();
    fixture f = make_world(3000, test_seed(), 0, "auto");
    duet_plan before = *duet_world_get_plan(f.world);
    duet_profile profile;
    must(duet_world_load_profile(f.world, folder.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_DEFAULT);
    put_for(folder.store, f.world, "of other kernels");
    must(duet_world_load_profile(f.world, folder.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_STALE);
    assert_memory_equal(&profile.plan, &before, sizeof before);
    assert_memory_equal(duet_world_get_plan(f.world), &before, sizeof before);
    must(text_write_file(folder.store, "rubbish", 7, ERR));
    must_fail(duet_world_load_profile(f.world, folder.store, &profile, ERR),
              DUET_STATUS_STORE_FAILED, "");
    assert_int_equal(profile.grade, DUET_GRADE_DEFAULT);
    assert_memory_equal(duet_world_get_plan(f.world), &before, sizeof before);
}

// Makes it as if it had been measured on twice as many objects, where sharing gained as much as
// that.
#define OF_TWICE_AS_MANY                                                           \
    "UPDATE profile SET gain = 3, gain_low = 2, gain_high = 4, true_pairs = 100; " \
    "UPDATE workload SET n = 2 * n, key = 'another'"

TEST(a_plan_of_another_workload_comes_without_figures)
{
    test_folder folder = test_folder_make();
    fixture f = make_world(3000, test_seed(), 0, "auto");
    duet_profile profile;
    put_for(folder.store, f.world, NULL);
    test_store_run(folder.store, OF_TWICE_AS_MANY);
    must(duet_world_load_profile(f.world, folder.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_TRANSFERRED);
    assert_int_equal(profile.plan.share, 24576);
    assert_int_equal(duet_world_get_plan(f.world)->share, 24576);
    assert_true(profile.step_ms == 0 && profile.gain == 0 && profile.gain_low == 0 &&
                profile.gain_high == 0 && profile.true_pairs == 0 && profile.measured_s == 0);
    assert_string_equal(profile.verdict, "");
}

// ------------------------------------------------------------- duet profiles why

#define SCENE "test_profiled.scene.lua"

static const char scene_text[] = "local random = random(3)\n"
                                 "for _ = 1, 500 do\n"
                                 "  add(random.uniform(0, 20), random.uniform(0, 20), "
                                 "random.uniform(0, 20), 0.5, 0.5, 0.5, 0, 0, 0, 1)\n"
                                 "end\n"
                                 "return { dims = 3 }\n";

static void put_for_scene(const char *path)
{
    duet_device_pair *pair = kept(duet_device_pair_open(NULL, ERR));
    duet_scene *scene = kept(duet_scene_load(SCENE, NULL, 0, ERR));
    duet_world_def def = duet_scene_world_def(scene, pair);
    duet_world *world = kept(duet_world_create(&def, ERR));
    must(duet_world_set_scene(world, scene, ERR));
    put_for(path, world, NULL);
}

static cJSON *ask_why(const char *path)
{
    program p = program_done(program_run("profiles why %s --profile %s --json", SCENE, path));
    assert_string_equal(p.err, "");
    return json_of(p.out);
}

static void assert_why(const cJSON *o, const char *grade, const char *says)
{
    assert_string_equal(json_string(o, "grade"), grade);
    const cJSON *line = NULL;
    bool said = false;
    cJSON_ArrayForEach(line, json_field(o, "why"))
    {
        said |= strstr(line->valuestring, says) != NULL;
    }
    if (!said)
        fail_msg("nothing says '%s'", says);
}

TEST(a_file_that_is_named_is_all_that_why_looks_in)
{
    test_folder user = test_folder_make(), system = test_folder_make();
    char installed[128], variables[256];
    test_write_file(SCENE, scene_text);
    snprintf(installed, sizeof installed, "%s/duet", system.path);
    assert_int_equal(mkdir(installed, 0755), 0);
    snprintf(installed, sizeof installed, "%s/duet/profiles.db", system.path);
    put_for_scene(installed);
    snprintf(variables, sizeof variables, "XDG_DATA_DIRS=%s DUET_PROFILE=%s", system.path,
             user.store);
    program p = program_run_with(variables, "profiles why %s", SCENE);
    assert_says(p.out, "\nexact: ");
    p = program_done(
        program_run_with(variables, "profiles why %s --profile %s", SCENE, user.store));
    assert_says(p.out, "there is no profile store", "\ndefault: ");
    assert_null(strstr(p.out, system.path));
}

TEST(why_names_the_plan_and_run_uses_it)
{
    test_folder folder = test_folder_make();
    test_write_file(SCENE, scene_text);
    cJSON *o = ask_why(folder.store);
    assert_why(o, "default", "there is no profile store");
    put_for_scene(folder.store);
    o = ask_why(folder.store);
    assert_why(o, "exact", "yes: manual 20");
    assert_true(json_number(o, "share") == 0.375);
    assert_string_equal(json_string(o, "variant_b"), "auto sort=radix");
    program p = program_done(program_run_with(folder.variable, "run %s --repeat 1", SCENE));
    assert_says(p.out, "plan: from the profile, exact; +50.0 % (+0.0 to +0.0) over ");
    p = program_run_with(folder.variable, "run %s --repeat 1 --json --check", SCENE);
    assert_says(p.out, "0.375", "\"exact\"");
    p = program_run_with(folder.variable, "run %s --repeat 1 --share 1/2", SCENE);
    assert_says(p.out, "plan: as given");
    p = program_done(program_run("profiles why %s --profile %s", SCENE, folder.store));
    assert_says(p.out, devices_are_two() ? "\nexact: share 0.3750, mode own, A auto, "
                                           "B auto sort=radix"
                                         : "\nexact: kernels auto sort=radix");
    p = program_run("profiles why %s --profile %s --level sat15", SCENE, folder.store);
    assert_says(p.out, "\n  exact         no: ", "\n  other driver  no: ", "\n  stale         no: ",
                "of which nothing is known");
    test_store_run(folder.store, "UPDATE profile SET share = 0, verdict = 'same'");
    p = program_run_with(folder.variable, "run %s --repeat 1", SCENE);
    if (devices_are_two())
        assert_says(p.out, "exact; B alone; no share promises more");
}

TEST(why_and_run_say_that_no_figure_is_known)
{
    static const char *const figures[] = {"ms", "gain", "gain_low", "gain_high", "verdict"};
    test_folder folder = test_folder_make();
    test_write_file(SCENE, scene_text);
    put_for_scene(folder.store);
    test_store_run(folder.store, OF_TWICE_AS_MANY);
    cJSON *o = ask_why(folder.store);
    assert_why(o, "transferred", "none of its figures is of this workload");
    assert_true(json_number(o, "share") == 0.375);
    for (size_t i = 0; i < sizeof figures / sizeof *figures; ++i)
        assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(o, figures[i])));
    assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(o, "true_pairs")));
    assert_string_equal(json_string(o, "uid"), "");
    program p = program_run("profiles why %s --profile %s", SCENE, folder.store);
    assert_says(p.out, "what a step takes and gains here is not known");
    p = program_run_with(folder.variable, "run %s --repeat 1", SCENE);
    assert_says(p.out, "plan: from the profile of another workload; what it gains here "
                       "is not known");
}

// ------------------------------------------------------------ queries

static duet_tree *make_tree(const fixture *f)
{
    duet_tree_def def = duet_default_tree_def();
    def.pair = f->pair;
    def.share = 0;
    duet_tree *tree = kept(duet_tree_create(&def, ERR));
    must(duet_tree_set_objects(tree, DUET_OBJECT_POSES, f->poses, f->n, ERR));
    return tree;
}

static duet_grade load_query(duet_tree *tree, const char *query, uint64_t n, const char *path,
                             uint32_t share)
{
    duet_profile profile;
    must(duet_tree_load_profile(tree, query, n, path, &profile, ERR));
    assert_int_equal(profile.plan.share, share);
    return profile.grade;
}

// Also for a tenth more items, and for boxes of the same octave.
TEST(a_query_takes_its_profile_and_others_keep_their_share)
{
    enum { RAYS = 640, SHARE = 3 * DUET_SHARE_ONE / 8 };
    test_folder folder = test_folder_make();
    fixture f = make_world(1000, test_seed(), 0, "auto");
    duet_tree *tree = make_tree(&f);
    profile_subject subject;
    query_name name;
    must(query_name_read("rays", &name, ERR));
    must(profile_subject_read_query(tree, &name, RAYS, &subject, ERR));
    assert_int_equal(load_query(tree, "rays closest", RAYS, folder.store, 0), DUET_GRADE_DEFAULT);
    put_subject(folder.store, &subject, NULL);
    assert_int_equal(load_query(tree, "rays closest", RAYS, folder.store, SHARE), DUET_GRADE_EXACT);
    assert_int_equal(load_query(tree, "rays closest", RAYS + RAYS / 20, folder.store, SHARE),
                     DUET_GRADE_INTERPOLATED);
    assert_int_equal(load_query(tree, "rays closest", 10 * RAYS, folder.store, SHARE),
                     DUET_GRADE_DEFAULT); // the share stays
    assert_int_equal(load_query(tree, "rays any", RAYS, folder.store, 0), DUET_GRADE_DEFAULT);

    duet_ray_query_def closest = duet_default_ray_query_def(), any = closest;
    duet_ray_query_result result;
    duet_ray rays[RAYS] = {0};
    closest.tree = any.tree = tree;
    any.wants = DUET_QUERY_ANY;
    duet_ray_query *tuned = kept(duet_ray_query_create(&closest, ERR));
    duet_ray_query *other = kept(duet_ray_query_create(&any, ERR));
    must(duet_ray_query_run(other, rays, RAYS, &result, ERR));
    assert_true(result.device_ms[0] == 0 && result.device_ms[1] > 0);
    must(duet_ray_query_run(tuned, rays, RAYS, &result, ERR));
    assert_true(result.device_ms[0] > 0 && result.device_ms[1] > 0);
    must(duet_tree_set_share(tree, 0, ERR));
    must(duet_ray_query_run(tuned, rays, RAYS, &result, ERR));
    assert_true(result.device_ms[0] == 0);

    // A plan that no race has spoken for, or was measured with other kernels, is not followed.
    test_store_run(folder.store, "UPDATE profile SET kernels = 'other'");
    assert_int_equal(load_query(tree, "rays closest", RAYS, folder.store, 0), DUET_GRADE_STALE);
    must(duet_tree_set_objects(tree, DUET_OBJECT_POSES, f.poses, 4 * f.n / 10, ERR));
    assert_int_equal(load_query(tree, "rays closest", RAYS, folder.store, 0), DUET_GRADE_DEFAULT);
}

TEST(names_of_queries_are_read_as_they_are_written)
{
    static const char *const names[] = {
        "rays closest", "rays any", "rays every",       "sweeps any",         "boxes",
        "boxes itself", "points",   "points nearest 8", "points nearest 1024"};
    static const char *const wrong[] = {"",
                                        "ray",
                                        "rays ",
                                        "rays closest ",
                                        "boxes 1",
                                        "points nearest 0",
                                        "points nearest 1025",
                                        "points nearest 8x",
                                        "points nearest",
                                        "rays  any"};
    query_name name;
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char written[QUERY_NAME];
        must(query_name_read(names[i], &name, ERR));
        query_name_write(&name, written);
        assert_string_equal(written, names[i]);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        duet_error err = {0};
        if (query_name_read(wrong[i], &name, &err))
            fail_msg("'%s' is no query", wrong[i]);
    }
}
