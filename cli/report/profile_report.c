// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/report/profile_report.h"

#include "cli/report/pareto.h"

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

static bool is_here(const profile_entry *e)
{
    char host[PROFILE_SHA];
    profile_host(host);
    return e->session.host && strcmp(e->session.host, host) == 0;
}

static bool same_words(const char *a, const char *b)
{
    return strcmp(a ? a : "", b ? b : "") == 0;
}

static bool is_one(const profile_entry *e)
{
    return e->row.plan.share == 0 && e->row.best_share == 0 && same_words(e->a.name, e->b.name) &&
           same_words(e->a.part, e->b.part) && same_words(e->a.driver, e->b.driver);
}

// --------------------------------------------------------------------------- JSON

void profile_report_add_device(cJSON *o, const char *name, const profile_entry_device *d)
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
    profile_report_add_device(o, "a", &e->a);
    profile_report_add_device(o, "b", &e->b);
    json_add(o, FLAG("one_device", is_one(e)));
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
             STRING("created", profile_report_when(e->created_ns).chars), FLAG("here", is_here(e)));
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
