// SPDX-License-Identifier: MIT
#include "cli/report/bench_report.h"

#include "cli/report/table.h"
#include "cli/say.h"
#include "tuner/race.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double level = 0.95;

static const char *const fields[] = {"against_ms", "ratio", "ratio_low", "ratio_high", "verdict"};

// The least part of a time that the case would have taken on a machine of its
// own. Squared, for a step also waits for the slower of its threads.
static double least_of(const cJSON *one)
{
    double own = fmax(1 - json_number(one, "cpu_load"), 0.05);
    return own * own;
}

// What other programs may be to blame for is neither faster nor slower.
static race_gain doubt(race_gain gain, const cJSON *one, const cJSON *before)
{
    bool decided = gain.verdict == RACE_FASTER || gain.verdict == RACE_SLOWER;
    gain.interval.low *= least_of(before);
    gain.interval.high /= least_of(one);
    if (decided && gain.interval.low <= 1 && gain.interval.high >= 1)
        gain.verdict = RACE_AMBIGUOUS;
    return gain;
}

static void compare_case(cJSON *one, const cJSON *before)
{
    double own[BENCH_SAMPLES_MOST];
    double others[BENCH_SAMPLES_MOST];
    uint32_t n_own = bench_samples(one, own);
    uint32_t n_others = bench_samples(before, others);
    race_gain gain = doubt(race_compare_apart(own, n_own, others, n_others, level), one, before);
    cJSON_AddNumberToObject(one, fields[0], json_number(before, "median_ms"));
    cJSON_AddNumberToObject(one, fields[1], gain.ratio);
    cJSON_AddNumberToObject(one, fields[2], gain.interval.low);
    cJSON_AddNumberToObject(one, fields[3], gain.interval.high);
    cJSON_AddStringToObject(one, fields[4], race_verdict_name(gain.verdict));
}

void bench_compare(cJSON *results, const cJSON *before)
{
    cJSON *one;
    cJSON_ArrayForEach(one, json_list(results, "cases"))
    {
        const cJSON *earlier = bench_find(before, one);
        if (earlier && !*json_string(one, "failed") && !*json_string(one, "verdict"))
            compare_case(one, earlier);
    }
}

// ---------------------------------------------------------------- tables

static void heads(table *t, bool compared)
{
    static const char *const names[] = {"share", "mode",   "kernels", "ms",   "from", "to", "A ms",
                                        "B ms",  "before", "ratio",   "from", "to",   ""};
    for (int i = 0; i < (compared ? 13 : 8); ++i)
        table_cell(t, "%s", names[i]);
}

static void kernels_cell(table *t, const cJSON *one)
{
    const char *a = json_string(one, "variant_a");
    const char *b = json_string(one, "variant_b");
    bool same = strcmp(a, b) == 0;
    table_cell(t, "%s%s%s", a, same ? "" : " | ", same ? "" : b);
}

static void comparison_cells(table *t, const cJSON *one)
{
    if (!*json_string(one, "verdict")) {
        for (int i = 0; i < 4; ++i)
            table_cell(t, "-");
        table_cell(t, "new");
        return;
    }
    table_cell(t, "%.3f", json_number(one, "against_ms"));
    for (int i = 1; i < 4; ++i)
        table_cell(t, "%.3f", json_number(one, fields[i]));
    table_cell(t, "%s", json_string(one, "verdict"));
}

static void case_row(table *t, const cJSON *one, bool compared)
{
    static const char *const times[] = {"median_ms", "low_ms", "high_ms", "a_ms", "b_ms"};
    table_cell(t, "%.2f", json_number(one, "share"));
    table_cell(t, "%s", json_string(one, "mode"));
    kernels_cell(t, one);
    for (int i = 0; i < 5; ++i) {
        if (*json_string(one, "failed"))
            table_cell(t, i == 0 ? "failed" : "-");
        else
            table_cell(t, "%.3f", json_number(one, times[i]));
    }
    if (compared)
        comparison_cells(t, one);
}

void bench_print_scene(const cJSON *results, const char *scene, const cJSON *before)
{
    table t = table_begin(before ? "rllrrrrrrrrrl" : "rllrrrrr");
    bool begun = false;
    const cJSON *one;
    cJSON_ArrayForEach(one, json_list(results, "cases"))
    {
        if (strcmp(json_string(one, "scene"), scene) != 0)
            continue;
        if (!begun) {
            printf("%s, %s objects, %.0fD\n", say_name(scene).chars,
                   table_count((uint64_t)json_number(one, "objects")).chars,
                   json_number(one, "dims"));
            heads(&t, before != NULL);
        }
        begun = true;
        case_row(&t, one, before != NULL);
    }
    table_print(&t, stdout);
    putchar('\n');
    fflush(stdout);
}

static double mean_others(const cJSON *results)
{
    double sum = 0;
    int n = 0;
    const cJSON *one;
    cJSON_ArrayForEach(one, json_list(results, "cases"))
    {
        sum += json_number(one, "cpu_load");
        n += !*json_string(one, "failed");
    }
    return n > 0 ? sum / n : 0;
}

void bench_print_verdicts(const cJSON *results, const cJSON *before)
{
    uint32_t counts[RACE_AMBIGUOUS + 1] = {0};
    const cJSON *one;
    if (!before)
        return;
    cJSON_ArrayForEach(one, json_list(results, "cases"))
    {
        for (int v = 0; v <= RACE_AMBIGUOUS; ++v)
            counts[v] += strcmp(json_string(one, "verdict"), race_verdict_name(v)) == 0;
    }
    printf("against %s:", say_name(json_string(before, "time")).chars);
    for (int v = 0; v <= RACE_AMBIGUOUS; ++v)
        printf("%s %u %s", v ? "," : "", counts[v], race_verdict_name((race_verdict)v));
    printf(" (intervals of %.0f %%)\n", 100 * level);
    printf("other programs used %.0f %% of the processors, and then %.0f %%; what they may be to "
           "blame for is ambiguous\n",
           100 * mean_others(results), 100 * mean_others(before));
}
