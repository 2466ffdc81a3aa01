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

// The noise of medians before anything is known, as if from so many of them.
#define USUAL_RESIDUAL 0.03
#define USUAL_POINTS 4

#define ROUNDS 20        // reweightings, for the least absolute errors
#define SMALL_ERROR 0.01 // counts like its square: no weight is above one
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
