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

static bool check_file(const cJSON *o, const char *path, duet_error *err)
{
    const char *type = json_string(o, "type");
    if (strcmp(type, LEVEL_COSTS_TYPE) == 0)
        return level_costs_report_check(o, path, err);
    if (strcmp(type, COSTS_TYPE) == 0)
        return costs_report_check(o, path, err);
    if (strcmp(type, BENCH_TYPE) == 0)
        return bench_check(o, path, err);
    return bad_input(err,
                     "%s: no results of 'duet bench --output', 'duet accuracy --json' or 'duet "
                     "explain --measure --json'",
                     path);
}

static bool add_files(cJSON *files, char **paths, duet_error *err)
{
    bool ok = true;
    for (; ok && *paths; ++paths) {
        cJSON *o = json_read(*paths, err);
        ok = o && cJSON_AddItemToArray(files, o) && check_file(o, *paths, err);
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

static bool write_page(const arguments *args, const cJSON *shown, duet_error *err)
{
    const char *path = args->out ? args->out : usual_page;
    if (!page_write(path, shown, err))
        return false;
    if (!args->out)
        printf("-> %s\n", path);
    return true;
}

static bool run(void *given, char **paths, duet_error *err)
{
    const arguments *args = given;
    cJSON *files, *shown = page_begin(&files);
    bool ok = add_files(files, paths, err) &&
              add_store(shown, args->store, cJSON_GetArraySize(files) == 0, err) &&
              write_page(args, shown, err);
    cJSON_Delete(shown);
    return ok;
}

SUBCOMMAND(report, 0)
