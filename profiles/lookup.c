// SPDX-License-Identifier: MIT
// A table of grades, tried from the best down.
#define _POSIX_C_SOURCE 200809L
#include "profiles/lookup.h"

#include "profiles/fit.h"
#include "profiles/neighbour.h"
#include "profiles/sql.h"

#include <math.h>
#include <string.h>
#include <time.h>

// A forecast that is less certain than this (one standard deviation of a
// step's time, relative) is no ground for a plan.
#define MOST_DOUBT 0.2

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

// Live profiles of the pair for other workloads of the family.
typedef struct neighbours {
    double at[NEIGHBOUR_QUANTITIES]; // the workload asked for
    neighbour below;                 // the nearest sizes of scenes that are alike
    neighbour above;
    neighbour nearest; // of the scenes up to these, alike or not
} neighbours;

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
    text family;     // of the workload
    neighbours near; // from the grade "interpolated" on
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
    SQL_COLUMN("p.watched", profile_found, watched),
    SQL_COLUMN("p.disturbed", profile_found, disturbed),
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
    const char *columns; // beside the id
    const char *of;
    const char *which;
} rows_query;

static const rows_query exact_query = {
    "", OF_WORKLOAD, "AND p.kernels = ?5 AND p.pair_id = ?7 ORDER BY p.median_ns LIMIT 1"};

static const rows_query other_driver_query = {"", OF_WORKLOAD, "AND p.kernels = ?5 " SAME_SEATS};

