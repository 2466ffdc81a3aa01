// SPDX-License-Identifier: MIT
#include "profiles/profile.h"

#include "base/clock.h"
#include "profiles/sql.h"

#include <math.h>

static bool retire_live(store *s, const profile_row *row, const char *reason, duet_error *err)
{
    sql q = sql_make(s,
                     "UPDATE profile SET live = 0, dead_reason = ? WHERE workload_id = ? AND "
                     "pair_id = ? AND objective = ? AND kernels = ? AND level = ? AND live = 1",
                     err);
    sql_text(&q, reason);
    sql_int(&q, row->workload_id);
    sql_int(&q, row->pair_id);
    sql_text(&q, row->objective);
    sql_text(&q, row->kernels);
    sql_text(&q, row->plan.level);
    return sql_run(&q);
}

// But what is another number, or none, in the table.
static const sql_column row_columns[] = {
    SQL_COLUMN("pair_id", profile_row, pair_id),
    SQL_COLUMN("workload_id", profile_row, workload_id),
    SQL_COLUMN("kernels", profile_row, kernels),
    SQL_COLUMN("objective", profile_row, objective),
    SQL_PLAN_COLUMNS(profile_row, plan),
    SQL_COLUMN("median_ns", profile_row, median_ns),
    SQL_COLUMN("low_ns", profile_row, low_ns),
    SQL_COLUMN("high_ns", profile_row, high_ns),
    SQL_COLUMN("gain", profile_row, gain),
    SQL_COLUMN("gain_low", profile_row, gain_low),
    SQL_COLUMN("gain_high", profile_row, gain_high),
    SQL_COLUMN("verdict", profile_row, verdict),
    SQL_COLUMN("missed_rate", profile_row, missed_rate),
    SQL_COLUMN("false_rate", profile_row, false_rate),
    SQL_COLUMN("terms", profile_row, terms),
    SQL_COLUMN("origin", profile_row, origin),
    {0},
};

// -1 is no number.
static void bind_number(sql *q, int64_t number)
{
    if (number < 0)
        sql_text(q, NULL);
    else
        sql_int(q, number);
}

static bool insert(store *s, const profile_row *row, const char *uid, duet_error *err)
{
    sql q = sql_insert(s, "profile", row_columns,
                       "true_pairs, single_ns, best_share, best_mode, session_id, trial, uid, "
                       "created_ns, live",
                       "", err);
    sql_bind(&q, row_columns, row);
    bind_number(&q, row->true_pairs);
    sql_real(&q, row->single_ns != 0 ? row->single_ns : NAN);
    sql_int(&q, row->best_mode ? row->best_share : row->plan.share);
    sql_text(&q, row->best_mode ? row->best_mode : row->plan.mode);
    sql_text(&q, row->session);
    bind_number(&q, row->trial_number);
    sql_text(&q, uid);
    sql_int(&q, clock_calendar_ns());
    sql_int(&q, 1);
    return sql_run(&q);
}

bool profile_put(store *s, const profile_row *row, const char *reason, duet_error *err)
{
    char uid[PROFILE_ID];
    if (row->terms && !sql_check_object("a profile's terms", row->terms, err))
        return false;
    if (!profile_new_id(uid, err) || !store_begin(s, err))
        return false;
    bool ok = retire_live(s, row, reason, err);
    ok = ok && insert(s, row, uid, err);
    return store_end(s, ok, err);
}

// ---------------------------------------------------------------- as people see it

const char profile_entry_from[] =
    " FROM profile p JOIN pair ON pair.id = p.pair_id JOIN env a ON a.id = env_a "
    "JOIN device da ON da.id = a.device_id JOIN env b ON b.id = env_b "
    "JOIN device db ON db.id = b.device_id JOIN workload w ON w.id = p.workload_id "
    "LEFT JOIN session s ON s.id = p.session_id LEFT JOIN script ON script.key = s.script "
    "WHERE substr(p.uid, 1, length(?1)) = ?1 AND (p.live = 1 OR ?2) "
    "ORDER BY p.live DESC, p.pair_id, w.family, w.n, p.created_ns";

