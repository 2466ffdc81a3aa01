// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/report/profile_report.h"

#include "cli/report/pareto.h"
#include "cli/say.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

profile_report_date profile_report_when(int64_t calendar_ns)
{
    profile_report_date date = {""};
    time_t seconds = (time_t)(calendar_ns / 1000000000);
    struct tm parts;
    if (calendar_ns > 0 && gmtime_r(&seconds, &parts))
        strftime(date.chars, sizeof date.chars, "%Y-%m-%d %H:%M", &parts);
    return date;
}

bool profile_report_is_here(const profile_entry *e)
{
    char host[PROFILE_SHA];
    profile_host(host);
    return e->session.host && strcmp(e->session.host, host) == 0;
}

static bool same_words(const char *a, const char *b)
{
    return strcmp(a ? a : "", b ? b : "") == 0;
}

bool profile_report_is_one(const profile_entry *e)
{
    return e->row.plan.share == 0 && e->row.best_share == 0 && same_words(e->a.name, e->b.name) &&
           same_words(e->a.part, e->b.part) && same_words(e->a.driver, e->b.driver);
}

// --------------------------------------------------------------------------- JSON

static void add_device(cJSON *o, const char *name, const profile_entry_device *d)
{
    cJSON *device = cJSON_AddObjectToObject(o, name);
    json_add(device, STRING("name", d->name), STRING("part", d->part ? d->part : ""),
             STRING("driver", d->driver), STRING("platform_version", d->platform_version));
}

static void add_plan(cJSON *o, const profile_plan *plan)
{
    json_add_plan(o, plan->share / (double)PROFILE_SHARE_ONE, plan->mode, plan->variant_a,
                  plan->variant_b);
    json_add(o, STRING("level", plan->level));
}

cJSON *profile_report_json(const profile_entry *e)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("uid", e->uid), FLAG("live", !e->dead_reason));
    if (e->dead_reason)
        json_add(o, STRING("dead_reason", e->dead_reason));
    json_add(o, STRING("scene", e->scene ? e->scene : ""), STRING("family", e->family),
             NUMBER("dims", e->dims));
    if (e->query) {
        json_add(o, STRING("query", e->query), NUMBER("items", e->n));
    }
    json_add(o, FLAG("moving", e->moving), NUMBER("objects", (double)(e->query ? e->boxes : e->n)));
    add_device(o, "a", &e->a);
    add_device(o, "b", &e->b);
    add_plan(o, &e->row.plan);
    json_add(o, NUMBER("ms", e->row.median_ns * 1e-6), NUMBER("low_ms", e->row.low_ns * 1e-6),
             NUMBER("high_ms", e->row.high_ns * 1e-6),
             INTERVAL("gain", e->row.gain, e->row.gain_low, e->row.gain_high),
             STRING("verdict", e->row.verdict), NUMBER("rounds", e->row.rounds),
             NUMBER("watched", e->row.watched), NUMBER("disturbed", e->row.disturbed),
             NUMBER("single_ms", e->row.single_ns * 1e-6));
    json_add_whole(o, e->row.whole_ns * 1e-6, e->row.whole_gain, e->row.whole_gain_low,
                   e->row.whole_gain_high);
    json_add_rates(o, (double)e->row.true_pairs, e->row.missed_rate, e->row.false_rate);
    if (e->row.terms)
        json_add_object(o, "terms", e->row.terms);
    json_add(o, STRING("objective", e->row.objective), STRING("origin", e->row.origin),
             STRING("kernels", e->row.kernels),
             STRING("created", profile_report_when(e->created_ns).chars),
             FLAG("here", profile_report_is_here(e)));
    return o;
}

void profile_report_add_session(cJSON *o, const profile_entry_session *s)
{
    if (!s->id)
        return;
    cJSON *session = cJSON_AddObjectToObject(o, "session");
    json_add(session, STRING("id", s->id), STRING("state", s->state),
             STRING("strategy", s->strategy));
    json_add_object(session, "options", s->options);
    if (s->script)
        json_add(session, STRING("script", s->script));
    json_add(session, STRING("tool_version", s->tool_version), STRING("host", s->host),
             NUMBER("seed", s->seed), NUMBER("resumed", s->resumed),
             NUMBER("launches", s->launches), NUMBER("load", s->load),
             NUMBER("timer_ns", s->timer_ns),
             STRING("started", profile_report_when(s->started_ns).chars),
             STRING("ended", profile_report_when(s->ended_ns).chars));
}

static bool add_trial(void *context, int64_t number, const profile_trial *trial)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, NUMBER("number", number));
    add_plan(o, &trial->plan);
    json_add(o, STRING("outcome", trial->outcome));
    if (trial->reason)
        json_add(o, STRING("reason", trial->reason));
    json_add(o, NUMBER("samples", trial->n_samples), NUMBER("outliers", trial->outliers),
             NUMBER("ms", trial->median_ns * 1e-6), NUMBER("low_ms", trial->low_ns * 1e-6),
             NUMBER("high_ms", trial->high_ns * 1e-6), NUMBER("a_ms", trial->a_ns * 1e-6),
             NUMBER("b_ms", trial->b_ns * 1e-6));
    if (trial->terms)
        json_add_object(o, "terms", trial->terms);
    return cJSON_AddItemToArray(context, o);
}

