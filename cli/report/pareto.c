// SPDX-License-Identifier: MIT
#include "cli/report/pareto.h"

#include "cli/report/json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A plan with the sums over its trials.
typedef struct measured {
    const cJSON *trial; // one of them, for the plan's words
    double ms;
    double joules;
    uint32_t n;
} measured;

static bool same_plan(const cJSON *a, const cJSON *b)
{
    static const char *const names[] = {"mode", "variant_a", "variant_b"};
    bool same = json_number(a, "share") == json_number(b, "share");
    for (int i = 0; i < 3; ++i)
        same = same && strcmp(json_string(a, names[i]), json_string(b, names[i])) == 0;
    return same;
}

static double joules_of(const cJSON *trial)
{
    return json_number(cJSON_GetObjectItemCaseSensitive(trial, "terms"), "joules");
}

static uint32_t gather(const cJSON *trials, measured *plans)
{
    uint32_t n = 0, at;
    const cJSON *trial;
    cJSON_ArrayForEach(trial, trials)
    {
        if (!(joules_of(trial) > 0))
            continue;
        for (at = 0; at < n && !same_plan(plans[at].trial, trial);)
            ++at;
        n += at == n;
        plans[at].trial = trial;
        plans[at].ms += json_number(trial, "ms");
        plans[at].joules += joules_of(trial);
        ++plans[at].n;
    }
    for (uint32_t i = 0; i < n; ++i) {
        plans[i].ms /= plans[i].n;
        plans[i].joules /= plans[i].n;
    }
    return n;
}

static int by_time(const void *a, const void *b)
{
    const measured *x = a, *y = b;
    double differ = x->ms != y->ms ? x->ms - y->ms : x->joules - y->joules;
    return (differ > 0) - (differ < 0);
}

// In the order of their time, a plan is on the front if it takes less energy than all before it.
static void add_front(cJSON *front, measured *plans, uint32_t n)
{
    double least = INFINITY;
    qsort(plans, n, sizeof *plans, by_time);
    for (uint32_t i = 0; i < n; ++i) {
        if (plans[i].joules >= least)
            continue;
        least = plans[i].joules;
        cJSON *row = json_add_row(front);
        json_add_plan(row, json_number(plans[i].trial, "share"),
                      json_string(plans[i].trial, "mode"), json_string(plans[i].trial, "variant_a"),
                      json_string(plans[i].trial, "variant_b"));
        json_add(row, NUMBER("ms", plans[i].ms), NUMBER("joules", plans[i].joules));
    }
}

void pareto_add(cJSON *o)
{
    const cJSON *trials = json_list(o, "trials");
    measured *plans = calloc((size_t)cJSON_GetArraySize(trials) + 1, sizeof *plans);
    uint32_t n = plans ? gather(trials, plans) : 0;
    if (n > 0)
        add_front(cJSON_AddArrayToObject(o, "pareto"), plans, n);
    free(plans);
}
