// SPDX-License-Identifier: MIT
// A session's owner is the process that measures it. Whether that still lives
// is asked of the system on the same machine, by number and start time, since
// numbers are used again; on another machine the heartbeat must do.
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "profiles/session.h"

#include "base/clock.h"
#include "profiles/fit.h"
#include "profiles/sql.h"

#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#define SILENT_NS 600000000000 // ten minutes without a heartbeat: another machine's owner has gone

bool profile_new_id(char id[PROFILE_ID], duet_error *err)
{
    uint8_t bytes[16];
    if (getentropy(bytes, sizeof bytes) != 0)
        return error_set(err, DUET_STATUS_IO_FAILED, "random bytes: %s", strerror(errno));
    for (size_t i = 0; i < sizeof bytes; ++i)
        snprintf(id + 2 * i, 3, "%02x", bytes[i]);
    return true;
}

// When the process was started, in the kernel's ticks; 0 where it is not known,
// or where it ended and only waits for its parent.
static int64_t process_start(int64_t pid)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%" PRId64 "/stat", pid);
    text t = {0};
    int64_t start = 0;
    // The name, in brackets, may hold anything; the start is the 20th field after it.
    if (text_read_file(&t, path, NULL)) {
        const char *at = strrchr(t.chars, ')');
        if (at && (strncmp(at, ") Z", 3) == 0 || strncmp(at, ") X", 3) == 0))
            at = NULL;
        for (int i = 0; at && i < 20; ++i)
            at = strchr(at + 1, ' ');
        start = at ? strtoll(at, NULL, 10) : 0;
    }
    text_free(&t);
    return start;
}

static bool owner_lives(const char *host, int64_t pid, int64_t pid_start, int64_t heartbeat_ns)
{
    char here[PROFILE_SHA];
    profile_host(here);
    if (strcmp(host, here) != 0)
        return heartbeat_ns + SILENT_NS > clock_calendar_ns();
    if (kill((pid_t)pid, 0) != 0 && errno == ESRCH)
        return false;
    return process_start(pid) == pid_start;
}

static bool put_script(store *s, const char *script, char key[PROFILE_SHA], duet_error *err)
{
    profile_sha(script, strlen(script), key);
    sql q = sql_make(s, "INSERT INTO script (key, body) VALUES (?, ?) ON CONFLICT (key) DO NOTHING",
                     err);
    sql_text(&q, key);
    sql_text(&q, script);
    return sql_run(&q);
}

static const char *options_of(const profile_session *session)
{
    return session->options ? session->options : "{}";
}

static bool insert(store *s, const profile_session *session, const char *id, const char *script,
                   duet_error *err)
{
    char host[PROFILE_SHA];
    profile_host(host);
    int64_t now = clock_calendar_ns();
    sql q = sql_make(
        s,
        "INSERT INTO session (id, state, pair_id, workload_id, kernels, strategy, objective, "
        "options, seed, script, tool_version, host, pid, pid_start, load, timer_ns, started_ns, "
        "heartbeat_ns) VALUES (?, 'running', ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
        err);
    sql_text(&q, id);
    sql_int(&q, session->pair_id);
    sql_int(&q, session->workload_id);
    sql_text(&q, session->kernels);
    sql_text(&q, session->strategy);
    sql_text(&q, session->objective);
    sql_text(&q, options_of(session));
    sql_int(&q, (int64_t)session->seed);
    sql_text(&q, script);
    sql_text(&q, session->tool_version);
    sql_text(&q, host);
    sql_int(&q, getpid());
    sql_int(&q, process_start(getpid()));
    sql_real(&q, session->load);
    sql_real(&q, session->timer_ns);
    sql_int(&q, now);
    sql_int(&q, now);
    return sql_run(&q);
}

bool profile_session_begin(store *s, const profile_session *session, char id[PROFILE_ID],
                           duet_error *err)
{
    if (!sql_check_object("a session's options", options_of(session), err) ||
        !profile_new_id(id, err) || !store_begin(s, err))
        return false;
    char script[PROFILE_SHA];
    bool ok = !session->script || put_script(s, session->script, script, err);
    ok = ok && insert(s, session, id, session->script ? script : NULL, err);
    return store_end(s, ok, err);
}

