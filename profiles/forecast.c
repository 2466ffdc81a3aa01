// SPDX-License-Identifier: MIT
#include "profiles/forecast.h"

#include "profiles/sql.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct named_fit {
    char host[PROFILE_SHA];
    char role[8];
    char mode[16];
    char level[16];
    char variant[96];
    fit f;
} named_fit;

typedef struct fit_list {
    named_fit *fits;
    uint32_t n;
    uint32_t capacity;
} fit_list;

static named_fit *add_fit(fit_list *list, duet_error *err)
{
    if (list->n == list->capacity) {
        uint32_t capacity = list->capacity ? 2 * list->capacity : 16;
        named_fit *fits = realloc(list->fits, capacity * sizeof *fits);
        if (!fits) {
            error_set(err, DUET_STATUS_NO_MEMORY, "%u fits: no memory", capacity);
            return NULL;
        }
        list->fits = fits;
        list->capacity = capacity;
    }
    return &list->fits[list->n++];
}

static bool read_fits(store *s, const forecast_ask *ask, const char *env, fit_list *list,
                      duet_error *err)
{
    sql q = sql_make(s,
                     "SELECT host, role, mode, level, variant, " FIT_COLUMNS " FROM fit "
                     "WHERE env_id = (SELECT id FROM env WHERE key = ?) AND family = ? "
                     "AND kernels = ?",
                     err);
    sql_text(&q, env);
    sql_text(&q, ask->family);
    sql_text(&q, ask->kernels);
    bool ok = true;
    while (ok && sql_row(&q)) {
        named_fit *row = add_fit(list, err);
        ok = row != NULL;
        if (!ok)
            break;
        sql_copy(row->host, sizeof row->host, sql_get_text(&q, 0));
        sql_copy(row->role, sizeof row->role, sql_get_text(&q, 1));
        sql_copy(row->mode, sizeof row->mode, sql_get_text(&q, 2));
        sql_copy(row->level, sizeof row->level, sql_get_text(&q, 3));
        sql_copy(row->variant, sizeof row->variant, sql_get_text(&q, 4));
        if (!fit_read(&q, 5, &row->f))
            --list->n;
    }
    return sql_close(&q) && ok;
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
// the lines cross. False where they do not rise as times should.
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
    fit_time alone_a = predict_alone(ask, &lists[0], a);
    fit_time alone_b = predict_alone(ask, &lists[1], b);
    out->a_is_best = alone_a.ns < alone_b.ns;
    out->one = out->a_is_best ? alone_a : alone_b;
    return out->one.ns > 0 && cross(ask, &a->f, &b->f, out);
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

static bool same_work(const profile_plan *a, const profile_plan *b)
{
    return strcmp(a->mode, b->mode) == 0 && strcmp(a->level, b->level) == 0 &&
           strcmp(a->variant_a, b->variant_a) == 0 && strcmp(a->variant_b, b->variant_b) == 0;
}

// Of many plans, the one that looks quickest is likely one that little is known
// of; so the slow end of the interval decides.
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
                (ask->plan && !same_work(ask->plan, &f.plan)))
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

void forecast_take(const forecast *f, profile_found *found)
{
    double ratio = f->one.ns / f->both.ns;
    double sd = ratio * hypot(f->doubt, f->one.sd_ns / f->one.ns);
    bool faster = ratio - 2 * sd > 1;
    *found = (profile_found){.plan = f->plan};
    found->share_low = share_of(f->share - 2 * f->share_sd);
    found->share_high = share_of(f->share + 2 * f->share_sd);
    found->plan.share = faster ? share_of(f->share) : f->a_is_best ? PROFILE_SHARE_ONE : 0;
    found->median_ns = faster ? f->both.ns : f->one.ns;
    if (faster) {
        found->gain = ratio - 1;
        found->gain_low = ratio - 2 * sd - 1;
        found->gain_high = ratio + 2 * sd - 1;
    }
    sql_copy(found->verdict, sizeof found->verdict, faster ? "faster" : "same");
}
