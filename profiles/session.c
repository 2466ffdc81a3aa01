// SPDX-License-Identifier: MIT
// A session's owner is the process that measures it. Whether that still lives
// is asked of the system on the same machine, by number and start time, since
// numbers are used again; on another machine the heartbeat must do.
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "profiles/session.h"

#include "base/clock.h"
#include "base/text_file.h"
#include "profiles/fit.h"
#include "profiles/sql.h"

#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SILENT_NS 600000000000 // ten minutes without a heartbeat: another machine's owner has gone

// When the process was started, in the kernel's ticks; 0 if it is not known,
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

// Columns that decide whether two sessions ask for the same, but the script.
static const sql_column question_columns[] = {
    SQL_COLUMN("workload_id", profile_session, workload_id),
    SQL_COLUMN("pair_id", profile_session, pair_id),
    SQL_COLUMN("kernels", profile_session, kernels),
    SQL_COLUMN("strategy", profile_session, strategy),
    SQL_COLUMN("objective", profile_session, objective),
    SQL_COLUMN("options", profile_session, options),
    SQL_COLUMN("seed", profile_session, seed),
    {0},
};

static void bind_question(sql *q, const profile_session *session)
{
    profile_session whole = *session;
    whole.options = options_of(session);
    sql_bind(q, question_columns, &whole);
}

// This process, alive now. host: as long as the statement.
static void bind_owner(sql *q, char host[PROFILE_SHA])
{
    profile_host(host);
    sql_text(q, host);
    sql_int(q, getpid());
    sql_int(q, process_start(getpid()));
    sql_int(q, clock_calendar_ns());
}

