// SPDX-License-Identifier: MIT
// duet profiles show: a profile with the session it comes from and all its trials, or a run of a
// cluster.
#include "cli/commands/profiles.h"
#include "cli/report/cluster_run_report.h"
#include "cli/report/profile_report.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <inttypes.h>
#include <string.h>

// The trials' kernels, each told once and numbered as it is met.
typedef struct trial_table {
    table rows;
    text kernels; // each ends with a NUL
    unsigned n_kernels;
} trial_table;

static unsigned kernels_number(trial_table *t, const char *variant)
{
    const char *known = text_chars(&t->kernels);
    for (unsigned i = 1; i <= t->n_kernels; ++i, known += strlen(known) + 1)
        if (strcmp(known, variant) == 0)
            return i;
    text_add_bytes(&t->kernels, variant, strlen(variant) + 1);
    return ++t->n_kernels;
}

static bool add_trial_row(void *context, int64_t number, const profile_trial *trial)
{
    trial_table *all = context;
    table *t = &all->rows;
    table_cell(t, "%" PRId64, number);
    table_cell(t, "%.4f", trial->plan.share / (double)PROFILE_SHARE_ONE);
    table_words(t, trial->plan.mode, NULL);
    table_cell(t, "%u", kernels_number(all, trial->plan.variant_a));
    table_cell(t, "%u", kernels_number(all, trial->plan.variant_b));
    table_cell(t, "%u", trial->n_samples);
    table_cell(t, "%.3f", trial->median_ns * 1e-6);
    table_cell(t, "%.3f", trial->low_ns * 1e-6);
    table_cell(t, "%.3f", trial->high_ns * 1e-6);
    table_cell(t, "%.3f", trial->a_ns * 1e-6);
    table_cell(t, "%.3f", trial->b_ns * 1e-6);
    table_cell(t, "%s%s%s", trial->outcome, trial->reason ? ": " : "",
               trial->reason ? trial->reason : "");
    return true;
}

static void print_kernels(const trial_table *t)
{
    table names = table_begin("rl");
    table_words(&names, "A, B", "kernels", NULL);
    const char *name = text_chars(&t->kernels);
    for (unsigned i = 1; i <= t->n_kernels; ++i, name += strlen(name) + 1) {
        table_cell(&names, "%u", i);
        table_words(&names, say_name(name).chars, NULL);
    }
    table_print(&names, stdout);
}

// Prints while the entry is there, since it is gone after the visit.
typedef struct showing {
    store *s;
    bool json;
    bool ok;
    duet_error *err;
} showing;

static bool show_json(showing *show, const profile_entry *e)
{
    cJSON *o = profile_report_json(e);
    bool ok = profile_report_add_trials(o, show->s, e->session.id, show->err);
    profile_report_add_session(o, &e->session);
    if (ok)
        return say_json(o, show->err);
    cJSON_Delete(o);
    return false;
}

static bool show_text(showing *show, const profile_entry *e)
{
    profile_report_text(e);
    if (!e->session.id)
        return true;
    trial_table t = {.rows = table_begin("rrlrrrrrrrrl")};
    table_words(&t.rows, "trial", "share", "mode", "A", "B", "runs", "ms", "low", "high", "A ms",
                "B ms", "outcome", NULL);
    bool ok = profile_trial_each(show->s, e->session.id, add_trial_row, &t, show->err);
    printf("\n");
    table_print(&t.rows, stdout);
    printf("\n");
    print_kernels(&t);
    text_free(&t.kernels);
    return ok;
}

static bool show_entry(void *context, const profile_entry *e)
{
    showing *show = context;
    show->ok = show->json ? show_json(show, e) : show_text(show, e);
    return false;
}

bool profiles_show(store *s, const char *uid, bool json, duet_error *err)
{
    char whole[PROFILE_ID];
    showing sh = {.s = s, .json = json, .err = err};
    if (!cluster_run_find(s, uid, whole, err))
        return false;
    if (*whole)
        return cluster_run_report_show(s, whole, json, err);
    return profile_find(s, uid, whole, err) &&
           profile_entry_each(s, whole, true, show_entry, &sh, err) && sh.ok;
}
