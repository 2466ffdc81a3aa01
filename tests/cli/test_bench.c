// SPDX-License-Identifier: MIT
// duet bench, as a person calls it; on one small scene of the set.
#include "support/devices.h"
#include "support/json.h"
#include "support/test.h"

#include "base/text.h"

#define OUT "test_bench.json"
#define OLD "test_bench.old.json"
#define BENCH "bench --quick --scene paper "

static cJSON *read_json(const char *path)
{
    return json_of(test_read_file(path).chars);
}

static void measure(void)
{
    program_done(program_run(BENCH "--repeat 7 -o " OUT));
}

// The results with all times multiplied, as if of an earlier Duet, while other
// programs had that part of the processors.
static void write_old(double factor, double others)
{
    cJSON *o = read_json(OUT);
    cJSON *one;
    cJSON *item;
    cJSON_ArrayForEach(one, json_field(o, "cases"))
        cJSON_ArrayForEach(item, json_field(one, "samples_ms"))
            cJSON_SetNumberValue(item, item->valuedouble * factor);
    cJSON_ArrayForEach(one, json_field(o, "cases"))
        cJSON_SetNumberValue(cJSON_GetObjectItem(one, "cpu_load"), others);
    char *chars = cJSON_Print(o);
    test_write_file(OLD, chars);
    cJSON_free(chars);
}

static void assert_verdicts(const char *arguments, const char *verdict)
{
    program p = program_run(BENCH "--json --against " OLD " %s", arguments);
    bool slower = strcmp(verdict, "slower") == 0;
    if (p.exit_code != slower)
        fail_msg("exit code %d: %s", p.exit_code, p.err);
    if (slower && !strstr(p.err, "cases became slower for sure: paper by '"))
        fail_msg("%s", p.err);
    cJSON *o = json_of(p.out);
    const cJSON *one;
    cJSON_ArrayForEach(one, json_field(o, "cases"))
        assert_string_equal(json_string(one, "verdict"), verdict);
}

TEST(results_hold_every_sample_and_the_devices)
{
    cJSON *o = read_json(OUT);
    assert_string_equal(json_string(o, "type"), "duet bench");
    assert_int_equal(json_size(o, "devices"), 2);
    const cJSON *cases = json_field(o, "cases");
    assert_true(cJSON_GetArraySize(cases) >= (devices_are_two() ? 9 : 3));
    const char *hash = json_string(cases->child, "hash");
    const cJSON *one;
    cJSON_ArrayForEach(one, cases)
    {
        assert_int_equal(json_size(one, "samples_ms"), 7);
        assert_string_equal(json_string(one, "hash"), hash);
        double median = json_number(one, "median_ms");
        assert_true(median >= json_number(one, "low_ms"));
        assert_true(median <= json_number(one, "high_ms"));
    }
}

TEST(a_millionfold_difference_is_seen_and_few_samples_are_ambiguous)
{
    write_old(1e6, 0);
    assert_verdicts("--repeat 7", "faster");
    assert_verdicts("--repeat 2", "ambiguous");
    write_old(1e-6, 0);
    assert_verdicts("--repeat 7", "slower");
}

TEST(what_other_programs_may_be_to_blame_for_is_ambiguous)
{
    write_old(150, 0.99);
    assert_verdicts("--repeat 7", "ambiguous");
}

TEST(an_only_device_has_no_share)
{
    program p = program_done(program_run("bench --quick --scene paper2d --repeat 1 --pair cpu"));
    assert_says(p.out, "kernels");
    assert_null(strstr(p.out, "share"));
    assert_null(strstr(p.out, "A ms"));
}

TEST(the_whole_set_costs_levels_and_effects)
{
    cJSON *o = read_json(OUT);
    const cJSON *levels = json_field(json_row(o, "accuracy", 0), "levels");
    assert_true(cJSON_GetArraySize(levels) >= (devices_are_two() ? 2 : 1) * 5);
    program p = program_done(program_run("bench --quick --scene falling --json"));
    o = json_of(p.out);
    const cJSON *effects = json_field(json_row(o, "effects", 0), "effects");
    const cJSON *one;
    cJSON_ArrayForEach(one, effects)
    {
        const char *name = json_string(one, "effect");
        bool alone = strcmp(name, "contact_response") == 0 || strcmp(name, "friction") == 0;
        if (alone != (alone && cJSON_GetObjectItem(one, "ms")))
            fail_msg("'%s' has no time", name);
    }
}

TEST(text_says_what_it_was_compared_with)
{
    write_old(1e6, 0);
    program p = program_done(program_run(BENCH "--repeat 7 --against " OLD));
    const char *const says[] = {"paper, 3 000 objects, 3D",
                                "sort=radix",
                                devices_are_two() ? "slab" : "kernels",
                                "before",
                                "faster, 0 same, 0 slower, 0 ambiguous",
                                NULL};
    assert_says_all(p.out, says);
    assert_null(strstr(p.out, "\n\n\n"));
    assert_int_not_equal(strncmp(p.out + strlen(p.out) - 2, "\n\n", 2), 0);
}

TEST(a_stopped_run_says_what_its_file_holds)
{
    char says[128];
    program p = program_run_with("timeout --foreground --preserve-status -s INT 1",
                                 "bench --quick --repeat 512 -o " OLD);
    assert_int_equal(p.exit_code, 130);
    cJSON *o = read_json(OLD);
    int n = json_size(o, "cases") + json_size(o, "accuracy");
    snprintf(says, sizeof says, "duet: stopped; " OLD " holds %d case%s\n", n, n == 1 ? "" : "s");
    assert_string_equal(p.err, says);
}

TEST(what_is_no_result_is_refused_in_one_line)
{
    static const char *const bad[][2] = {
        {"", OLD ": not JSON"},
        {"{", OLD ": not JSON"},
        {"[]", OLD ": no results of 'duet bench --output'"},
        {"{\"type\":\"duet bench\",\"version\":9}", OLD ": results of version 9"},
        {"{\"type\":\"duet bench\",\"version\":1}", OLD ": 'cases' or the two 'devices'"},
        {"{\"type\":\"duet bench\",\"version\":1,\"devices\":[{},{}],\"cases\":[7]}",
         OLD ": case 0: 'scene' is not a string"},
        {"{\"type\":\"duet bench\",\"version\":1,\"devices\":[{},{}],\"cases\":[{\"scene\":\"s\","
         "\"objects\":1,\"share\":0,\"mode\":\"own\",\"variant_a\":\"\",\"variant_b\":\"\","
         "\"hash\":\"\",\"median_ms\":1,\"low_ms\":1,\"high_ms\":1,\"a_ms\":1,\"b_ms\":1,"
         "\"stages\":[],\"samples_ms\":[1,-2]}]}",
         OLD ": case 0: 'samples_ms' is not 1 to 512 times above 0"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        test_write_file(OLD, bad[i][0]);
        program p = program_run(BENCH "--against " OLD);
        program_assert_refused(p, 1, bad[i][1]);
    }
    program_assert_refused(program_run("bench --scene abacus"), 2,
                           "--scene 'abacus': the set has paper,");
    program_assert_refused(program_run(BENCH "--against no/such.json"), 1, "no/such.json");
}

TEST_BEGIN(measure)