// But those of the row.
static const sql_column entry_columns[] = {
    SQL_COLUMN("coalesce(p.true_pairs, -1)", profile_entry, row.true_pairs),
    SQL_COLUMN("p.single_ns", profile_entry, row.single_ns),
    SQL_COLUMN("p.best_share", profile_entry, row.best_share),
    SQL_COLUMN("p.best_mode", profile_entry, row.best_mode),
    SQL_COLUMN("p.uid", profile_entry, uid),
    SQL_COLUMN("p.created_ns", profile_entry, created_ns),
    SQL_COLUMN("p.dead_reason", profile_entry, dead_reason),
    SQL_COLUMN("da.name", profile_entry, a.name),
    SQL_COLUMN("a.part", profile_entry, a.part),
    SQL_COLUMN("a.driver", profile_entry, a.driver),
    SQL_COLUMN("a.platform_version", profile_entry, a.platform_version),
    SQL_COLUMN("db.name", profile_entry, b.name),
    SQL_COLUMN("b.part", profile_entry, b.part),
    SQL_COLUMN("b.driver", profile_entry, b.driver),
    SQL_COLUMN("b.platform_version", profile_entry, b.platform_version),
    SQL_COLUMN("w.name", profile_entry, scene),
    SQL_COLUMN("w.dims", profile_entry, dims),
    SQL_COLUMN("w.n", profile_entry, n),
    SQL_COLUMN("w.family", profile_entry, family),
    SQL_COLUMN("s.id", profile_entry, session.id),
    SQL_COLUMN("s.state", profile_entry, session.state),
    SQL_COLUMN("s.strategy", profile_entry, session.strategy),
    SQL_COLUMN("s.options", profile_entry, session.options),
    SQL_COLUMN("script.body", profile_entry, session.script),
    SQL_COLUMN("s.tool_version", profile_entry, session.tool_version),
    SQL_COLUMN("s.host", profile_entry, session.host),
    SQL_COLUMN("s.seed", profile_entry, session.seed),
    SQL_COLUMN("s.resumed", profile_entry, session.resumed),
    SQL_COLUMN("(SELECT count(*) FROM trial WHERE session_id = s.id)", profile_entry,
               session.trials),
    SQL_COLUMN("(SELECT sum(launches) FROM trial WHERE session_id = s.id)", profile_entry,
               session.launches),
    SQL_COLUMN("s.load", profile_entry, session.load),
    SQL_COLUMN("s.timer_ns", profile_entry, session.timer_ns),
    SQL_COLUMN("s.started_ns", profile_entry, session.started_ns),
    SQL_COLUMN("s.ended_ns", profile_entry, session.ended_ns),
    {0},
};

bool profile_entry_each(store *s, const char *uid, bool dead_too, profile_entry_visit *visit,
                        void *context, duet_error *err)
{
    text rest = {0};
    text_add(&rest, ", ");
    sql_add_names(&rest, "p.", row_columns);
    text_add(&rest, "%s", profile_entry_from);
    bool ok = text_ok(&rest, err);
    sql q = sql_select(s, entry_columns, text_chars(&rest), err);
    sql_text(&q, uid ? uid : "");
    sql_int(&q, dead_too);
    bool more = ok;
    while (more && sql_row(&q)) {
        profile_entry entry = {0};
        sql_read(&q, sql_read(&q, 0, entry_columns, &entry), row_columns, &entry.row);
        more = visit(context, &entry);
    }
    text_free(&rest);
    return sql_close(&q) && ok;
}

// ---------------------------------------------------------------- levels

static void bind_cost_key(sql *q, const profile_level_cost_key *key)
{
    sql_int(q, key->pair_id);
    sql_int(q, key->workload_id);
    sql_text(q, key->kernels);
}

static bool clear_costs(store *s, const profile_level_cost_key *key, duet_error *err)
{
    sql q = sql_make(
        s, "DELETE FROM level_cost WHERE pair_id = ? AND workload_id = ? AND kernels = ?", err);
    bind_cost_key(&q, key);
    return sql_run(&q);
}

static const sql_column cost_columns[] = {
    SQL_COLUMN("level", profile_level_cost, level),
    SQL_COLUMN("step_ns", profile_level_cost, step_ns),
    SQL_COLUMN("true_pairs", profile_level_cost, true_pairs),
    SQL_COLUMN("missed", profile_level_cost, missed),
    SQL_COLUMN("invented", profile_level_cost, invented),
    {0},
};

static bool insert_cost(store *s, const profile_level_cost_key *key, const profile_level_cost *cost,
                        duet_error *err)
{
    sql q = sql_insert(s, "level_cost", cost_columns, "pair_id, workload_id, kernels, created_ns",
                       "", err);
    sql_bind(&q, cost_columns, cost);
    bind_cost_key(&q, key);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q);
}

bool profile_level_costs_put(store *s, const profile_level_cost_key *key,
                             const profile_level_cost *costs, uint32_t n, duet_error *err)
{
    if (!store_begin(s, err))
        return false;
    bool ok = clear_costs(s, key, err);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = insert_cost(s, key, &costs[i], err);
    return store_end(s, ok, err);
}

bool profile_level_costs_get(store *s, const profile_level_cost_key *key, profile_level_cost *costs,
                             uint32_t *n, duet_error *err)
{
    sql q = sql_select(
        s, cost_columns,
        " FROM level_cost WHERE pair_id = ? AND workload_id = ? AND kernels = ? ORDER BY level",
        err);
    bind_cost_key(&q, key);
    for (*n = 0; *n < PROFILE_LEVEL_COSTS && sql_row(&q); ++*n)
        sql_read(&q, 0, cost_columns, &costs[*n]);
    return sql_close(&q);
}
