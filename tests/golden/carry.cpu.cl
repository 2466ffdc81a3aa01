// carry.DIMS2.SPIN0.RESPONSE0.FRICTION0.SLEEP0.EVENTS0.WG1.PER_ITEM1024
#define DIMS 2
#define SPIN 0
#define RESPONSE 0
#define FRICTION 0
#define SLEEP 0
#define EVENTS 0
#define WG 1
#define PER_ITEM 1024
#line 1 "kernels/common.clh"
#line 1 "kernels/flags.clh"
#line 1 "kernels/contact.clh"
#line 1 "kernels/carry.cl.in"
// SPDX-License-Identifier: MIT
// Contacts taken over into new rows: records and colours of those that are
// still pairs. The others are forgotten, and what slept leaning on one wakes.
//
//   starts, others  the new rows
#line 25 "kernels/carry.cl.in"

__kernel void carry(__global const uint2 *restrict old_links, __global const uint *restrict old_touches,
                    __global const float *restrict old_contacts, uint n_old,
#line 37 "kernels/carry.cl.in"
                    __global const uint *restrict starts, __global const uint *restrict others,
                    __global uint *restrict touches, __global float *restrict contacts)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_old);
    for (uint i = first; i < last; ++i) {
        uint2 link = old_links[i];
        uint low = starts[link.x], high = starts[link.x + 1], end = high;
        while (low < high) {
            uint middle = low + (high - low) / 2;
            if (others[middle] < link.y)
                low = middle + 1;
            else
                high = middle;
        }
        uint touch = old_touches[i], n = touch & TOUCH_POINTS;
        __global const float *old = old_contacts + (size_t)i * RECORD;
        if (low < end && others[low] == link.y) {
            touches[low] = touch;
            for (uint k = 0; n > 0 && k < HEAD + n * PART; ++k)
                contacts[(size_t)low * RECORD + k] = old[k];
#line 61 "kernels/carry.cl.in"
        }
#line 85 "kernels/carry.cl.in"
    }
}
