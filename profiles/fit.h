// SPDX-License-Identifier: MIT
// The time of one device's part as a function of the workload's size, and what
// those of two devices predict.
//
//     time = base + each * n + own * w + crowd * w * occupancy
//
// for a device that does w of n objects: what it costs to begin, what is done
// for every object by each device, what is done for its own, and what grows
// with how many share a cell. The covariance says if the measurements leave
// a term open, and predictions that depend on it come with a wide interval.
#ifndef PROFILES_FIT_H
#define PROFILES_FIT_H

#include "profiles/store.h"

#define FIT_TERMS 4

typedef struct fit_point {
    double n;
    double own; // objects that the device does
    double occupancy;
    double time_ns;
    double weight; // fit_make's
} fit_point;

typedef struct fit {
    double terms[FIT_TERMS];
    double covariance[FIT_TERMS][FIT_TERMS];
    double residual; // relative, one standard deviation
    uint32_t points;
    double n_min;
    double n_max;
} fit;

typedef struct fit_time {
    double ns;
    double sd_ns; // the prediction's, noise of a measurement included
} fit_time;

// Least squares of relative errors, without times that were disturbed;
// n_points > 0.
void fit_make(fit_point *points, uint32_t n_points, fit *f);
fit_time fit_predict(const fit *f, double n, double own, double occupancy);

// Makes the fits of the session's devices and family again, or those of all.
bool fit_session(store *s, const char *session, duet_error *err);
bool fit_all(store *s, duet_error *err);

#endif
