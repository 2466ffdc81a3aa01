// SPDX-License-Identifier: MIT
// All of graph colouring (graph_colour.cl) in one launch, and the contacts that push listed by colour: by a team of a
// CPU's groups (team.clh), or by a GPU's that all run at once and meet (meet.clh).
//
//   mark, then rounds of choose and take    as launches of their own do
//   count    each part its contacts of each key
//   place    behind those of lesser keys, and of lesser parts
//   lay      each colour into blocks
//
// The list has a part's contacts of a colour in any order, but those of COLOUR_OVERFLOW in the order of the rows.
//
//   sorts           1: lists contacts even if none has another colour than before
//   spans           [COLOUR_SPANS]
//   block_capacity  blocks, of `block` contacts each, for which there is space
#define KEYS COLOUR_KEY(COLOURS, COLOUR_KEYS)
#define PUSHING_KEYS COLOUR_KEY(COLOUR_WAITS, COLOUR_KEYS)

// The key of the k-th contact, which is kept; NONE: it pushes nothing.
static inline uint keep_key(const colouring *c, uint k)
{
    uint i = AWAKE_CONTACT_OF(c, k);
    uint colour = c->colours[i];
    uint key = colour < COLOUR_WAITS ? key_of(colour, c->touches[i]) : NONE;
    c->keys[k] = key;
    return key;
}

// Contacts of a colour begin a block, and those of COLOUR_OVERFLOW have one each. By one work-item.
static inline void lay_blocks(const colouring *c)
{
    uint used = 0, blocks = 0;
    for (uint colour = 0; colour <= COLOUR_OVERFLOW; ++colour) {
        uint first = c->key_starts[COLOUR_KEY(colour, COLOUR_KEYS)];
        uint count = c->key_starts[COLOUR_KEY(colour + 1, COLOUR_KEYS)] - first;
        c->spans[colour] = (uint4)(first, count, blocks * c->block, 0);
        blocks += colour == COLOUR_OVERFLOW ? count : (count + c->block - 1) / c->block;
        used = count > 0 ? colour + 1 : used;
    }
    c->spans[COLOUR_SPANS - 1] = (uint4)(used, blocks, 0, 0);
    if (blocks > c->block_capacity || c->flags[FLAG_ROUNDS] > TEAM_ROUNDS)
        atomic_or(c->flags + FLAG_FULL, 1u);
}

#if MEET

typedef __local uint *counts;

static inline uint2 range_of_group(uint n)
{
    uint groups = get_num_groups(0), each = (n + groups - 1) / groups, from = min((uint)get_group_id(0) * each, n);
    return (uint2)(from, min(from + each, n));
}

static inline void count_keys(const colouring *c, uint2 range, counts own)
{
    const uint item = get_local_id(0), group = get_group_id(0);
    for (uint key = item; key < PUSHING_KEYS; key += WG)
        own[key] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = range.x + item; k < range.y; k += WG) {
        uint key = keep_key(c, k);
        if (key != NONE)
            atomic_add(own + key, 1u);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint key = item; key < PUSHING_KEYS; key += WG)
        c->key_counts[group * PUSHING_KEYS + key] = own[key];
}

