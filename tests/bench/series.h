// SPDX-License-Identifier: MIT
// Samples of one quantity.
#ifndef BENCH_SERIES_H
#define BENCH_SERIES_H

#include <stdint.h>

enum { SERIES_ROOM = 1024 };

typedef struct series {
    double samples[SERIES_ROOM];
    uint32_t n;
} series;

void series_add(series *s, double sample); // the first SERIES_ROOM are kept
double series_median(const series *s);
double series_least(const series *s);

#endif
