// SPDX-License-Identifier: MIT
#include "profiles/trial.h"

#include "base/clock.h"
#include "profiles/session.h"
#include "profiles/sql.h"

#include <stdlib.h>
#include <string.h>

static const sql_column trial_columns[] = {
    SQL_PLAN_COLUMNS(profile_trial, plan),
    SQL_COLUMN("outcome", profile_trial, outcome),
    SQL_COLUMN("reason", profile_trial, reason),
    SQL_COLUMN("build_ms", profile_trial, build_ms),
    SQL_COLUMN("outliers", profile_trial, outliers),
    SQL_COLUMN("disturbed", profile_trial, disturbed),
    SQL_COLUMN("terms", profile_trial, terms),
    SQL_COLUMN("focus_ns", profile_trial, focus_ns),
    SQL_COLUMN("spent_ns", profile_trial, spent_ns),
    SQL_COLUMN("scope", profile_trial, scope),
    {0},
};

// These exist only of a trial that was measured.
static const sql_column statistic_columns[] = {
    SQL_COLUMN("median_ns", profile_trial, median_ns),
    SQL_COLUMN("mad_ns", profile_trial, mad_ns),
    SQL_COLUMN("low_ns", profile_trial, low_ns),
    SQL_COLUMN("high_ns", profile_trial, high_ns),
    SQL_COLUMN("a_ns", profile_trial, a_ns),
    SQL_COLUMN("b_ns", profile_trial, b_ns),
    {0},
};

#define STATISTICS "median_ns, mad_ns, low_ns, high_ns, a_ns, b_ns"

static const sql_column sample_columns[] = {
    SQL_COLUMN("total_ns", profile_sample, total_ns),
    SQL_COLUMN("a_ns", profile_sample, a_ns),
    SQL_COLUMN("b_ns", profile_sample, b_ns),
    SQL_COLUMN("transfer_ns", profile_sample, transfer_ns),
    SQL_COLUMN("merge_ns", profile_sample, merge_ns),
    SQL_COLUMN("cpu_ns", profile_sample, cpu_ns),
    SQL_COLUMN("wait_ns", profile_sample, wait_ns),
    SQL_COLUMN("flags", profile_sample, flags),
    SQL_COLUMN("at_ns", profile_sample, at_ns),
    {0},
};

static uint32_t count_launches(const profile_trial *trial)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < trial->n_samples; ++i)
        n += (trial->samples[i].flags & (PROFILE_SAMPLE_WARM_UP | PROFILE_SAMPLE_DISTURBED)) == 0;
    return n;
}

static bool insert_trial(store *s, const char *session, int64_t number, const profile_trial *trial,
                         duet_error *err)
{
    bool measured = strcmp(trial->outcome, "ok") == 0;
    sql q = sql_insert(s, "trial", trial_columns,
                       STATISTICS ", session_id, number, launches, created_ns", "", err);
    sql_bind(&q, trial_columns, trial);
    sql_bind(&q, statistic_columns, measured ? trial : NULL);
    sql_text(&q, session);
    sql_int(&q, number);
    sql_int(&q, count_launches(trial));
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q);
}

static bool insert_samples(store *s, int64_t trial_id, const profile_trial *trial, duet_error *err)
{
    sql q = sql_insert(s, "sample", sample_columns, "trial_id, number", "", err);
    for (uint32_t i = 0; i < trial->n_samples; ++i) {
        sql_again(&q);
        sql_bind(&q, sample_columns, &trial->samples[i]);
        sql_int(&q, trial_id);
        sql_int(&q, i);
        sql_row(&q);
    }
    return sql_close(&q);
}

bool profile_trial_drop(store *s, const char *session, int64_t from, duet_error *err)
{
    sql q = sql_make(s, "DELETE FROM trial WHERE session_id = ? AND number >= ?", err);
    sql_text(&q, session);
    sql_int(&q, from);
    return sql_run(&q);
}

bool profile_trial_add(store *s, const char *session, int64_t number, const profile_trial *trial,
                       duet_error *err)
{
    if (trial->terms && !sql_check_object("a trial's terms", trial->terms, err))
        return false;
    if (!store_begin(s, err))
        return false;
    bool ok = profile_session_beat(s, session, err) &&
              profile_trial_drop(s, session, number, err) &&
              insert_trial(s, session, number, trial, err) &&
              insert_samples(s, sqlite3_last_insert_rowid(s->db), trial, err);
    return store_end(s, ok, err);
}

bool profile_trial_find(store *s, const char *session, const profile_plan *plan, int64_t *number,
                        duet_error *err)
{
    sql q =
        sql_make(s,
                 "SELECT coalesce(max(number), -1) FROM trial WHERE session_id = ? AND "
                 "share = ? AND mode = ? AND variant_a = ? AND variant_b = ? AND outcome = 'ok' "
                 "AND scope = 65536",
                 err);
    sql_text(&q, session);
    sql_int(&q, plan->share);
    sql_text(&q, plan->mode);
    sql_text(&q, plan->variant_a);
    sql_text(&q, plan->variant_b);
    *number = sql_row(&q) ? sql_get_int(&q, 0) : -1;
    return sql_close(&q);
}

bool profile_trial_each(store *s, const char *session, profile_trial_visit *visit, void *context,
                        duet_error *err)
{
    sql q = sql_select(
        s, trial_columns,
        ", " STATISTICS ", id, number FROM trial WHERE session_id = ? ORDER BY number", err);
    sql_text(&q, session);
    bool ok = true;
    bool more = true;
    while (ok && more && sql_row(&q)) {
        profile_trial trial = {0};
        int rest = sql_read(&q, 0, trial_columns, &trial);
        rest = sql_read(&q, rest, statistic_columns, &trial);
        sql samples =
            sql_select(s, sample_columns, " FROM sample WHERE trial_id = ? ORDER BY number", err);
        sql_int(&samples, sql_get_int(&q, rest));
        profile_sample *list = sql_rows(&samples, sample_columns, sizeof *list, &trial.n_samples);
        trial.samples = list;
        ok = sql_close(&samples);
        more = ok && visit(context, sql_get_int(&q, rest + 1), &trial);
        free(list);
    }
    return sql_close(&q) && ok;
}
