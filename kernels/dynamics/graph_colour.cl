// SPDX-License-Identifier: MIT
// Graph colouring (Jones and Plassmann).
//
// Invariant: contacts of one colour share no body that moves, and a contact keeps its colour while it
// lasts. Ranks come from the ids, so colours depend neither on the device nor on the order of work.
//
//   mark     contacts that begin to push wait
//   choose   each body points to its waiting contact of the greatest rank     \  in rounds, until
//   take     a contact that both its bodies point to takes the least colour   /   none waits
//            that both have free
//   key      what contacts are sorted by
//
//   colours [n_contacts] COLOUR_NONE: pushes nothing; COLOUR_WAITS: to be coloured
//   used    [n] a bit for each colour taken
//   choices [n] the contact that the object points to; NONE: none waits
#define LAST_COLOUR (COLOUR_OVERFLOW - 1u) // bits of used
#define NONE 0xffffffffu

static inline uint rank_of(uint2 link)
{
    uint k = link.x * 0x9E3779B9u ^ (link.y + 0x7F4A7C15u) * 0x85EBCA6Bu;
    k ^= k >> 15;
    k *= 0x2C1B3C6Du;
    k ^= k >> 13;
    return k;
}

// Marks contacts that begin or cease to push.
__kernel void graph_colour_mark(GRAPH_COLOUR_MARK_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE_CONTACTS);
    uint waiting = 0, changed = 0;
    for (uint k = first; k < last; ++k) {
        uint i = AWAKE_CONTACT_AT(k);
        uint2 link = links[i];
        bool pushes = (touches[i] & TOUCH_POINTS) && (bodies[(size_t)link.x * BODY + BODY_VELOCITY].w > 0.0f ||
                                                      bodies[(size_t)link.y * BODY + BODY_VELOCITY].w > 0.0f);
#if SENSORS
        pushes = pushes && !(sensors[link.x] > 0.0f || (link.y < n && sensors[link.y] > 0.0f));
#endif
        uint old = colours[i];
        uint colour = !pushes ? COLOUR_NONE : old == COLOUR_NONE ? COLOUR_WAITS : old;
        changed |= colour != old;
        colours[i] = colour;
        if (colour != COLOUR_WAITS)
            continue;
        ++waiting;
        atomic_xchg(choices + link.x, i);
        if (link.y < n)
            atomic_xchg(choices + link.y, i);
    }
    if (waiting)
        atomic_add(flags + FLAG_UNCOLOURED, waiting);
    if (changed)
        atomic_or(flags + FLAG_RECOLOURED, 1u);
}

static inline void add_contact(uint i, __global const uint2 *links, __global const uint *colours, uint *used, uint *best,
                           uint *best_rank)
{
    uint colour = colours[i];
    if (colour <= LAST_COLOUR)
        *used |= 1u << colour;
    if (colour != COLOUR_WAITS)
        return;
    uint rank = rank_of(links[i]);
    if (*best == NONE || rank > *best_rank || (rank == *best_rank && i < *best)) {
        *best = i;
        *best_rank = rank;
    }
}

__kernel void graph_colour_choose(GRAPH_COLOUR_CHOOSE_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    for (uint j = first; j < last; ++j) {
        uint id = AWAKE_AT(j);
        if (choices[id] == NONE)
            continue;
        uint taken = 0, best = NONE, best_rank = 0;
        for (uint i = starts[id]; i < starts[id + 1]; ++i)
            add_contact(i, links, colours, &taken, &best, &best_rank);
        for (uint k = return_starts[id]; k < return_starts[id + 1]; ++k)
            add_contact(returns[k], links, colours, &taken, &best, &best_rank);
        used[id] = taken;
        choices[id] = best;
    }
}

// One work-item an object, which owns the contact that it chose.
__kernel void graph_colour_take(GRAPH_COLOUR_TAKE_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    uint done = 0;
    for (uint k = first; k < last; ++k) {
        uint id = AWAKE_AT(k);
        uint i = choices[id];
        if (i == NONE || links[i].x != id)
            continue;
        uint other = links[i].y;
        uint taken = used[id];
        if (other < n && velocities[other].w > 0) { // asleep or not
            if (choices[other] != i)
                continue;
            taken |= used[other];
        }
        uint colour = popcount(taken ^ (taken + 1)) - 1; // the least bit that is not set
        colours[i] = colour <= LAST_COLOUR ? colour : COLOUR_OVERFLOW;
        ++done;
    }
    if (done) {
        atomic_sub(flags + FLAG_UNCOLOURED, done);
        atomic_max(flags + FLAG_ROUNDS, round);
    }
}

// Keys contacts by colour, and within it most points first, so that work-items side by side have as
// much to do. Contacts of COLOUR_OVERFLOW keep the order of the rows. There may be more keys than listed
// contacts: the rest push nothing.
__kernel void graph_colour_key(GRAPH_COLOUR_KEY_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_keys), n_here = N_AWAKE_CONTACTS;
    for (uint k = first; k < last; ++k) {
        uint i = k < n_here ? AWAKE_CONTACT_AT(k) : 0;
        uint colour = k < n_here ? colours[i] : COLOUR_NONE;
        list[k] = i;
        keys[k] = colour * COLOUR_KEYS + (colour <= LAST_COLOUR ? POINTS - (touches[i] & TOUCH_POINTS) : 0);
    }
}
