// SPDX-License-Identifier: MIT
#include "cluster/cut.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <zoltan.h>

// With so many points a part is off by less than one in a hundred.
enum { LEAST_SAMPLE = 1 << 16, SAMPLE_A_RANK = 1 << 12 };

typedef struct sample {
    const object_form *form;
    const object_rows *rows;
    uint32_t n;
} sample;

// Evenly over the rows, which are in the order of their ids.
static uint32_t row_of(const sample *s, uint32_t point)
{
    return (uint32_t)((uint64_t)s->rows->n * point / s->n);
}

// ---------------------------------------------------------------- what Zoltan asks

static int count_points(void *data, int *code)
{
    *code = ZOLTAN_OK;
    return (int)((const sample *)data)->n;
}

static void list_points(void *data, int n_global, int n_local, ZOLTAN_ID_PTR global,
                        ZOLTAN_ID_PTR local, int n_weights, float *weights, int *code)
{
    const sample *s = data;
    for (uint32_t i = 0; i < s->n; ++i) {
        global[i * (uint32_t)n_global] = i;
        local[i * (uint32_t)n_local] = i;
        weights[i * (uint32_t)n_weights] = (float)s->rows->n / (float)s->n;
    }
    *code = ZOLTAN_OK;
}

static int count_dims(void *data, int *code)
{
    (void)data;
    *code = ZOLTAN_OK;
    return 3;
}

static void find_points(void *data, int n_global, int n_local, int n, ZOLTAN_ID_PTR global,
                        ZOLTAN_ID_PTR local, int dims, double *centres, int *code)
{
    const sample *s = data;
    (void)n_global, (void)global;
    for (int i = 0; i < n; ++i)
        object_centre(s->form, object_row(s->rows, s->form, row_of(s, local[i * n_local])),
                      &centres[i * dims]);
    *code = ZOLTAN_OK;
}

// ---------------------------------------------------------------- the cut

static bool check(const ranks *r, int code, duet_error *err)
{
    return code == ZOLTAN_OK || code == ZOLTAN_WARN ||
           error_set(err, DUET_STATUS_NO_MEMORY,
                     "cutting the world into parts for %d ranks: Zoltan fails with %d", r->n, code);
}

static bool share_weights(cut *c, ranks *r, double weight, duet_error *err)
{
    double *weights = malloc((size_t)r->n * sizeof *weights);
    c->parts = malloc((size_t)r->n * sizeof *c->parts);
    bool ok = weights && c->parts;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "weights of %d ranks: no memory", r->n);
    if (ok && !(isfinite(weight) && weight > 0))
        ok = error_set(err, DUET_STATUS_BAD_ARGUMENT, "weight is %g; expected a number above 0",
                       weight);
    ok = ranks_agree(r, ok, err);
    if (ok)
        ranks_gather(r, &weight, weights, sizeof weight);
    double sum = 0, greatest = weight;
    for (int q = 0; ok && q < r->n; ++q)
        greatest = fmax(greatest, weights[q]);
    for (int q = 0; ok && q < r->n; ++q)
        sum += weights[q] / greatest; // which has no end for several of 1e308
    for (int q = 0; ok && q < r->n; ++q)
        c->parts[q] = (float)(weights[q] / greatest / sum);
    free(weights);
    return ok;
}

bool cut_begin(cut *c, ranks *r, double weight, duet_error *err)
{
    float version = 0;
    *c = (cut){0};
    if (!share_weights(c, r, weight, err))
        return false;
    if (r->n == 1)
        return true;
    Zoltan_Initialize(0, NULL, &version);
    c->zoltan = Zoltan_Create(r->comm);
    static const char *const settings[][2] = {
        {"DEBUG_LEVEL", "0"},     {"LB_METHOD", "RCB"}, {"KEEP_CUTS", "1"},
        {"RETURN_LISTS", "NONE"}, {"REMAP", "0"},       {"OBJ_WEIGHT_DIM", "1"},
        {"AVERAGE_CUTS", "1"},
    };
    bool ok = c->zoltan;
    for (size_t i = 0; ok && i < sizeof settings / sizeof *settings; ++i)
        Zoltan_Set_Param(c->zoltan, settings[i][0], settings[i][1]);
    return ranks_agree(r, ok || check(r, ZOLTAN_MEMERR, err), err);
}

