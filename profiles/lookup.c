// SPDX-License-Identifier: MIT
// A table of grades, tried from the best down.
#define _POSIX_C_SOURCE 200809L
#include "profiles/lookup.h"

#include "profiles/fit.h"
#include "profiles/sql.h"

#include <math.h>
#include <string.h>
#include <time.h>

// A prediction that is less certain than this (one standard deviation of a
// step's time, relative) is no ground to divide the work on.
#define MOST_DOUBT 0.2

#define SIZE_SLACK 1.1   // a size within a tenth of one that was measured is next to it
#define CROWD_SLACK 1.25 // and so is a crowding within a quarter

const char *profile_grade_name(profile_grade grade)
{
    static const char *const names[] = {"exact",       "other driver", "interpolated",
                                        "transferred", "stale",        "default"};
    return names[grade];
}

profile_request profile_default_request(void)
{
    profile_request request = {
        .objective = "time",
        .max_missed_rate = INFINITY,
        .max_false_rate = INFINITY,
    };
    profile_host(request.host);
    return request;
}

// Of rows whose pair is one device twice, those that are looked for. Stores of earlier
// versions keep with them what two equal devices share.
typedef enum partnership {
    PARTNERS_NONE,  // of the device alone
    PARTNERS_EQUAL, // of it and another
    PARTNERS_OTHER, // there are none: the pair is two devices
} partnership;

// A request at one level, with its keys, on its way down.
typedef struct look {
    store *s;
    const profile_request *request;
    profile_workload at; // the request's, at that level
    char env[2][PROFILE_SHA];
    char seat[2][PROFILE_SHA];
    char workload[PROFILE_SHA];
    int64_t pair_id; // 0 where these devices were never measured together
    partnership partners;
    text family; // of the workload
    profile_found *found;
    text *why; // NULL: nobody asks
    duet_error *err;
} look;

static bool find_pair(look *l)
{
    sql q = sql_make(l->s,
                     "SELECT id FROM pair WHERE env_a = (SELECT id FROM env WHERE key = ?) "
                     "AND env_b = (SELECT id FROM env WHERE key = ?)",
                     l->err);
    sql_text(&q, l->env[0]);
    sql_text(&q, l->env[1]);
    l->pair_id = sql_row(&q) ? sql_get_int(&q, 0) : 0;
    return sql_close(&q);
}

static bool prepare(look *l)
{
    const profile_pair *pair = l->request->pair;
    profile_env_keys(&pair->a, l->env[0], l->seat[0]);
    profile_env_keys(&pair->b, l->env[1], l->seat[1]);
    if (l->partners != PARTNERS_EQUAL)
        l->partners = strcmp(l->env[0], l->env[1]) == 0 ? PARTNERS_NONE : PARTNERS_OTHER;
    return find_pair(l);
}

static bool turn_to_level(look *l, const char *level)
{
    l->at = *l->request->workload;
    l->at.level = level;
    text_free(&l->family);
    profile_workload_family(&l->at, &l->family);
    return profile_workload_key(&l->at, l->workload, l->err) && text_ok(&l->family, l->err);
}

// ---------------------------------------------------------- grades that are rows

