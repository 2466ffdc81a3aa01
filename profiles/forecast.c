// SPDX-License-Identifier: MIT
#include "profiles/forecast.h"

#include "profiles/sql.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define REACH 4 // how far from the sizes measured a forecast is made

typedef struct named_fit {
    char host[PROFILE_SHA];
    char role[8];
    char mode[16];
    char level[16];
    char variant[PROFILE_VARIANT];
    char covariance[512]; // f's, as stored
    fit f;
} named_fit;

static const sql_column named_columns[] = {
    SQL_COLUMN("host", named_fit, host),
    SQL_COLUMN("role", named_fit, role),
    SQL_COLUMN("mode", named_fit, mode),
    SQL_COLUMN("level", named_fit, level),
    SQL_COLUMN("variant", named_fit, variant),
    SQL_COLUMN("covariance", named_fit, covariance),
    SQL_COLUMN("base", named_fit, f.terms[0]),
    SQL_COLUMN("each", named_fit, f.terms[1]),
    SQL_COLUMN("own", named_fit, f.terms[2]),
    SQL_COLUMN("crowd", named_fit, f.terms[3]),
    SQL_COLUMN("residual", named_fit, f.residual),
    SQL_COLUMN("points", named_fit, f.points),
    SQL_COLUMN("n_min", named_fit, f.n_min),
    SQL_COLUMN("n_max", named_fit, f.n_max),
    {0},
};

typedef struct fit_list {
    named_fit *fits;
    uint32_t n;
} fit_list;

// False if a hand-written row has not 16 numbers.
static bool read_covariance(named_fit *row)
{
    const char *at = row->covariance;
    for (int i = 0; i < FIT_TERMS * FIT_TERMS; ++i) {
        char *end = NULL;
        row->f.covariance[i / FIT_TERMS][i % FIT_TERMS] = strtod(at, &end);
        if (end == at)
            return false;
        at = end;
    }
    return true;
}

static bool read_fits(store *s, const forecast_ask *ask, const char *env, fit_list *list,
                      duet_error *err)
{
    uint32_t n = 0;
    sql q = sql_select(s, named_columns,
                       " FROM fit WHERE env_id = (SELECT id FROM env WHERE key = ?) AND family = ? "
                       "AND kernels = ?",
                       err);
    sql_text(&q, env);
    sql_text(&q, ask->family);
    sql_text(&q, ask->kernels);
    list->fits = sql_rows(&q, named_columns, sizeof *list->fits, &n);
    for (uint32_t i = 0; i < n; ++i)
        if (read_covariance(&list->fits[i]))
            list->fits[list->n++] = list->fits[i];
    return sql_close(&q);
}

static fit_time predict(const forecast_ask *ask, const fit *f, double share)
{
    return fit_predict(f, ask->n, share * ask->n, ask->occupancy);
}

// By the device's own times without a partner, or else by what its part would
// take if it were the whole.
static fit_time predict_alone(const forecast_ask *ask, const fit_list *list, const named_fit *part)
{
    for (uint32_t i = 0; i < list->n; ++i) {
        const named_fit *row = &list->fits[i];
        if (strcmp(row->role, "alone") == 0 && strcmp(row->host, part->host) == 0 &&
            strcmp(row->level, part->level) == 0 && strcmp(row->variant, part->variant) == 0)
            return predict(ask, &row->f, 1);
    }
    return predict(ask, &part->f, 1);
}

// Both parts' times are straight lines in the share; they end together where
// the lines cross. False if they do not rise as times should.
static bool cross(const forecast_ask *ask, const fit *a, const fit *b, forecast *out)
{
    double a_rise = predict(ask, a, 1).ns - predict(ask, a, 0).ns;
    double b_rise = predict(ask, b, 1).ns - predict(ask, b, 0).ns;
    if (!(a_rise > 0 && b_rise > 0))
        return false;
    double slope = a_rise + b_rise;
    out->share = fmin(1, fmax(0, (predict(ask, b, 1).ns - predict(ask, a, 0).ns) / slope));
    fit_time by_a = predict(ask, a, out->share);
    fit_time by_b = predict(ask, b, 1 - out->share);
    out->both = by_a.ns > by_b.ns ? by_a : by_b;
    out->share_sd = hypot(by_a.sd_ns, by_b.sd_ns) / slope;
    out->doubt = fmax(by_a.sd_ns, by_b.sd_ns) / out->both.ns;
    return out->both.ns > 0;
}

