// SPDX-License-Identifier: MIT
// Lists of what a step may change, in ascending order: bodies, and contacts.
//
// Invariant: a body that is not listed sleeps or never moves, and no step of the listed ones changes it. A body
// that is awake wakes what it touches; if a contact then ends, what it wakes has neighbours that wake in the
// same step. So sleepers up to two contacts away may wake. Their contacts are listed, with both bodies of each
// that have a mass.
//
//   mark    bodies that are awake get level 1
//   spread  bodies of mass beside those of the level before get the next one, up to WAKE_LEVELS + 1
//   count   each part counts its bodies and contacts; a scan makes places of that
//   list    each part writes them
//
//   levels          [n] 0: is not listed; next_levels [n] after a spread
//   part_counts     [2 n_parts + 1] of PER_ITEM bodies each, then of PER_ITEM contacts each
//   awake           [n] ids, awake_contacts [n_contacts]
//   n_listed        [2] how many there are

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
        levels[id] = is_awake(&s, id) ? 1 : 0;
}

static inline bool touches_awake(const scene *s, uint id)
{
    bool found = false;
    for (uint i = s->starts[id]; !found && i < s->starts[id + 1]; ++i)
        found = s->others[i] < s->n && s->levels[s->others[i]] > 0;
    for (uint k = s->return_starts[id]; !found && k < s->return_starts[id + 1]; ++k)
        found = s->levels[s->links[s->returns[k]].x] > 0;
    return found;
}

__kernel void spread_awake(SPREAD_AWAKE_ARGS)
{
    const scene s = {SPREAD_AWAKE_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        uint has = s.levels[id];
        bool reached = has == 0 && velocities[id].w > 0 && touches_awake(&s, id);
        next_levels[id] = reached ? level : has;
    }
}

static inline bool is_contact_listed(uint2 link, __global const uint *levels, uint n)
{
    uint level_a = levels[link.x], level_b = link.y < n ? levels[link.y] : 0;
    return (level_a > 0 && level_a <= WAKE_LEVELS) || (level_b > 0 && level_b <= WAKE_LEVELS);
}

__kernel void count_awake(COUNT_AWAKE_ARGS)
{
    uint part = get_global_id(0), first = part * PER_ITEM;
    uint bodies = 0, contacts = 0;
    if (part >= n_parts)
        return;
    for (uint id = first; id < min(first + PER_ITEM, n); ++id)
        bodies += levels[id] > 0;
    for (uint i = first; i < min(first + PER_ITEM, n_contacts); ++i)
        contacts += is_contact_listed(links[i], levels, n);
    part_counts[part] = bodies;
    part_counts[n_parts + part] = contacts;
}

__kernel void list_awake(LIST_AWAKE_ARGS)
{
    uint part = get_global_id(0), first = part * PER_ITEM;
    if (part >= n_parts)
        return;
    uint before = part_counts[n_parts];
    uint body = part_counts[part], contact = part_counts[n_parts + part] - before;
    for (uint id = first; id < min(first + PER_ITEM, n); ++id)
        if (levels[id] > 0)
            awake[body++] = id;
    for (uint i = first; i < min(first + PER_ITEM, n_contacts); ++i)
        if (is_contact_listed(links[i], levels, n))
            awake_contacts[contact++] = i;
    if (part == n_parts - 1) {
        n_listed[LISTED_BODIES] = body;
        n_listed[LISTED_CONTACTS] = contact;
    }
}