static const sql_column found_columns[] = {
    SQL_COLUMN("p.share", profile_found, plan.share),
    SQL_COLUMN("p.mode", profile_found, plan.mode),
    SQL_COLUMN("p.level", profile_found, plan.level),
    SQL_COLUMN("p.variant_a", profile_found, plan.variant_a),
    SQL_COLUMN("p.variant_b", profile_found, plan.variant_b),
    SQL_COLUMN("p.share", profile_found, share_low),
    SQL_COLUMN("p.share", profile_found, share_high),
    SQL_COLUMN("p.median_ns", profile_found, median_ns),
    SQL_COLUMN("p.low_ns", profile_found, low_ns),
    SQL_COLUMN("p.high_ns", profile_found, high_ns),
    SQL_COLUMN("p.single_ns", profile_found, single_ns),
    SQL_COLUMN("p.gain", profile_found, gain),
    SQL_COLUMN("p.gain_low", profile_found, gain_low),
    SQL_COLUMN("p.gain_high", profile_found, gain_high),
    SQL_COLUMN("p.verdict", profile_found, verdict),
    SQL_COLUMN("p.rounds", profile_found, rounds),
    SQL_COLUMN("coalesce(p.best_share, p.share)", profile_found, best_share),
    SQL_COLUMN("coalesce(p.best_mode, p.mode)", profile_found, best_mode),
    SQL_COLUMN("p.terms", profile_found, terms),
    SQL_COLUMN("p.whole_ns", profile_found, whole_ns),
    SQL_COLUMN("p.whole_gain", profile_found, whole_gain),
    SQL_COLUMN("p.whole_gain_low", profile_found, whole_gain_low),
    SQL_COLUMN("p.whole_gain_high", profile_found, whole_gain_high),
    SQL_COLUMN("p.missed_rate", profile_found, missed_rate),
    SQL_COLUMN("p.false_rate", profile_found, false_rate),
    SQL_COLUMN("coalesce(p.true_pairs, -1)", profile_found, true_pairs),
    SQL_COLUMN("p.created_ns", profile_found, created_ns),
    SQL_COLUMN("p.session_id", profile_found, session),
    SQL_COLUMN("p.uid", profile_found, uid),
    SQL_COLUMN("p.dead_reason", profile_found, unused),
    {0},
};

// Rates that nobody measured are above every limit; certified has none.
#define WITHIN(rate, most)                                                                  \
    "(" most " > 1e299 OR ((p.true_pairs IS NOT NULL OR p.level = 'certified') AND p." rate \
    " <= " most "))"
#define ACCURATE "AND " WITHIN("missed_rate", "?3") " AND " WITHIN("false_rate", "?4") " "

// Whether the row is of two devices: its search divided the work, or found that best. With one
// device no search does. Trials may be gone, and rows without a search have none.
#define DIVIDED                                                                      \
    "(coalesce(p.best_share, p.share) BETWEEN 1 AND 65535 OR EXISTS (SELECT 1 FROM " \
    "trial WHERE session_id = p.session_id AND share BETWEEN 1 AND 65535))"
#define PARTNERS "AND " DIVIDED " = ?6 "
_Static_assert(PARTNERS_NONE == 0 && PARTNERS_EQUAL == 1 && PARTNERS_OTHER == 2,
               "the queries' numbers");

#define OF_WORKLOAD "profile p WHERE p.workload_id = (SELECT id FROM workload WHERE key = ?1) "

#define SAME_SEATS                                                                         \
    "AND p.pair_id IN (SELECT pair.id FROM env a JOIN pair ON env_a = a.id JOIN env b ON " \
    "env_b = b.id WHERE a.seat = ?7 AND b.seat = ?8) ORDER BY p.created_ns DESC LIMIT 1"

// Where a query looks, and which of the rows there it takes.
typedef struct rows_query {
    const char *of;
    const char *which;
} rows_query;

static const rows_query exact_query = {
    OF_WORKLOAD, "AND p.kernels = ?5 AND p.pair_id = ?7 ORDER BY p.median_ns LIMIT 1"};

static const rows_query other_driver_query = {OF_WORKLOAD, "AND p.kernels = ?5 " SAME_SEATS};

static const rows_query stale_query = {OF_WORKLOAD, "AND p.kernels <> ?5 " SAME_SEATS};

// An accuracy without limit is above every rate that is stored.
static double limit(double rate)
{
    return isfinite(rate) ? rate : 1e300;
}