bool profile_report_add_trials(cJSON *o, store *s, const char *session, duet_error *err)
{
    cJSON *trials = cJSON_AddArrayToObject(o, "trials");
    bool ok = !session || profile_trial_each(s, session, add_trial, trials, err);
    pareto_add(o);
    return ok;
}

// --------------------------------------------------------------------------- text

static const char *or_none(const char *chars)
{
    return chars && *chars ? chars : "-";
}

void profile_report_device(const char *label, const profile_entry_device *d)
{
    printf("%s%s%s%s%s, driver %s\n", label, say_name(d->name).chars, d->part ? " [" : "",
           say_name(d->part).chars, d->part ? "]" : "", say_name(d->driver).chars);
}

void profile_report_device_row(table *t, const char *label, const profile_entry_device *d)
{
    table_words(t, label, NULL);
    table_cell(t, "%s%s%s%s, driver %s", say_name(d->name).chars, d->part ? " [" : "",
               say_name(d->part).chars, d->part ? "]" : "", say_name(d->driver).chars);
}

static void add_search(table *t, const profile_entry *e)
{
    const profile_entry_session *s = &e->session;
    table_words(t, "session", NULL);
    if (!s->id) {
        table_words(t, "none: put in by hand", NULL);
        return;
    }
    table_cell(t, "%s, %s, duet %s on %s machine, load %.2f, clock of %.0f ns",
               say_name(s->id).chars, say_name(s->state).chars, say_name(s->tool_version).chars,
               profile_report_is_here(e) ? "this" : "another", s->load, s->timer_ns);
    table_words(t, "search", NULL);
    table_cell(t,
               "%s, seed %" PRId64 ", %" PRId64 " trials, %" PRId64 " launches, resumed %" PRId64
               " times",
               say_name(s->strategy).chars, s->seed, s->trials, s->launches, s->resumed);
    table_words(t, "options", say_name(s->options).chars, "when", NULL);
    table_cell(t, "%s to %s UTC", profile_report_when(s->started_ns).chars,
               or_none(profile_report_when(s->ended_ns).chars));
}

static void add_result(table *t, const profile_entry *e)
{
    const profile_row *row = &e->row;
    table_words(t, "plan", NULL);
    if (profile_report_is_one(e))
        table_cell(t, "%s, level %s", say_name(row->plan.variant_b).chars,
                   say_name(row->plan.level).chars);
    else
        table_cell(t, "share %.5f (%u of %d), mode %s, A %s, B %s, level %s",
                   row->plan.share / (double)PROFILE_SHARE_ONE, row->plan.share, PROFILE_SHARE_ONE,
                   say_name(row->plan.mode).chars, say_name(row->plan.variant_a).chars,
                   say_name(row->plan.variant_b).chars, say_name(row->plan.level).chars);
    table_words(t, "step", NULL);
    table_cell(t, "%.4f ms (%.4f to %.4f)", row->median_ns * 1e-6, row->low_ns * 1e-6,
               row->high_ns * 1e-6);
    if (!profile_report_is_one(e)) {
        table_text gain =
            table_gain(row->plan.share, row->gain, row->gain_low, row->gain_high, row->verdict);
        table_words(t, "gain", say_name(gain.chars).chars, NULL);
    }
    if (row->rounds > 0) {
        table_words(t, "rounds", NULL);
        table_cell(t, "%u", row->rounds);
    }
    table_words(t, "quiet", NULL);
    if (row->watched > 0)
        table_cell(t, "%u of %u launches waited for a core", row->disturbed, row->watched);
    else
        table_words(t, "was not looked at", NULL);
    if (row->whole_ns > 0) {
        table_text whole = table_whole(e->a.name, NULL, row->whole_gain, row->whole_gain_low,
                                       row->whole_gain_high);
        table_words(t, "whole", NULL);
        table_cell(t, "%.4f ms; %s", row->whole_ns * 1e-6, say_name(whole.chars).chars);
    }
    table_words(t, "accuracy", NULL);
    if (row->true_pairs < 0)
        table_words(t, "was not measured", NULL);
    else
        table_cell(t, "of %s pairs that collide, %.3g %% are missed and %.3g %% false ones added",
                   table_count((uint64_t)row->true_pairs).chars, 100 * row->missed_rate,
                   100 * row->false_rate);
    if (row->terms)
        table_words(t, "terms", say_name(row->terms).chars, NULL);
    table_words(t, "kernels", say_name(row->kernels).chars, NULL);
}

void profile_report_text(const profile_entry *e)
{
    table t = table_begin("ll");
    table_words(&t, "profile", NULL);
    table_cell(&t, "%s%s%s", say_name(e->uid).chars, e->dead_reason ? ", dead: " : "",
               say_name(e->dead_reason).chars);
    bool one = profile_report_is_one(e);
    profile_report_device_row(&t, one ? "device" : "A", &e->a);
    if (!one)
        profile_report_device_row(&t, "B", &e->b);
    table_words(&t, "workload", NULL);
    table_cell(&t, "%s, %s: %s", say_name(or_none(e->scene)).chars,
               e->query ? table_things((uint64_t)e->n, "item", "items").chars
                        : table_things((uint64_t)e->n, "object", "objects").chars,
               say_name(e->family).chars);
    add_result(&t, e);
    add_search(&t, e);
    table_print(&t, stdout);
    if (e->session.id && e->session.script) {
        printf("script\n");
        say_lines(e->session.script);
        printf("\n");
    }
}
