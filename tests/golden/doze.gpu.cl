// doze.DIMS3.DOUBLE0.SPIN0.FRICTION0.WG64.PER_ITEM1
#define DIMS 3
#define DOUBLE 0
#define SPIN 0
#define FRICTION 0
#define RESPONSE 1
#define WG 64
#define PER_ITEM 1
#line 1 "kernels/common.clh"
#line 1 "kernels/motion.clh"
#line 1 "kernels/flags.clh"
#line 1 "kernels/contact.clh"
#line 1 "kernels/doze.cl.in"
// SPDX-License-Identifier: MIT
// Who sleeps: an object that has been at rest for long and that nothing touches
// which moves. One that moves wakes what it touches, and those what they touch;
// what lost something that pushed it was woken by having no rest.
//
//   rests   [n] seconds at rest, 0 for what moves
//   asleep  [n] SLEEPS, or what it did until now, WOKE
static inline float least_rest(float least, uint id, uint n, __global const float *rests,
                               __global const real4 *velocities
#line 13 "kernels/doze.cl.in"
)
{
    if (id >= n)
        return least;
    real4 velocity = velocities[id];
    if (velocity.w > 0)
        return fmin(least, rests[id]);
    real fastest = dot_product(velocity, velocity);
#line 24 "kernels/doze.cl.in"
    return fastest > 0 ? 0.0f : least;
}

__kernel void doze(__global const uint2 *restrict links, __global const uint *restrict touches,
                   __global const uint *restrict starts, __global const uint *restrict return_starts,
                   __global const uint *restrict returns, uint n, __global const float *restrict rests,
                   __global const real4 *restrict velocities,
#line 34 "kernels/doze.cl.in"
                   float sleep_after, __global uint *restrict asleep, volatile __global uint *restrict flags)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        float least = rests[id];
        for (uint i = starts[id]; i < starts[id + 1]; ++i)
            if (touches[i] & TOUCH_POINTS)
                least = least_rest(least, links[i].y, n, rests, velocities
#line 46 "kernels/doze.cl.in"
                );
        for (uint k = return_starts[id]; k < return_starts[id + 1]; ++k)
            if (touches[returns[k]] & TOUCH_POINTS)
                least = least_rest(least, links[returns[k]].x, n, rests, velocities
#line 53 "kernels/doze.cl.in"
                );
        bool slept = asleep[id] & SLEEPS, sleeps = least > 0.0f && rests[id] >= sleep_after;
        if (sleeps != slept)
            atomic_or(flags + FLAG_DOZED, 1u);
        asleep[id] = (sleeps ? SLEEPS : 0u) | (slept && !sleeps ? WOKE : 0u);
    }
}