// Where the profile that was found comes from, if anybody asks.
static bool tell_origin(look *l, int64_t id)
{
    if (!l->why)
        return true;
    char when[32] = "";
    time_t seconds = (time_t)(l->found->created_ns / 1000000000);
    struct tm parts;
    if (gmtime_r(&seconds, &parts))
        strftime(when, sizeof when, "%Y-%m-%d %H:%M UTC", &parts);
    sql q = sql_make(l->s,
                     "SELECT p.origin, coalesce(s.host, '') FROM profile p "
                     "LEFT JOIN session s ON s.id = p.session_id WHERE p.id = ?",
                     l->err);
    sql_int(&q, id);
    if (sql_row(&q)) {
        const char *host = sql_get_text(&q, 1);
        const char *where = strcmp(host, l->request->host) == 0 ? "this machine"
                            : *host ? "another machine with such devices"
                                    : "an unknown machine";
        text_add(l->why, "yes: %s %s on %s%s%s", sql_get_text(&q, 0), when, where,
                 l->found->session[0] ? ", session " : "", l->found->session);
    }
    return sql_close(&q);
}

// For the ids of rows, with what all queries ask for bound; `key` is of the workload, or of its
// family. Only what limits the rows is in the statement, and the columns are read by another
// where there is a row: an application's start pays for each word of SQL that is compiled.
static sql ask_rows(look *l, const rows_query *query, const char *key)
{
    double missed = limit(l->request->max_missed_rate), added = limit(l->request->max_false_rate);
    text statement = {0};
    text_add(&statement, "SELECT p.id FROM %s%s%sAND p.objective = ?2 AND p.live = 1 %s", query->of,
             missed < 1e299 || added < 1e299 ? ACCURATE : "",
             l->partners == PARTNERS_OTHER ? "" : PARTNERS, query->which);
    sql q = sql_make_text(l->s, &statement, l->err);
    sql_text(&q, key);
    sql_text(&q, l->request->objective);
    sql_real(&q, missed);
    sql_real(&q, added);
    sql_text(&q, l->request->kernels);
    sql_int(&q, l->partners);
    return q;
}

// The first id; 0 where there is none.
static bool close_rows(sql *q, int64_t *id)
{
    *id = sql_row(q) ? sql_get_int(q, 0) : 0;
    return sql_close(q);
}

static bool take_row(look *l, int64_t id, bool *held)
{
    *held = id != 0;
    if (!*held)
        return true;
    sql q = sql_select(l->s, found_columns, " FROM profile p WHERE p.id = ?", l->err);
    sql_int(&q, id);
    *l->found = (profile_found){0};
    if (sql_row(&q))
        sql_read(&q, 0, found_columns, l->found);
    return sql_close(&q) && tell_origin(l, id);
}

static bool find_by_seats(look *l, const rows_query *query, bool *held)
{
    int64_t id;
    sql q = ask_rows(l, query, l->workload);
    sql_text(&q, l->seat[0]);
    sql_text(&q, l->seat[1]);
    return close_rows(&q, &id) && take_row(l, id, held);
}

static bool refuse(look *l, const char *reason)
{
    text_add(l->why, "no: %s", reason);
    return true;
}

// As many of the seven as the query asks for.
static void bind_question(const look *l, sql *q)
{
    const char *const texts[] = {l->env[0],   l->env[1],           NULL,
                                 l->workload, l->request->kernels, l->request->objective};
    int n = sqlite3_bind_parameter_count(q->stmt);
    for (int i = 0; i < n; ++i) {
        if (i < 6 && texts[i])
            sql_text(q, texts[i]);
        else
            sql_int(q, i < 6 ? l->pair_id : l->partners);
    }
}

// Of profiles for just this: by the workload, the pair, the kernels and the objective.
static sql ask_exact(look *l, const char *query)
{
    sql q = sql_make(l->s, query, l->err);
    sql_text(&q, l->workload);
    sql_int(&q, l->pair_id);
    sql_text(&q, l->request->kernels);
    sql_text(&q, l->request->objective);
    return q;
}