static const rows_query stale_query = {"", OF_WORKLOAD, "AND p.kernels <> ?5 " SAME_SEATS};

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
    text_add(&statement, "SELECT p.id%s FROM %s%s%sAND p.objective = ?2 AND p.live = 1 %s",
             query->columns, query->of, missed < 1e299 || added < 1e299 ? ACCURATE : "",
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

// ---------------------------------------------------------- grades of neighbours

// CROSS: by the family first, which has few sizes.
#define OF_FAMILY "workload w CROSS JOIN profile p ON p.workload_id = w.id WHERE w.family = ?1 "
#define SAME_PAIR "AND p.kernels = ?5 AND p.pair_id = ?7 "
#define QUANTITIES ", w.n, w.occ_mean, w.occ_p99, w.size_ratio, iif(w.dims = 3, cells_z, cells_y)"
_Static_assert(NEIGHBOUR_OBJECTS == 0 && NEIGHBOUR_OCCUPANCY == 1 && NEIGHBOUR_CROWDING == 2 &&
                   NEIGHBOUR_SIZES == 3 && NEIGHBOUR_LAYERS == 4,
               "the order of the columns");

static const rows_query below_query = {QUANTITIES, OF_FAMILY,
                                       SAME_PAIR "AND w.n < ?8 ORDER BY w.n DESC"};
static const rows_query above_query = {QUANTITIES, OF_FAMILY,
                                       SAME_PAIR "AND w.n >= ?8 ORDER BY w.n"};

static bool read_neighbour(look *l, int64_t id, neighbour *near)
{
    sql q = sql_select(l->s, found_columns, " FROM profile p WHERE p.id = ?", l->err);
    sql_int(&q, id);
    if (sql_row(&q))
        sql_read(&q, 0, found_columns, &near->found);
    return sql_close(&q);
}

// From the workload's size outwards, up to the first scene that is alike.
static bool look_outwards(look *l, const rows_query *query, neighbour *alike)
{
    neighbours *all = &l->near;
    int64_t nearest_id = 0, alike_id = 0;
    sql q = ask_rows(l, query, text_chars(&l->family));
    sql_int(&q, l->pair_id);
    sql_int(&q, (int64_t)l->at.n);
    while (alike_id == 0 && sql_row(&q)) {
        neighbour near = {0};
        for (int i = 0; i < NEIGHBOUR_QUANTITIES; ++i)
            near.quantities[i] = sql_get_real(&q, 1 + i);
        if (!neighbour_is_there(&all->nearest) ||
            neighbour_apart(near.quantities, all->at, NULL) <
                neighbour_apart(all->nearest.quantities, all->at, NULL)) {
            all->nearest = near;
            nearest_id = sql_get_int(&q, 0);
        }
        if (neighbour_is_alike(near.quantities, all->at)) {
            *alike = near;
            alike_id = sql_get_int(&q, 0);
        }
    }
    return sql_close(&q) && (nearest_id == 0 || read_neighbour(l, nearest_id, &all->nearest)) &&
           (alike_id == 0 || read_neighbour(l, alike_id, alike));
}

static bool find_neighbours(look *l)
{
    l->near = (neighbours){0};
    neighbour_describe(&l->at, l->near.at);
    return l->pair_id == 0 || (look_outwards(l, &below_query, &l->near.below) &&
                               look_outwards(l, &above_query, &l->near.above));
}

// Rates of another size say nothing; certified misses none.
static bool is_accurate_anywhere(const look *l)
{
    bool asked = isfinite(l->request->max_missed_rate) || isfinite(l->request->max_false_rate);
    return !asked || strcmp(l->at.level, "certified") == 0;
}

// How the workload differs most from the nearest one that was measured.
static void tell_unlike(look *l, const neighbours *all)
{
    neighbour_quantity q;
    neighbour_apart(all->nearest.quantities, all->at, &q);
    text_add(l->why,
             "%.0f objects were measured, of a scene that is not alike: %s %.3g there, %.3g "
             "here",
             all->nearest.quantities[NEIGHBOUR_OBJECTS], neighbour_quantity_name(q),
             all->nearest.quantities[q], all->at[q]);
}

// Why what was measured does not surround the workload.
static bool tell_gap(look *l, const neighbours *all)
{
    bool below = neighbour_is_there(&all->below), above = neighbour_is_there(&all->above);
    text_add(l->why, "no: ");
    if (below && above)
        text_add(l->why,
                 "at %.0f and at %.0f objects the work is divided in other ways, and which is "
                 "the quicker one here is not known",
                 all->below.quantities[NEIGHBOUR_OBJECTS],
                 all->above.quantities[NEIGHBOUR_OBJECTS]);
    else if (below || above)
        text_add(l->why, "the size is %s those measured, the nearest of which is %.0f",
                 below ? "above" : "below",
                 (below ? &all->below : &all->above)->quantities[NEIGHBOUR_OBJECTS]);
    else
        tell_unlike(l, all);
    return true;
}

static bool take_next(look *l, const neighbours *all)
{
    const profile_found *found = &all->nearest.found;
    neighbour_take(&all->nearest, all->at, l->found);
    text_add(l->why, "yes: %.0f objects were measured, which is next to it%s%s",
             all->nearest.quantities[NEIGHBOUR_OBJECTS], found->session[0] ? ", session " : "",
             found->session);
    return true;
}

enum { MOTION_REACH = 4 }; // kernels suit a motion of as many times more or fewer bodies

// What a step of one motion takes says nothing of another's, whose bodies may meet at another time:
// only the plan is taken, and no figure.
static bool lend_to_motion(look *l, const neighbour *near, bool *held)
{
    double n = near->quantities[NEIGHBOUR_OBJECTS], at = l->near.at[NEIGHBOUR_OBJECTS];
    *held = fmax(n, at) <= MOTION_REACH * fmin(n, at);
    if (*held)
        neighbour_lend(&near->found, l->found);
    text_add(l->why, "%s of %.0f bodies",
             *held ? "yes: the plan of such a motion"
                   : "no: the nearest motion that was measured is",
             n);
    return true;
}

static bool look_interpolated(look *l, bool *held)
{
    const neighbours *all = &l->near;
    if (!find_neighbours(l))
        return false;
    if (!neighbour_is_there(&all->nearest))
        return refuse(l, "no like workload was measured on these two devices");
    if (profile_workload_moves(&l->at))
        return lend_to_motion(l, &all->nearest, held);
    bool next = neighbour_is_next(all->nearest.quantities, all->at);
    if (!next && !is_accurate_anywhere(l))
        return refuse(l, "accuracy is asked for, which rates of other sizes say nothing about");
    *held = neighbour_is_there(&all->below) && neighbour_is_there(&all->above) &&
            neighbour_between(&all->below, &all->above, all->at, l->found);
    if (*held)
        text_add(l->why, "yes: it lies between %.0f and %.0f objects, which were measured",
                 all->below.quantities[NEIGHBOUR_OBJECTS],
                 all->above.quantities[NEIGHBOUR_OBJECTS]);
    else if (next) {
        *held = true;
        return take_next(l, all);
    }
    return *held || tell_gap(l, all);
}

// ---------------------------------------------------------- lent plans

// The nearest neighbour's plan, if what it gains lasts as far as this.
static bool lend(look *l, const neighbour *near, double apart, bool *held)
{
    double reach = neighbour_reach(&near->found);
    *held = apart <= reach;
    if (*held)
        neighbour_lend(&near->found, l->found);
    text_add(l->why, "%s: the nearest plan, of %.0f objects, ", *held ? "yes" : "no",
             near->quantities[NEIGHBOUR_OBJECTS]);
    if (reach > 1)
        text_add(l->why, "is surely the faster one up to %.3g times apart, and this is %.3g%s",
                 reach, apart, *held ? "; none of its figures is of this workload" : "");
    else
        text_add(l->why, "is not surely the faster one anywhere else");
    return true;
}

// Whatever is not sure is left to the default plan.
static bool use_forecast(look *l, const forecast *f, bool *held)
{
    *held = f->doubt <= MOST_DOUBT && forecast_take(f, l->found);
    text_add(l->why,
             "%s: %u times of %.0f to %.0f objects say %.4g ms +- %.1f %% by both at share "
             "%.4f +- %.4f, %.4g ms by one%s",
             *held ? "yes" : "no", f->points, f->n_min, f->n_max, f->both.ns * 1e-6, 100 * f->doubt,
             f->share, f->share_sd, f->alone[!f->a_is_best].ns * 1e-6,
             *held ? "" : ", which does not say surely what is faster");
    return true;
}

static bool look_at_fits(look *l, bool *held)
{
    forecast_ask ask = {
        .env_a = l->env[0],
        .env_b = l->env[1],
        .family = text_chars(&l->family),
        .kernels = l->request->kernels,
        .host = l->request->host,
        .n = (double)l->at.n,
        .occupancy = l->at.occ_mean,
    };
    forecast f;
    bool found = false;
    if (l->partners == PARTNERS_NONE)
        return refuse(l, "one device alone has no other to share with");
    if (!forecast_best(l->s, &ask, &f, &found, l->err))
        return false;
    return found ? use_forecast(l, &f, held)
                 : refuse(l, "one of the devices was never measured on a like workload");
}

static bool look_transferred(look *l, bool *held)
{
    const neighbours *all = &l->near;
    if (!is_accurate_anywhere(l))
        return refuse(l, "accuracy is asked for, which times of other sizes say nothing about");
    if (profile_workload_moves(&l->at))
        return refuse(l, "a motion's plan is that of its own pair of devices");
    if (!neighbour_is_there(&all->nearest))
        return look_at_fits(l, held);
    return lend(l, &all->nearest, neighbour_apart(all->nearest.quantities, all->at, NULL), held);
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
