// SPDX-License-Identifier: MIT
// duet report: one page with everything that was measured, to be read in a
// browser, sent by mail or kept; it loads nothing.
#include "base/error.h"
#include "cli/commands.h"
#include "cli/commands/profiles.h"
#include "cli/costs.h"
#include "cli/options.h"
#include "cli/report/bench_results.h"
#include "cli/report/level_costs_report.h"
#include "cli/report/page.h"

#include <stdio.h>
#include <string.h>

enum { RESULTS_MOST = 64 };

static const char usual_page[] = "duet-report.html";

typedef struct arguments {
    const char *out; // NULL: the usual page, and a line that names it
    const char *store;
} arguments;

static const option options[] = {
    OPTION_OUTPUT("output", out, "FILE.html", "the page (duet-report.html)"),
    PROFILE_OPTION_ROW(store),
    {0},
};

static const command_line line = {
    .name = "report",
    .operands = "[RESULTS.json...]",
    .most_operands = RESULTS_MOST,
    .about = "Makes one HTML page of the profile store and of results of 'duet bench\n"
             "--output', the earliest first, 'duet accuracy --json' and 'duet explain\n"
             "--measure --json': profiles, searches, accuracy against time, what effects\n"
             "cost, stages, history.",
    .options = options,
};

// The contents of the files; later costs of a scene replace earlier ones.
typedef struct results {
    cJSON *files[RESULTS_MOST];
    cJSON *bench[RESULTS_MOST]; // the earliest first
    cJSON *levels[RESULTS_MOST];
    cJSON *effects[RESULTS_MOST];
    uint32_t n_files;
    uint32_t n_bench;
    uint32_t n_levels;
    uint32_t n_effects;
} results;

static bool is_same_subject(const cJSON *x, const cJSON *y)
{
    static const char *const names[] = {"scene", "a", "b"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (strcmp(json_string(x, names[i]), json_string(y, names[i])) != 0)
            return false;
    return json_number(x, "objects") == json_number(y, "objects");
}

static void keep_latest(cJSON **list, uint32_t *n, cJSON *one)
{
    uint32_t i = 0;
    while (i < *n && !is_same_subject(list[i], one))
        ++i;
    if (i == RESULTS_MOST)
        return;
    list[i] = one;
    *n += i == *n;
}

static void keep_bench(results *r, cJSON *o)
{
    cJSON *one;
    r->bench[r->n_bench++] = o;
    cJSON_ArrayForEach(one, json_list(o, "accuracy")) keep_latest(r->levels, &r->n_levels, one);
    cJSON_ArrayForEach(one, json_list(o, "effects")) keep_latest(r->effects, &r->n_effects, one);
}

static bool keep_file(results *r, cJSON *o, const char *path, duet_error *err)
{
    const char *type = json_string(o, "type");
    r->files[r->n_files++] = o;
    if (strcmp(type, LEVEL_COSTS_TYPE) == 0) {
        keep_latest(r->levels, &r->n_levels, o);
        return level_costs_report_check(o, path, err);
    }
    if (strcmp(type, COSTS_TYPE) == 0) {
        keep_latest(r->effects, &r->n_effects, o);
        return costs_report_check(o, path, err);
    }
    if (strcmp(type, BENCH_TYPE) != 0)
        return error_set(err, DUET_STATUS_BAD_INPUT,
                         "%s: no results of 'duet bench --output', 'duet accuracy --json' or 'duet "
                         "explain --measure --json'",
                         path);
    keep_bench(r, o);
    return bench_check(o, path, err);
}

static bool read_results(results *r, char **paths, duet_error *err)
{
    bool ok = true;
    for (; ok && *paths; ++paths) {
        cJSON *o = json_read(*paths, err);
        ok = o && keep_file(r, o, *paths, err);
    }
    return ok;
}

// A store that is not there is no failure if there are results to show.
static bool add_store(cJSON *shown, const char *path, bool needed, duet_error *err)
{
    duet_error failure = {0};
    store *s = profiles_open(path, STORE_READ, &failure);
    if (!s && failure.status == DUET_STATUS_NOT_FOUND && !path && !needed) {
        json_add(shown, STRING("no_store", "There is no profile store yet; duet tune makes one."));
        return true;
    }
    if (!s)
        return error_copy(err, &failure);
    bool ok = page_add_store(shown, s, err) && store_check_read(s, err);
    store_close(s);
    return ok;
}

static void add_list(cJSON *shown, const char *name, cJSON *const *list, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i)
        cJSON_AddItemReferenceToArray(cJSON_GetObjectItem(shown, name), list[i]);
}

static bool write_page(const arguments *args, const results *r, duet_error *err)
{
    cJSON *shown = page_begin();
    add_list(shown, "levels", r->levels, r->n_levels);
    add_list(shown, "effects", r->effects, r->n_effects);
    add_list(shown, "bench", r->bench, r->n_bench);
    const char *path = args->out ? args->out : usual_page;
    bool ok = add_store(shown, args->store, r->n_files == 0, err) && page_write(path, shown, err);
    if (ok && !args->out)
        printf("-> %s\n", path);
    cJSON_Delete(shown);
    return ok;
}

static bool run(void *args, char **paths, duet_error *err)
{
    results r = {.n_files = 0};
    bool ok = read_results(&r, paths, err) && write_page(args, &r, err);
    for (uint32_t i = 0; i < r.n_files; ++i)
        cJSON_Delete(r.files[i]);
    return ok;
}

SUBCOMMAND(report, 0)
