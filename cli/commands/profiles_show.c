// SPDX-License-Identifier: MIT
// duet profiles show: a profile with the session it comes from and all its trials, or a run of a
// cluster. duet profiles diff: two profiles side by side, and which is the quicker.
#include "cli/commands/profiles.h"
#include "cli/report/pareto.h"
#include "cli/report/profile_report.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <inttypes.h>
#include <math.h>
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

static void add_ms(table *t, double ns)
{
    if (isnan(ns))
        table_words(t, "-", NULL);
    else
        table_cell(t, "%.3f", ns * 1e-6);
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
    add_ms(t, trial->median_ns);
    add_ms(t, trial->low_ns);
    add_ms(t, trial->high_ns);
    add_ms(t, trial->a_ns);
    add_ms(t, trial->b_ns);
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

static bool show_json(profile_showing *show, const profile_entry *e)
{
    cJSON *o = profile_report_json(e);
    bool ok = profile_report_add_trials(o, show->s, e->session.id, show->err);
    profile_report_add_session(o, &e->session);
    if (ok)
        return say_json(o, show->err);
    cJSON_Delete(o);
    return false;
}

static bool print_pareto(profile_showing *show, const profile_entry *e)
{
    cJSON *o = cJSON_CreateObject();
    bool ok = profile_report_add_trials(o, show->s, e->session.id, show->err);
    pareto_print(o);
    cJSON_Delete(o);
    return ok;
}

static bool show_text(profile_showing *show, const profile_entry *e)
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
    return ok && print_pareto(show, e);
}

static bool show_entry(void *context, const profile_entry *e)
{
    profile_showing *show = context;
    show->ok = show->json ? show_json(show, e) : show_text(show, e);
    return false;
}

bool profiles_show(store *s, const char *uid, bool json, duet_error *err)
{
    char whole[PROFILE_ID];
    profile_showing sh = {.s = s, .json = json, .err = err};
    return profile_find(s, uid, whole, err) &&
           profile_entry_each(s, whole, true, show_entry, &sh, err) && sh.ok;
}

// ------------------------------------------------------------------- two of them

static bool keep_json(void *context, const profile_entry *e)
{
    cJSON *o = profile_report_json(e);
    if (e->session.strategy)
        json_add(o, STRING("strategy", e->session.strategy));
    if (e->session.options)
        json_add_object(o, "options", e->session.options);
    *(cJSON **)context = o;
    return false;
}

static cJSON *read_entry(store *s, const char *uid, duet_error *err)
{
    char whole[PROFILE_ID];
    cJSON *o = NULL;
    if (profile_find(s, uid, whole, err))
        profile_entry_each(s, whole, true, keep_json, &o, err);
    return o;
}

// By how much a step of one profile is longer, and whether the intervals of both medians leave no
// doubt of it.
static double longer(const cJSON *one, const cJSON *other, bool *sure)
{
    *sure = json_number(one, "low_ms") > json_number(other, "high_ms");
    return json_number(one, "ms") / json_number(other, "ms") - 1;
}

static void add_field(table *t, const char *name, const cJSON *one, const cJSON *other)
{
    const cJSON *const both[] = {one, other};
    table_words(t, name, NULL);
    for (int i = 0; i < 2; ++i) {
        char *chars = both[i] ? cJSON_PrintUnformatted(both[i]) : NULL;
        if (cJSON_IsString(both[i]))
            table_words(t, say_name(both[i]->valuestring).chars, NULL);
        else if (cJSON_IsNumber(both[i]))
            table_cell(t, "%.6g", both[i]->valuedouble);
        else if (cJSON_IsNull(both[i]))
            table_words(t, "-", NULL);
        else
            table_words(t, chars ? say_name(chars).chars : "-", NULL);
        cJSON_free(chars);
    }
    table_words(t, cJSON_Compare(one, other, true) ? "" : "*", NULL);
}

static void print_both(const cJSON *one, const cJSON *other)
{
    static const char *const fields[] = {
        "uid",        "live",   "dead_reason", "scene",    "objects",    "a",
        "b",          "level",  "share",       "mode",     "variant_a",  "variant_b",
        "ms",         "low_ms", "high_ms",     "gain",     "gain_low",   "gain_high",
        "verdict",    "rounds", "single_ms",   "whole_ms", "whole_gain", "missed_rate",
        "false_rate", "origin", "strategy",    "options",  "kernels",    "created"};
    table t = table_begin("lllr");
    for (size_t i = 0; i < sizeof fields / sizeof *fields; ++i) {
        const cJSON *a = cJSON_GetObjectItemCaseSensitive(one, fields[i]);
        const cJSON *b = cJSON_GetObjectItemCaseSensitive(other, fields[i]);
        if (a || b)
            add_field(&t, fields[i], a, b);
    }
    table_print(&t, stdout);
    if (strcmp(json_string(one, "family"), json_string(other, "family")) != 0 ||
        json_number(one, "objects") != json_number(other, "objects")) {
        printf("\nTheir workloads differ, so their times say nothing of each other.\n");
        return;
    }
    bool sure;
    bool first_is_longer = json_number(one, "ms") > json_number(other, "ms");
    const cJSON *slow = first_is_longer ? one : other, *quick = first_is_longer ? other : one;
    double by = longer(slow, quick, &sure);
    printf("\nA step of %.8s takes %.1f %% longer than one of %.8s%s.\n", json_string(slow, "uid"),
           100 * by, json_string(quick, "uid"),
           sure ? "" : ", which is within the intervals of both");
}

bool profiles_diff(store *s, const char *first, const char *second, bool json, duet_error *err)
{
    cJSON *o = cJSON_CreateObject();
    cJSON *one = read_entry(s, first, err);
    cJSON *other = one ? read_entry(s, second, err) : NULL;
    cJSON_AddItemToObject(o, "first", one);
    cJSON_AddItemToObject(o, "second", other);
    if (other && json)
        return say_json(o, err);
    if (other)
        print_both(one, other);
    cJSON_Delete(o);
    return other;
}