void cut_end(cut *c)
{
    if (c->zoltan)
        Zoltan_Destroy(&c->zoltan);
    free(c->parts);
    *c = (cut){0};
}

static int set_part_sizes(cut *c, const ranks *r)
{
    int *parts = calloc(2 * (size_t)r->n, sizeof *parts);
    if (!parts)
        return ZOLTAN_MEMERR;
    for (int q = 0; q < r->n; ++q)
        parts[q] = q;
    Zoltan_LB_Set_Part_Sizes(c->zoltan, 1, -1, NULL, NULL, NULL); // as if they were never set
    int code = Zoltan_LB_Set_Part_Sizes(c->zoltan, 1, r->n, parts, parts + r->n, c->parts);
    free(parts);
    return code;
}

static int partition(cut *c)
{
    int changes = 0, n_global = 0, n_local = 0, n_in = 0, n_out = 0;
    ZOLTAN_ID_PTR in_global = NULL, in_local = NULL, out_global = NULL, out_local = NULL;
    int *in_ranks = NULL, *in_parts = NULL, *out_ranks = NULL, *out_parts = NULL;
    int code = Zoltan_LB_Partition(c->zoltan, &changes, &n_global, &n_local, &n_in, &in_global,
                                   &in_local, &in_ranks, &in_parts, &n_out, &out_global, &out_local,
                                   &out_ranks, &out_parts);
    Zoltan_LB_Free_Part(&in_global, &in_local, &in_ranks, &in_parts);
    Zoltan_LB_Free_Part(&out_global, &out_local, &out_ranks, &out_parts);
    return code;
}

static void keep_part(cut *c, int part)
{
    int dims = 0;
    bool known = c->is_made &&
                 Zoltan_RCB_Box(c->zoltan, part, &dims, &c->lower[0], &c->lower[1], &c->lower[2],
                                &c->upper[0], &c->upper[1], &c->upper[2]) == ZOLTAN_OK;
    for (int k = 0; k < 3 && !known; ++k) {
        c->lower[k] = c->zoltan ? INFINITY : -INFINITY;
        c->upper[k] = -c->lower[k];
    }
}

bool cut_make(cut *c, ranks *r, const object_form *form, const object_rows *rows, duet_error *err)
{
    c->is_made = false;
    keep_part(c, r->self);
    if (!c->zoltan)
        return true;
    uint64_t n = rows->n;
    ranks_sum(r, &n, 1);
    if (n == 0)
        return true;
    double points = fmax(LEAST_SAMPLE, (double)SAMPLE_A_RANK * r->n);
    double own = ceil(fmin(rows->n, points * rows->n / (double)n));
    sample s = {form, rows, (uint32_t)own};
    Zoltan_Set_Num_Obj_Fn(c->zoltan, count_points, &s);
    Zoltan_Set_Obj_List_Fn(c->zoltan, list_points, &s);
    Zoltan_Set_Num_Geom_Fn(c->zoltan, count_dims, &s);
    Zoltan_Set_Geom_Multi_Fn(c->zoltan, find_points, &s);
    bool ok = ranks_agree(r, check(r, set_part_sizes(c, r), err), err);
    c->is_made = ok && ranks_agree(r, check(r, partition(c), err), err);
    keep_part(c, r->self);
    return c->is_made;
}

int cut_home(const cut *c, const double centre[3])
{
    double at[3] = {centre[0], centre[1], centre[2]};
    int rank = 0, part = 0;
    if (c->is_made && Zoltan_LB_Point_PP_Assign(c->zoltan, at, &rank, &part) != ZOLTAN_OK)
        return 0;
    return rank;
}
