// SPDX-License-Identifier: MIT
#include "profiles/profile.h"

#include "base/clock.h"
#include "profiles/sql.h"

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

static bool insert(store *s, const profile_row *row, const char *uid, duet_error *err)
{
    sql q = sql_make(
        s,
        "INSERT INTO profile (uid, pair_id, workload_id, kernels, objective, level, share, mode, "
        "variant_a, variant_b, median_ns, low_ns, high_ns, gain, gain_low, gain_high, verdict, "
        "missed_rate, false_rate, true_pairs, single_ns, best_share, best_mode, terms, origin, "
        "session_id, trial, created_ns, live) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, nullif(?, -1), "
        "nullif(?, 0.0), ?, ?, ?, ?, ?, nullif(?, -1), ?, 1)",
        err);
    sql_text(&q, uid);
    sql_int(&q, row->pair_id);
    sql_int(&q, row->workload_id);
    sql_text(&q, row->kernels);
    sql_text(&q, row->objective);
    sql_text(&q, row->plan.level);
    sql_int(&q, row->plan.share);
    sql_text(&q, row->plan.mode);
    sql_text(&q, row->plan.variant_a);
    sql_text(&q, row->plan.variant_b);
    sql_real(&q, row->median_ns);
    sql_real(&q, row->low_ns);
    sql_real(&q, row->high_ns);
    sql_real(&q, row->gain);
    sql_real(&q, row->gain_low);
    sql_real(&q, row->gain_high);
    sql_text(&q, row->verdict);
    sql_real(&q, row->missed_rate);
    sql_real(&q, row->false_rate);
    sql_int(&q, row->true_pairs);
    sql_real(&q, row->single_ns);
    sql_int(&q, row->best_mode ? row->best_share : row->plan.share);
    sql_text(&q, row->best_mode ? row->best_mode : row->plan.mode);
    sql_text(&q, row->terms);
    sql_text(&q, row->origin);
    sql_text(&q, row->session);
    sql_int(&q, row->trial_number);
    sql_int(&q, clock_calendar_ns());
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

// The columns, in the order in which read_entry takes them.
static const char entry_query[] =
    "SELECT p.uid, p.created_ns, p.dead_reason, "
    "da.name, a.part, a.driver, a.platform_version, db.name, b.part, b.driver, "
    "b.platform_version, w.name, w.dims, w.n, w.family, "
    "p.pair_id, p.workload_id, p.kernels, p.objective, p.share, p.median_ns, p.low_ns, p.high_ns, "
    "p.gain, p.gain_low, p.gain_high, p.verdict, p.missed_rate, p.false_rate, "
    "coalesce(p.true_pairs, -1), p.single_ns, p.best_share, p.best_mode, p.terms, p.origin, "
    "p.mode, p.level, p.variant_a, p.variant_b, "
    "s.id, s.state, s.strategy, s.options, script.body, s.tool_version, s.host, s.seed, s.resumed, "
    "(SELECT count(*) FROM trial WHERE session_id = s.id), "
    "(SELECT sum(launches) FROM trial WHERE session_id = s.id), "
    "s.load, s.timer_ns, s.started_ns, s.ended_ns "
    "FROM profile p JOIN pair ON pair.id = p.pair_id JOIN env a ON a.id = env_a "
    "JOIN device da ON da.id = a.device_id JOIN env b ON b.id = env_b "
    "JOIN device db ON db.id = b.device_id JOIN workload w ON w.id = p.workload_id "
    "LEFT JOIN session s ON s.id = p.session_id LEFT JOIN script ON script.key = s.script "
    "WHERE substr(p.uid, 1, length(?1)) = ?1 AND (p.live = 1 OR ?2) "
    "ORDER BY p.live DESC, p.pair_id, w.family, w.n, p.created_ns";

// Takes the columns one after the other.
typedef struct reader {
    const sql *q;
    int column;
} reader;

static const char *next_text(reader *r)
{
    return sql_get_text(r->q, r->column++);
}

static int64_t next_int(reader *r)
{
    return sql_get_int(r->q, r->column++);
}

static double next_real(reader *r)
{
    return sql_get_real(r->q, r->column++);
}

static void read_device(reader *r, profile_entry_device *d)
{
    d->name = next_text(r);
    d->part = next_text(r);
    d->driver = next_text(r);
    d->platform_version = next_text(r);
}

static void read_row(reader *r, profile_row *row)
{
    row->pair_id = next_int(r);
    row->workload_id = next_int(r);
    row->kernels = next_text(r);
    row->objective = next_text(r);
    row->plan.share = (uint32_t)next_int(r);
    row->median_ns = next_real(r);
    row->low_ns = next_real(r);
    row->high_ns = next_real(r);
    row->gain = next_real(r);
    row->gain_low = next_real(r);
    row->gain_high = next_real(r);
    row->verdict = next_text(r);
    row->missed_rate = next_real(r);
    row->false_rate = next_real(r);
    row->true_pairs = next_int(r);
    row->single_ns = next_real(r);
    row->best_share = (uint32_t)next_int(r);
    row->best_mode = next_text(r);
    row->terms = next_text(r);
    row->origin = next_text(r);
    sql_copy(row->plan.mode, sizeof row->plan.mode, next_text(r));
    sql_copy(row->plan.level, sizeof row->plan.level, next_text(r));
    sql_copy(row->plan.variant_a, sizeof row->plan.variant_a, next_text(r));
    sql_copy(row->plan.variant_b, sizeof row->plan.variant_b, next_text(r));
}

static void read_session(reader *r, profile_entry_session *session)
{
    session->id = next_text(r);
    session->state = next_text(r);
    session->strategy = next_text(r);
    session->options = next_text(r);
    session->script = next_text(r);
    session->tool_version = next_text(r);
    session->host = next_text(r);
    session->seed = next_int(r);
    session->resumed = next_int(r);
    session->trials = next_int(r);
    session->launches = next_int(r);
    session->load = next_real(r);
    session->timer_ns = next_real(r);
    session->started_ns = next_int(r);
    session->ended_ns = next_int(r);
}

static profile_entry read_entry(const sql *q)
{
    profile_entry entry = {0};
    reader r = {.q = q};
    entry.uid = next_text(&r);
    entry.created_ns = next_int(&r);
    entry.dead_reason = next_text(&r);
    read_device(&r, &entry.a);
    read_device(&r, &entry.b);
    entry.scene = next_text(&r);
    entry.dims = next_int(&r);
    entry.n = next_int(&r);
    entry.family = next_text(&r);
    read_row(&r, &entry.row);
    read_session(&r, &entry.session);
    return entry;
}

bool profile_entry_each(store *s, const char *uid, bool dead_too, profile_entry_visit *visit,
                        void *context, duet_error *err)
{
    sql q = sql_make(s, entry_query, err);
    sql_text(&q, uid ? uid : "");
    sql_int(&q, dead_too);
    bool more = true;
    while (more && sql_row(&q)) {
        profile_entry entry = read_entry(&q);
        more = visit(context, &entry);
    }
    return sql_close(&q);
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

static bool insert_cost(store *s, const profile_level_cost_key *key, const profile_level_cost *cost,
                        duet_error *err)
{
    sql q = sql_make(s,
                     "INSERT INTO level_cost (pair_id, workload_id, kernels, level, step_ns, "
                     "true_pairs, missed, invented, created_ns) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                     err);
    bind_cost_key(&q, key);
    sql_text(&q, cost->level);
    sql_real(&q, cost->step_ns);
    sql_int(&q, (int64_t)cost->true_pairs);
    sql_int(&q, (int64_t)cost->missed);
    sql_int(&q, (int64_t)cost->invented);
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
    sql q = sql_make(s,
                     "SELECT level, step_ns, true_pairs, missed, invented FROM level_cost "
                     "WHERE pair_id = ? AND workload_id = ? AND kernels = ? ORDER BY level",
                     err);
    bind_cost_key(&q, key);
    for (*n = 0; *n < PROFILE_LEVEL_COSTS && sql_row(&q); ++*n) {
        profile_level_cost *cost = &costs[*n];
        *cost = (profile_level_cost){.step_ns = sql_get_real(&q, 1),
                                     .true_pairs = (uint64_t)sql_get_int(&q, 2),
                                     .missed = (uint64_t)sql_get_int(&q, 3),
                                     .invented = (uint64_t)sql_get_int(&q, 4)};
        sql_copy(cost->level, sizeof cost->level, sql_get_text(&q, 0));
    }
    return sql_close(&q);
}
