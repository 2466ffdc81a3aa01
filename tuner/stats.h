// SPDX-License-Identifier: MIT
// Statistics of few and disturbed times: medians and what follows from them.
//
// Nothing here assumes normal errors. Launch times have a hard floor and a
// long tail, so a mean and its deviation say little (Hoefler & Belli,
// "Scientific Benchmarking of Parallel Computing Systems", SC 2015).
#ifndef TUNER_STATS_H
#define TUNER_STATS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct stats_interval {
    double low;
    double high;
    double confidence; // that it really has
} stats_interval;

// Returns the median of n > 0 values, in any order; up to STATS_MOST of them.
#define STATS_MOST 512
double stats_median(const double *values, uint32_t n);

// A quarter of the values lie below it: what a launch takes that nothing else
// disturbs, though half of them are disturbed.
double stats_quartile(const double *values, uint32_t n);

// The median distance from the median. 1.4826 of it estimates a deviation.
double stats_mad(const double *values, uint32_t n);

// Marks what lies more than five deviations above the median: a launch that
// something else disturbed. Nothing is dropped; returns how many were marked.
uint32_t stats_mark_outliers(const double *values, uint32_t n, bool *marks);

// The interval of the median between two order statistics, from the binomial distribution of how
// many values lie below it (Conover, "Practical Nonparametric Statistics", section 3.2). It is the
// narrowest symmetric one with at least the confidence asked for; if n is too small for that, all
// the values and the confidence that they give.
stats_interval stats_median_interval(const double *values, uint32_t n, double confidence);

// Sequential test for the sign of what differences scatter about. Returns -1
// or 1 once the median of d lies further from 0 than `width` deviations of a
// mean of n, else 0: not decided by these n. sigma is a single one's deviation.
int stats_sign(const double *d, uint32_t n, double sigma, double width);

#endif
