// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "profiles/lookup_steps.h"

#include <string.h>
#include <time.h>

bool why_not(lookup *l, const char *reason)
{
    text_add(l->why, "no: %s", reason);
    return true;
}

bool why_found(lookup *l, int64_t id)
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

// ---------------------------------------------------------------- what an exact profile lacks

// Binds as many of the six texts as the query has parameters.
static void bind_question(const lookup *l, sql *q)
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

// Asks for profiles of just this workload, pair, kernels and objective.
static sql ask_exact(lookup *l, const char *query)
{
    sql q = sql_make(l->s, query, l->err);
    sql_text(&q, l->workload);
    sql_int(&q, l->pair_id);
    sql_text(&q, l->request->kernels);
    sql_text(&q, l->request->objective);
    return q;
}

// Says what the profile that is there gets wrong.
static bool tell_inaccuracy(lookup *l)
{
    sql q = ask_exact(l, "SELECT p.missed_rate, p.false_rate, coalesce(p.true_pairs, -1) "
                         "FROM workload w JOIN profile p ON p.workload_id = w.id AND p.live = 1 "
                         "WHERE w.key = ? AND p.pair_id = ? AND p.kernels = ? AND p.objective = ?");
    if (sql_row(&q) && sql_get_int(&q, 2) < 0)
        why_not(l, "how many pairs it misses, or adds falsely, was not measured");
    else
        text_add(
            l->why,
            "no: for each true pair it misses %.3g and adds %.3g false ones, above %.3g or %.3g",
            sql_get_real(&q, 0), sql_get_real(&q, 1), l->request->max_missed_rate,
            l->request->max_false_rate);
    return sql_close(&q);
}

// Why the last profile that was measured for just this is not used.
static bool tell_unused(lookup *l, bool *told)
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

bool why_not_exact(lookup *l)
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
    };
#undef LIVE
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; ++i) {
        sql q = sql_make(l->s, steps[i].query, l->err);
        bind_question(l, &q);
        bool there = sql_row(&q);
        if (!sql_close(&q))
            return false;
        if (!there)
            return why_not(l, steps[i].missing);
    }
    return tell_inaccuracy(l);
}

// ---------------------------------------------------------------- neighbours and forecasts

// How the workload differs most from the nearest one that was measured.
static void tell_unlike(lookup *l)
{
    const neighbours *all = &l->near;
    neighbour_quantity q;
    neighbour_ratio(all->nearest.quantities, all->at, &q);
    text_add(l->why,
             "%.0f objects were measured, of a scene that is not alike: %s %.3g there, %.3g "
             "here",
             all->nearest.quantities[NEIGHBOUR_OBJECTS], neighbour_quantity_name(q),
             all->nearest.quantities[q], all->at[q]);
}

void why_not_between(lookup *l)
{
    const neighbours *all = &l->near;
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
        tell_unlike(l);
}

void why_between(lookup *l)
{
    text_add(l->why, "yes: it lies between %.0f and %.0f objects, which were measured",
             l->near.below.quantities[NEIGHBOUR_OBJECTS],
             l->near.above.quantities[NEIGHBOUR_OBJECTS]);
}

void why_next(lookup *l)
{
    const neighbour *nearest = &l->near.nearest;
    const char *session = nearest->found.session;
    text_add(l->why, "yes: %.0f objects were measured, which is next to it%s%s",
             nearest->quantities[NEIGHBOUR_OBJECTS], session[0] ? ", session " : "", session);
}

void why_motion(lookup *l, double n, bool held)
{
    text_add(
        l->why, "%s of %.0f bodies",
        held ? "yes: the plan of such a motion" : "no: the nearest motion that was measured is", n);
}

void why_transferred(lookup *l, const neighbour *near, double ratio, bool held)
{
    double safe = neighbour_safe_ratio(&near->found);
    text_add(l->why, "%s: the nearest plan, of %.0f objects, ", held ? "yes" : "no",
             near->quantities[NEIGHBOUR_OBJECTS]);
    if (safe > 1)
        text_add(l->why, "is surely the faster one up to %.3g times apart, and this is %.3g%s",
                 safe, ratio, held ? "; none of its figures is of this workload" : "");
    else
        text_add(l->why, "is not surely the faster one anywhere else");
}

void why_forecast(lookup *l, const forecast *f, bool held)
{
    text_add(l->why,
             "%s: %u times of %.0f to %.0f objects say %.4g ms +- %.1f %% by both at share "
             "%.4f +- %.4f, %.4g ms by one%s",
             held ? "yes" : "no", f->points, f->n_min, f->n_max, f->both.ns * 1e-6, 100 * f->doubt,
             f->share, f->share_sd, f->alone[!f->a_is_best].ns * 1e-6,
             held ? "" : ", which does not say surely what is faster");
}
