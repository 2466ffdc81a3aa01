// SPDX-License-Identifier: MIT
// duet profiles: looks into the profile store, and moves rows in and out.
#define _POSIX_C_SOURCE 200809L
#include "cli/commands/profiles.h"

#include "base/clock.h"
#include "base/error.h"
#include "cli/commands.h"
#include "cli/options.h"
#include "cli/report/json.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "profiles/exchange.h"
#include "profiles/profile.h"
#include "profiles/upkeep.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <inttypes.h>
#include <string.h>
#include <time.h>

typedef struct verb verb;

typedef struct arguments {
    const verb *verb;
    const char *store;
    uint64_t samples;
    uint64_t days;
    bool dead;
    bool json;
} arguments;

store *profiles_open(const char *path, store_access access, duet_error *err)
{
    text user = {0};
    bool ok = path || store_user_path(&user, err);
    store *s = ok ? store_open(path ? path : text_chars(&user), access, err) : NULL;
    text_free(&user);
    if (s && store_note(s))
        fprintf(stderr, "duet: %s\n", say_name(store_note(s)).chars);
    return s;
}

profiles_date profiles_when(int64_t calendar_ns)
{
    profiles_date date = {""};
    time_t seconds = (time_t)(calendar_ns / 1000000000);
    struct tm parts;
    if (calendar_ns > 0 && gmtime_r(&seconds, &parts))
        strftime(date.chars, sizeof date.chars, "%Y-%m-%d %H:%M", &parts);
    return date;
}

enum { UID_SHOWN = 8 }; // digits that tell profiles of one store apart

static const char *or_none(const char *chars)
{
    return chars && *chars ? chars : "-";
}

static bool is_here(const profile_entry *e)
{
    char host[PROFILE_SHA];
    profile_host(host);
    return e->session.host && strcmp(e->session.host, host) == 0;
}

// --------------------------------------------------------------------------- JSON

static void add_device(cJSON *o, const char *name, const profile_entry_device *d)
{
    cJSON *device = cJSON_AddObjectToObject(o, name);
    cJSON_AddStringToObject(device, "name", d->name);
    cJSON_AddStringToObject(device, "part", d->part ? d->part : "");
    cJSON_AddStringToObject(device, "driver", d->driver);
    cJSON_AddStringToObject(device, "platform_version", d->platform_version);
}

static void add_plan(cJSON *o, const profile_plan *plan)
{
    json_add_plan(o, plan->share / (double)PROFILE_SHARE_ONE, plan->mode, plan->variant_a,
                  plan->variant_b);
    cJSON_AddStringToObject(o, "level", plan->level);
}

cJSON *profiles_entry_json(const profile_entry *e)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "uid", e->uid);
    cJSON_AddBoolToObject(o, "live", !e->dead_reason);
    if (e->dead_reason)
        cJSON_AddStringToObject(o, "dead_reason", e->dead_reason);
    cJSON_AddStringToObject(o, "scene", e->scene ? e->scene : "");
    cJSON_AddStringToObject(o, "family", e->family);
    cJSON_AddNumberToObject(o, "dims", (double)e->dims);
    cJSON_AddNumberToObject(o, "objects", (double)e->n);
    add_device(o, "a", &e->a);
    add_device(o, "b", &e->b);
    add_plan(o, &e->row.plan);
    cJSON_AddNumberToObject(o, "ms", e->row.median_ns * 1e-6);
    cJSON_AddNumberToObject(o, "low_ms", e->row.low_ns * 1e-6);
    cJSON_AddNumberToObject(o, "high_ms", e->row.high_ns * 1e-6);
    cJSON_AddNumberToObject(o, "gain", e->row.gain);
    cJSON_AddNumberToObject(o, "gain_low", e->row.gain_low);
    cJSON_AddNumberToObject(o, "gain_high", e->row.gain_high);
    cJSON_AddStringToObject(o, "verdict", e->row.verdict);
    cJSON_AddNumberToObject(o, "rounds", e->row.rounds);
    cJSON_AddNumberToObject(o, "single_ms", e->row.single_ns * 1e-6);
    if (e->row.whole_ns > 0) {
        cJSON_AddNumberToObject(o, "whole_ms", e->row.whole_ns * 1e-6);
        cJSON_AddNumberToObject(o, "whole_gain", e->row.whole_gain);
        cJSON_AddNumberToObject(o, "whole_gain_low", e->row.whole_gain_low);
        cJSON_AddNumberToObject(o, "whole_gain_high", e->row.whole_gain_high);
    }
    if (e->row.true_pairs >= 0) {
        cJSON_AddNumberToObject(o, "missed_rate", e->row.missed_rate);
        cJSON_AddNumberToObject(o, "false_rate", e->row.false_rate);
        cJSON_AddNumberToObject(o, "true_pairs", (double)e->row.true_pairs);
    }
    if (e->row.terms)
        json_add_object(o, "terms", e->row.terms);
    cJSON_AddStringToObject(o, "objective", e->row.objective);
    cJSON_AddStringToObject(o, "origin", e->row.origin);
    cJSON_AddStringToObject(o, "kernels", e->row.kernels);
    cJSON_AddStringToObject(o, "created", profiles_when(e->created_ns).chars);
    cJSON_AddBoolToObject(o, "here", is_here(e));
    return o;
}

