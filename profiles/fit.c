// SPDX-License-Identifier: MIT
// Times span decades, so the relative error is what is made small: each
// equation is divided by its time. Columns are scaled to a mean square of one,
// and each coefficient is held, as if by one more measurement, to be 0 +- 1 in
// that scale: no part of a time is far above the whole of it. That decides
// little if there are measurements, and keeps the rest within bounds.
//
// A busy machine disturbs many times, some of them tenfold. So the sum of
// absolute errors is made least first, which heeds the greater part of the
// times; what is then far off is left out, and the rest is fitted by squares.
#include "profiles/fit.h"

#include "base/clock.h"
#include "profiles/sql.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// The noise of medians before anything is known, as if from so many of them.
#define USUAL_RESIDUAL 0.03
#define USUAL_POINTS 4

#define ROUNDS 20        // reweightings, for the least absolute errors
#define SMALL_ERROR 0.01 // counts like its square: no weight is above one
#define REACH 4          // how far from the sizes measured a forecast is made
#define FAR_OFF 3        // deviations

static void fill_terms(const fit_point *p, double terms[FIT_TERMS])
{
    terms[0] = 1;
    terms[1] = p->n;
    terms[2] = p->own;
    terms[3] = p->own * p->occupancy;
}

// The inverse of a symmetric positive definite matrix, in place, by
// Gauss-Jordan elimination.
static void invert(double m[FIT_TERMS][FIT_TERMS])
{
    for (int k = 0; k < FIT_TERMS; ++k) {
        double pivot = m[k][k];
        m[k][k] = 1;
        for (int j = 0; j < FIT_TERMS; ++j)
            m[k][j] /= pivot;
        for (int i = 0; i < FIT_TERMS; ++i) {
            if (i == k)
                continue;
            double factor = m[i][k];
            m[i][k] = 0;
            for (int j = 0; j < FIT_TERMS; ++j)
                m[i][j] -= factor * m[k][j];
        }
    }
}

typedef struct equations {
    double scale[FIT_TERMS];
    double gram[FIT_TERMS][FIT_TERMS];
    double right[FIT_TERMS];
} equations;

// Each point with its weight.
static void add_up(const fit_point *points, uint32_t n_points, equations *e)
{
    *e = (equations){0};
    double terms[FIT_TERMS];
    for (uint32_t p = 0; p < n_points; ++p) {
        fill_terms(&points[p], terms);
        for (int i = 0; i < FIT_TERMS; ++i)
            e->scale[i] += pow(terms[i] / points[p].time_ns, 2) / n_points;
    }
    for (int i = 0; i < FIT_TERMS; ++i)
        e->scale[i] = e->scale[i] > 0 ? sqrt(e->scale[i]) : 1;
    for (uint32_t p = 0; p < n_points; ++p) {
        fill_terms(&points[p], terms);
        for (int i = 0; i < FIT_TERMS; ++i) {
            double row = terms[i] / points[p].time_ns / e->scale[i];
            row *= points[p].weight;
            e->right[i] += row;
            for (int j = 0; j < FIT_TERMS; ++j)
                e->gram[i][j] += row * terms[j] / points[p].time_ns / e->scale[j];
        }
    }
}

// Coefficients and covariance for a given relative noise.
static void solve(const equations *e, double noise, fit *f)
{
    double inverse[FIT_TERMS][FIT_TERMS];
    for (int i = 0; i < FIT_TERMS; ++i)
        for (int j = 0; j < FIT_TERMS; ++j)
            inverse[i][j] = e->gram[i][j] + (i == j ? noise * noise : 0);
    invert(inverse);
    for (int i = 0; i < FIT_TERMS; ++i) {
        f->terms[i] = 0;
        for (int j = 0; j < FIT_TERMS; ++j) {
            f->terms[i] += inverse[i][j] * e->right[j] / e->scale[i];
            f->covariance[i][j] = noise * noise * inverse[i][j] / (e->scale[i] * e->scale[j]);
        }
    }
}

static double sum_terms(const fit *f, const fit_point *p)
{
    double terms[FIT_TERMS];
    double sum = 0;
    fill_terms(p, terms);
    for (int i = 0; i < FIT_TERMS; ++i)
        sum += f->terms[i] * terms[i];
    return sum;
}

static double error_of(const fit *f, const fit_point *p)
{
    return fabs(sum_terms(f, p) / p->time_ns - 1);
}

// The median of the errors, to within a millionth of the greatest.
static double median_error(const fit *f, const fit_point *points, uint32_t n_points)
{
    double low = 0;
    double high = 0;
    for (uint32_t p = 0; p < n_points; ++p)
        high = fmax(high, error_of(f, &points[p]));
    for (int i = 0; i < 20; ++i) {
        double middle = (low + high) / 2;
        uint32_t below = 0;
        for (uint32_t p = 0; p < n_points; ++p)
            below += error_of(f, &points[p]) <= middle;
        *(2 * below > n_points ? &high : &low) = middle;
    }
    return high;
}

static void fit_least_absolute(fit_point *points, uint32_t n_points, fit *f)
{
    equations e;
    for (uint32_t p = 0; p < n_points; ++p)
        points[p].weight = 1;
    for (int i = 0; i < ROUNDS; ++i) {
        add_up(points, n_points, &e);
        solve(&e, USUAL_RESIDUAL, f);
        for (uint32_t p = 0; p < n_points; ++p)
            points[p].weight = SMALL_ERROR / fmax(SMALL_ERROR, error_of(f, &points[p]));
    }
}

