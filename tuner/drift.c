// SPDX-License-Identifier: MIT
// A CUSUM of the log ratio in units of its own deviation, with half a unit of
// slack: at a limit of twelve a steady machine raises a false alarm once in
// about a million steps, and a shift of two units is seen within ten.
#include "tuner/drift.h"

#include <math.h>

#define SMOOTHING 0.05
#define LEAST_DEVIATION 0.05 // a shift of less is not worth tuning for
#define SLACK 0.5
#define LIMIT 12.0
#define MOST_A_STEP 4.0 // so that a hiccup of one step does not raise it

static double clamp(double x, double most)
{
    return fmin(most, fmax(-most, x));
}

bool drift_update(drift *d, double measured_ns, double expected_ns)
{
    if (!(measured_ns > 0 && expected_ns > 0))
        return false;
    if (d->n++ == 0)
        d->variance = LEAST_DEVIATION * LEAST_DEVIATION;
    double deviation = fmax(LEAST_DEVIATION, sqrt(d->variance));
    double x = clamp(log(measured_ns / expected_ns), MOST_A_STEP * deviation);
    double off = x - d->mean;
    d->mean += SMOOTHING * off;
    d->variance = (1 - SMOOTHING) * (d->variance + SMOOTHING * off * off);
    d->up = fmax(0, d->up + x / deviation - SLACK);
    d->down = fmax(0, d->down - x / deviation - SLACK);
    return d->up > LIMIT || d->down > LIMIT;
}