static void add_session(cJSON *o, const profile_entry_session *s)
{
    if (!s->id)
        return;
    cJSON *session = cJSON_AddObjectToObject(o, "session");
    cJSON_AddStringToObject(session, "id", s->id);
    cJSON_AddStringToObject(session, "state", s->state);
    cJSON_AddStringToObject(session, "strategy", s->strategy);
    json_add_object(session, "options", s->options);
    if (s->script)
        cJSON_AddStringToObject(session, "script", s->script);
    cJSON_AddStringToObject(session, "tool_version", s->tool_version);
    cJSON_AddStringToObject(session, "host", s->host);
    cJSON_AddNumberToObject(session, "seed", (double)s->seed);
    cJSON_AddNumberToObject(session, "resumed", (double)s->resumed);
    cJSON_AddNumberToObject(session, "launches", (double)s->launches);
    cJSON_AddNumberToObject(session, "load", s->load);
    cJSON_AddNumberToObject(session, "timer_ns", s->timer_ns);
    cJSON_AddStringToObject(session, "started", profiles_when(s->started_ns).chars);
    cJSON_AddStringToObject(session, "ended", profiles_when(s->ended_ns).chars);
}

static bool add_trial(void *context, int64_t number, const profile_trial *trial)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "number", (double)number);
    add_plan(o, &trial->plan);
    cJSON_AddStringToObject(o, "outcome", trial->outcome);
    if (trial->reason)
        cJSON_AddStringToObject(o, "reason", trial->reason);
    cJSON_AddNumberToObject(o, "samples", trial->n_samples);
    cJSON_AddNumberToObject(o, "outliers", trial->outliers);
    cJSON_AddNumberToObject(o, "ms", trial->median_ns * 1e-6);
    cJSON_AddNumberToObject(o, "low_ms", trial->low_ns * 1e-6);
    cJSON_AddNumberToObject(o, "high_ms", trial->high_ns * 1e-6);
    cJSON_AddNumberToObject(o, "a_ms", trial->a_ns * 1e-6);
    cJSON_AddNumberToObject(o, "b_ms", trial->b_ns * 1e-6);
    if (trial->terms)
        json_add_object(o, "terms", trial->terms);
    return cJSON_AddItemToArray(context, o);
}

bool profiles_add_trials(cJSON *o, store *s, const char *session, duet_error *err)
{
    cJSON *trials = cJSON_AddArrayToObject(o, "trials");
    return !session || profile_trial_each(s, session, add_trial, trials, err);
}

// --------------------------------------------------------------------------- list

