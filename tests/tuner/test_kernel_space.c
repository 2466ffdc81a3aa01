// SPDX-License-Identifier: MIT
// Parameters that can be set of the kernels that a world really runs.
#include "support/test.h"

#include "tuner/subject.h"

enum { BOXES = 300 };

static subject usual;

static void begin(void)
{
    duet_device_pair_def devices = duet_default_device_pair_def();
    devices.a = devices.b = "cpu";
    duet_world_def def = duet_default_world_def();
    def.pair = kept(duet_device_pair_create(&devices, ERR));
    duet_world *world = kept(duet_world_create(&def, ERR));
    duet_pose poses[BOXES];
    for (int i = 0; i < BOXES; ++i)
        poses[i] =
            (duet_pose){{0.7f * (float)(i % 17), 0.8f * (float)(i % 5), 0.9f * (float)(i % 13)},
                        {0.5f, 0.5f, 0.5f},
                        {0, 0, 0, 1}};
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, BOXES, ERR));
    usual = (subject){.kind = &subject_still, .state = world};
}

static duet_plan plan_of_b(const char *variant)
{
    duet_plan plan = {.mode = DUET_MODE_OWN, .variant_a = "simd"};
    strcpy(plan.variant_b, variant);
    return plan;
}

static kernel_spaces read_b(const char *variant)
{
    kernel_spaces spaces = {0};
    duet_plan plan = plan_of_b(variant);
    must(duet_world_set_plan(usual.state, &plan, ERR));
    must(kernel_spaces_read(usual.state, 1, &spaces, ERR));
    return spaces;
}

static const kernel_space *find(const kernel_spaces *spaces, const char *kernel)
{
    for (uint32_t i = 0; i < spaces->n; ++i)
        if (strcmp(spaces->of[i].kernel, kernel) == 0)
            return &spaces->of[i];
    fail_msg("'%s' has no space", kernel);
    return NULL;
}

// Neither what the scene decides nor what has one value is free.
TEST(the_search_of_a_cpu_has_48_configs)
{
    static const char *const names[] = {"BUF", "AHEAD", "PER_ITEM"};
    static const int64_t now[] = {512, 32, 1024};
    own(kernel_spaces) spaces = read_b("simd");
    const kernel_space *s = find(&spaces, "pair_search_simd");
    assert_ptr_equal(s, spaces.of); // first, as what takes longest
    assert_int_equal(s->n_configs, 4 * 4 * 3);
    assert_int_equal(s->n_params, 3);
    for (uint32_t i = 0; i < 3; ++i) {
        assert_string_equal(s->params[i].name, names[i]);
        assert_int_equal(s->params[i].values[s->configs[s->now][i]], now[i]);
    }
}

TEST(what_a_variant_sets_is_not_free)
{
    own(kernel_spaces) spaces = read_b("simd pair_search_simd.BUF=256");
    assert_int_equal(find(&spaces, "pair_search_simd")->n_configs, 4 * 3);
}

// A combination that the card rules out is no config: on a CPU 2 * 3 * 4 * 2 less those whose BATCH
// is no multiple of LANES.
TEST(configs_that_are_not_valid_are_left_out)
{
    own(kernel_spaces) spaces = read_b("simd");
    assert_int_equal(find(&spaces, "hash")->n_configs, (2 * 3 - 1) * 4 * 2);
}

TEST(a_config_as_text_runs_and_finds_the_same_pairs)
{
    char variant[DUET_VARIANT] = "simd", full[DUET_VARIANT];
    measure_launch plain = {0}, set = {0};
    own(kernel_spaces) spaces = read_b("simd");
    const kernel_space *s = find(&spaces, "clear");
    assert_true(kernel_space_write(s, s->now, variant));
    assert_string_equal(variant, "simd");
    uint32_t other = s->now == 0 ? 1 : 0;
    assert_true(kernel_space_write(s, other, variant));
    assert_ptr_equal(strstr(variant, "simd clear."), variant);
    snprintf(full, sizeof full, "%*s", (int)sizeof full - 8, "simd");
    assert_false(kernel_space_write(s, other, full));
    measure_machine machine = subject_machine(&usual, 0);
    duet_plan plan = plan_of_b("simd");
    must(machine.launch(machine.context, &plan, false, &plain, ERR));
    strcpy(plan.variant_b, variant);
    must(machine.launch(machine.context, &plan, false, &set, ERR));
    assert_true(plain.hash == set.hash && plain.hash != 0);
}

// The search of a CPU tests what it finds: its stage is a part of T_GPU2 all the same.
TEST(terms_count_the_search_that_tests)
{
    static const char *const stages[] = {"search"};
    measure_launch launch = {0};
    measure_machine machine = subject_machine(&usual, 0);
    duet_plan plan = plan_of_b("simd");
    must(machine.launch(machine.context, &plan, true, &launch, ERR));
    double ms = (double)measure_stages_ns(&launch, 1, stages, 1) * 1e-6;
    assert_true(ms > 0);
    assert_int_equal(measure_stages_ns(&launch, 0, stages, 1), 0);
    assert_true(launch.terms.gpu2 > 0.999 * ms);
}

TEST_BEGIN(begin)
