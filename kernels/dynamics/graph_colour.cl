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
// A team (team.clh) does all of it, and sorts, in one launch: colour_contacts. A GPU whose groups meet takes all rounds
// in one: colour_rounds.cl. colouring.clh has what a round does.

static inline bool is_pushing(const colouring *c, uint i, uint2 link)
{
    bool pushes = (c->touches[i] & TOUCH_POINTS) && (c->bodies[(size_t)link.x * BODY + BODY_VELOCITY].w > 0.0f ||
                                                     c->bodies[(size_t)link.y * BODY + BODY_VELOCITY].w > 0.0f);
#if SENSORS
    pushes = pushes && !(c->sensors[link.x] > 0.0f || (link.y < c->n && c->sensors[link.y] > 0.0f));
#endif
    return pushes;
}

// Marks contacts that begin or cease to push.
static inline void mark_contacts(const colouring *c, uint first, uint last)
{
    uint waiting = 0, changed = 0;
    for (uint k = first; k < last; ++k) {
        uint i = AWAKE_CONTACT_OF(c, k);
        uint2 link = c->links[i];
        uint old = c->colours[i];
        uint colour = !is_pushing(c, i, link) ? COLOUR_NONE : old == COLOUR_NONE ? COLOUR_WAITS : old;
        changed |= colour != old;
        c->colours[i] = colour;
        if (colour != COLOUR_WAITS)
            continue;
        ++waiting;
        atomic_xchg(c->choices + link.x, i);
        if (link.y < c->n)
            atomic_xchg(c->choices + link.y, i);
    }
    if (waiting)
        atomic_add(c->flags + FLAG_UNCOLOURED, waiting);
    if (changed)
        atomic_or(c->flags + FLAG_RECOLOURED, 1u);
}

__kernel void graph_colour_mark(GRAPH_COLOUR_MARK_ARGS)
{
    const colouring c = {GRAPH_COLOUR_MARK_VALUES};
    if (WAITS_FOR_LISTS)
        return;
    uint first = get_global_id(0) * PER_ITEM;
    mark_contacts(&c, first, min(first + PER_ITEM, N_AWAKE_CONTACTS));
}

__kernel void graph_colour_choose(GRAPH_COLOUR_CHOOSE_ARGS)
{
    const colouring c = {GRAPH_COLOUR_CHOOSE_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    choose_contacts(&c, first, min(first + PER_ITEM, N_AWAKE));
}

__kernel void graph_colour_take(GRAPH_COLOUR_TAKE_ARGS)
{
    const colouring c = {GRAPH_COLOUR_TAKE_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    take_contacts(&c, round, first, min(first + PER_ITEM, N_AWAKE));
}

static inline uint key_of(uint colour, uint touch)
{
    return COLOUR_KEY(colour, COLOUR_KEYS) + (colour <= LAST_COLOUR ? POINTS - (touch & TOUCH_POINTS) : 0);
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
        uint colour = k < n_here ? min(colours[i], (uint)COLOUR_NONE) : COLOUR_NONE;
        list[k] = i;
        keys[k] = key_of(colour, touches[i]);
    }
}

#if TEAM

#define KEYS COLOUR_KEY(COLOURS, COLOUR_KEYS)
#define PUSHING_KEYS COLOUR_KEY(COLOUR_WAITS, COLOUR_KEYS)

// Counts the keys of a part's contacts that push.
static inline void count_keys(const colouring *c, uint part, uint2 range)
{
    uint counts[PUSHING_KEYS] = {0};
    for (uint k = range.x; k < range.y; ++k) {
        uint i = AWAKE_CONTACT_OF(c, k);
        uint colour = c->colours[i];
        uint key = colour < COLOUR_WAITS ? key_of(colour, c->touches[i]) : NONE;
        c->keys[k] = key;
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

//   sorts  1: lists contacts even if none has another colour than before
__kernel void colour_contacts(COLOUR_CONTACTS_ARGS)
{
    const colouring c = {COLOUR_CONTACTS_VALUES};
    team_member t = TEAM_MEMBER;
    if (WAITS_FOR_LISTS)
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