static const option list_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_FLAG("dead", dead, "those that are not used, too, with the reason"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line list_line = {
    .name = "profiles list",
    .operands = "",
    .about = "Lists the profiles of the store by device pair and size.",
    .options = list_options,
};

// Rows are gathered while the pair stays the same.
typedef struct listing {
    table rows;
    text notes;
    uint64_t n;
    int64_t pair_id;
    bool dead;
    cJSON *json; // an array; NULL: prints
} listing;

static void print_device(const char *label, const profile_entry_device *d)
{
    printf("%s%s%s%s%s, driver %s\n", label, say_name(d->name).chars, d->part ? " [" : "",
           say_name(d->part).chars, d->part ? "]" : "", say_name(d->driver).chars);
}

static table begin_rows(void)
{
    table t = table_begin("llrlrlllrrlll");
    table_words(&t, "profile", "scene", "objects", "level", "share", "mode", "A", "B", "ms",
                "gain %", "verdict", "when", "where", NULL);
    return t;
}

static void add_row(table *t, const profile_entry *e)
{
    const profile_row *row = &e->row;
    const char *where = is_here(e) ? "here" : "elsewhere";
    table_cell(t, "%.*s", UID_SHOWN, e->uid);
    table_words(t, or_none(e->scene), table_count((uint64_t)e->n).chars, row->plan.level, NULL);
    table_cell(t, "%.4f", row->plan.share / (double)PROFILE_SHARE_ONE);
    table_words(t, row->plan.mode, row->plan.variant_a, row->plan.variant_b, NULL);
    table_cell(t, "%.3f", row->median_ns * 1e-6);
    if (row->plan.share > 0 && row->plan.share < PROFILE_SHARE_ONE)
        table_cell(t, "%+.1f", 100 * row->gain);
    else
        table_words(t, "-", NULL);
    table_words(t,
                row->plan.share == 0                   ? "B alone"
                : row->plan.share == PROFILE_SHARE_ONE ? "A alone"
                                                       : row->verdict,
                profiles_when(e->created_ns).chars, e->dead_reason ? e->dead_reason : where, NULL);
}

// Below the table, since it is said of few rows.
static void note_whole(text *notes, const profile_entry *e)
{
    const profile_row *row = &e->row;
    if (row->whole_ns > 0 && row->whole_gain_high < 0)
        text_add(notes, "%.*s: %s\n", UID_SHOWN, e->uid,
                 table_whole(e->a.name, row->whole_gain, row->whole_gain_low, row->whole_gain_high)
                     .chars);
}

static void print_rows(listing *l)
{
    table_print(&l->rows, stdout);
    say_lines(text_chars(&l->notes));
    text_free(&l->notes);
}

static bool list_entry(void *context, const profile_entry *e)
{
    listing *l = context;
    ++l->n;
    if (l->json)
        return cJSON_AddItemToArray(l->json, profiles_entry_json(e));
    bool dead = e->dead_reason != NULL;
    if (l->n == 1 || e->row.pair_id != l->pair_id || dead != l->dead) {
        if (l->n > 1) {
            print_rows(l);
            printf("\n");
        }
        if (dead && (l->n == 1 || !l->dead))
            printf("not used:\n");
        print_device("A: ", &e->a);
        print_device("B: ", &e->b);
        l->rows = begin_rows();
    }
    add_row(&l->rows, e);
    note_whole(&l->notes, e);
    l->pair_id = e->row.pair_id;
    l->dead = dead;
    return true;
}

static bool list(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)operands;
    cJSON *o = args->json ? cJSON_CreateObject() : NULL;
    listing l = {.json = o ? cJSON_AddArrayToObject(o, "profiles") : NULL};
    if (o)
        cJSON_AddStringToObject(o, "store", store_path(s));
    bool ok = profile_entry_each(s, NULL, args->dead, list_entry, &l, err);
    if (!o && l.n > 0)
        print_rows(&l);
    else if (!o && ok)
        printf("%s: no profiles yet; duet tune makes them\n", say_name(store_path(s)).chars);
    if (ok && o)
        return say_json(o, err);
    cJSON_Delete(o);
    return ok;
}

// --------------------------------------------------------------------------- show

static const option show_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line show_line = {
    .name = "profiles show",
    .operands = "PROFILE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Shows a profile, named by the first digits that 'duet profiles list' prints, with\n"
             "the session it comes from and all its trials.",
    .options = show_options,
};