// Finds where the group's contacts of each key begin.
static inline void add_up(const colouring *c, counts places, counts all)
{
    const uint item = get_local_id(0), group = get_group_id(0), groups = get_num_groups(0);
    for (uint key = item; key < PUSHING_KEYS; key += WG) {
        uint before = 0, sum = 0;
#pragma unroll 16
        for (uint q = 0; q < groups; ++q) {
            uint count = c->key_counts[q * PUSHING_KEYS + key];
            before += q < group ? count : 0;
            sum += count;
        }
        places[key] = before;
        all[key] = sum;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint key = item; key <= KEYS; key += WG) {
        uint start = 0;
        for (uint lesser = 0; lesser < min(key, (uint)PUSHING_KEYS); ++lesser)
            start += all[lesser];
        if (key < PUSHING_KEYS)
            places[key] += start;
        if (group == 0)
            c->key_starts[key] = start;
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (get_global_id(0) == 0)
        lay_blocks(c);
}

static inline void list_contacts(const colouring *c, uint2 range, counts places)
{
    const uint item = get_local_id(0), in_order = COLOUR_KEY(COLOUR_OVERFLOW, COLOUR_KEYS), first = places[in_order];
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = range.x + item; k < range.y; k += WG) {
        uint key = c->keys[k];
        if (key == NONE)
            continue;
        uint at = atomic_add(places + key, 1u);
        if (key != in_order)
            c->list[at] = AWAKE_CONTACT_OF(c, k);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint at = first, end = item == 0 ? places[in_order] : first;
    for (uint k = range.x; at < end; ++k)
        if (c->keys[k] == in_order)
            c->list[at++] = AWAKE_CONTACT_OF(c, k);
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void colour_contacts(COLOUR_CONTACTS_ARGS)
{
    const colouring c = {COLOUR_CONTACTS_VALUES};
    __local uint places[PUSHING_KEYS], all_places[PUSHING_KEYS];
    if (WAITS_FOR_AWAKE)
        return;
    const uint n_bodies = N_AWAKE, n_here = N_AWAKE_CONTACTS, first = get_global_id(0), all = get_global_size(0);
    meeting groups = begin_meetings(team);
    for (uint k = first; k < n_here; k += all)
        mark_contacts(&c, k, k + 1);
    meet(&groups);
    for (uint turn = 1; flags[FLAG_UNCOLOURED] > 0; ++turn) {
        for (uint k = first; k < n_bodies; k += all)
            choose_contacts(&c, k, k + 1);
        meet(&groups);
        for (uint k = first; k < n_bodies; k += all)
            take_contacts(&c, turn, k, k + 1);
        meet(&groups);
    }
    if (!sorts && !flags[FLAG_RECOLOURED])
        return;
    const uint2 range = range_of_group(n_here);
    count_keys(&c, range, places);
    meet(&groups);
    add_up(&c, places, all_places);
    list_contacts(&c, range, places);
}

#else

// Counts the keys of a part's contacts that push.
static inline void count_keys(const colouring *c, uint part, uint2 range)
{
    uint counts[PUSHING_KEYS] = {0};
    for (uint k = range.x; k < range.y; ++k) {
        uint key = keep_key(c, k);
        if (key != NONE)
            counts[key] += 1;
    }
    for (uint key = 0; key < PUSHING_KEYS; ++key)
        c->key_counts[part * PUSHING_KEYS + key] = counts[key];
}

// Finds the place in the list of a part's contacts of each key: behind lesser keys, and lesser parts.
static inline void add_up(const colouring *c, uint part, uint groups, uint places[PUSHING_KEYS])
{
    uint sum = 0;
    for (uint key = 0; key < PUSHING_KEYS; ++key) {
        if (part == 0)
            c->key_starts[key] = sum;
        for (uint q = 0; q < groups; ++q) {
            if (q == part)
                places[key] = sum;
            sum += c->key_counts[q * PUSHING_KEYS + key];
        }
    }
    for (uint key = PUSHING_KEYS; part == 0 && key <= KEYS; ++key)
        c->key_starts[key] = sum;
    if (part == 0)
        lay_blocks(c);
}

static inline void list_contacts(const colouring *c, uint part, uint groups, uint2 range)
{
    uint places[PUSHING_KEYS];
    add_up(c, part, groups, places);
    for (uint k = range.x; k < range.y; ++k)
        if (c->keys[k] != NONE)
            c->list[places[c->keys[k]]++] = AWAKE_CONTACT_OF(c, k);
}

// A group that is behind the others goes on as they did: where none waits any more, they took as many rounds as
// the last that coloured something.
static inline bool is_round_next(const colouring *c, uint round)
{
    volatile __global const uint *flags = c->flags;
    bool waits = flags[FLAG_UNCOLOURED] > 0;
    order_memory();
    return waits || round <= flags[FLAG_ROUNDS];
}

__kernel void colour_contacts(COLOUR_CONTACTS_ARGS)
{
    const colouring c = {COLOUR_CONTACTS_VALUES};
    team_member t = TEAM_MEMBER;
    if (WAITS_FOR_AWAKE)
        return;
    uint n_bodies = N_AWAKE, n_here = N_AWAKE_CONTACTS, part;
    uint by_contacts = parts_of(&t, n_here, TEAM_LEAST_BODIES), by_bodies = parts_of(&t, n_bodies, TEAM_LEAST_BODIES);
    IN_STAGE(&t, &part, by_contacts) {
        uint2 range = range_of(&t, part, n_here);
        mark_contacts(&c, range.x, range.y);
    }
    END_STAGE(&t);
    for (uint turn = 1; is_round_next(&c, turn); ++turn) {
        IN_STAGE(&t, &part, by_bodies) {
            uint2 range = range_of(&t, part, n_bodies);
            choose_contacts(&c, range.x, range.y);
        }
        END_STAGE(&t);
        IN_STAGE(&t, &part, by_bodies) {
            uint2 range = range_of(&t, part, n_bodies);
            take_contacts(&c, turn, range.x, range.y);
        }
        END_STAGE(&t);
    }
    if (!sorts && !flags[FLAG_RECOLOURED])
        return;
    IN_STAGE(&t, &part, 1)
        count_keys(&c, part, range_of(&t, part, n_here));
    END_STAGE(&t);
    IN_STAGE(&t, &part, 1)
        list_contacts(&c, part, t.groups, range_of(&t, part, n_here));
}

#endif
