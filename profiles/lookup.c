// SPDX-License-Identifier: MIT
// The ladder: a table of rungs, tried from the best grade down.
#define _POSIX_C_SOURCE 200809L
#include "profiles/lookup.h"

#include "profiles/forecast.h"
#include "profiles/sql.h"

#include <math.h>
#include <string.h>
#include <time.h>

// A prediction that is less certain than this (one standard deviation of a
// step's time, relative) is no ground to divide the work on.
#define MOST_DOUBT 0.2

#define SIZE_SLACK 1.1 // a size that is a tenth outside of those measured is within them

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

// A request with its keys, on its way down.
typedef struct look {
    store *s;
    const profile_request *request;
    char env[2][PROFILE_SHA];
    char seat[2][PROFILE_SHA];
    char workload[PROFILE_SHA];
    int64_t pair_id; // 0 where these devices were never measured together
    text family;     // of the workload
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
    profile_env_key(&pair->a, l->env[0]);
    profile_env_key(&pair->b, l->env[1]);
    profile_env_seat(&pair->a, l->seat[0]);
    profile_env_seat(&pair->b, l->seat[1]);
    profile_workload_family(l->request->workload, &l->family);
    return profile_workload_key(l->request->workload, l->workload, l->err) &&
           text_ok(&l->family, l->err) && find_pair(l);
}

// ---------------------------------------------------------- rungs that are rows

#define ROW                                                                                        \
    "SELECT p.share, p.mode, p.level, p.variant_a, p.variant_b, p.median_ns, p.gain, p.gain_low, " \
    "p.gain_high, p.verdict, p.created_ns, coalesce(p.session_id, ''), p.origin, "                 \
    "coalesce((SELECT host FROM session WHERE id = p.session_id), ''), p.uid FROM profile p "      \
    "WHERE p.live = 1 AND p.workload_id = (SELECT id FROM workload WHERE key = ?1) "               \
    "AND p.objective = ?2 AND p.missed_rate <= ?3 AND p.false_rate <= ?4 "

#define SAME_SEATS                                                                         \
    "AND p.pair_id IN (SELECT pair.id FROM env a JOIN pair ON env_a = a.id JOIN env b ON " \
    "env_b = b.id WHERE a.seat = ?6 AND b.seat = ?7) ORDER BY p.created_ns DESC LIMIT 1"

static const char exact_query[] =
    ROW "AND p.kernels = ?5 AND p.pair_id = ?6 ORDER BY p.median_ns LIMIT 1";

static const char other_driver_query[] = ROW "AND p.kernels = ?5 " SAME_SEATS;

static const char stale_query[] = ROW "AND p.kernels <> ?5 " SAME_SEATS;

// An accuracy without limit is above every rate that is stored.
static double limit(double rate)
{
    return isfinite(rate) ? rate : 1e300;
}

static void take_row(look *l, const sql *q)
{
    profile_found *found = l->found;
    found->plan.share = (uint32_t)sql_get_int(q, 0);
    sql_copy(found->plan.mode, sizeof found->plan.mode, sql_get_text(q, 1));
    sql_copy(found->plan.level, sizeof found->plan.level, sql_get_text(q, 2));
    sql_copy(found->plan.variant_a, sizeof found->plan.variant_a, sql_get_text(q, 3));
    sql_copy(found->plan.variant_b, sizeof found->plan.variant_b, sql_get_text(q, 4));
    found->share_low = found->share_high = found->plan.share;
    found->median_ns = sql_get_real(q, 5);
    found->gain = sql_get_real(q, 6);
    found->gain_low = sql_get_real(q, 7);
    found->gain_high = sql_get_real(q, 8);
    sql_copy(found->verdict, sizeof found->verdict, sql_get_text(q, 9));
    found->created_ns = sql_get_int(q, 10);
    sql_copy(found->session, sizeof found->session, sql_get_text(q, 11));
    sql_copy(found->uid, sizeof found->uid, sql_get_text(q, 14));
}

static void tell_row(look *l, const sql *q)
{
    if (!l->why)
        return;
    char when[32] = "";
    time_t seconds = (time_t)(l->found->created_ns / 1000000000);
    struct tm parts;
    if (gmtime_r(&seconds, &parts))
        strftime(when, sizeof when, "%Y-%m-%d %H:%M UTC", &parts);
    const char *host = sql_get_text(q, 13);
    const char *where = strcmp(host, l->request->host) == 0 ? "this machine"
                        : *host                             ? "another machine with such devices"
                                                            : "an unknown machine";
    text_add(l->why, "yes: %s %s on %s%s%s", sql_get_text(q, 12), when, where,
             l->found->session[0] ? ", session " : "", l->found->session);
}

