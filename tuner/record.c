// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE
#include "tuner/record.h"

#include "runtime/selection/profile_subject.h"
#include "tuner/terms.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static bool check_writable(const record *r, duet_error *err)
{
    if (store_writable(r->store))
        return true;
    const char *note = store_note(r->store);
    return error_set(err, DUET_STATUS_STORE_FAILED, "%s: cannot be written%s%s",
                     store_path(r->store), note ? ": " : "", note ? note : "");
}

bool record_open(record *r, const char *path, duet_error *err)
{
    *r = (record){.store = store_open(path, STORE_WRITE, err)};
    bool ok = r->store && check_writable(r, err);
    if (!ok)
        record_close(r);
    return ok;
}

bool record_aim(record *r, const profile_request *request, duet_error *err)
{
    r->request = *request;
    return profile_pair_put(r->store, request->pair, &r->pair_id, err) &&
           profile_workload_put(r->store, request->workload, &r->workload_id, err);
}

void record_close(record *r)
{
    store_close(r->store);
    r->store = NULL;
}

profile_level_cost_key record_cost_key(const record *r)
{
    return (profile_level_cost_key){r->pair_id, r->workload_id, r->request.kernels};
}

// ---------------------------------------------------------------- session

// Whatever decides what the tuning measures: another budget is another session.
static void write_options(const duet_tune_def *def, text *json)
{
    text_add(json, "{\"seconds\":%.17g,\"trials\":%" PRIu32 ",\"repeats\":%" PRIu32,
             def->budget_seconds, def->budget_trials, def->repeats);
    text_add(json, ",\"variants\":[");
    for (uint32_t i = 0; i < def->n_variants; ++i)
        text_add(json, "%s\"%s\"", i ? "," : "", def->variants[i]);
    text_add(json, "],\"modes\":[");
    for (uint32_t i = 0; i < def->n_modes; ++i)
        text_add(json, "%s\"%s\"", i ? "," : "", duet_mode_name(def->modes[i]));
    text_add(json, "]");
    if (def->search)
        text_add(json, ",\"search\":\"%s\"", def->search);
    if (def->steps)
        text_add(json, ",\"steps\":%" PRIu32, def->steps);
    text_add(json, "}");
}

static double timer_resolution(void)
{
    struct timespec ts = {0};
    clock_getres(CLOCK_MONOTONIC, &ts);
    return (double)ts.tv_sec * 1e9 + (double)ts.tv_nsec;
}

static double machine_load(void)
{
    double load;
    return getloadavg(&load, 1) == 1 ? load : 0;
}

static profile_session session_of(const record *r, const char *name)
{
    return (profile_session){
        .pair_id = r->pair_id,
        .workload_id = r->workload_id,
        .kernels = r->request.kernels,
        .strategy = name,
        .objective = r->request.objective,
        .tool_version = duet_version(),
        .load = machine_load(),
        .timer_ns = timer_resolution(),
    };
}

// Describes what is asked: whatever decides what is measured. options must live as long.
static profile_session question_of(const record *r, const duet_tune_def *def, text *options)
{
    write_options(def, options);
    profile_session session = session_of(r, def->strategy);
    session.options = text_chars(options);
    session.seed = def->seed;
    session.script = def->strategy_lua ? def->strategy_lua : def->script;
    return session;
}

bool record_known(record *r, const duet_tune_def *def, profile_found *found, duet_error *err)
{
    text options = {0};
    char uid[PROFILE_ID];
    profile_session session = question_of(r, def, &options);
    bool ok = text_ok(&options, err) && profile_session_known(r->store, &session, uid, err) &&
              profile_read(r->store, uid, found, err);
    text_free(&options);
    return ok;
}

static bool take_up(record *r, const profile_session *session, trial_log *state, bool *resumed,
                    duet_error *err)
{
    profile_resumed found = {0};
    if (!profile_session_resume(r->store, session, &found, err))
        return false;
    bool ok = true;
    if (found.claim == PROFILE_CLAIM_BUSY)
        ok = error_set(err, DUET_STATUS_STORE_FAILED,
                       "%s: process %" PRId64 " is tuning this workload; wait for it or stop it",
                       store_path(r->store), found.pid);
    *resumed = found.claim == PROFILE_CLAIM_RESUMED;
    if (!*resumed)
        return ok;
    memcpy(r->session, found.id, sizeof r->session);
    return record_recall(r, state, err);
}

bool record_begin(record *r, const duet_tune_def *def, trial_log *state, bool *resumed,
                  duet_error *err)
{
    text options = {0};
    profile_session session = question_of(r, def, &options);
    // One transaction, so that of two processes one begins.
    bool ok = text_ok(&options, err) && store_begin(r->store, err);
    if (ok) {
        ok = take_up(r, &session, state, resumed, err);
        if (ok && !*resumed)
            ok = profile_session_begin(r->store, &session, r->session, err);
        ok = store_end(r->store, ok, err);
    }
    text_free(&options);
    return ok;
}