// Leaves out what is far off. The noise of the rest, of which about half of
// the coefficients are decided, the prior deciding the others.
static double leave_out(fit_point *points, uint32_t n_points, const fit *f)
{
    const double to_deviation = 1.4826; // from a median of absolute errors
    double most = FAR_OFF * fmax(SMALL_ERROR, to_deviation * median_error(f, points, n_points));
    double sum = USUAL_POINTS * USUAL_RESIDUAL * USUAL_RESIDUAL;
    double n = 0;
    for (uint32_t p = 0; p < n_points; ++p) {
        double error = error_of(f, &points[p]);
        points[p].weight = error <= most;
        n += points[p].weight;
        sum += points[p].weight * error * error;
    }
    return sqrt(sum / (USUAL_POINTS + fmax(0, n - FIT_TERMS / 2.0)));
}

void fit_make(fit_point *points, uint32_t n_points, fit *f)
{
    equations e;
    *f = (fit){.points = n_points, .n_min = DBL_MAX};
    fit_least_absolute(points, n_points, f);
    f->residual = leave_out(points, n_points, f);
    add_up(points, n_points, &e);
    solve(&e, f->residual, f);
    for (uint32_t p = 0; p < n_points; ++p) {
        f->n_min = fmin(f->n_min, points[p].n);
        f->n_max = fmax(f->n_max, points[p].n);
    }
}

fit_time fit_predict(const fit *f, double n, double own, double occupancy)
{
    fit_point p = {.n = n, .own = own, .occupancy = occupancy};
    double terms[FIT_TERMS];
    fill_terms(&p, terms);
    fit_time t = {.ns = sum_terms(f, &p)};
    double variance = pow(f->residual * t.ns, 2);
    for (int i = 0; i < FIT_TERMS; ++i)
        for (int j = 0; j < FIT_TERMS; ++j)
            variance += f->covariance[i][j] * terms[i] * terms[j];
    t.sd_ns = sqrt(variance);
    return t;
}

// ----------------------------------------------------------------- in the store

#define FIT_KEY "env_id, family, kernels, host, role, mode, level, variant"

static const sql_column point_columns[] = {
    SQL_COLUMN("n", fit_point, n),
    SQL_COLUMN("own", fit_point, own),
    SQL_COLUMN("occupancy", fit_point, occupancy),
    SQL_COLUMN("time_ns", fit_point, time_ns),
    {0},
};

// Binds the eight columns of a fit's key, as `key` gives them.
static void bind_key(sql *q, const sql *key)
{
    sql_int(q, sql_get_int(key, 0));
    for (int i = 1; i < 8; ++i)
        sql_text(q, sql_get_text(key, i));
}

static bool read_points(store *s, const sql *key, fit_point **points, uint32_t *n, duet_error *err)
{
    sql q = sql_select(s, point_columns,
                       " FROM part WHERE env_id = ? AND family = ? AND kernels = ? AND host = ? "
                       "AND role = ? AND mode = ? AND level = ? AND variant = ?",
                       err);
    bind_key(&q, key);
    *points = sql_rows(&q, point_columns, sizeof **points, n);
    return sql_close(&q);
}

static bool write_fit(store *s, const sql *key, const fit *f, duet_error *err)
{
    text covariance = {0};
    for (int i = 0; i < FIT_TERMS; ++i)
        for (int j = 0; j < FIT_TERMS; ++j)
            text_add(&covariance, i + j == 0 ? "%.17g" : " %.17g", f->covariance[i][j]);
    sql q = sql_make(s,
                     "INSERT OR REPLACE INTO fit (" FIT_KEY ", base, each, own, crowd, "
                     "covariance, residual, points, n_min, n_max, fitted_ns) "
                     "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                     err);
    bind_key(&q, key);
    for (int i = 0; i < FIT_TERMS; ++i)
        sql_real(&q, f->terms[i]);
    sql_text(&q, text_chars(&covariance));
    sql_real(&q, f->residual);
    sql_int(&q, f->points);
    sql_int(&q, (int64_t)f->n_min);
    sql_int(&q, (int64_t)f->n_max);
    sql_int(&q, clock_calendar_ns());
    bool ok = sql_run(&q) && text_ok(&covariance, err);
    text_free(&covariance);
    return ok;
}

// Makes the fit for each key that the query gives.
static bool make_fits(store *s, sql *keys, duet_error *err)
{
    bool ok = true;
    while (ok && sql_row(keys)) {
        fit f;
        fit_point *points = NULL;
        uint32_t n = 0;
        ok = read_points(s, keys, &points, &n, err);
        if (ok) {
            fit_make(points, n, &f);
            ok = write_fit(s, keys, &f, err);
        }
        free(points);
    }
    return sql_close(keys) && ok;
}

bool fit_session(store *s, const char *session, duet_error *err)
{
    sql keys = sql_make(s,
                        "SELECT DISTINCT p.env_id, p.family, p.kernels, p.host, p.role, p.mode, "
                        "p.level, p.variant FROM session JOIN workload w ON w.id = workload_id "
                        "JOIN pair ON pair.id = pair_id JOIN part p ON p.family = w.family "
                        "AND p.env_id IN (env_a, env_b) AND p.kernels = session.kernels "
                        "AND p.host = session.host WHERE session.id = ?",
                        err);
    sql_text(&keys, session);
    return make_fits(s, &keys, err);
}

bool fit_all(store *s, duet_error *err)
{
    sql keys = sql_make(s, "SELECT DISTINCT " FIT_KEY " FROM part", err);
    return make_fits(s, &keys, err);
}

// ------------------------------------------------------------------- forecasts

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