// A query on rows with what all of them ask for bound.
static sql ask_rows(look *l, const char *query)
{
    sql q = sql_make(l->s, query, l->err);
    sql_text(&q, l->workload);
    sql_text(&q, l->request->objective);
    sql_real(&q, limit(l->request->max_missed_rate));
    sql_real(&q, limit(l->request->max_false_rate));
    sql_text(&q, l->request->kernels);
    return q;
}

static bool close_row(look *l, sql *q, bool *held)
{
    *held = sql_row(q);
    if (*held) {
        take_row(l, q);
        tell_row(l, q);
    }
    return sql_close(q);
}

static bool find_by_seats(look *l, const char *query, bool *held)
{
    sql q = ask_rows(l, query);
    sql_text(&q, l->seat[0]);
    sql_text(&q, l->seat[1]);
    return close_row(l, &q, held);
}

static bool refuse(look *l, const char *reason)
{
    if (l->why)
        text_add(l->why, "no: %s", reason);
    return true;
}

// As many of the six as the query asks for.
static void bind_question(const look *l, sql *q)
{
    const char *const texts[] = {l->env[0],   l->env[1],           NULL,
                                 l->workload, l->request->kernels, l->request->objective};
    int n = sqlite3_bind_parameter_count(q->stmt);
    for (int i = 0; i < n; ++i) {
        if (texts[i])
            sql_text(q, texts[i]);
        else
            sql_int(q, l->pair_id);
    }
}

