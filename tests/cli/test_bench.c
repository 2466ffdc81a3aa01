// SPDX-License-Identifier: MIT
// duet bench, as a person calls it; on one small scene of the set.
#include "support/devices.h"
#include "support/json.h"
#include "support/program.h"
#include "support/test.h"

#include "base/text.h"

#define OUT "test_bench.json"
#define OLD "test_bench.old.json"
#define BENCH "bench --quick --scene paper "

static cJSON *read_json(const char *path)
{
    own(text) t = test_read_file(path);
    cJSON *o = json_of(text_chars(&t));
    assert_non_null(o);
    return o;
}

static int measure(void **state)
{
    (void)state;
    program_done(program_run(BENCH "--repeat 7 -o " OUT));
    return 0;
}

// The results with all times multiplied, as if of an earlier Duet, while other
// programs had that part of the processors.
static void write_old(double factor, double others)
{
    cJSON *o = read_json(OUT);
    cJSON *one;
    cJSON *item;
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(o, "cases"))
        cJSON_ArrayForEach(item, cJSON_GetObjectItem(one, "samples_ms"))
            cJSON_SetNumberValue(item, item->valuedouble * factor);
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(o, "cases"))
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
    cJSON_ArrayForEach(one, cJSON_GetObjectItem(o, "cases"))
        assert_string_equal(cJSON_GetObjectItem(one, "verdict")->valuestring, verdict);
}

TEST(results_hold_every_sample_and_the_devices)
{
    cJSON *o = read_json(OUT);
    assert_string_equal(cJSON_GetObjectItem(o, "type")->valuestring, "duet bench");
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(o, "devices")), 2);
    const cJSON *cases = cJSON_GetObjectItem(o, "cases");
    assert_true(cJSON_GetArraySize(cases) >= (devices_are_two() ? 9 : 3));
    const char *hash = cJSON_GetObjectItem(cases->child, "hash")->valuestring;
    const cJSON *one;
    cJSON_ArrayForEach(one, cases)
    {
        assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(one, "samples_ms")), 7);
        assert_string_equal(cJSON_GetObjectItem(one, "hash")->valuestring, hash);
        double median = cJSON_GetObjectItem(one, "median_ms")->valuedouble;
        assert_true(median >= cJSON_GetObjectItem(one, "low_ms")->valuedouble);
        assert_true(median <= cJSON_GetObjectItem(one, "high_ms")->valuedouble);
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
    assert_non_null(strstr(p.out, "kernels"));
    assert_null(strstr(p.out, "share"));
    assert_null(strstr(p.out, "A ms"));
}

TEST(the_whole_set_costs_levels_and_effects)
{
    cJSON *o = read_json(OUT);
    const cJSON *levels = cJSON_GetObjectItem(cJSON_GetObjectItem(o, "accuracy")->child, "levels");
    assert_true(cJSON_GetArraySize(levels) >= (devices_are_two() ? 2 : 1) * 5);
    program p = program_done(program_run("bench --quick --scene falling --json"));
    o = json_of(p.out);
    const cJSON *effects = cJSON_GetObjectItem(cJSON_GetObjectItem(o, "effects")->child, "effects");
    const cJSON *one;
    cJSON_ArrayForEach(one, effects)
    {
        const char *name = cJSON_GetObjectItem(one, "effect")->valuestring;
        bool alone = strcmp(name, "contact_response") == 0 || strcmp(name, "friction") == 0;
        if (alone != (alone && cJSON_GetObjectItem(one, "ms")))
            fail_msg("'%s' has no time", name);
    }
}

TEST(text_says_what_it_was_compared_with)
{
    write_old(1e6, 0);
    program p = program_done(program_run(BENCH "--repeat 7 --against " OLD));
    const char *const says[] = {"paper, 3 000 objects, 3D", "sort=radix",
                                devices_are_two() ? "slab" : "kernels", "before",
                                "faster, 0 same, 0 slower, 0 ambiguous"};
    for (size_t i = 0; i < sizeof says / sizeof says[0]; ++i)
        if (!strstr(p.out, says[i]))
            fail_msg("'%s' is missing in\n%s", says[i], p.out);
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
    int n = cJSON_GetArraySize(cJSON_GetObjectItem(o, "cases")) +
            cJSON_GetArraySize(cJSON_GetObjectItem(o, "accuracy"));
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

TEST_MAIN(measure, NULL)