static bool add_trial_row(void *context, int64_t number, const profile_trial *trial)
{
    table *t = context;
    table_cell(t, "%" PRId64, number);
    table_cell(t, "%.4f", trial->plan.share / (double)PROFILE_SHARE_ONE);
    table_words(t, trial->plan.mode, trial->plan.variant_a, trial->plan.variant_b, NULL);
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

static void print_lines(const char *label, const char *lines)
{
    printf("%s", label);
    say_lines(lines);
    printf("\n");
}

static void print_session(const profile_entry *e)
{
    const profile_entry_session *s = &e->session;
    if (!s->id) {
        printf("session   none: put in by hand\n");
        return;
    }
    printf("session   %s, %s, duet %s on %s machine, load %.2f, clock of %.0f ns\n",
           say_name(s->id).chars, say_name(s->state).chars, say_name(s->tool_version).chars,
           is_here(e) ? "this" : "another", s->load, s->timer_ns);
    printf("search    %s, seed %" PRId64 ", %" PRId64 " trials, %" PRId64
           " launches, resumed %" PRId64 " times\n",
           say_name(s->strategy).chars, s->seed, s->trials, s->launches, s->resumed);
    print_lines("options   ", s->options);
    printf("when      %s to %s UTC\n", profiles_when(s->started_ns).chars,
           or_none(profiles_when(s->ended_ns).chars));
    if (s->script)
        print_lines("script\n", s->script);
}

static void print_entry(const profile_entry *e)
{
    const profile_row *row = &e->row;
    printf("profile   %s%s%s\n", say_name(e->uid).chars, e->dead_reason ? ", dead: " : "",
           say_name(e->dead_reason).chars);
    print_device("A         ", &e->a);
    print_device("B         ", &e->b);
    printf("workload  %s, %s objects: %s\n", say_name(or_none(e->scene)).chars,
           table_count((uint64_t)e->n).chars, say_name(e->family).chars);
    printf("plan      share %.5f (%u of %d), mode %s, A %s, B %s, level %s\n",
           row->plan.share / (double)PROFILE_SHARE_ONE, row->plan.share, PROFILE_SHARE_ONE,
           say_name(row->plan.mode).chars, say_name(row->plan.variant_a).chars,
           say_name(row->plan.variant_b).chars, say_name(row->plan.level).chars);
    printf("step      %.4f ms (%.4f to %.4f)\n", row->median_ns * 1e-6, row->low_ns * 1e-6,
           row->high_ns * 1e-6);
    table_text gain =
        table_gain(row->plan.share, row->gain, row->gain_low, row->gain_high, row->verdict);
    printf("gain      %s\n", say_name(gain.chars).chars);
    if (row->rounds > 0)
        printf("rounds    %u\n", row->rounds);
    if (row->whole_ns > 0)
        printf("whole     %.4f ms; %s\n", row->whole_ns * 1e-6,
               say_name(table_whole(e->a.name, row->whole_gain, row->whole_gain_low,
                                    row->whole_gain_high)
                            .chars)
                   .chars);
    if (row->true_pairs < 0)
        printf("accuracy  was not measured\n");
    else
        printf("accuracy  by %s true pairs %g are missed, %g invented\n",
               table_count((uint64_t)row->true_pairs).chars, row->missed_rate, row->false_rate);
    if (row->terms)
        print_lines("terms     ", row->terms);
    printf("kernels   %s\n", say_name(row->kernels).chars);
    print_session(e);
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
    cJSON *o = profiles_entry_json(e);
    bool ok = profiles_add_trials(o, show->s, e->session.id, show->err);
    add_session(o, &e->session);
    if (ok)
        return say_json(o, show->err);
    cJSON_Delete(o);
    return false;
}

static bool show_text(showing *show, const profile_entry *e)
{
    print_entry(e);
    if (!e->session.id)
        return true;
    table t = table_begin("rrlllrrrrrrl");
    table_words(&t, "trial", "share", "mode", "A", "B", "samples", "ms", "low", "high", "A ms",
                "B ms", "outcome", NULL);
    bool ok = profile_trial_each(show->s, e->session.id, add_trial_row, &t, show->err);
    table_print(&t, stdout);
    return ok;
}

static bool show_entry(void *context, const profile_entry *e)
{
    showing *show = context;
    show->ok = show->json ? show_json(show, e) : show_text(show, e);
    return false;
}

static bool show(store *s, const arguments *args, char **operands, duet_error *err)
{
    char uid[PROFILE_ID];
    showing sh = {.s = s, .json = args->json, .err = err};
    return profile_find(s, operands[0], uid, err) &&
           profile_entry_each(s, uid, true, show_entry, &sh, err) && sh.ok;
}

// --------------------------------------------------------------------------- diff

static const command_line diff_line = {
    .name = "profiles diff",
    .operands = "PROFILE PROFILE",
    .least_operands = 2,
    .most_operands = 2,
    .about = "Shows two profiles side by side, and which of them is the quicker.",
    .options = show_options,
};

static bool diff(store *s, const arguments *args, char **operands, duet_error *err)
{
    return profiles_diff(s, operands[0], operands[1], args->json, err);
}

// --------------------------------------------------------------------- use, forget

static const option uid_options[] = {
    PROFILE_OPTION_ROW(store),
    {0},
};

static const command_line use_line = {
    .name = "profiles use",
    .operands = "PROFILE",
    .least_operands = 1,
    .most_operands = 1,
    .about =
        "Makes a stored profile the one that applications load in its place, as it was before\n"
        "another replaced it. 'duet profiles list --dead' shows those that are not used.",
    .options = uid_options,
};

static const command_line forget_line = {
    .name = "profiles forget",
    .operands = "PROFILE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Removes a profile. What was measured for it stays, and no other takes its place.",
    .options = uid_options,
};

static bool use(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)args;
    return profile_use(s, operands[0], err);
}

