// SPDX-License-Identifier: MIT
// Matches old contacts with new rows: contacts that are still pairs keep their records
// and colours. The others are dropped, and a body that slept leaning on one wakes.
//
// Invariant: the contacts of a row ascend by their other body, in old rows and in new ones, so a
// work-item goes through both side by side.
//
//   starts, others  the new rows
#define AHEAD (WG == 1 ? 16 : 8) // contacts whose records are asked for in time

// The first place from low on whose other is not below.
static inline uint place_of(__global const uint *others, uint low, uint high, uint other)
{
    while (low < high) {
        uint middle = low + (high - low) / 2;
        if (others[middle] < other)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// Two floats at a time, where a record has an even number; a CPU, whose stores wait in a short queue, eight.
#if RECORD % 2
typedef float piece;
#else
typedef float2 piece;
#endif

static inline void copy_record(__global float *to, __global const float *from, uint floats)
{
    const uint each = sizeof(piece) / sizeof(float);
    uint k = 0;
#if WG == 1
    for (; k + 8 <= floats; k += 8)
        vstore8(vload8(0, from + k), 0, to + k);
#endif
    for (; k < floats; k += each)
        *(__global piece *)(to + k) = *(__global const piece *)(from + k);
}

__kernel void match_contacts(MATCH_CONTACTS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_old);
    uint row = NO_PLACE, low = 0, end = 0;
    for (uint i = first; i < last; ++i) {
        uint2 link = old_links[i];
        if (link.x == NO_PLACE) { // it went to another domain
            row = NO_PLACE;
            continue;
        }
        if (link.x != row) {
            row = link.x;
            end = starts[row + 1];
            low = place_of(others, starts[row], end, link.y);
        }
        while (low < end && others[low] < link.y)
            ++low;
        uint ahead = min(i + AHEAD, last - 1);
        uint asked = old_touches[ahead] & TOUCH_POINTS, words = WG == 1 ? HEAD + asked * POINT_FLOATS : 32;
        for (uint k = 0; asked > 0 && k < words; k += 16)
            ask_for(old_contacts + (size_t)ahead * RECORD + k);
        uint touch = old_touches[i], points = touch & TOUCH_POINTS;
        __global const float *old = old_contacts + (size_t)i * RECORD;
        if (low < end && others[low] == link.y) {
            touches[low] = touch;
            if (points > 0)
                copy_record(contacts + (size_t)low * RECORD, old, HEAD + points * POINT_FLOATS);
#if CONTACT_RESPONSE
            colours[low] = old_colours[i];
#endif
        }
#if SLEEP
        else if (was_pushed(old, points)) {
            wake_both(link, n, asleep, rests);
        }
#endif
    }
}