// The latest one that is not at its end and asks for the same.
static bool find_unfinished(store *s, const profile_session *session, profile_resumed *resumed,
                            duet_error *err)
{
    sql q = sql_make(
        s,
        "SELECT id, state, host, pid, pid_start, heartbeat_ns, coalesce(search_state, ''), "
        "(SELECT count(*) FROM trial WHERE session_id = session.id) FROM session "
        "WHERE workload_id = ? AND pair_id = ? AND kernels = ? AND strategy = ? AND objective = ? "
        "AND options = ? AND seed = ? AND state IN ('running', 'stopped') "
        "ORDER BY started_ns DESC LIMIT 1",
        err);
    sql_int(&q, session->workload_id);
    sql_int(&q, session->pair_id);
    sql_text(&q, session->kernels);
    sql_text(&q, session->strategy);
    sql_text(&q, session->objective);
    sql_text(&q, options_of(session));
    sql_int(&q, (int64_t)session->seed);
    if (sql_row(&q)) {
        sql_copy(resumed->id, sizeof resumed->id, sql_get_text(&q, 0));
        resumed->pid = sql_get_int(&q, 3);
        bool running = strcmp(sql_get_text(&q, 1), "running") == 0;
        bool lives = running && owner_lives(sql_get_text(&q, 2), resumed->pid, sql_get_int(&q, 4),
                                            sql_get_int(&q, 5));
        resumed->claim = lives ? PROFILE_CLAIM_BUSY : PROFILE_CLAIM_RESUMED;
        text_add(&resumed->search_state, "%s", sql_get_text(&q, 6));
        resumed->trials = (uint32_t)sql_get_int(&q, 7);
    }
    return sql_close(&q) && text_ok(&resumed->search_state, err);
}

static bool become_owner(store *s, const char *id, duet_error *err)
{
    char host[PROFILE_SHA];
    profile_host(host);
    sql q = sql_make(s,
                     "UPDATE session SET state = 'running', host = ?, pid = ?, pid_start = ?, "
                     "heartbeat_ns = ?, resumed = resumed + 1, ended_ns = NULL WHERE id = ?",
                     err);
    sql_text(&q, host);
    sql_int(&q, getpid());
    sql_int(&q, process_start(getpid()));
    sql_int(&q, clock_calendar_ns());
    sql_text(&q, id);
    return sql_run(&q);
}

bool profile_session_resume(store *s, const profile_session *session, profile_resumed *resumed,
                            duet_error *err)
{
    *resumed = (profile_resumed){0};
    // Found and taken in one transaction, so that two processes never take one session.
    if (!store_begin(s, err))
        return false;
    bool ok = find_unfinished(s, session, resumed, err);
    if (ok && resumed->claim == PROFILE_CLAIM_RESUMED)
        ok = become_owner(s, resumed->id, err);
    return store_end(s, ok, err);
}

void profile_resumed_free(profile_resumed *resumed)
{
    text_free(&resumed->search_state);
}

bool profile_session_save(store *s, const char *id, const char *search_state, duet_error *err)
{
    if (search_state && !sql_check_object("a search's state", search_state, err))
        return false;
    if (!store_begin(s, err))
        return false;
    sql q = sql_make(s,
                     "UPDATE session SET search_state = coalesce(?, search_state), "
                     "heartbeat_ns = ? WHERE id = ?",
                     err);
    sql_text(&q, search_state);
    sql_int(&q, clock_calendar_ns());
    sql_text(&q, id);
    bool ok = sql_run(&q);
    if (ok && sqlite3_changes(s->db) == 0)
        ok = error_set(err, DUET_STATUS_STORE_FAILED,
                       "%s: has no session %s; it was removed meanwhile", s->path, id);
    return store_end(s, ok, err);
}

