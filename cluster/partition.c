// SPDX-License-Identifier: MIT
#include "cluster/partition.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>

// So many points make a box off by a few in a hundred at most.
enum { LEAST_SAMPLE = 1 << 16, SAMPLE_A_RANK = 1 << 13 };

// Weights as numbers up to 1, which have a sum for several of 1e308 too.
static void keep_weights(partition *p, const ranks *r)
{
    double sum = 0, greatest = 0;
    for (int q = 0; q < r->n; ++q)
        greatest = fmax(greatest, p->weights[q]);
    for (int q = 0; q < r->n; ++q)
        sum += p->weights[q] /= greatest;
    p->due = p->weights[r->self] / sum;
}

static bool share_weights(partition *p, ranks *r, double weight, duet_error *err)
{
    int unknown = 0;
    p->weights = malloc((size_t)r->n * sizeof *p->weights);
    bool ok = p->weights || no_memory(err, "weights of %d ranks", r->n);
    if (ok && !(isfinite(weight) && weight >= 0))
        ok =
            bad_argument(err, "weight is %g; expected a number above 0, or 0 on all ranks", weight);
    if (!ranks_agree(r, ok, err))
        return false;
    ranks_gather(r, &weight, p->weights, sizeof weight);
    for (int q = 0; q < r->n; ++q)
        unknown += p->weights[q] == 0;
    if (unknown > 0 && unknown < r->n)
        return bad_argument(err,
                            "weight is 0 on %d of %d ranks; expected numbers above 0, or 0 on all",
                            unknown, r->n);
    for (int q = 0; q < r->n; ++q)
        p->weights[q] = unknown ? 1 : p->weights[q];
    keep_weights(p, r);
    return true;
}

bool partition_weigh(partition *p, ranks *r, double speed)
{
    if (!(ranks_greatest(r, speed > 0 ? -speed : 0) < 0))
        return false;
    ranks_gather(r, &speed, p->weights, sizeof speed);
    keep_weights(p, r);
    return true;
}

bool partition_begin(partition *p, ranks *r, double weight, duet_error *err)
{
    *p = (partition){0};
    bool ok = share_weights(p, r, weight, err) &&
              ranks_agree(r, bisection_begin(&p->parts, (uint32_t)r->n, err), err);
    if (ok)
        p->box = extent_all;
    return ok;
}

void partition_end(partition *p)
{
    bisection_end(&p->parts);
    free(p->weights);
    *p = (partition){0};
}

uint32_t partition_sample(bisection_point *points, uint64_t n, const object_form *form,
                          const object_rows *rows)
{
    uint32_t own = rows->n < n ? rows->n : (uint32_t)n;
    for (uint32_t i = 0; i < own; ++i) {
        uint32_t row = (uint32_t)((uint64_t)rows->n * i / own);
        object_row_centre(rows, form, row, points[i].at);
        points[i].weight = (double)rows->n / own;
    }
    return own;
}

// Every rank sends its sample to rank 0, which cuts: so that all have the same planes, even if
// their machines round in different ways.
bool partition_make(partition *p, ranks *r, const object_form *form, const object_rows *rows,
                    duet_error *err)
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
        partition_sample(out.rows, out.n, form, rows);
    ok = parcels_exchange(r, ok, &out, &in, err);
    if (ok && r->self == 0)
        bisection_cut(&p->parts, p->weights, in.rows, in.n);
    if (ok)
        ranks_broadcast(r, p->parts.planes, (uint64_t)r->n * sizeof *p->parts.planes);
    p->box = bisection_box(&p->parts, (uint32_t)r->self, &extent_all);
    parcels_end(&in);
    parcels_end(&out);
    return ok;
}
