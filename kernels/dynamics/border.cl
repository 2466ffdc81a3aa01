// SPDX-License-Identifier: MIT
// Contacts of a domain that is one of many: its host looks at those that wait for a colour which more than this
// domain's contacts decide, and at those that travel.
//
// Invariant: choices of shared bodies are NONE, so that graph_colour_take takes none of their contacts, and
// none of lesser rank beside these: what it takes has the colour that all domains together would find.
//
//   mark_border   contacts that begin to push wait, as in graph_colour_mark; those of ghosts alone only if they
//                 may be solved here
//   choose_inner  as graph_colour_choose; ranks come from ids, which here are no places
//   count_border  1 for each contact that is listed
//   list_border   which these are
//   used_colours  of some bodies: a bit for each colour that their contacts have
//   border_key    what contacts are sorted by, as in graph_colour_key; of a colour those come first that have a ghost, or
//                 a body that is one elsewhere
//
//   places        [n + FIXED] id, and bits of border.h
//   border_starts [n_contacts + 1]
//   border        row, owner, other and colour of each that is listed; rows ascend
static inline bool is_awake(uint kind, uint asleep)
{
    return (kind & PLACE_MOVES) && !(asleep & SLEEPS);
}

#if SLEEP
#define IS_AWAKE(place) is_awake(places[place].y, asleep[place])
#else
#define IS_AWAKE(place) is_awake(places[place].y, 0)
#endif

__kernel void mark_border(MARK_BORDER_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_contacts), waiting = 0;
    for (uint i = first; i < last; ++i) {
        uint2 link = links[i], kind = (uint2)(places[link.x].y, places[link.y].y);
        uint old = colours[i];
        if (old & COLOUR_LEFT)
            continue;
        bool pushes = (touches[i] & TOUCH_POINTS) && !((kind.x | kind.y) & PLACE_SENSOR) &&
                      (IS_AWAKE(link.x) || IS_AWAKE(link.y)) && (every > 1 || decides(kind.x) || decides(kind.y));
        uint colour = !pushes ? COLOUR_NONE : old == COLOUR_NONE ? COLOUR_WAITS : old;
        colours[i] = colour;
        if (colour != COLOUR_WAITS)
            continue;
        ++waiting;
        if (!(kind.x & PLACE_SHARED))
            atomic_xchg(choices + link.x, i);
        if ((kind.y & (PLACE_MOVES | PLACE_SHARED)) == PLACE_MOVES)
            atomic_xchg(choices + link.y, i);
    }
    if (waiting)
        atomic_add(flags + FLAG_UNCOLOURED, waiting);
}

static inline void add_contact(uint i, __global const uint2 *links, __global const uint *colours,
                               __global const uint2 *places, colour_choice *choice)
{
    uint colour = colours[i];
    if (colour <= LAST_COLOUR)
        choice->used |= 1u << colour;
    if (colour == COLOUR_WAITS)
        choose_waiting(choice, i, (uint2)(places[links[i].x].x, places[links[i].y].x));
}

__kernel void choose_inner(CHOOSE_INNER_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        colour_choice choice = {0, NONE, 0};
        if (choices[id] == NONE)
            continue;
        const body_row row = row_of(starts, return_starts, returns, id);
        for (uint k = 0; k < row.n; ++k)
            add_contact(contact_of(&row, k), links, colours, places, &choice);
        used[id] = choice.used;
        choices[id] = choice.best;
    }
}

static inline bool is_told(uint kind, uint other, uint colour, uint touch, uint listed)
{
    if (listed == LISTED_WAITING)
        return colour == COLOUR_WAITS || colour == COLOUR_OVERFLOW;
    if (listed == LISTED_GHOSTS)
        return (colour & BORDER_COLOUR) <= COLOUR_OVERFLOW && (is_ghost(kind) || is_ghost(other));
    if (!(touch & TOUCH_POINTS))
        return false;
    if (listed == LISTED_SHARED)
        return (kind | other) & PLACE_SHARED;
    const uint sent = PLACE_OWN | PLACE_MOVES | PLACE_SHARED;
    return ((kind & PLACE_MOVES ? kind : other) & sent) == sent;
}

__kernel void count_border(COUNT_BORDER_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_contacts + 1);
    for (uint i = first; i < last; ++i) {
        uint2 link = i < n_contacts ? links[i] : (uint2)(NO_PLACE);
        bool told = link.x != NO_PLACE && is_told(places[link.x].y, places[link.y].y, colours[i], touches[i], listed);
        border_starts[i] = told ? 1 : 0;
    }
}

__kernel void list_border(LIST_BORDER_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_contacts);
    for (uint i = first; i < last; ++i)
        if (border_starts[i] != border_starts[i + 1])
            border[border_starts[i]] = (uint4)(i, links[i].x, links[i].y, colours[i]);
}

__kernel void border_key(BORDER_KEY_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_contacts);
    for (uint i = first; i < last; ++i) {
        uint colour = min(colours[i], (uint)COLOUR_NONE), key = COLOUR_KEY(colour, BORDER_KEYS);
        uint kinds = places[links[i].x].y | places[links[i].y].y;
        if (colour <= LAST_COLOUR)
            key += (kinds & (PLACE_SHARED | PLACE_SENT) ? 1 : 2) * COLOUR_KEYS - (touches[i] & TOUCH_POINTS);
        list[i] = i;
        keys[i] = key;
    }
}

static inline uint bit_of(uint colour)
{
    return colour <= COLOUR_OVERFLOW ? 1u << colour : 0;
}

__kernel void used_colours(USED_COLOURS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_ids);
    for (uint k = first; k < last; ++k) {
        const body_row row = row_of(starts, return_starts, returns, row_ids[first_id + k]);
        uint used = 0;
        for (uint i = 0; i < row.n; ++i)
            used |= bit_of(colours[contact_of(&row, i)]);
        gathered[k] = used;
    }
}
