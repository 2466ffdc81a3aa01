// SPDX-License-Identifier: MIT
// Matches old contacts with new rows: contacts that are still pairs keep their records
// and colours. The others are dropped, and a body that slept leaning on one wakes.
//
// Invariant: the contacts of a row ascend by their other body, in old rows and in new ones, so a
// work-item goes through both side by side.
//
//   starts, others  the new rows
typedef struct {
    ARG_FIELDS
} matching;

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

// The row of the contact before, and where the search in it goes on.
typedef struct {
    uint row, low, end;
} row_place;

// Finds a contact's place among the new ones, and keeps all there but its record; NO_PLACE: it is dropped.
static inline uint match_contact(const matching *m, uint i, row_place *p)
{
    uint2 link = m->old_links[i];
    if (link.x == NO_PLACE) { // it went to another domain
        p->row = NO_PLACE;
        return NO_PLACE;
    }
    if (link.x != p->row) {
        p->row = link.x;
        p->end = m->starts[link.x + 1];
        p->low = place_of(m->others, m->starts[link.x], p->end, link.y);
    }
    while (p->low < p->end && m->others[p->low] < link.y)
        ++p->low;
    if (p->low < p->end && m->others[p->low] == link.y) {
        m->touches[p->low] = m->old_touches[i];
#if CONTACT_RESPONSE
        m->colours[p->low] = m->old_colours[i];
#endif
        return p->low;
    }
#if SLEEP
    if (was_pushed(m->old_contacts + (size_t)i * RECORD, m->old_touches[i] & TOUCH_POINTS))
        wake_both(link, m->n, m->asleep, m->rests);
#endif
    return NO_PLACE;
}

static inline uint floats_of(uint points)
{
    return points > 0 ? HEAD + points * POINT_FLOATS : 0;
}

#if WG == 1

#define AHEAD 16 // contacts whose records are asked for in time

static inline void ask_for_record(const matching *m, uint i)
{
    uint words = floats_of(m->old_touches[i] & TOUCH_POINTS);
    for (uint k = 0; k < words; k += 16)
        ask_for(m->old_contacts + (size_t)i * RECORD + k);
}

// Eight floats at a time, since stores wait in a short queue, and then two if a record has an even number.
#if RECORD % 2
typedef float piece;
#else
typedef float2 piece;
#endif

static inline void copy_record(__global float *to, __global const float *from, uint floats)
{
    const uint each = sizeof(piece) / sizeof(float);
    uint k = 0;
    for (; k + 8 <= floats; k += 8)
        vstore8(vload8(0, from + k), 0, to + k);
    for (; k < floats; k += each)
        *(__global piece *)(to + k) = *(__global const piece *)(from + k);
}

__kernel void match_contacts(MATCH_CONTACTS_ARGS)
{
    const matching m = {MATCH_CONTACTS_VALUES};
    row_place place = {NO_PLACE, 0, 0};
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_old);
    for (uint i = first; i < last; ++i) {
        ask_for_record(&m, min(i + AHEAD, last - 1));
        uint at = match_contact(&m, i, &place);
        if (at != NO_PLACE)
            copy_record(contacts + (size_t)at * RECORD, old_contacts + (size_t)i * RECORD,
                        floats_of(old_touches[i] & TOUCH_POINTS));
    }
}

#else

// A record that is copied: from the old ones, to the new ones, and how many floats.
typedef struct {
    uint from, to, floats;
} record_copy;

// Work-items side by side copy floats side by side.
#define COPIERS 32

static inline void copy_records(const matching *m, __local const record_copy *copies, uint n)
{
    const uint item = get_local_id(0);
    for (uint e = item / COPIERS; e < n; e += WG / COPIERS) {
        record_copy c = copies[e];
        for (uint k = item % COPIERS; k < c.floats; k += COPIERS)
            m->contacts[(size_t)c.to * RECORD + k] = m->old_contacts[(size_t)c.from * RECORD + k];
    }
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void match_contacts(MATCH_CONTACTS_ARGS)
{
    const matching m = {MATCH_CONTACTS_VALUES};
    __local record_copy copies[WG];
    __local uint n_copies;
    row_place place = {NO_PLACE, 0, 0};
    for (uint k = 0; k < PER_ITEM; ++k) {
        const uint i = get_global_id(0) * PER_ITEM + k;
        if (get_local_id(0) == 0)
            n_copies = 0;
        barrier(CLK_LOCAL_MEM_FENCE);
        uint at = i < n_old ? match_contact(&m, i, &place) : NO_PLACE;
        uint floats = at != NO_PLACE ? floats_of(old_touches[i] & TOUCH_POINTS) : 0;
        if (floats > 0)
            copies[atomic_inc(&n_copies)] = (record_copy){i, at, floats};
        barrier(CLK_LOCAL_MEM_FENCE);
        copy_records(&m, copies, n_copies);
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

#endif