// Which of what an exact profile needs is not there.
static bool tell_what_is_missing(look *l)
{
#define LIVE "SELECT 1 FROM workload w JOIN profile p ON p.workload_id = w.id AND p.live = 1 "
    static const struct {
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
    return refuse(l, "what was measured misses or invents more pairs than allowed");
}

static bool look_exact(look *l, bool *held)
{
    if (l->pair_id != 0) {
        sql q = ask_rows(l, exact_query);
        sql_int(&q, l->pair_id);
        if (!close_row(l, &q, held))
            return false;
    }
    return *held || !l->why || tell_what_is_missing(l);
}

static bool look_other_driver(look *l, bool *held)
{
    return find_by_seats(l, other_driver_query, held) &&
           (*held || refuse(l, "nor under another version of a driver"));
}

static bool look_stale(look *l, bool *held)
{
    return find_by_seats(l, stale_query, held) && (*held || refuse(l, "nor with other kernels"));
}

// ---------------------------------------------------------- rungs that are fits

// Takes the forecast where it is certain enough.
static bool use_forecast(look *l, const forecast *f, bool *held)
{
    *held = f->doubt <= MOST_DOUBT;
    if (*held)
        forecast_take(f, l->found);
    if (l->why && *held)
        text_add(l->why,
                 "yes: %u times of %.0f to %.0f objects say %.4g ms +- %.1f %% by both at share "
                 "%.4f +- %.4f, %.4g ms by one",
                 f->points, f->n_min, f->n_max, f->both.ns * 1e-6, 100 * f->doubt, f->share,
                 f->share_sd, f->one.ns * 1e-6);
    else if (l->why)
        text_add(l->why, "no: what is known of %.0f to %.0f objects leaves %.0f %% of doubt",
                 f->n_min, f->n_max, 100 * f->doubt);
    return true;
}

// The plan of this pair's live profile whose size is the nearest from above or
// from below; n is 0 where there is none.
static bool nearest_plan(look *l, const char *query, profile_plan *plan, double *n)
{
    sql q = sql_make(l->s, query, l->err);
    sql_text(&q, text_chars(&l->family));
    sql_text(&q, l->request->objective);
    sql_real(&q, limit(l->request->max_missed_rate));
    sql_real(&q, limit(l->request->max_false_rate));
    sql_text(&q, l->request->kernels);
    sql_int(&q, l->pair_id);
    sql_int(&q, (int64_t)l->request->workload->n);
    *n = 0;
    if (sql_row(&q)) {
        *n = sql_get_real(&q, 0);
        sql_copy(plan->mode, sizeof plan->mode, sql_get_text(&q, 1));
        sql_copy(plan->level, sizeof plan->level, sql_get_text(&q, 2));
        sql_copy(plan->variant_a, sizeof plan->variant_a, sql_get_text(&q, 3));
        sql_copy(plan->variant_b, sizeof plan->variant_b, sql_get_text(&q, 4));
    }
    return sql_close(&q);
}

#define NEIGHBOUR                                                                                 \
    "SELECT w.n, p.mode, p.level, p.variant_a, p.variant_b FROM workload w CROSS JOIN profile p " \
    "ON p.workload_id = w.id WHERE w.family = ?1 AND p.live = 1 AND p.objective = ?2 "            \
    "AND p.missed_rate <= ?3 AND p.false_rate <= ?4 AND p.kernels = ?5 AND p.pair_id = ?6 "

static bool find_neighbour(look *l, profile_plan *plan, bool *found)
{
    profile_plan above = {0};
    double n = (double)l->request->workload->n;
    double n_above = 0;
    double n_below = 0;
    *found = false;
    if (l->pair_id == 0)
        return true;
    if (!nearest_plan(l, NEIGHBOUR "AND w.n >= ?7 ORDER BY w.n LIMIT 1", &above, &n_above) ||
        !nearest_plan(l, NEIGHBOUR "AND w.n < ?7 ORDER BY w.n DESC LIMIT 1", plan, &n_below))
        return false;
    if (n_above > 0 && (n_below <= 0 || n_above / n < n / n_below))
        *plan = above;
    *found = n_above > 0 || n_below > 0;
    return true;
}

static bool forecast_best_of(look *l, const profile_plan *plan, forecast *f, bool *found)
{
    forecast_ask ask = {
        .env_a = l->env[0],
        .env_b = l->env[1],
        .family = text_chars(&l->family),
        .kernels = l->request->kernels,
        .host = l->request->host,
        .n = (double)l->request->workload->n,
        .occupancy = l->request->workload->occ_mean,
        .plan = plan,
    };
    return forecast_best(l->s, &ask, f, found, l->err);
}

static bool look_interpolated(look *l, bool *held)
{
    profile_plan plan = {0};
    forecast f;
    bool found = false;
    if (!find_neighbour(l, &plan, &found))
        return false;
    if (!found)
        return refuse(l, "no like workload was measured on these two devices");
    if (!forecast_best_of(l, &plan, &f, &found))
        return false;
    if (!found)
        return refuse(l, "like workloads were measured, but too few shares to predict others");
    double n = (double)l->request->workload->n;
    if (n * SIZE_SLACK < f.n_min || n > f.n_max * SIZE_SLACK)
        return refuse(l, "the size is beyond those measured");
    return use_forecast(l, &f, held);
}

static bool look_transferred(look *l, bool *held)
{
    // Fits know times and not how many pairs were missed.
    if (isfinite(l->request->max_missed_rate) || isfinite(l->request->max_false_rate) ||
        strcmp(l->request->workload->level, "auto") == 0)
        return refuse(l, "accuracy is asked for, which times of other sizes say nothing about");
    forecast f;
    bool found = false;
    if (!forecast_best_of(l, NULL, &f, &found))
        return false;
    if (!found)
        return refuse(l, "one of the devices was never measured on a like workload");
    return use_forecast(l, &f, held);
}

// -------------------------------------------------------------------- the ladder

static const struct {
    profile_grade grade;
    bool (*look)(look *l, bool *held);
} rungs[] = {
    {PROFILE_EXACT, look_exact},
    {PROFILE_OTHER_DRIVER, look_other_driver},
    {PROFILE_INTERPOLATED, look_interpolated},
    {PROFILE_TRANSFERRED, look_transferred},
    {PROFILE_STALE, look_stale},
};

static bool climb_down(look *l)
{
    for (size_t i = 0; i < sizeof rungs / sizeof rungs[0]; ++i) {
        bool held = false;
        if (l->why)
            text_add(l->why, "  %-12s ", profile_grade_name(rungs[i].grade));
        if (!rungs[i].look(l, &held))
            return false;
        if (l->why)
            text_add(l->why, "\n");
        if (held) {
            l->found->grade = rungs[i].grade;
            return true;
        }
    }
    return true;
}

bool profile_lookup(store *s, const profile_request *request, profile_found *found, text *why,
                    duet_error *err)
{
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    look l = {.s = s, .request = request, .found = found, .why = why, .err = err};
    bool ok = prepare(&l) && climb_down(&l);
    if (!ok)
        *found = (profile_found){.grade = PROFILE_DEFAULT};
    text_free(&l.family);
    return ok && (!why || text_ok(why, err));
}
