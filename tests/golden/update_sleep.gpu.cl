// update_sleep.DIMS3.DOUBLE0.ANGULAR_VELOCITY0.FRICTION0.SENSORS0.WG64.PER_ITEM1
#define DIMS 3
#define DOUBLE 0
#define ANGULAR_VELOCITY 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#define SENSORS 0
#define WG 64
#define PER_ITEM 1
#define UPDATE_SLEEP_ARGS \
    __global const uint2 *restrict links, \
    __global const uint *restrict touches, \
    __global const uint *restrict starts, \
    __global const uint *restrict return_starts, \
    __global const uint *restrict returns, \
    uint n, \
    __global const float *restrict rests, \
    __global const float4 *restrict velocities, \
    float sleep_after, \
    __global uint *restrict asleep, \
    volatile __global uint *restrict flags
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/update_sleep.cl.in"
// SPDX-License-Identifier: MIT
// Sleep. A body sleeps when it has rested for `sleep_after` seconds and touches no body
// that moves. A moving body wakes what it touches, and that wakes what it touches. A
// body that lost a contact was woken before, by having its rest time set to 0.
//
//   rests   [n] seconds at rest, 0 for what moves; below 0: has no mass, and a command changed it
//   asleep  [n] SLEEPS, or what it did until now, WOKE
typedef struct {
    __global const uint2 *links;
    __global const uint *touches;
    __global const uint *starts;
    __global const uint *return_starts;
    __global const uint *returns;
    uint n;
    __global const float *rests;
    __global const real4 *velocities;
#line 23 "kernels/dynamics/update_sleep.cl.in"
} touched;

static inline bool is_at_rest(const touched *t, uint id)
{
    if (id >= t->n)
        return true;
    real4 velocity = t->velocities[id];
    if (velocity.w > 0)
        return t->rests[id] > 0.0f;
    if (t->rests[id] < 0.0f)
        return false;
    real fastest = dot_product(velocity, velocity);
#line 38 "kernels/dynamics/update_sleep.cl.in"
    return !(fastest > 0);
}

#line 48 "kernels/dynamics/update_sleep.cl.in"
static inline bool touches_rest_only(const touched *t, uint id)
{
    bool only = true;
#line 55 "kernels/dynamics/update_sleep.cl.in"
    for (uint i = t->starts[id]; only && i < t->starts[id + 1]; ++i)
        if (t->touches[i] & TOUCH_POINTS)
#line 60 "kernels/dynamics/update_sleep.cl.in"
            only = is_at_rest(t, t->links[i].y);
#line 62 "kernels/dynamics/update_sleep.cl.in"
    for (uint k = t->return_starts[id]; only && k < t->return_starts[id + 1]; ++k)
        if (t->touches[t->returns[k]] & TOUCH_POINTS)
#line 67 "kernels/dynamics/update_sleep.cl.in"
            only = is_at_rest(t, t->links[t->returns[k]].x);
#line 69 "kernels/dynamics/update_sleep.cl.in"
    return only;
}

__kernel void update_sleep(UPDATE_SLEEP_ARGS)
{
    const touched t = {links, touches, starts, return_starts, returns, n, rests, velocities,
#line 83 "kernels/dynamics/update_sleep.cl.in"
    };
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    bool awake = false;
    for (uint id = first; id < last; ++id) {
        bool slept = asleep[id] & SLEEPS;
        bool sleeps = rests[id] > 0.0f && rests[id] >= sleep_after && touches_rest_only(&t, id);
        if (sleeps != slept)
            atomic_or(flags + FLAG_FELL_ASLEEP, 1u);
        asleep[id] = (sleeps ? SLEEPS : 0u) | (slept && !sleeps ? WOKE : 0u);
        awake = awake || !(sleeps || (!(velocities[id].w > 0) && is_at_rest(&t, id)));
    }
    if (awake)
        atomic_or(flags + FLAG_AWAKE, 1u);
}
