// SPDX-License-Identifier: MIT
#include "tuner/stats.h"

#include "base/compare.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void sort_into(double *sorted, const double *values, uint32_t n)
{
    assert(n > 0 && n <= STATS_MOST);
    memcpy(sorted, values, n * sizeof *values);
    qsort(sorted, n, sizeof *sorted, compare_double);
}

double stats_median(const double *values, uint32_t n)
{
    double sorted[STATS_MOST];
    sort_into(sorted, values, n);
    return (sorted[(n - 1) / 2] + sorted[n / 2]) / 2;
}

double stats_quartile(const double *values, uint32_t n)
{
    double sorted[STATS_MOST];
    sort_into(sorted, values, n);
    return sorted[n / 4];
}

double stats_mad(const double *values, uint32_t n)
{
    double distances[STATS_MOST];
    double median = stats_median(values, n);
    for (uint32_t i = 0; i < n; ++i)
        distances[i] = fabs(values[i] - median);
    return stats_median(distances, n);
}

uint32_t stats_mark_outliers(const double *values, uint32_t n, bool *marks)
{
    double median = stats_median(values, n);
    double limit = median + 5 * 1.4826 * stats_mad(values, n);
    uint32_t marked = 0;
    for (uint32_t i = 0; i < n; ++i) {
        marks[i] = n > 2 && values[i] > limit;
        marked += marks[i];
    }
    return marked;
}

// The chance that fewer than k of n fair coins show heads.
static double chance_below(uint32_t k, uint32_t n)
{
    double chance = 0;
    for (uint32_t i = 0; i < k; ++i)
        chance += exp(lgamma(n + 1.0) - lgamma(i + 1.0) - lgamma(n - i + 1.0) - n * log(2.0));
    return chance;
}

stats_interval stats_median_interval(const double *values, uint32_t n, double confidence)
{
    double sorted[STATS_MOST];
    sort_into(sorted, values, n);
    uint32_t cut = 0; // values left out at each end
    while (2 * (cut + 1) < n && 1 - 2 * chance_below(cut + 2, n) >= confidence)
        ++cut;
    return (stats_interval){sorted[cut], sorted[n - 1 - cut], 1 - 2 * chance_below(cut + 1, n)};
}

int stats_sign(const double *d, uint32_t n, double sigma, double width)
{
    double median = stats_median(d, n);
    if (fabs(median) <= width * sigma / sqrt(n))
        return 0;
    return median > 0 ? 1 : -1;
}