// What the profile that is there gets wrong.
static bool tell_inaccuracy(look *l)
{
    sql q = ask_exact(l, "SELECT p.missed_rate, p.false_rate, coalesce(p.true_pairs, -1) "
                         "FROM workload w JOIN profile p ON p.workload_id = w.id AND p.live = 1 "
                         "WHERE w.key = ? AND p.pair_id = ? AND p.kernels = ? AND p.objective = ?");
    if (sql_row(&q) && sql_get_int(&q, 2) < 0)
        refuse(l, "how many pairs it misses, or adds falsely, was not measured");
    else
        text_add(
            l->why,
            "no: for each true pair it misses %.3g and adds %.3g false ones, above %.3g or %.3g",
            sql_get_real(&q, 0), sql_get_real(&q, 1), l->request->max_missed_rate,
            l->request->max_false_rate);
    return sql_close(&q);
}

// Why the last profile that was measured for just this is not used.
static bool tell_unused(look *l, bool *told)
{
    sql q =
        ask_exact(l, "SELECT p.uid, p.dead_reason FROM workload w "
                     "JOIN profile p ON p.workload_id = w.id WHERE w.key = ?1 AND p.pair_id = ?2 "
                     "AND p.kernels = ?3 AND p.objective = ?4 AND NOT EXISTS (SELECT 1 FROM "
                     "profile WHERE workload_id = w.id AND pair_id = ?2 AND kernels = ?3 AND "
                     "live = 1) ORDER BY p.created_ns DESC LIMIT 1");
    *told = sql_row(&q);
    if (*told)
        text_add(l->why, "no: it was measured, but profile %.8s is not used: %s",
                 sql_get_text(&q, 0), sql_get_text(&q, 1));
    return sql_close(&q);
}

// Which of what an exact profile needs is not there.
static bool tell_what_is_missing(look *l)
{
    bool told;
    if (!tell_unused(l, &told) || told)
        return told;
#define LIVE "SELECT 1 FROM workload w JOIN profile p ON p.workload_id = w.id AND p.live = 1 "
    const struct {
        const char *query;
        const char *missing;
    } steps[] = {
        {"SELECT 1 FROM env WHERE key = ?1", "device A was never measured with this driver"},
        {"SELECT 1 FROM env WHERE key = ?2", "device B was never measured with this driver"},
        {"SELECT 1 WHERE ?3 <> 0", "these two devices were never measured together"},
        {"SELECT 1 FROM workload WHERE key = ?4", "no such workload was ever measured"},
        {LIVE "WHERE w.key = ?4 AND p.pair_id = ?3",
         "this workload was never measured on these two devices"},
        {LIVE "WHERE w.key = ?4 AND p.pair_id = ?3 AND p.kernels = ?5",
         "the kernels changed since it was measured"},
        {LIVE "WHERE w.key = ?4 AND p.pair_id = ?3 AND p.kernels = ?5 AND p.objective = ?6",
         "it was measured for another objective"},
        {LIVE "WHERE w.key = ?4 AND p.pair_id = ?3 AND p.kernels = ?5 AND p.objective = ?6 "
              "AND (?7 = 2 OR " DIVIDED " = ?7)",
         l->partners == PARTNERS_NONE ? "it was measured on two such devices"
                                      : "it was measured on one such device alone"},
    };
#undef LIVE
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; ++i) {
        sql q = sql_make(l->s, steps[i].query, l->err);
        bind_question(l, &q);
        bool there = sql_row(&q);
        if (!sql_close(&q))
            return false;
        if (!there)
            return refuse(l, steps[i].missing);
    }
    return tell_inaccuracy(l);
}

static bool look_exact(look *l, bool *held)
{
    if (l->pair_id != 0) {
        int64_t id;
        sql q = ask_rows(l, &exact_query, l->workload);
        sql_int(&q, l->pair_id);
        if (!close_rows(&q, &id) || !take_row(l, id, held))
            return false;
    }
    return *held || !l->why || tell_what_is_missing(l);
}

