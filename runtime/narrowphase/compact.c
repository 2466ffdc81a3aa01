// SPDX-License-Identifier: MIT
// Transforms in 20 bytes.
//
// The greatest part of the quaternion becomes 32767 or its negative. Each of the three others
// is off by at most half a unit, the quaternion by sqrt(3) / 2 of one in a length of 32767 or
// more, and the rotation by twice that angle: 5.3e-5 rad.
#include "runtime/duet.h"

#include "base/error.h"

#include <math.h>
#include <string.h>

enum { GREATEST = 32767 };

bool duet_compact_transform_set(duet_compact_transform *compact, const duet_transform *transform,
                                duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(compact, __func__, "compact", err) ||
        !error_given(transform, __func__, "transform", err))
        return false;
    const float *q = transform->rotation;
    double greatest = 0;
    bool finite = true;
    for (int k = 0; k < 4; ++k) {
        finite = finite && isfinite(q[k]);
        greatest = fmax(greatest, fabs((double)q[k]));
    }
    bool ok = finite && greatest > 0;
    memcpy(compact->centre, transform->centre, sizeof compact->centre);
    for (int k = 0; k < 4; ++k)
        compact->rotation[k] = ok ? (int16_t)lrint(GREATEST * ((double)q[k] / greatest)) : 0;
    return ok || error_set(err, DUET_STATUS_BAD_OBJECT,
                           "the rotation %g %g %g %g is zero or not finite; expected a quaternion",
                           (double)q[0], (double)q[1], (double)q[2], (double)q[3]);
}
