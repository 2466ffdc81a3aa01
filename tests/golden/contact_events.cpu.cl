// contact_events.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.CONTACT_RESPONSE0.FRICTION0.HITS0.WG1.PER_ITEM16
#define DIMS 2
#define DOUBLE 0
#define ORIGIN 0
#define ANGULAR_VELOCITY 0
#define CONTACT_RESPONSE 0
#define FRICTION 0
#define HITS 0
#define WG 1
#define PER_ITEM 16
#define CONTACT_EVENTS_ARGS \
    __global const uint *restrict touches, \
    __global const float *restrict contacts, \
    uint n_contacts, \
    __global uint *restrict touching
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/contact_events.cl.in"
// SPDX-License-Identifier: MIT
// Which contacts touch: those with a point that overlapped when the contact was looked at,
// or that pushed in the step. A sleeping contact is as it was when it fell asleep.
//
// Runs while centres and velocities are still those that the step began with.
//
//   touching [(n_contacts + 31) / 32] a bit for each contact
//   hits     [n_contacts][HIT_WORDS] in any order (records.h)
#line 73 "kernels/dynamics/contact_events.cl.in"

static inline bool is_touching(__global const float *record, uint points)
{
    bool touches = false;
    for (uint k = 0; k < points; ++k) {
        __global const float *point = record + HEAD + k * POINT_FLOATS;
        touches = touches || point[OF_SEPARATION] <= 0.0f;
#line 83 "kernels/dynamics/contact_events.cl.in"
    }
    return touches;
}

__kernel void contact_events(CONTACT_EVENTS_ARGS)
{
    uint n_words = (n_contacts + 31) / 32;
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_words);
#line 99 "kernels/dynamics/contact_events.cl.in"
    for (uint w = first; w < last; ++w) {
        uint word = 0;
        for (uint i = 32 * w; i < min(32 * w + 32, n_contacts); ++i) {
            uint points = touches[i] & TOUCH_POINTS;
            __global const float *record = contacts + (size_t)i * RECORD;
            if (!is_touching(record, points))
                continue;
            word |= 1u << (i & 31u);
#line 131 "kernels/dynamics/contact_events.cl.in"
        }
        touching[w] = word;
    }
}
