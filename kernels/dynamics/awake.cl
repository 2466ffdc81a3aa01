// SPDX-License-Identifier: MIT
// Lists of what a step may change, in ascending order: bodies, and contacts.
//
// Invariant: a body that is not listed sleeps or never moves, and no step of the listed ones changes it, but for
// those that wake_touching of update_sleep.cl wakes. All contacts of bodies that are awake are listed, with both
// bodies of each that have a mass; what wakes in a step is awake in lists that are made again then.
//
//   mark    bodies that are awake; with `woken` those of the last lists as well
//   spread  each part counts its contacts of these, and marks the bodies of mass beside them
//   count   each part counts its bodies; a scan makes places of both counts
//   list    each part writes them
//
//   levels          [n] 0: is not listed
//   part_counts     [2 n_parts + 1] of PER_ITEM bodies each, then of PER_ITEM contacts each
//   awake           [n] ids, awake_contacts [n_contacts]
//   n_listed        [2] how many there are

#define LEVEL_AWAKE 1
#define LEVEL_BESIDE 2

static inline bool is_awake(const scene *s, uint id)
{
    if (!(s->velocities[id].w > 0))
        return !is_at_rest(s, id);
    return !(s->asleep[id] & SLEEPS) || (s->asleep[id] & PRESSED) || !has_rested(s, id);
}

__kernel void mark_awake(MARK_AWAKE_ARGS)
{
    const scene s = {MARK_AWAKE_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id)
        levels[id] = (woken && levels[id] == LEVEL_AWAKE) || is_awake(&s, id) ? LEVEL_AWAKE : 0;
}

// The objects of a contact.
static inline uint2 link_of(const scene *s, uint i)
{
    uint2 link = s->links[i];
//@ if CARRIED == 1 then
    link.y = MOVER_OF(s, link.y);
//@ end
    return link;
}

static inline bool is_contact_listed(uint2 link, __global const volatile uint *levels, uint n)
{
    return levels[link.x] == LEVEL_AWAKE || (link.y < n && levels[link.y] == LEVEL_AWAKE);
}

static inline void list_beside(const scene *s, uint id, volatile __global uint *levels)
{
    if (id < s->n && levels[id] == 0 && s->velocities[id].w > 0)
        levels[id] = LEVEL_BESIDE;
}

__kernel void spread_awake(SPREAD_AWAKE_ARGS)
{
    const scene s = {SPREAD_AWAKE_VALUES};
    uint part = get_global_id(0), first = part * PER_ITEM;
    uint contacts = 0;
    if (part >= n_parts)
        return;
    for (uint i = first; i < min(first + PER_ITEM, n_contacts); ++i) {
        uint2 link = link_of(&s, i);
        if (!is_contact_listed(link, levels, n))
            continue;
        ++contacts;
        list_beside(&s, link.x, levels);
        list_beside(&s, link.y, levels);
    }
    part_counts[n_parts + part] = contacts;
}

__kernel void count_awake(COUNT_AWAKE_ARGS)
{
    uint part = get_global_id(0), first = part * PER_ITEM;
    uint bodies = 0;
    if (part >= n_parts)
        return;
    for (uint id = first; id < min(first + PER_ITEM, n); ++id)
        bodies += levels[id] > 0;
    part_counts[part] = bodies;
}

__kernel void list_awake(LIST_AWAKE_ARGS)
{
    const scene s = {LIST_AWAKE_VALUES};
    uint part = get_global_id(0), first = part * PER_ITEM;
    if (part >= n_parts)
        return;
    uint before = part_counts[n_parts];
    uint body = part_counts[part], contact = part_counts[n_parts + part] - before;
    for (uint id = first; id < min(first + PER_ITEM, n); ++id)
        if (levels[id] > 0)
            awake[body++] = id;
    for (uint i = first; i < min(first + PER_ITEM, n_contacts); ++i)
        if (is_contact_listed(link_of(&s, i), levels, n))
            awake_contacts[contact++] = i;
    if (part == n_parts - 1) {
        n_listed[LISTED_BODIES] = body;
        n_listed[LISTED_CONTACTS] = contact;
    }
}