static bool forget(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)args;
    return profile_forget(s, operands[0], err);
}

// ------------------------------------------------------------------------- export

static const option export_options[] = {PROFILE_OPTION_ROW(store), {0}};

static const command_line export_line = {
    .name = "profiles export",
    .operands = "[FILE]",
    .most_operands = 1,
    .about = "Writes the whole store as JSON lines, to FILE or to stdout.",
    .options = export_options,
};

static bool export_rows(store *s, const arguments *args, char **operands, duet_error *err)
{
    const char *path = operands[0];
    (void)args;
    return path ? profile_export_file(s, path, err) : profile_export(s, stdout, "stdout", err);
}

// ------------------------------------------------------------------ import, merge

static const option import_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line import_line = {
    .name = "profiles import",
    .operands = "FILE|-",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Takes in the rows of an export: all of them or, where a line is wrong, none.",
    .options = import_options,
};

static const command_line merge_line = {
    .name = "profiles merge",
    .operands = "OTHER.db",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Takes in the rows of another store, which is only read. Every row stays with its\n"
             "own devices and machine; the store's own profiles stay live.",
    .options = import_options,
};

static bool tell_counts(const arguments *args, const profile_import_counts *counts, duet_error *err)
{
    if (!args->json) {
        printf("%s rows added, %s known already\n", table_count(counts->added).chars,
               table_count(counts->known).chars);
        return true;
    }
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "added", (double)counts->added);
    cJSON_AddNumberToObject(o, "known", (double)counts->known);
    return say_json(o, err);
}

static bool import_rows(store *s, const arguments *args, char **operands, duet_error *err)
{
    const char *path = operands[0];
    bool is_stdin = strcmp(path, "-") == 0;
    FILE *in = is_stdin ? stdin : fopen(path, "r");
    if (!in)
        return error_set(err, errno == ENOENT ? DUET_STATUS_NOT_FOUND : DUET_STATUS_IO_FAILED,
                         "%s: %s", path, strerror(errno));
    profile_import_counts counts;
    bool ok = profile_import(s, in, is_stdin ? "stdin" : path, &counts, err);
    if (!is_stdin)
        fclose(in);
    return ok && tell_counts(args, &counts, err);
}

static bool merge_rows(store *s, const arguments *args, char **operands, duet_error *err)
{
    profile_import_counts counts;
    return profile_merge(s, operands[0], &counts, err) && tell_counts(args, &counts, err);
}

// -------------------------------------------------------------------------- prune

static const option prune_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_COUNT("samples", samples, "K", "launches of each trial to keep (16)", 0, UINT32_MAX),
    OPTION_COUNT("older", days, "DAYS", "only what is older than that (0: all)", 0, 36500),
    OPTION_FLAG("dead", dead, "forget profiles that were replaced, too"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line prune_line = {
    .name = "profiles prune",
    .operands = "",
    .about = "Thins the single launches of finished trials, whose medians and intervals stay.",
    .options = prune_options,
};

static bool prune(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)operands;
    const int64_t day_ns = 86400000000000;
    profile_prune_counts counts;
    profile_prune_def def = {
        .keep_samples = (uint32_t)args->samples,
        .before_ns = args->days ? clock_calendar_ns() - (int64_t)args->days * day_ns : INT64_MAX,
        .drop_dead = args->dead,
    };
    if (!profile_prune(s, &def, &counts, err))
        return false;
    if (!args->json) {
        printf("%s launches and %s profiles forgotten, the file is %s smaller\n",
               table_count(counts.samples).chars, table_count(counts.profiles).chars,
               table_bytes(counts.bytes > 0 ? (uint64_t)counts.bytes : 0).chars);
        return true;
    }
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "samples", (double)counts.samples);
    cJSON_AddNumberToObject(o, "profiles", (double)counts.profiles);
    cJSON_AddNumberToObject(o, "bytes", (double)counts.bytes);
    return say_json(o, err);
}

