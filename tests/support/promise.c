// SPDX-License-Identifier: MIT
#include "support/promise.h"

#include "runtime/narrowphase/narrow.h"

#include <math.h>

// Bounds in float hold between these sizes.
#define LEAST_SIZE 0x1p-70
#define GREATEST_SIZE 0x1p100

double promise_size(const hard_pair *p, uint32_t dims)
{
    double size = 0;
    for (uint32_t i = 0; i < dims; ++i)
        size += fabs((double)p->b.centre[i] - p->a.centre[i]) + p->a.half_extents[i] +
                p->b.half_extents[i];
    return size;
}

bool promise_allows(double missed, double added, const hard_pair *pair, uint32_t dims, bool answer)
{
    bool truth = narrow_exact(&pair->a, &pair->b, dims);
    double bound = truth ? missed : added;
    if (answer == truth)
        return true;
    if (bound == 0)
        return false;
    double size = promise_size(pair, dims);
    if (size < LEAST_SIZE || size > GREATEST_SIZE)
        return true;
    double separation = narrow_separation_apart(&pair->a, &pair->b, narrow_here, dims);
    double rounding = NARROW_SLACK * 0x1p-53 * size;
    return fabs(separation) <= bound * size + rounding;
}