// ---------------------------------------------------------------- trial

static bool keep_trial(void *context, uint32_t number, const measurement *m, duet_error *err)
{
    const record *r = context;
    const trial *of = &m->trial;
    text terms = {0};
    terms_to_json(&of->terms, &terms);
    profile_trial row = m->row;
    row.plan = profile_subject_write_plan(&of->plan, r->request.workload->level);
    row.reason = of->usable ? NULL : m->failure.text;
    row.disturbed = of->disturbed - m->repeated;
    row.a_ns = (double)of->sample.a_ns;
    row.b_ns = (double)of->sample.b_ns;
    row.focus_ns = of->focus_ns;
    row.spent_ns = of->spent_ns;
    row.scope = of->scope;
    row.terms = of->usable ? text_chars(&terms) : NULL;
    row.samples = m->samples;
    row.n_samples = m->n_samples;
    bool ok = text_ok(&terms, err) && profile_trial_add(r->store, r->session, number, &row, err);
    text_free(&terms);
    return ok;
}

typedef struct recalling {
    trial_log *state;
    duet_error *err;
    bool ok;
} recalling;

static bool recall_trial(void *context, int64_t number, const profile_trial *row)
{
    recalling *to = context;
    duet_plan plan;
    trial t;
    (void)number;
    to->ok = profile_subject_read_plan(&row->plan, &plan, to->err);
    if (to->ok) {
        t = measure_recall(&plan, row);
        to->ok = trial_log_add(to->state, &t, to->err);
    }
    return to->ok;
}

bool record_recall(const record *r, trial_log *state, duet_error *err)
{
    recalling to = {state, err, true};
    return profile_trial_each(r->store, r->session, recall_trial, &to, err) && to.ok;
}

tune_recorder record_recorder(record *r)
{
    return (tune_recorder){.context = r, .trial = keep_trial};
}

// ---------------------------------------------------------------- profile

// A row of what is aimed at; what the plan is worth is still to be filled in.
static profile_row row_of(const record *r, const duet_plan *plan, const char *origin)
{
    return (profile_row){
        .pair_id = r->pair_id,
        .workload_id = r->workload_id,
        .kernels = r->request.kernels,
        .objective = r->request.objective,
        .plan = profile_subject_write_plan(plan, r->request.workload->level),
        .origin = origin,
        .session = r->session,
    };
}

// A search of another kind is research: applications load it by request only.
static const char *unused_because(const duet_tune_def *def, char because[64])
{
    bool usual = strcmp(def->strategy, duet_strategy_get_name(0)) == 0 ||
                 (strcmp(def->objective, "energy") == 0 && strcmp(def->strategy, "annealing") == 0);
    if (def->keep == DUET_KEEP_ALWAYS || usual)
        return NULL;
    snprintf(because, 64, "found by strategy '%s' without --keep", def->strategy);
    return because;
}

// The figures that an outcome and a profile share: FIGURE(of an outcome, of a profile, ns or other
// units of the profile in one of the outcome, and the reverse).
#define FIGURES(FIGURE)                            \
    FIGURE(step_ms, median_ns, 1e6, 1e-6)          \
    FIGURE(step_low_ms, low_ns, 1e6, 1e-6)         \
    FIGURE(step_high_ms, high_ns, 1e6, 1e-6)       \
    FIGURE(single_ms, single_ns, 1e6, 1e-6)        \
    FIGURE(gain, gain, 1, 1)                       \
    FIGURE(gain_low, gain_low, 1, 1)               \
    FIGURE(gain_high, gain_high, 1, 1)             \
    FIGURE(rounds, rounds, 1, 1)                   \
    FIGURE(watched, watched, 1, 1)                 \
    FIGURE(disturbed, disturbed, 1, 1)             \
    FIGURE(whole_ms, whole_ns, 1e6, 1e-6)          \
    FIGURE(whole_gain, whole_gain, 1, 1)           \
    FIGURE(whole_gain_low, whole_gain_low, 1, 1)   \
    FIGURE(whole_gain_high, whole_gain_high, 1, 1) \
    FIGURE(accuracy.missed, missed_rate, 1, 1)     \
    FIGURE(accuracy.false_rate, false_rate, 1, 1)

