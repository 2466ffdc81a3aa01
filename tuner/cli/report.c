// SPDX-License-Identifier: MIT
// duet report: one page with everything that was measured, to be read in a
// browser, sent by mail or kept; it loads nothing.
#include "tuner/cli/report.h"

#include "runtime/base/error.h"
#include "tuner/cli/commands.h"
#include "tuner/cli/options.h"
#include "tuner/cli/page.h"
#include "tuner/cli/profiles.h"
#include "tuner/cli/say.h"

#include <stdio.h>
#include <time.h>

enum { RESULTS_MOST = 64 };

typedef struct arguments {
    const char *out;
    const char *store;
} arguments;

static const option options[] = {
    OPTION_TEXT("o", out, "FILE.html", "the page (duet-report.html)"),
    PROFILE_OPTION_ROW(store),
    {0},
};

static const command_line line = {
    .name = "report",
    .operands = "[RESULTS.json...]",
    .most_operands = RESULTS_MOST,
    .about = "Makes one HTML page of the profile store and of results that 'duet bench --out'\n"
             "kept, the earliest first: profiles, searches, stages, history.",
    .options = options,
};

static bool read_results(cJSON **results, char **paths, int n, duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && i < n; ++i) {
        results[i] = bench_read(paths[i], err);
        ok = results[i] != NULL;
    }
    return ok;
}

// A store that is not there is no failure where there are results to show.
static bool add_store(text *page, const char *path, bool needed, duet_error *err)
{
    duet_error failure = {0};
    store *s = profiles_open(path, STORE_READ, &failure);
    if (!s && failure.status == DUET_NOT_FOUND && !path && !needed) {
        page_paragraph(page, "There is no profile store yet; duet tune makes one.");
        return true;
    }
    if (!s)
        return error_set(err, failure.status, "%s", failure.text);
    bool ok = report_store(page, s, err);
    store_close(s);
    return ok;
}

static bool write_page(const arguments *args, cJSON *const *results, uint32_t n, duet_error *err)
{
    char when[40];
    text page = {0};
    time_t now = time(NULL);
    strftime(when, sizeof when, "%Y-%m-%d %H:%M UTC", gmtime(&now));
    page_begin(&page, "Duet: what was measured");
    page_paragraph(&page, "Made %s by Duet %s.", when, duet_version());
    bool ok = add_store(&page, args->store, n == 0, err);
    if (n > 0)
        report_bench(&page, results, n);
    page_end(&page);
    ok = ok && text_ok(&page, err);
    ok = ok && text_write_file(args->out, text_chars(&page), page.length, err);
    text_free(&page);
    return ok;
}

static bool report(const arguments *args, char **paths, int n, duet_error *err)
{
    cJSON *results[RESULTS_MOST] = {NULL};
    bool ok = read_results(results, paths, n, err);
    ok = ok && write_page(args, results, (uint32_t)n, err);
    for (int i = 0; i < n; ++i)
        cJSON_Delete(results[i]);
    return ok;
}

int command_report(int argc, char **argv)
{
    arguments args = {.out = "duet-report.html"};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    duet_error err = {0};
    return report(&args, operands, n_operands, &err) ? EXIT_OK : say_failed(&err);
}