static bool look_other_driver(look *l, bool *held)
{
    return find_by_seats(l, &other_driver_query, held) &&
           (*held || refuse(l, "nor under another version of a driver"));
}

static bool look_stale(look *l, bool *held)
{
    return find_by_seats(l, &stale_query, held) && (*held || refuse(l, "nor with other kernels"));
}

// ---------------------------------------------------------- grades that are fits

// Takes the forecast where it is certain enough.
static bool use_forecast(look *l, const forecast *f, bool *held)
{
    *held = f->doubt <= MOST_DOUBT;
    if (!*held) {
        text_add(l->why,
                 "no: from what was measured of %.0f to %.0f objects a step's time is known "
                 "only to within %.0f %%",
                 f->n_min, f->n_max, 100 * f->doubt);
        return true;
    }
    forecast_take(f, l->found);
    text_add(l->why,
             "yes: %u times of %.0f to %.0f objects say %.4g ms +- %.1f %% by both at share "
             "%.4f +- %.4f, %.4g ms by one",
             f->points, f->n_min, f->n_max, f->both.ns * 1e-6, 100 * f->doubt, f->share,
             f->share_sd, f->one.ns * 1e-6);
    return true;
}

// A live profile of this pair for a workload of another size.
typedef struct neighbour {
    double n; // 0: there is none
    double occupancy;
    profile_found found;
} neighbour;

// CROSS: by the family first, which has few sizes.
#define OF_FAMILY "workload w CROSS JOIN profile p ON p.workload_id = w.id WHERE w.family = ?1 "
#define SAME_PAIR "AND p.kernels = ?5 AND p.pair_id = ?7 "

static bool read_neighbour(look *l, int64_t id, neighbour *near)
{
    *near = (neighbour){0};
    if (id == 0)
        return true;
    sql q = sql_select(l->s, found_columns,
                       ", w.n, w.occ_mean FROM profile p JOIN workload w ON w.id = p.workload_id "
                       "WHERE p.id = ?",
                       l->err);
    sql_int(&q, id);
    if (sql_row(&q)) {
        int rest = sql_read(&q, 0, found_columns, &near->found);
        near->n = sql_get_real(&q, rest);
        near->occupancy = sql_get_real(&q, rest + 1);
    }
    return sql_close(&q);
}

static bool find_one(look *l, const char *which, neighbour *near)
{
    int64_t id;
    const rows_query query = {OF_FAMILY, which};
    sql q = ask_rows(l, &query, text_chars(&l->family));
    sql_int(&q, l->pair_id);
    sql_int(&q, (int64_t)l->at.n);
    return close_rows(&q, &id) && read_neighbour(l, id, near);
}

// The nearest sizes below and above; the nearer of them, by ratio, comes first.
static bool find_neighbours(look *l, neighbour near[2])
{
    double n = (double)l->at.n;
    near[0] = near[1] = (neighbour){0};
    if (l->pair_id == 0)
        return true;
    if (!find_one(l, SAME_PAIR "AND w.n < ?8 ORDER BY w.n DESC LIMIT 1", &near[0]) ||
        !find_one(l, SAME_PAIR "AND w.n >= ?8 ORDER BY w.n LIMIT 1", &near[1]))
        return false;
    if (near[1].n > 0 && (near[0].n <= 0 || near[1].n / n < n / near[0].n)) {
        neighbour below = near[0];
        near[0] = near[1];
        near[1] = below;
    }
    return true;
}

static bool is_about(double a, double b, double slack)
{
    return a <= b * slack && b <= a * slack;
}

// A time of so many objects, on the line through both neighbours', or in proportion to the only
// one.
static double time_between(const neighbour near[2], double n, double ns, double other_ns)
{
    if (near[1].n <= 0 || !(ns > 0 && other_ns > 0))
        return ns * n / near[0].n;
    return ns + (other_ns - ns) * (n - near[0].n) / (near[1].n - near[0].n);
}

