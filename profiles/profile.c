// SPDX-License-Identifier: MIT
#include "profiles/profile.h"

#include "base/clock.h"
#include "profiles/sql.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define LIVE_OF_KEY                                                                         \
    "workload_id = ?1 AND pair_id = ?2 AND objective = ?3 AND kernels = ?4 AND level = ?5 " \
    "AND live = 1"

static void bind_key(sql *q, const profile_row *row)
{
    sql_int(q, row->workload_id);
    sql_int(q, row->pair_id);
    sql_text(q, row->objective);
    sql_text(q, row->kernels);
    sql_text(q, row->plan.level);
}

static bool retire_live(store *s, const profile_row *row, const char *reason, duet_error *err)
{
    sql q = sql_make(s, "UPDATE profile SET live = 0, dead_reason = ?6 WHERE " LIVE_OF_KEY, err);
    bind_key(&q, row);
    sql_text(&q, reason);
    return sql_run(&q);
}

static const sql_column row_columns[] = {
    SQL_COLUMN("pair_id", profile_row, pair_id),
    SQL_COLUMN("workload_id", profile_row, workload_id),
    SQL_COLUMN("kernels", profile_row, kernels),
    SQL_COLUMN("objective", profile_row, objective),
    SQL_PLAN_COLUMNS(profile_row, plan),
#define FIGURE(type, name) SQL_COLUMN(#name, profile_row, name),
#define WORD(name) SQL_COLUMN(#name, profile_row, name),
#define COUNT(name) SQL_COUNT_COLUMN(#name, profile_row, name),
#include "profiles/profile_figures.inl"
    SQL_COLUMN("terms", profile_row, terms),
    SQL_COLUMN("origin", profile_row, origin),
    SQL_COLUMN("session_id", profile_row, session),
    SQL_COUNT_COLUMN("trial", profile_row, trial_number),
    {0},
};

// The row as it is stored: NULL, by way of NaN, where nothing was raced.
static profile_row stored(const profile_row *row)
{
    profile_row r = *row;
    if (!(r.single_ns > 0))
        r.single_ns = NAN;
    if (!(r.whole_ns > 0))
        r.whole_ns = r.whole_gain = r.whole_gain_low = r.whole_gain_high = NAN;
    if (!r.best_mode) {
        r.best_mode = row->plan.mode;
        r.best_share = row->plan.share;
    }
    return r;
}

static bool insert(store *s, const profile_row *row, const profile_placed *placed, duet_error *err)
{
    sql q = sql_insert(s, "profile", row_columns, "uid, created_ns, live, dead_reason", "", err);
    bool live = !*placed->unused;
    profile_row r = stored(row);
    sql_bind(&q, row_columns, &r);
    sql_text(&q, placed->uid);
    sql_int(&q, clock_calendar_ns());
    sql_int(&q, live);
    sql_text(&q, live ? NULL : placed->unused);
    return sql_run(&q);
}

// ---------------------------------------------------------------- which one is live

// How sure a gain is.
typedef struct evidence {
    char uid[PROFILE_ID]; // empty: there is no such profile
    char verdict[16];
    double gain_low;
    double gain_high;
    uint32_t rounds;
    uint32_t watched; // launches
    uint32_t disturbed;
    double low_ns; // a step's
    double high_ns;
    bool asked_alike; // by the session of the row that is compared
} evidence;

static const sql_column evidence_columns[] = {
    SQL_COLUMN("uid", evidence, uid),
    SQL_COLUMN("verdict", evidence, verdict),
    SQL_COLUMN("gain_low", evidence, gain_low),
    SQL_COLUMN("gain_high", evidence, gain_high),
    SQL_COLUMN("rounds", evidence, rounds),
    SQL_COLUMN("watched", evidence, watched),
    SQL_COLUMN("disturbed", evidence, disturbed),
    SQL_COLUMN("low_ns", evidence, low_ns),
    SQL_COLUMN("high_ns", evidence, high_ns),
    SQL_COLUMN("coalesce((SELECT a.strategy = b.strategy AND a.options = b.options "
               "FROM session a JOIN session b WHERE a.id = session_id AND b.id = ?6), 1)",
               evidence, asked_alike),
    {0},
};

static bool find_live(store *s, const profile_row *row, evidence *live, duet_error *err)
{
    sql q = sql_select(s, evidence_columns, " FROM profile WHERE " LIVE_OF_KEY, err);
    bind_key(&q, row);
    sql_text(&q, row->session);
    *live = (evidence){0};
    if (sql_row(&q))
        sql_read(&q, 0, evidence_columns, live);
    return sql_close(&q);
}

// How far other programs can have falsified a plan and its times, which no interval shows.
typedef enum quietness {
    QUIETNESS_DISTURBED, // most launches were disturbed
    QUIETNESS_UNKNOWN,   // nobody looked
    QUIETNESS_QUIET
} quietness;

static quietness quietness_of(uint32_t watched, uint32_t disturbed)
{
    if (watched == 0)
        return QUIETNESS_UNKNOWN;
    return 2 * (uint64_t)disturbed > watched ? QUIETNESS_DISTURBED : QUIETNESS_QUIET;
}

// One device has no race: what is known of its step is as wide as the step's interval. The same
// search again says that the machine has changed.
static bool is_timed_as_well(const profile_row *row, const evidence *live)
{
    return strcmp(row->origin, "measured") != 0 || live->asked_alike || live->low_ns <= 0 ||
           row->high_ns * live->low_ns <= live->high_ns * row->low_ns;
}