// -------------------------------------------------------------------------- check

static const command_line check_line = {
    .name = "profiles check",
    .operands = "",
    .about = "Whether the file is whole and its rows are what their keys say.",
    .options = import_options,
};

static bool print_report(const arguments *args, const char *report, duet_error *err)
{
    if (!args->json) {
        say_lines(*report ? report : "sound\n");
        return true;
    }
    cJSON *o = cJSON_CreateObject();
    cJSON *problems = cJSON_AddArrayToObject(o, "problems");
    for (const char *at = report; *at; at += strcspn(at, "\n") + 1) {
        char problem[512];
        snprintf(problem, sizeof problem, "%.*s", (int)strcspn(at, "\n"), at);
        cJSON_AddItemToArray(problems, cJSON_CreateString(problem));
    }
    return say_json(o, err);
}

static bool check(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)operands;
    text report = {0};
    uint32_t problems = 0;
    bool ok =
        profile_check(s, &report, &problems, err) && print_report(args, text_chars(&report), err);
    if (ok && problems > 0)
        ok = error_set(err, DUET_STATUS_STORE_FAILED,
                       "%s: %" PRIu32 " rows are not sound; bring back a copy, or export what is "
                       "left and import it into a fresh file",
                       store_path(s), problems);
    text_free(&report);
    return ok;
}

// --------------------------------------------------------------------- the verbs

struct verb {
    const char *name;
    const char *about; // in the list of verbs
    const command_line *line;
    store_access access;
    bool (*run)(store *s, const arguments *args, char **operands, duet_error *err);
};

static const verb verbs[] = {
    {"list", "the profiles there are", &list_line, STORE_READ, list},
    {"show", "one of them, with its trials and where it comes from", &show_line, STORE_READ, show},
    {"diff", "two of them, side by side", &diff_line, STORE_READ, diff},
    {"use", "makes one the profile that applications load", &use_line, STORE_WRITE, use},
    {"forget", "removes one", &forget_line, STORE_WRITE, forget},
    {"why", "which profile a scene would get here, and on which grounds", NULL, STORE_READ, NULL},
    {"export", "the store as JSON lines", &export_line, STORE_READ, export_rows},
    {"import", "takes such lines in", &import_line, STORE_WRITE, import_rows},
    {"merge", "takes the rows of another store in", &merge_line, STORE_WRITE, merge_rows},
    {"prune", "thins the single launches", &prune_line, STORE_WRITE, prune},
    {"check", "whether the store is sound", &check_line, STORE_READ, check},
};

enum { N_VERBS = sizeof verbs / sizeof verbs[0] };

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    store *s = profiles_open(args->store, args->verb->access, err);
    bool ok = s && args->verb->run(s, args, operands, err) && store_check_read(s, err);
    store_close(s);
    return ok;
}

static void print_verbs(void)
{
    printf("duet profiles VERB [arguments]\nWhat was measured, and what applications load.\n\n");
    for (int i = 0; i < N_VERBS; ++i)
        printf("  %-18s %s\n", verbs[i].name, verbs[i].about);
    printf("\n'duet profiles VERB --help' lists its options.\n");
}

static int refuse_verb(const char *name)
{
    text known = {0};
    for (int i = 0; i < N_VERBS; ++i)
        text_add(&known, "%s%s", i ? ", " : "", verbs[i].name);
    int exit_code =
        say_wrong("profiles", "%s%s%s: give one of %s", *name ? "there is no '" : "",
                  *name ? name : "what to do is missing", *name ? "'" : "", text_chars(&known));
    text_free(&known);
    return exit_code;
}

int command_profiles(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (strcmp(name, "why") == 0)
        return profiles_why(argc - 1, argv + 1);
    for (int i = 0; i < N_VERBS; ++i) {
        arguments args = {.verb = &verbs[i], .samples = 16};
        if (strcmp(name, verbs[i].name) == 0)
            return options_run(verbs[i].line, argc - 1, argv + 1, &args, run);
    }
    if (strcmp(name, "--help") != 0 && strcmp(name, "-h") != 0)
        return refuse_verb(name);
    print_verbs();
    return EXIT_OK;
}