// The nearer neighbour's plan, and the times of both for so many objects.
static void take_neighbour(look *l, const neighbour near[2])
{
    profile_found *found = l->found;
    const profile_found *other = &near[1].found;
    double n = (double)l->at.n;
    *found = near[0].found;
    found->median_ns = time_between(near, n, found->median_ns, other->median_ns);
    found->low_ns = time_between(near, n, found->low_ns, other->low_ns);
    found->high_ns = time_between(near, n, found->high_ns, other->high_ns);
    found->single_ns = time_between(near, n, found->single_ns, other->single_ns);
    found->whole_ns = time_between(near, n, found->whole_ns, other->whole_ns);
    found->share_low = (uint32_t)(found->plan.share / SIZE_SLACK);
    found->share_high = (uint32_t)fmin(found->plan.share * SIZE_SLACK, PROFILE_SHARE_ONE);
}

// What was measured for almost such a workload is better than what fits say.
static bool use_neighbour(look *l, const neighbour near[2])
{
    const profile_found *found = &near[0].found;
    take_neighbour(l, near);
    text_add(l->why, "yes: %.0f objects were measured, which is next to it%s%s", near[0].n,
             found->session[0] ? ", session " : "", found->session);
    return true;
}

static bool forecast_best_of(look *l, const profile_plan *plan, double slack, forecast *f,
                             bool *found)
{
    *found = false;
    if (l->partners == PARTNERS_NONE) // one device shares with none
        return true;
    forecast_ask ask = {
        .env_a = l->env[0],
        .env_b = l->env[1],
        .family = text_chars(&l->family),
        .kernels = l->request->kernels,
        .host = l->request->host,
        .n = (double)l->at.n,
        .occupancy = l->at.occ_mean,
        .plan = plan,
        .slack = slack,
    };
    return forecast_best(l->s, &ask, f, found, l->err);
}

// Fits know times and not how many pairs were missed; certified misses none.
static bool is_accurate_anywhere(const look *l)
{
    bool asked = isfinite(l->request->max_missed_rate) || isfinite(l->request->max_false_rate);
    return !asked || strcmp(l->at.level, "certified") == 0;
}

// By the plan of the nearer neighbour, or of the other, or else by any, of those
// that were measured at sizes around this one. Where one device did it all, a plan
// says nothing of how they would share.
static bool forecast_between(look *l, const neighbour near[2], forecast *f, bool *found)
{
    *found = false;
    for (int i = 0; i < 2 && !*found; ++i) {
        const profile_plan *plan = &near[i].found.plan;
        bool shared = near[i].n > 0 && plan->share > 0 && plan->share < PROFILE_SHARE_ONE;
        if (shared && !forecast_best_of(l, plan, SIZE_SLACK, f, found))
            return false;
    }
    return *found || forecast_best_of(l, NULL, SIZE_SLACK, f, found);
}

// Whether one device did it all at both sizes, by the same kernels. There may be no fits
// that say how two would share, as where both are one device.
static bool is_alone_at_both(const neighbour near[2])
{
    const profile_plan *a = &near[0].found.plan, *b = &near[1].found.plan;
    return near[0].n > 0 && near[1].n > 0 && a->share == b->share &&
           (a->share == 0 || a->share == PROFILE_SHARE_ONE) &&
           strcmp(a->variant_a, b->variant_a) == 0 && strcmp(a->variant_b, b->variant_b) == 0;
}

static bool use_both(look *l, const neighbour near[2], bool *held)
{
    *held = true;
    take_neighbour(l, near);
    text_add(l->why, "yes: one device did it best at %.0f and at %.0f objects, alike",
             fmin(near[0].n, near[1].n), fmax(near[0].n, near[1].n));
    return true;
}