bool profile_session_end(store *s, const char *id, const char *how, duet_error *err)
{
    if (!store_begin(s, err))
        return false;
    int64_t now = clock_calendar_ns();
    sql q = sql_make(s, "UPDATE session SET state = ?, heartbeat_ns = ?, ended_ns = ? WHERE id = ?",
                     err);
    sql_text(&q, how);
    sql_int(&q, now);
    sql_int(&q, now);
    sql_text(&q, id);
    bool ok = sql_run(&q);
    if (ok && strcmp(how, "complete") == 0)
        ok = fit_session(s, id, err);
    return store_end(s, ok, err);
}

// ---------------------------------------------------------------- trials

// Statistics exist only of a trial that was measured.
static void bind_statistic(sql *q, const profile_trial *trial, double value)
{
    if (strcmp(trial->outcome, "ok") == 0)
        sql_real(q, value);
    else
        sql_text(q, NULL);
}

static uint32_t count_launches(const profile_trial *trial)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < trial->n_samples; ++i)
        n += (trial->samples[i].flags & PROFILE_SAMPLE_WARM_UP) == 0;
    return n;
}

static bool insert_trial(store *s, const char *session, int64_t number, const profile_trial *trial,
                         duet_error *err)
{
    sql q = sql_make(s,
                     "INSERT INTO trial (session_id, number, share, mode, level, variant_a, "
                     "variant_b, outcome, reason, build_ms, launches, outliers, median_ns, mad_ns, "
                     "low_ns, high_ns, a_ns, b_ns, terms, created_ns) "
                     "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                     err);
    sql_text(&q, session);
    sql_int(&q, number);
    sql_int(&q, trial->plan.share);
    sql_text(&q, trial->plan.mode);
    sql_text(&q, trial->plan.level);
    sql_text(&q, trial->plan.variant_a);
    sql_text(&q, trial->plan.variant_b);
    sql_text(&q, trial->outcome);
    sql_text(&q, trial->reason);
    sql_real(&q, trial->build_ms);
    sql_int(&q, count_launches(trial));
    sql_int(&q, trial->outliers);
    bind_statistic(&q, trial, trial->median_ns);
    bind_statistic(&q, trial, trial->mad_ns);
    bind_statistic(&q, trial, trial->low_ns);
    bind_statistic(&q, trial, trial->high_ns);
    bind_statistic(&q, trial, trial->a_ns);
    bind_statistic(&q, trial, trial->b_ns);
    sql_text(&q, trial->terms);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q);
}

static bool insert_samples(store *s, int64_t trial_id, const profile_trial *trial, duet_error *err)
{
    sql q = sql_make(s, "INSERT INTO sample VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", err);
    for (uint32_t i = 0; i < trial->n_samples; ++i) {
        const profile_sample *sample = &trial->samples[i];
        sql_again(&q);
        sql_int(&q, trial_id);
        sql_int(&q, i);
        sql_int(&q, sample->total_ns);
        sql_int(&q, sample->a_ns);
        sql_int(&q, sample->b_ns);
        sql_int(&q, sample->transfer_ns);
        sql_int(&q, sample->merge_ns);
        sql_int(&q, sample->flags);
        sql_int(&q, sample->at_ns);
        sql_row(&q);
    }
    return sql_close(&q);
}

bool profile_trial_add(store *s, const char *session, const profile_trial *trial,
                       const char *search_state, int64_t *number, duet_error *err)
{
    if (trial->terms && !sql_check_object("a trial's terms", trial->terms, err))
        return false;
    if (!store_begin(s, err))
        return false;
    bool ok = profile_session_save(s, session, search_state, err);
    ok = ok && sql_find(s, "SELECT count(*) FROM trial WHERE session_id = ?", session, number, err);
    ok = ok && insert_trial(s, session, *number, trial, err);
    ok = ok && insert_samples(s, sqlite3_last_insert_rowid(s->db), trial, err);
    return store_end(s, ok, err);
}