static bool put_profile(record *r, const duet_tune_def *def, duet_tune_outcome *o, duet_error *err)
{
    char because[64];
    text terms = {0};
    profile_placed placed;
    terms_to_json(&o->terms, &terms);
    profile_row row = row_of(r, &o->plan, "measured");
#define TO_ROW(of_outcome, of_profile, by, back) row.of_profile = o->of_outcome * by;
    FIGURES(TO_ROW)
    row.verdict = o->verdict;
    row.true_pairs = def->task ? -1 : (int64_t)o->true_pairs; // -1: there are none to count
    row.best_share = o->best.share;
    row.best_mode = duet_mode_name(o->best.mode);
    row.terms = text_chars(&terms);
    bool ok = text_ok(&terms, err) && profile_trial_drop(r->store, r->session, o->trials, err) &&
              profile_trial_find(r->store, r->session, &row.plan, &row.trial_number, err) &&
              profile_put(r->store, &row, *o->unused ? o->unused : unused_because(def, because),
                          "replaced by a later tuning", &placed, err);
    if (ok) {
        memcpy(o->uid, placed.uid, sizeof placed.uid);
        memcpy(o->unused, placed.unused, sizeof placed.unused);
    }
    text_free(&terms);
    return ok;
}

bool record_tell(const profile_found *found, duet_tune_outcome *o, duet_error *err)
{
    *o = (duet_tune_outcome){.known = true,
                             .true_pairs = found->true_pairs > 0 ? (uint64_t)found->true_pairs : 0};
#define TO_OUTCOME(of_outcome, of_profile, by, back) o->of_outcome = found->of_profile * back;
    FIGURES(TO_OUTCOME)
    memcpy(o->verdict, found->verdict, sizeof o->verdict);
    memcpy(o->uid, found->uid, sizeof found->uid);
    memcpy(o->unused, found->unused, sizeof o->unused);
    terms_from_json(found->terms, &o->terms);
    profile_plan best = found->plan;
    best.share = found->best_share;
    memcpy(best.mode, found->best_mode, sizeof best.mode);
    return profile_subject_read_plan(&found->plan, &o->plan, err) &&
           profile_subject_read_plan(&best, &o->best, err);
}

bool record_end(record *r, const char *how, const duet_tune_def *def, duet_tune_outcome *outcome,
                duet_error *err)
{
    bool ok = strcmp(how, "complete") != 0 || put_profile(r, def, outcome, err);
    return profile_session_end(r->store, r->session, ok ? how : "failed", err) && ok;
}

// Keeps a plan that was found without trials, as a session of its own.
static bool keep_found(record *r, const char *strategy, profile_row *row, const char *because,
                       duet_error *err)
{
    profile_session session = session_of(r, strategy);
    if (!profile_session_begin(r->store, &session, r->session, err))
        return false;
    row->trial_number = -1;
    bool ok = profile_put(r->store, row, NULL, because, NULL, err);
    return profile_session_end(r->store, r->session, ok ? "complete" : "failed", err) && ok;
}

bool record_raced(record *r, const duet_plan *plan, const race *ran, uint32_t winner,
                  uint32_t other, duet_error *err)
{
    const double *times = ran->rivals[winner].ns;
    const uint32_t n = ran->rivals[winner].rounds;
    const stats_interval in = stats_median_interval(times, n, ran->options.confidence);
    const race_gain gain =
        winner == other ? race_no_gain(RACE_SAME) : race_compare(ran, winner, other);
    profile_row row = row_of(r, plan, "measured");
    row.median_ns = race_median(ran, winner);
    row.low_ns = in.low;
    row.high_ns = in.high;
    row.gain = gain.ratio - 1;
    row.gain_low = gain.interval.low - 1;
    row.gain_high = gain.interval.high - 1;
    row.verdict = race_verdict_name(gain.verdict);
    row.rounds = n;
    row.true_pairs = -1;
    return keep_found(r, "race", &row, "replaced by a later tuning", err);
}

// The gain of sharing was not measured again: it is taken from the profile before, if there is one.
bool record_online(record *r, const duet_plan *plan, double step_ns, duet_error *err)
{
    profile_found before;
    if (!profile_lookup(r->store, &r->request, &before, NULL, err))
        return false;
    profile_row row = row_of(r, plan, "online");
    row.median_ns = row.low_ns = row.high_ns = step_ns;
    row.verdict = "ambiguous";
    row.true_pairs = -1;
    if (before.grade == PROFILE_EXACT) {
        row.gain = before.gain;
        row.gain_low = before.gain_low;
        row.gain_high = before.gain_high;
        row.verdict = before.verdict;
        row.rounds = before.rounds;
        row.watched = before.watched;
        row.disturbed = before.disturbed;
        row.missed_rate = before.missed_rate;
        row.false_rate = before.false_rate;
        row.true_pairs = before.true_pairs;
    }
    return keep_found(r, "chunks", &row, "tuned on line", err);
}