// Why none of the plans that were measured does.
static bool tell_gap(look *l, const neighbour near[2])
{
    double n = (double)l->at.n;
    if (near[0].n > 0 && near[1].n > 0)
        text_add(l->why,
                 "no: no plan was measured both at %.0f objects or fewer and at %.0f or more",
                 fmin(near[0].n, near[1].n), fmax(near[0].n, near[1].n));
    else
        text_add(l->why, "no: the size is %s those measured, the nearest of which is %.0f",
                 near[0].n < n ? "above" : "below", near[0].n);
    return true;
}

static bool look_interpolated(look *l, bool *held)
{
    neighbour near[2];
    forecast f;
    bool found = false;
    if (!find_neighbours(l, near))
        return false;
    if (near[0].n <= 0)
        return refuse(l, "no like workload was measured on these two devices");
    *held = is_about(near[0].n, (double)l->at.n, SIZE_SLACK) &&
            is_about(near[0].occupancy, l->at.occ_mean, CROWD_SLACK);
    if (*held)
        return use_neighbour(l, near);
    if (!is_accurate_anywhere(l))
        return refuse(l, "accuracy is asked for, which times of other sizes say nothing about");
    if (!forecast_between(l, near, &f, &found))
        return false;
    if (found)
        return use_forecast(l, &f, held);
    return is_alone_at_both(near) ? use_both(l, near, held) : tell_gap(l, near);
}

static bool look_transferred(look *l, bool *held)
{
    if (!is_accurate_anywhere(l))
        return refuse(l, "accuracy is asked for, which times of other sizes say nothing about");
    forecast f;
    bool found = false;
    if (!forecast_best_of(l, NULL, 0, &f, &found))
        return false;
    if (!found)
        return refuse(l, l->partners == PARTNERS_NONE
                             ? "one device alone has no other to share with"
                             : "one of the devices was never measured on a like workload");
    return use_forecast(l, &f, held);
}

// -------------------------------------------------------------------- the grades

static const struct {
    profile_grade grade;
    bool (*look)(look *l, bool *held);
} grades[] = {
    {PROFILE_EXACT, look_exact},
    {PROFILE_OTHER_DRIVER, look_other_driver},
    {PROFILE_INTERPOLATED, look_interpolated},
    {PROFILE_TRANSFERRED, look_transferred},
    {PROFILE_STALE, look_stale},
};

static bool try_grades(look *l)
{
    for (size_t i = 0; i < sizeof grades / sizeof grades[0]; ++i) {
        bool held = false;
        text_add(l->why, "  %-12s ", profile_grade_name(grades[i].grade));
        if (!grades[i].look(l, &held))
            return false;
        text_add(l->why, "\n");
        if (held) {
            l->found->grade = grades[i].grade;
            return true;
        }
    }
    return true;
}

static bool is_better(const profile_found *a, const profile_found *b)
{
    return a->grade != b->grade ? a->grade < b->grade
                                : a->grade != PROFILE_DEFAULT && a->median_ns < b->median_ns;
}

// Whether any workload like this was measured at this level.
static bool is_measured(look *l, bool *measured)
{
    sql q = sql_make(l->s,
                     "SELECT 1 FROM workload w JOIN profile p ON p.workload_id = w.id "
                     "WHERE w.family = ? AND p.live = 1 LIMIT 1",
                     l->err);
    sql_text(&q, text_chars(&l->family));
    *measured = sql_row(&q);
    return sql_close(&q);
}

// The best that any of the levels has.
static bool try_levels(look *l, profile_found *best)
{
    const profile_request *request = l->request;
    for (uint32_t i = 0; i < request->n_levels; ++i) {
        profile_found found = {.grade = PROFILE_DEFAULT};
        bool measured = false;
        l->found = &found;
        if (!turn_to_level(l, request->levels[i]) || !is_measured(l, &measured))
            return false;
        text_add(l->why, " level %s%s\n", request->levels[i],
                 measured ? "" : ": no like workload was measured at it");
        if (measured && !try_grades(l))
            return false;
        if (is_better(&found, best))
            *best = found;
    }
    return true;
}