static bool insert(store *s, const profile_session *session, const char *id, const char *script,
                   duet_error *err)
{
    char host[PROFILE_SHA];
    sql q = sql_insert(s, "session", question_columns,
                       "id, state, script, tool_version, load, timer_ns, host, pid, pid_start, "
                       "heartbeat_ns, started_ns",
                       "", err);
    bind_question(&q, session);
    sql_text(&q, id);
    sql_text(&q, "running");
    sql_text(&q, script);
    sql_text(&q, session->tool_version);
    sql_real(&q, session->load);
    sql_real(&q, session->timer_ns);
    bind_owner(&q, host);
    sql_int(&q, clock_calendar_ns());
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

// A session s that asks for the same. The text of a script decides only if the
// script is the strategy.
#define SAME_QUESTION                                                                   \
    "s.workload_id = ?1 AND s.pair_id = ?2 AND s.kernels = ?3 AND s.strategy = ?4 AND " \
    "s.objective = ?5 AND s.options = ?6 AND s.seed = ?7 AND "                          \
    "(s.strategy <> 'lua' OR s.script IS ?8) "

// key: of the script, which must live until sql_close.
static sql ask(store *s, const char *query, const profile_session *session, char key[PROFILE_SHA],
               duet_error *err)
{
    if (session->script)
        profile_sha(session->script, strlen(session->script), key);
    sql q = sql_make(s, query, err);
    bind_question(&q, session);
    sql_text(&q, session->script ? key : NULL);
    return q;
}

bool profile_session_known(store *s, const profile_session *session, char uid[PROFILE_ID],
                           duet_error *err)
{
    char key[PROFILE_SHA];
    sql q = ask(s,
                "SELECT p.uid FROM session s LEFT JOIN profile p ON p.session_id = s.id "
                "WHERE s.state = 'complete' AND " SAME_QUESTION "ORDER BY s.ended_ns DESC LIMIT 1",
                session, key, err);
    *uid = '\0';
    const char *found = sql_row(&q) ? sql_get_text(&q, 0) : NULL; // NULL: it was forgotten
    sql_copy(uid, PROFILE_ID, found ? found : "");
    return sql_close(&q);
}

// Two searches at once would disturb each other's times.
static bool find_owner(store *s, const profile_session *session, profile_resumed *resumed,
                       duet_error *err)
{
    char here[PROFILE_SHA];
    profile_host(here);
    sql q = sql_make(s,
                     "SELECT host, pid, pid_start, heartbeat_ns FROM session "
                     "WHERE workload_id = ? AND (pair_id = ? OR host = ?) AND state = 'running'",
                     err);
    sql_int(&q, session->workload_id);
    sql_int(&q, session->pair_id);
    sql_text(&q, here);
    while (resumed->claim != PROFILE_CLAIM_BUSY && sql_row(&q)) {
        resumed->pid = sql_get_int(&q, 1);
        if (owner_lives(sql_get_text(&q, 0), resumed->pid, sql_get_int(&q, 2), sql_get_int(&q, 3)))
            resumed->claim = PROFILE_CLAIM_BUSY;
    }
    return sql_close(&q);
}

// The latest one that is not at its end.
static bool find_unfinished(store *s, const profile_session *session, profile_resumed *resumed,
                            duet_error *err)
{
    char key[PROFILE_SHA];
    sql q =
        ask(s,
            "SELECT id FROM session s WHERE s.state IN ('running', 'stopped') AND " SAME_QUESTION
            "ORDER BY started_ns DESC LIMIT 1",
            session, key, err);
    if (sql_row(&q)) {
        sql_copy(resumed->id, sizeof resumed->id, sql_get_text(&q, 0));
        resumed->claim = PROFILE_CLAIM_RESUMED;
    }
    return sql_close(&q);
}

static bool become_owner(store *s, const char *id, duet_error *err)
{
    char host[PROFILE_SHA];
    sql q = sql_make(s,
                     "UPDATE session SET state = 'running', host = ?, pid = ?, pid_start = ?, "
                     "heartbeat_ns = ?, resumed = resumed + 1, ended_ns = NULL WHERE id = ?",
                     err);
    bind_owner(&q, host);
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
    bool ok = find_owner(s, session, resumed, err);
    if (ok && resumed->claim == PROFILE_CLAIM_NONE)
        ok = find_unfinished(s, session, resumed, err);
    if (ok && resumed->claim == PROFILE_CLAIM_RESUMED)
        ok = become_owner(s, resumed->id, err);
    return store_end(s, ok, err);
}

bool profile_searched_variant(store *s, const profile_search *search, char variant[PROFILE_VARIANT],
                              duet_error *err)
{
    sql q =
        sql_make(s,
                 "WITH own AS (SELECT iif(?, env_b, env_a) AS env FROM pair WHERE id = ?) "
                 "SELECT iif(pair.env_a = own.env, p.variant_a, p.variant_b) "
                 "FROM own JOIN pair ON own.env IN (pair.env_a, pair.env_b) "
                 "JOIN profile p ON p.pair_id = pair.id JOIN session ON session.id = p.session_id "
                 "WHERE p.workload_id = ? AND p.kernels = ? "
                 "AND json_extract(session.options, '$.search') = ? "
                 "ORDER BY p.created_ns DESC LIMIT 1",
                 err);
    sql_int(&q, search->device);
    sql_int(&q, search->pair_id);
    sql_int(&q, search->workload_id);
    sql_text(&q, search->kernels);
    sql_text(&q, search->what);
    sql_copy(variant, PROFILE_VARIANT, sql_row(&q) ? sql_get_text(&q, 0) : "");
    return sql_close(&q);
}

bool profile_session_beat(store *s, const char *id, duet_error *err)
{
    sql q = sql_make(s, "UPDATE session SET heartbeat_ns = ? WHERE id = ?", err);
    sql_int(&q, clock_calendar_ns());
    sql_text(&q, id);
    return sql_run(&q) &&
           (sqlite3_changes(s->db) > 0 ||
            error_set(err, DUET_STATUS_STORE_FAILED,
                      "%s: has no session %s; it was removed meanwhile", s->path, id));
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