static bool make_forecast(const forecast_ask *ask, const fit_list lists[2], const named_fit *a,
                          const named_fit *b, forecast *out)
{
    *out = (forecast){
        .here = strcmp(a->host, ask->host) == 0,
        .n_min = fmax(a->f.n_min, b->f.n_min),
        .n_max = fmin(a->f.n_max, b->f.n_max),
        .points = a->f.points + b->f.points,
    };
    sql_copy(out->plan.mode, sizeof out->plan.mode, a->mode);
    sql_copy(out->plan.level, sizeof out->plan.level, a->level);
    sql_copy(out->plan.variant_a, sizeof out->plan.variant_a, a->variant);
    sql_copy(out->plan.variant_b, sizeof out->plan.variant_b, b->variant);
    out->alone[0] = predict_alone(ask, &lists[0], a);
    out->alone[1] = predict_alone(ask, &lists[1], b);
    out->a_is_best = out->alone[0].ns < out->alone[1].ns;
    return out->alone[!out->a_is_best].ns > 0 && cross(ask, &a->f, &b->f, out);
}

static bool is_part(const named_fit *row, const char *role)
{
    return strcmp(row->role, "part") == 0 || strcmp(row->role, role) == 0;
}

// Two fits that can work together: of one machine, in one mode and level.
static bool match(const named_fit *a, const named_fit *b)
{
    return is_part(a, "a") && is_part(b, "b") && strcmp(a->host, b->host) == 0 &&
           strcmp(a->mode, b->mode) == 0 && strcmp(a->level, b->level) == 0;
}

static bool covers(const forecast_ask *ask, const forecast *f)
{
    return ask->n * REACH >= f->n_min && ask->n <= f->n_max * REACH;
}

// The plan that looks quickest among many is likely one that little is known of;
// so the slow end of the interval decides.
static double cautious_ns(const forecast *f)
{
    return f->both.ns * (1 + 2 * f->doubt);
}

bool forecast_best(store *s, const forecast_ask *ask, forecast *best, bool *found, duet_error *err)
{
    fit_list lists[2] = {0};
    bool ok = read_fits(s, ask, ask->env_a, &lists[0], err) &&
              read_fits(s, ask, ask->env_b, &lists[1], err);
    *found = false;
    for (uint32_t i = 0; ok && i < lists[0].n; ++i) {
        for (uint32_t j = 0; j < lists[1].n; ++j) {
            forecast f;
            if (!match(&lists[0].fits[i], &lists[1].fits[j]) ||
                !make_forecast(ask, lists, &lists[0].fits[i], &lists[1].fits[j], &f) ||
                !covers(ask, &f))
                continue;
            if (*found &&
                (f.here != best->here ? best->here : cautious_ns(&f) >= cautious_ns(best)))
                continue;
            *best = f;
            *found = true;
        }
    }
    free(lists[0].fits);
    free(lists[1].fits);
    return ok;
}

static uint32_t share_of(double r)
{
    return (uint32_t)lround(fmin(1, fmax(0, r)) * PROFILE_SHARE_ONE);
}

static bool is_surely_faster(const fit_time *a, const fit_time *b)
{
    return b->ns - a->ns > 2 * hypot(a->sd_ns, b->sd_ns);
}

// Fits are of devices' parts, and not of what the host does between them.
#define HOST_PART 1.05

bool forecast_take(const forecast *f, profile_found *found)
{
    const fit_time *one = &f->alone[!f->a_is_best], *other = &f->alone[f->a_is_best];
    fit_time both = {HOST_PART * f->both.ns, HOST_PART * f->both.sd_ns};
    bool shared = is_surely_faster(&both, one);
    if (!shared && !(is_surely_faster(one, &f->both) && is_surely_faster(one, other)))
        return false;
    *found = (profile_found){.plan = f->plan, .true_pairs = -1};
    found->share_low = share_of(f->share - 2 * f->share_sd);
    found->share_high = share_of(f->share + 2 * f->share_sd);
    found->plan.share = shared ? share_of(f->share) : f->a_is_best ? PROFILE_SHARE_ONE : 0;
    return true;
}