// As the request's pair is, or as two equal devices were in earlier versions.
static bool look_for(store *s, const profile_request *request, bool as_two_equal,
                     profile_found *found, text *why, duet_error *err)
{
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    look l = {.s = s, .request = request, .found = found, .why = why, .err = err};
    l.partners = as_two_equal ? PARTNERS_EQUAL : PARTNERS_NONE;
    bool ok = prepare(&l);
    if (ok && request->n_levels > 0)
        ok = try_levels(&l, found);
    else if (ok)
        ok = turn_to_level(&l, request->workload->level) && try_grades(&l);
    if (!ok)
        *found = (profile_found){.grade = PROFILE_DEFAULT};
    text_free(&l.family);
    return ok && (!why || text_ok(why, err));
}

static bool look_for_alike(store *s, const profile_request *request, profile_found *best, text *why,
                           duet_error *err)
{
    profile_pair twice = *request->pair;
    profile_request earlier = *request;
    profile_found found;
    text told = {0};
    twice.b = twice.a;
    twice.alike = false;
    earlier.pair = &twice;
    bool ok = look_for(s, &earlier, true, &found, why ? &told : NULL, err);
    if (ok && is_better(&found, best)) {
        *best = found;
        text_add(why, " by an earlier version, for two such devices\n%s", text_chars(&told));
    }
    text_free(&told);
    return ok && (!why || text_ok(why, err));
}

bool profile_lookup(store *s, const profile_request *request, profile_found *found, text *why,
                    duet_error *err)
{
    return look_for(s, request, false, found, why, err) &&
           (!request->pair->alike || found->grade == PROFILE_EXACT ||
            look_for_alike(s, request, found, why, err));
}

bool profile_read(store *s, const char *uid, profile_found *found, duet_error *err)
{
    sql q = sql_select(s, found_columns, " FROM profile p WHERE p.uid = ?", err);
    sql_text(&q, uid);
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    if (sql_row(&q)) {
        sql_read(&q, 0, found_columns, found);
        found->grade = PROFILE_EXACT;
    }
    return sql_close(&q);
}

// ---------------------------------------------------------------------- two files

static bool look_once(const char *path, const profile_request *request, profile_found *found,
                      text *why, bool *disturbed, duet_error *err)
{
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    store *s = store_open_look(path, err);
    bool ok = s && profile_lookup(s, request, found, why, err);
    *disturbed = s && !store_undisturbed(s);
    store_close(s);
    return ok;
}

// A writer that came in between may have shown half of its work, so the look
// is taken again; then it is seen to write, and read in step with it.
static bool look_in_file(const char *path, const profile_request *request, profile_found *found,
                         text *why, duet_error *err)
{
    enum { MAX_LOOKS = 3 };
    for (int i = 0;; ++i) {
        text told = {0};
        duet_error failure = {0};
        bool disturbed = false;
        bool ok = look_once(path, request, found, why ? &told : NULL, &disturbed, &failure);
        bool final = !disturbed || i == MAX_LOOKS;
        if (final && !ok)
            error_copy(err, &failure);
        if (final && why)
            text_add(why, "%s%s%s", ok ? path : failure.text, ok ? ":\n" : "\n", text_chars(&told));
        text_free(&told);
        if (final)
            return ok;
    }
}

bool profile_lookup_files(const char *user_path, const char *system_path,
                          const profile_request *request, profile_found *found, text *why,
                          duet_error *err)
{
    const char *paths[] = {user_path, system_path};
    bool ok = true;
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    for (int i = 0; i < 2 && found->grade != PROFILE_EXACT; ++i) {
        profile_found here;
        duet_error failure = {0};
        if (!paths[i])
            continue;
        if (!look_in_file(paths[i], request, &here, why, &failure) &&
            failure.status != DUET_STATUS_NOT_FOUND)
            ok = error_copy(err, &failure);
        if (here.grade < found->grade)
            *found = here;
    }
    return ok && (!why || text_ok(why, err));
}