bool profile_trial_find(store *s, const char *session, const profile_plan *plan, int64_t *number,
                        duet_error *err)
{
    sql q =
        sql_make(s,
                 "SELECT coalesce(max(number), -1) FROM trial WHERE session_id = ? AND "
                 "share = ? AND mode = ? AND variant_a = ? AND variant_b = ? AND outcome = 'ok'",
                 err);
    sql_text(&q, session);
    sql_int(&q, plan->share);
    sql_text(&q, plan->mode);
    sql_text(&q, plan->variant_a);
    sql_text(&q, plan->variant_b);
    *number = sql_row(&q) ? sql_get_int(&q, 0) : -1;
    return sql_close(&q);
}

// ------------------------------------------------------------------- reading

typedef struct sample_list {
    profile_sample *samples;
    uint32_t n;
    uint32_t capacity;
} sample_list;

static bool make_room(sample_list *list, duet_error *err)
{
    if (list->n < list->capacity)
        return true;
    uint32_t capacity = list->capacity ? 2 * list->capacity : 64;
    profile_sample *samples = realloc(list->samples, capacity * sizeof *samples);
    if (!samples)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%u samples: no memory", capacity);
    list->samples = samples;
    list->capacity = capacity;
    return true;
}

static bool read_samples(store *s, int64_t trial_id, sample_list *list, duet_error *err)
{
    sql q = sql_make(s,
                     "SELECT total_ns, a_ns, b_ns, transfer_ns, merge_ns, flags, at_ns "
                     "FROM sample WHERE trial_id = ? ORDER BY number",
                     err);
    sql_int(&q, trial_id);
    list->n = 0;
    bool ok = true;
    while (ok && sql_row(&q)) {
        ok = make_room(list, err);
        if (ok)
            list->samples[list->n++] = (profile_sample){
                .total_ns = sql_get_int(&q, 0),
                .a_ns = sql_get_int(&q, 1),
                .b_ns = sql_get_int(&q, 2),
                .transfer_ns = sql_get_int(&q, 3),
                .merge_ns = sql_get_int(&q, 4),
                .flags = (uint32_t)sql_get_int(&q, 5),
                .at_ns = sql_get_int(&q, 6),
            };
    }
    return sql_close(&q) && ok;
}

static profile_trial read_trial(const sql *q)
{
    profile_trial trial = {
        .plan.share = (uint32_t)sql_get_int(q, 2),
        .outcome = sql_get_text(q, 7),
        .reason = sql_get_text(q, 8),
        .build_ms = sql_get_real(q, 9),
        .outliers = (uint32_t)sql_get_int(q, 10),
        .median_ns = sql_get_real(q, 11),
        .mad_ns = sql_get_real(q, 12),
        .low_ns = sql_get_real(q, 13),
        .high_ns = sql_get_real(q, 14),
        .a_ns = sql_get_real(q, 15),
        .b_ns = sql_get_real(q, 16),
        .terms = sql_get_text(q, 17),
    };
    sql_copy(trial.plan.mode, sizeof trial.plan.mode, sql_get_text(q, 3));
    sql_copy(trial.plan.level, sizeof trial.plan.level, sql_get_text(q, 4));
    sql_copy(trial.plan.variant_a, sizeof trial.plan.variant_a, sql_get_text(q, 5));
    sql_copy(trial.plan.variant_b, sizeof trial.plan.variant_b, sql_get_text(q, 6));
    return trial;
}

bool profile_trial_each(store *s, const char *session, profile_trial_visit *visit, void *context,
                        duet_error *err)
{
    sql q = sql_make(s,
                     "SELECT id, number, share, mode, level, variant_a, variant_b, outcome, "
                     "reason, build_ms, outliers, median_ns, mad_ns, low_ns, high_ns, a_ns, b_ns, "
                     "terms FROM trial WHERE session_id = ? ORDER BY number",
                     err);
    sql_text(&q, session);
    sample_list list = {0};
    bool ok = true;
    bool more = true;
    while (ok && more && sql_row(&q)) {
        ok = read_samples(s, sql_get_int(&q, 0), &list, err);
        profile_trial trial = read_trial(&q);
        trial.samples = list.samples;
        trial.n_samples = list.n;
        more = ok && visit(context, sql_get_int(&q, 1), &trial);
    }
    free(list.samples);
    return sql_close(&q) && ok;
}