// `same` replaces another verdict only with a narrower interval.
static bool is_trusted_as_well(const profile_row *row, const evidence *live)
{
    double width = (1 + row->gain_high) / (1 + row->gain_low);
    bool narrow = width <= (1 + live->gain_high) / (1 + live->gain_low);
    if (row->rounds == 0)
        return live->rounds == 0 && is_timed_as_well(row, live);
    if (strcmp(row->verdict, "same") == 0 && strcmp(live->verdict, "same") != 0)
        return narrow;
    return narrow || row->rounds >= live->rounds;
}

// A search with other options, as fewer kernels to choose from, may find a worse plan
// and be as sure of it. The same search again says that the machine has changed.
static bool is_worse(const profile_row *row, const evidence *live)
{
    return strcmp(row->origin, "measured") == 0 && !live->asked_alike &&
           row->low_ns > live->high_ns;
}

// Why a row does not take the live one's place; NULL: it does.
static const char *kept_because(const profile_row *row, const evidence *live)
{
    quietness own = quietness_of(row->watched, row->disturbed);
    quietness others = quietness_of(live->watched, live->disturbed);
    if (own != others)
        return own > others ? NULL : "was measured beside fewer other programs";
    if (!is_trusted_as_well(row, live))
        return "is better measured";
    return is_worse(row, live) ? "has the faster plan" : NULL;
}

static bool place(store *s, const profile_row *row, const char *unused, profile_placed *placed,
                  duet_error *err)
{
    evidence live;
    if (!find_live(s, row, &live, err))
        return false;
    if (!unused && strcmp(row->verdict, "ambiguous") == 0)
        unused = PROFILE_TOO_FEW_ROUNDS;
    const char *kept = *live.uid ? kept_because(row, &live) : NULL;
    if (unused)
        snprintf(placed->unused, sizeof placed->unused, "%s", unused);
    else if (kept)
        snprintf(placed->unused, sizeof placed->unused, "%.8s %s", live.uid, kept);
    return true;
}

bool profile_put(store *s, const profile_row *row, const char *unused, const char *reason,
                 profile_placed *placed, duet_error *err)
{
    profile_placed here = {0};
    if (row->terms && !sql_check_object("a profile's terms", row->terms, err))
        return false;
    if (!profile_new_id(here.uid, err) || !store_begin(s, err))
        return false;
    bool ok = place(s, row, unused, &here, err);
    ok = ok && (*here.unused || retire_live(s, row, reason, err));
    ok = store_end(s, ok && insert(s, row, &here, err), err);
    if (ok && placed)
        *placed = here;
    return ok;
}

bool profile_find(store *s, const char *uid, char whole[PROFILE_ID], duet_error *err)
{
    int64_t n = 0;
    sql q = sql_make(s, "SELECT uid FROM profile WHERE substr(uid, 1, length(?1)) = ?1", err);
    sql_text(&q, uid);
    for (; sql_row(&q); ++n)
        sql_copy(whole, PROFILE_ID, sql_get_text(&q, 0));
    if (!sql_close(&q))
        return false;
    if (n == 0)
        return bad_argument(
            err, "%s: no profile begins with '%s'; 'duet profiles list --dead' shows them", s->path,
            uid);
    return n == 1 || bad_argument(err, "%s: %" PRId64 " profiles begin with '%s'; give more digits",
                                  s->path, n, uid);
}

// The live profile of the same key gives way.
static bool make_room(store *s, const char *uid, duet_error *err)
{
#define KEY "pair_id, workload_id, kernels, objective, level"
    sql q = sql_make(s,
                     "UPDATE profile SET live = 0, dead_reason = ?1 WHERE live = 1 AND uid <> ?2 "
                     "AND (" KEY ") = (SELECT " KEY " FROM profile WHERE uid = ?2)",
                     err);
#undef KEY
    sql_text(&q, "another was put to use");
    sql_text(&q, uid);
    return sql_run(&q);
}

static bool check_trusted(store *s, const char *uid, duet_error *err)
{
    int64_t id = 0;
    if (!sql_find(s, "SELECT id FROM profile WHERE uid = ? AND verdict = 'ambiguous'", uid, &id,
                  err))
        return false;
    return id == 0 ||
           bad_argument(
               err, "%s: profile %.8s cannot be put to use: its verdict is ambiguous; tune again",
               s->path, uid);
}

static bool run_on(store *s, const char *statement, const char *uid, duet_error *err)
{
    sql q = sql_make(s, statement, err);
    sql_text(&q, uid);
    return sql_run(&q);
}

bool profile_use(store *s, const char *uid, duet_error *err)
{
    char whole[PROFILE_ID];
    if (!store_begin(s, err))
        return false;
    bool ok =
        profile_find(s, uid, whole, err) && check_trusted(s, whole, err) &&
        make_room(s, whole, err) &&
        run_on(s, "UPDATE profile SET live = 1, dead_reason = NULL WHERE uid = ?", whole, err) &&
        store_audit(s, "use", whole, err);
    return store_end(s, ok, err);
}

bool profile_forget(store *s, const char *uid, duet_error *err)
{
    char whole[PROFILE_ID];
    if (!*uid)
        return bad_argument(
            err, "%s: an empty name is no profile's; 'duet profiles list --dead' shows them",
            s->path);
    if (!store_begin(s, err))
        return false;
    bool ok = profile_find(s, uid, whole, err) &&
              run_on(s, "DELETE FROM profile WHERE uid = ?", whole, err) &&
              store_audit(s, "forget", whole, err);
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
