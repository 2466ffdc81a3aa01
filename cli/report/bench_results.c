// SPDX-License-Identifier: MIT
#include "cli/report/bench_results.h"

#include "base/error.h"
#include "cli/costs.h"
#include "cli/report/level_costs_report.h"
#include "cli/report/rendering.h"
#include "tuner/race.h"
#include "tuner/stats.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { VERSION = 1 };
static const double level = 0.95; // the confidence of all intervals

// ---------------------------------------------------------------- writing

static void add_time(cJSON *o)
{
    char when[40];
    time_t now = time(NULL);
    strftime(when, sizeof when, "%Y-%m-%dT%H:%M:%SZ", gmtime(&now));
    json_add(o, STRING("time", when));
}

cJSON *bench_begin(const duet_device_pair *pair, bool quick)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("type", BENCH_TYPE), NUMBER("version", VERSION),
             STRING("duet", duet_version()));
    add_time(o);
    json_add(o, FLAG("quick", quick));
    cJSON *devices = cJSON_AddArrayToObject(o, "devices");
    for (int i = 0; i < 2; ++i) {
        const duet_device_info *info = duet_device_pair_get_info(pair, i);
        cJSON *device = json_add_row(devices);
        json_add(device, STRING("selector", info->selector), STRING("name", info->name),
                 STRING("driver", info->driver), STRING("platform", info->platform_version),
                 NUMBER("units", info->units));
    }
    cJSON_AddArrayToObject(o, "cases");
    cJSON_AddArrayToObject(o, "accuracy");
    cJSON_AddArrayToObject(o, "effects");
    return o;
}

static void add_times(cJSON *o, const timed *t)
{
    double ms[BENCH_SAMPLES_MOST];
    for (uint32_t i = 0; i < t->n; ++i)
        ms[i] = t->steps[i].total_ms;
    const timed_step *median = timed_median(t), *staged = timed_staged(t);
    stats_interval in = stats_median_interval(ms, t->n, level);
    json_add(o, NUMBER("median_ms", stats_median(ms, t->n)), NUMBER("low_ms", in.low),
             NUMBER("high_ms", in.high), NUMBER("confidence", in.confidence),
             NUMBER("a_ms", median->device_ms[0]), NUMBER("b_ms", median->device_ms[1]));
    cJSON_AddItemToObject(o, "samples_ms", cJSON_CreateDoubleArray(ms, (int)t->n));
    cJSON *stages = cJSON_AddArrayToObject(o, "stages");
    for (uint32_t i = 0; i < staged->n_stages; ++i) {
        cJSON *stage = json_add_row(stages);
        json_add(stage, STRING("name", staged->stages[i].name),
                 STRING("device", staged->stages[i].device == 0 ? "A" : "B"),
                 NUMBER("ms", staged->stages[i].ms));
    }
}

cJSON *bench_add(cJSON *results, const bench_subject *subject, const duet_plan *plan,
                 const timed *t, const duet_error *failure)
{
    cJSON *o = json_add_row(cJSON_GetObjectItem(results, "cases"));
    json_add(o, STRING("scene", subject->name), NUMBER("dims", subject->dims),
             NUMBER("objects", subject->objects));
    json_add_plan(o, (double)plan->share / DUET_SHARE_ONE, duet_mode_name(plan->mode),
                  plan->variant_a, plan->variant_b);
    if (failure) {
        json_add(o, STRING("failed", failure->text));
    } else {
        json_add_hash(o, t->hash);
        json_add(o, NUMBER("pairs", t->last.pairs));
        add_times(o, t);
        json_add_cores(o, &t->cores);
    }
    return o;
}

// ---------------------------------------------------------------- reading

// samples_ms of a case; returns how many.
static uint32_t samples_of(const cJSON *one, double samples[BENCH_SAMPLES_MOST])
{
    uint32_t n = 0;
    const cJSON *item;
    cJSON_ArrayForEach(item, json_list(one, "samples_ms"))
    {
        if (n < BENCH_SAMPLES_MOST)
            samples[n++] = item->valuedouble;
    }
    return n;
}

static const json_field of_any[] = {
    {"scene", cJSON_IsString, "a string"},
    {"objects", JSON_COUNT},
    {"share", JSON_AMOUNT},
    {"mode", cJSON_IsString, "a string"},
    {"variant_a", cJSON_IsString, "a string"},
    {"variant_b", cJSON_IsString, "a string"},
    {0},
};
static const json_field of_measured[] = {
    {"hash", cJSON_IsString, "a string"},
    {"median_ms", JSON_AMOUNT},
    {"low_ms", JSON_AMOUNT},
    {"high_ms", JSON_AMOUNT},
    {"a_ms", JSON_AMOUNT},
    {"b_ms", JSON_AMOUNT},
    {"samples_ms", cJSON_IsArray, "a list"},
    {"stages", cJSON_IsArray, "a list"},
    {0},
};

static bool check_samples(const cJSON *one, const char *where, duet_error *err)
{
    const cJSON *samples = json_list(one, "samples_ms");
    int n = cJSON_GetArraySize(samples);
    bool ok = n > 0 && n <= BENCH_SAMPLES_MOST;
    const cJSON *item;
    cJSON_ArrayForEach(item, samples) ok = ok && json_is_amount(item) && item->valuedouble > 0;
    return ok || bad_input(err, "%s: 'samples_ms' is not 1 to %d times above 0", where,
                           BENCH_SAMPLES_MOST);
}

