// SPDX-License-Identifier: MIT
// duet profiles show: a profile with the session it comes from and all its trials, or a run of a
// cluster. duet profiles diff: two profiles side by side, and which is the quicker.
#include "cli/commands/profiles.h"
#include "cli/report/profile_report.h"
#include "cli/report/rendering.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <string.h>

static bool show_text(cJSON *o, const profile_entry *e, duet_error *err)
{
    json_add(o, STRING("options_text", e->session.options), STRING("terms_text", e->row.terms));
    bool ok = rendering_print("cli/report/profile.lua", o, err);
    if (e->session.id && e->session.script) {
        printf("script\n");
        say_lines(e->session.script);
        printf("\n");
    }
    ok = ok && (!e->session.id || rendering_print("cli/report/trials.lua", o, err));
    cJSON_Delete(o);
    return ok;
}

static bool show_entry(void *context, const profile_entry *e)
{
    profile_showing *show = context;
    cJSON *o = profile_report_json(e);
    show->ok = profile_report_add_trials(o, show->s, e->session.id, show->err);
    profile_report_add_session(o, &e->session);
    if (show->ok)
        show->ok = show->json ? say_json(o, show->err) : show_text(o, e, show->err);
    else
        cJSON_Delete(o);
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
