// SPDX-License-Identifier: MIT
#include "cluster/work.h"

// The cost that an end is taken to have before times say it, and the most that it may have.
static const double first_end = 1.0, most_end = 16.0;

// The part of the sums that is kept; and rows tell nothing whose bodies have alike many ends, to
// this part.
static const double kept = 0.9, least_spread = 0.01;

work_model work_begin(void)
{
    return (work_model){.end = first_end};
}

static void fade(work_model *w)
{
    double *const sums[] = {&w->nn, &w->ne, &w->ee, &w->nt, &w->et};
    for (int i = 0; i < 5; ++i)
        *sums[i] *= kept;
}

// Least squares of busy_ns = body * bodies + end * ends. Ranks whose bodies have alike many
// contacts tell nothing.
static void fit(work_model *w)
{
    const double all = w->nn * w->ee, det = all - w->ne * w->ne;
    double body = w->nt * w->ee - w->et * w->ne, end = w->et * w->nn - w->nt * w->ne;
    if (!(det > least_spread * all) || !(body > 0.0))
        return;
    w->end = end > 0.0 ? end / body : 0.0;
    w->end = w->end < most_end ? w->end : most_end;
}

void work_note(work_model *w, const work_row *rows, uint32_t n)
{
    fade(w);
    for (uint32_t i = 0; i < n; ++i) {
        const work_row *r = &rows[i];
        w->nn += r->bodies * r->bodies;
        w->ne += r->bodies * r->ends;
        w->ee += r->ends * r->ends;
        w->nt += r->bodies * r->busy_ns;
        w->et += r->ends * r->busy_ns;
    }
    fit(w);
}