static bool check_case(const cJSON *one, const char *where, duet_error *err)
{
    if (!json_require(one, of_any, where, err))
        return false;
    return *json_string(one, "failed") ||
           (json_require(one, of_measured, where, err) && check_samples(one, where, err));
}

static bool check_cases(const cJSON *cases, const char *path, duet_error *err)
{
    int number = 0;
    const cJSON *one;
    cJSON_ArrayForEach(one, cases)
    {
        char where[512];
        snprintf(where, sizeof where, "%.400s: case %d", path, number++);
        if (!check_case(one, where, err))
            return false;
    }
    return true;
}

static bool check_parts(const cJSON *o, const char *path, duet_error *err)
{
    bool ok = true;
    const cJSON *one;
    cJSON_ArrayForEach(one, json_list(o, "accuracy")) ok =
        ok && level_costs_report_check(one, path, err);
    cJSON_ArrayForEach(one, json_list(o, "effects")) ok = ok && costs_report_check(one, path, err);
    return ok;
}

bool bench_check(const cJSON *o, const char *path, duet_error *err)
{
    if (strcmp(json_string(o, "type"), BENCH_TYPE) != 0)
        return bad_input(err, "%s: no results of 'duet bench --output'", path);
    if (json_number(o, "version") != VERSION)
        return bad_input(err, "%s: results of version %g; this Duet reads %d", path,
                         json_number(o, "version"), VERSION);
    const cJSON *cases = json_list(o, "cases");
    if (!cases || cJSON_GetArraySize(json_list(o, "devices")) != 2)
        return bad_input(err, "%s: 'cases' or the two 'devices' are missing", path);
    return check_cases(cases, path, err) && check_parts(o, path, err);
}

cJSON *bench_read(const char *path, duet_error *err)
{
    cJSON *o = json_read(path, err);
    if (o && bench_check(o, path, err))
        return o;
    cJSON_Delete(o);
    return NULL;
}

static bool is_same(const cJSON *a, const cJSON *b)
{
    static const char *const strings[] = {"scene", "mode", "variant_a", "variant_b"};
    for (size_t i = 0; i < sizeof strings / sizeof *strings; ++i)
        if (strcmp(json_string(a, strings[i]), json_string(b, strings[i])) != 0)
            return false;
    return json_number(a, "objects") == json_number(b, "objects") &&
           fabs(json_number(a, "share") - json_number(b, "share")) < 1e-9;
}

// The case that was measured on the same scene by the same plan, or NULL.
static const cJSON *find(const cJSON *results, const cJSON *like)
{
    const cJSON *one;
    cJSON_ArrayForEach(one, cJSON_GetObjectItemCaseSensitive(results, "cases"))
    {
        if (is_same(one, like) && !*json_string(one, "failed"))
            return one;
    }
    return NULL;
}

// ---------------------------------------------------------------- comparing

static const char *const fields[] = {"against_ms", "ratio", "ratio_low", "ratio_high", "verdict"};

// The least part of a time that the case would have taken on a machine of its
// own. Squared, for a step also waits for the slower of its threads.
static double least_of(const cJSON *one)
{
    double own = fmax(1 - json_number(one, "cpu_load"), 0.05);
    return own * own;
}

// A difference that other programs may have made is neither faster nor slower.
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
    uint32_t n_own = samples_of(one, own);
    uint32_t n_others = samples_of(before, others);
    race_gain gain = doubt(race_compare_apart(own, n_own, others, n_others, level), one, before);
    json_add(one, NUMBER(fields[0], json_number(before, "median_ms")),
             NUMBER(fields[1], gain.ratio), NUMBER(fields[2], gain.interval.low),
             NUMBER(fields[3], gain.interval.high),
             STRING(fields[4], race_verdict_name(gain.verdict)));
}

void bench_compare(cJSON *results, const cJSON *before)
{
    cJSON *one;
    cJSON_ArrayForEach(one, json_list(results, "cases"))
    {
        const cJSON *earlier = find(before, one);
        if (earlier && !*json_string(one, "failed") && !*json_string(one, "verdict"))
            compare_case(one, earlier);
    }
}

bool bench_first_slower(const cJSON *results, char name[BENCH_NAME], uint32_t *n)
{
    const cJSON *one;
    *n = 0;
    cJSON_ArrayForEach(one, json_list(results, "cases"))
    {
        if (strcmp(json_string(one, "verdict"), race_verdict_name(RACE_SLOWER)) != 0 || (*n)++ > 0)
            continue;
        snprintf(name, BENCH_NAME, "%.60s by '%.190s' and '%.190s', mode %.10s, share %.2f",
                 json_string(one, "scene"), json_string(one, "variant_a"),
                 json_string(one, "variant_b"), json_string(one, "mode"),
                 json_number(one, "share"));
    }
    return *n > 0;
}

// ---------------------------------------------------------------- as text

bool bench_tell(const cJSON *results, const char *scene, const cJSON *before, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("scene", scene), NUMBER("confidence", level));
    cJSON_AddItemReferenceToObject(o, "results", (cJSON *)results);
    if (before)
        cJSON_AddItemReferenceToObject(o, "before", (cJSON *)before);
    bool ok = rendering_tell(o, false, "cli/report/bench.lua", err);
    fflush(stdout);
    return ok;
}
