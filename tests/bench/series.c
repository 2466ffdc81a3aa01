// SPDX-License-Identifier: MIT
#include "series.h"

#include "base/compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void series_add(series *s, double sample)
{
    if (s->n < SERIES_ROOM)
        s->samples[s->n++] = sample;
}

double series_median(const series *s)
{
    if (s->n == 0)
        return NAN;
    double sorted[SERIES_ROOM];
    memcpy(sorted, s->samples, s->n * sizeof sorted[0]);
    qsort(sorted, s->n, sizeof sorted[0], compare_double);
    return 0.5 * (sorted[(s->n - 1) / 2] + sorted[s->n / 2]);
}

double series_least(const series *s)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < s->n; ++i)
        least = fmin(least, s->samples[i]);
    return least;
}
