// SPDX-License-Identifier: MIT
// duet explain of still scenes, as a person calls it.
#include "support/json.h"
#include "support/test.h"

// The lines about device B, which does all the work.
static cJSON *explain(const char *arguments)
{
    cJSON *o = json_of_run("explain %s --share 0 --json", arguments);
    const cJSON *search = json_field(o, "search");
    assert_int_equal(cJSON_GetArraySize(search), 1);
    return cJSON_GetArrayItem(search, 0);
}

static int value_of(const cJSON *b, const char *parameter)
{
    const cJSON *fact = NULL;
    cJSON_ArrayForEach(fact, json_field(b, "facts"))
    {
        if (strcmp(json_string(fact, "parameter"), parameter) == 0)
            return (int)json_number(fact, "value");
    }
    fail_msg("nothing is told of %s", parameter);
    return -1;
}

// The kernel of that name, and that it is told once.
static const cJSON *kernel_of(const cJSON *b, const char *name)
{
    const cJSON *found = NULL;
    const cJSON *k = NULL;
    size_t length = strlen(name);
    cJSON_ArrayForEach(k, json_field(b, "kernels"))
    {
        const char *its = json_string(k, "name");
        if (strncmp(its, name, length) != 0 || (its[length] && its[length] != '.'))
            continue;
        assert_null(found);
        found = k;
    }
    assert_non_null(found);
    return found;
}

static bool runs(const cJSON *b, const char *name)
{
    return json_true(kernel_of(b, name), "runs");
}

static const char *scene(const char *file)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", getenv("DUET_TEST_SCENES"), file);
    return path;
}

static cJSON *explain_paper(const char *options)
{
    char arguments[768];
    snprintf(arguments, sizeof arguments, "%s -n 500 %s", scene("paper.lua"), options);
    return explain(arguments);
}

TEST(the_kernels_of_each_search_run_and_the_others_are_left_out)
{
    static const struct {
        const char *words;
        const char *run[6];
        const char *left_out[6];
    } searches[] = {
        {"simd",
         {"scatter", "reorder_simd", "pair_search_simd"},
         {"radix", "cell_start", "bounds", "pair_search_gpu", "narrow", "narrow_simd"}},
        {"gpu sort=radix",
         {"radix", "cell_start", "reorder", "pair_search_gpu", "narrow"},
         {"scatter", "reorder_simd", "pair_search_simd", "pair_search_paper", "narrow_simd"}},
        {"gpu FROM_IDS=0", {"reorder", "pair_search_gpu"}, {"scatter", "radix"}},
        {"paper",
         {"radix", "cell_start", "bounds", "pair_search_paper", "narrow"},
         {"scatter", "reorder", "pair_search_simd"}},
    };
    for (size_t s = 0; s < sizeof searches / sizeof *searches; ++s) {
        char options[64];
        snprintf(options, sizeof options, "--variant '%s'", searches[s].words);
        cJSON *b = explain_paper(options);
        for (int i = 0; i < 6 && searches[s].run[i]; ++i)
            assert_true(runs(b, searches[s].run[i]));
        for (int i = 0; i < 6 && searches[s].left_out[i]; ++i)
            assert_false(runs(b, searches[s].left_out[i]));
        assert_true(runs(b, "clear") && runs(b, "hash") && runs(b, "scan"));
    }
}

TEST(properties_of_the_scene_are_told_by_their_parameter)
{
    cJSON *b = explain_paper("");
    assert_int_equal(value_of(b, "DIMS"), 3);
    assert_int_equal(value_of(b, "SHAPE"), 0);
    assert_int_equal(value_of(b, "ROTATED"), 1);
    assert_int_equal(value_of(b, "ACCURACY"), 0);
    assert_int_equal(value_of(b, "LEVELS"), 0);
    b = explain_paper("--level sat6 --variant 'gpu grid=hashed'");
    assert_int_equal(value_of(b, "ACCURACY"), 3);
    assert_int_equal(value_of(b, "GRID"), 1);
}

TEST(bounds_that_overlap_are_the_answer)
{
    cJSON *b = explain_paper("--level aabb");
    assert_false(runs(b, "narrow_simd"));
    assert_string_equal(json_string(kernel_of(b, "narrow_simd"), "why"),
                        "bounds that overlap are the answer");
}

TEST(a_still_scene_is_told_as_text)
{
    program p =
        program_done(program_run("explain %s -n 500 --share 0 --variant simd", scene("paper.lua")));
    assert_says(p.out, "ROTATED=1", "\nruns ", "\nleft out  ");
    assert_string_not_equal(p.out + strlen(p.out) - 2, "\n\n");
}

TEST(a_scene_that_moves_is_told_by_its_effects)
{
    program p = program_done(program_run("explain %s -n 50", scene("falling.lua")));
    assert_says(p.out, "gravity");
    assert_null(strstr(p.out, "pair_search_simd"));
    assert_says(p.out, "\n4 substeps a step, chosen: nothing stands");
    test_write_file("stack.lua",
                    "for i = 1, 50 do add { centre = { 0, 0, i - 0.5 }, half_extents = "
                    "{ .5, .5, .5 } } end\n"
                    "return { dims = 3, gravity = { 0, 0, -9.81 }, "
                    "wants = { 'contact_response' } }\n");
    p = program_done(program_run("explain stack.lua"));
    assert_says(p.out, "\n6 substeps a step, chosen: they hold the column of 50 bodies");
}

TEST(what_is_wrong_with_a_plan_is_one_line)
{
    program_assert_refused(program_run("explain %s -n 50 --variant abacus", scene("paper.lua")), 2,
                           "variant 'abacus': expected auto, simd, gpu or paper");
    program_assert_refused(program_run("explain %s -n 50 --level best", scene("paper.lua")), 2,
                           "best");
}

// The scene decides whether these say anything.
TEST(what_a_scene_has_no_use_for_is_refused)
{
    static const struct {
        const char *command;
        const char *scene;
        const char *says;
    } wrong[] = {
        {"explain --measure", "paper.lua", "--measure is of a scene that moves"},
        {"explain --level sat6", "falling.lua", "--level is of a scene that does not move"},
        {"accuracy --time 2", "paper.lua", "--time and --limit are of a scene that moves"},
        {"accuracy --repeat 2", "falling.lua",
         "--repeat is of the levels of a scene that does not"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        program p = program_run("%s -n 50 %s", wrong[i].command, scene(wrong[i].scene));
        program_assert_refused(p, 2, wrong[i].says);
    }
    program_assert_refused(program_run("explain %s -n 50 --mode nowhere", scene("falling.lua")), 2,
                           "--mode 'nowhere'");
}
