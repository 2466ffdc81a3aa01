// SPDX-License-Identifier: MIT
#include "cluster/cut.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>

// With so many points a part is off by a few in a hundred at most.
enum { LEAST_SAMPLE = 1 << 16, SAMPLE_A_RANK = 1 << 13 };

// Weights as numbers up to 1, which have a sum for several of 1e308 too.
static void keep_weights(cut *c, const ranks *r)
{
    double sum = 0, greatest = 0;
    for (int q = 0; q < r->n; ++q)
        greatest = fmax(greatest, c->weights[q]);
    for (int q = 0; q < r->n; ++q)
        sum += c->weights[q] /= greatest;
    c->due = c->weights[r->self] / sum;
}

static bool share_weights(cut *c, ranks *r, double weight, duet_error *err)
{
    int unknown = 0;
    c->weights = malloc((size_t)r->n * sizeof *c->weights);
    bool ok =
        c->weights || error_set(err, DUET_STATUS_NO_MEMORY, "weights of %d ranks: no memory", r->n);
    if (ok && !(isfinite(weight) && weight >= 0))
        ok = error_set(err, DUET_STATUS_BAD_ARGUMENT,
                       "weight is %g; expected a number above 0, or 0 on all ranks", weight);
    if (!ranks_agree(r, ok, err))
        return false;
    ranks_gather(r, &weight, c->weights, sizeof weight);
    for (int q = 0; q < r->n; ++q)
        unknown += c->weights[q] == 0;
    if (unknown > 0 && unknown < r->n)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "weight is 0 on %d of %d ranks; expected numbers above 0, or 0 on all",
                         unknown, r->n);
    for (int q = 0; q < r->n; ++q)
        c->weights[q] = unknown ? 1 : c->weights[q];
    keep_weights(c, r);
    return true;
}

bool cut_weigh(cut *c, ranks *r, double speed)
{
    double least = speed > 0 ? -speed : 0;
    ranks_greatest(r, &least, 1);
    if (!(least < 0))
        return false;
    ranks_gather(r, &speed, c->weights, sizeof speed);
    keep_weights(c, r);
    return true;
}

static void keep_part(cut *c, const ranks *r)
{
    bisection_box(&c->parts, (uint32_t)r->self, c->lower, c->upper);
}

bool cut_begin(cut *c, ranks *r, double weight, duet_error *err)
{
    *c = (cut){0};
    bool ok = share_weights(c, r, weight, err) &&
              ranks_agree(r, bisection_begin(&c->parts, (uint32_t)r->n, err), err);
    if (ok)
        keep_part(c, r);
    return ok;
}

void cut_end(cut *c)
{
    bisection_end(&c->parts);
    free(c->weights);
    *c = (cut){0};
}

uint32_t cut_sample(bisection_point *points, uint64_t n, const object_form *form,
                    const object_rows *rows)
{
    uint32_t own = rows->n < n ? rows->n : (uint32_t)n;
    for (uint32_t i = 0; i < own; ++i) {
        uint32_t row = (uint32_t)((uint64_t)rows->n * i / own);
        object_centre(form, object_row(rows, form, row), points[i].at);
        points[i].weight = (double)rows->n / own;
    }
    return own;
}

// Every rank sends its sample to rank 0, which cuts: so that all have the same planes, also where
// their machines round in different ways.
bool cut_make(cut *c, ranks *r, const object_form *form, const object_rows *rows, duet_error *err)
{
    uint64_t n = rows->n;
    if (r->n == 1)
        return true;
    ranks_sum(r, &n, 1);
    double points = fmax(LEAST_SAMPLE, (double)SAMPLE_A_RANK * r->n);
    double own = n > 0 ? ceil(fmin(rows->n, points * rows->n / (double)n)) : 0;
    parcels out = {0}, in = {0};
    bool ok = parcels_begin(&out, r, sizeof(bisection_point), err);
    if (ok)
        out.counts[0] = (uint64_t)own;
    ok = ok && parcels_reserve(&out, r, NULL, err);
    if (ok)
        cut_sample(out.rows, out.n, form, rows);
    ok = ranks_exchange(r, ok, &out, &in, err);
    if (ok && r->self == 0)
        bisection_cut(&c->parts, c->weights, in.rows, in.n);
    if (ok)
        ranks_tell(r, c->parts.planes, (uint64_t)r->n * sizeof *c->parts.planes);
    keep_part(c, r);
    parcels_end(&in);
    parcels_end(&out);
    return ok;
}
