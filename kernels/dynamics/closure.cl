// SPDX-License-Identifier: MIT
// Which contacts of ghosts a domain solves as well as their homes, so that ghosts need not come after each
// colour: all that what its own bodies become, between two times that ghosts come, follows from.
//
// A sweep takes one colour after the other. At its beginning all ghosts are right that a contact here has. An own
// body is right after a colour if all its contacts so far were solved, each of ends that were right; so from the
// last colour back each contact that is needed makes its ends needed, until ghosts come.
//
//   begin_ghosts  nothing is known but the colours at home
//   note_kept     colours of the contacts that are here, of each ghost; a contact that was left, and that pushes
//                 no more at home, is none of these
//   note_lacks    whether a ghost that is needed after a colour is changed by it, at home and not here
//   take_needed   contacts of a colour that are needed; before it ghosts come, if any lacks something or enough
//                 colours were taken
//   take_own      of a colour and those behind it the contacts that have an own end: all, if ghosts come after
//                 each colour
//   end_contacts  colours of contacts as they are solved here, or left
//   end_ghosts    after which colours each comes
//
//   border  [n_border] row, owner, other, and colour with bits of border.h; of one colour no two share a ghost
//   ghosts  [n] colours at home, colours of contacts that are solved here, after which the ghost comes, and of
//           contacts that are asked for
//   kept    [n] colours of contacts that are here
//   closing words of border.h
#define BELOW_ALL 0x7fffffffu // colours that are no COLOUR_OVERFLOW

// Bits of colours (from, to].
static inline uint colours_between(uint from, uint to)
{
    return (to == 31 ? 0xffffffffu : (1u << (to + 1)) - 1) & ~((1u << (from + 1)) - 1);
}

// The colour after which ghosts came last, and how many colours were taken since; none lies behind the last that
// there is.
typedef struct {
    uint came, taken, brought;
} closing_state;

static inline closing_state state_after(__global const uint *closing, uint colour)
{
    closing_state s = {LAST_COLOUR, 0, 0};
    if ((closing[CLOSING_PRESENT] & BELOW_ALL) >> colour) {
        s.came = closing[CLOSING_CAME + colour];
        s.taken = closing[CLOSING_TAKEN + colour];
        s.brought = closing[CLOSING_BROUGHT + colour];
    }
    return s;
}

// ------------------------------------------------------------ what is here

static inline bool pushes_at_home(__global const uint2 *places, __global const uint4 *ghosts, uint id, uint colour)
{
    return !is_ghost(places[id].y) || (ghosts[id].x >> colour & 1u);
}

__kernel void begin_ghosts(BEGIN_GHOSTS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        ghosts[id].yzw = 0;
        kept[id] = 0;
    }
}

__kernel void note_kept(NOTE_KEPT_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_border);
    for (uint k = first; k < last; ++k) {
        uint4 one = border[k];
        uint colour = one.w & BORDER_COLOUR;
        if ((one.w & COLOUR_LEFT) &&
            !(pushes_at_home(places, ghosts, one.y, colour) && pushes_at_home(places, ghosts, one.z, colour))) {
            border[k].w = COLOUR_LEFT | COLOUR_NONE;
            continue;
        }
        if (is_ghost(places[one.y].y))
            atomic_or(kept + one.y, 1u << colour);
        if (is_ghost(places[one.z].y))
            atomic_or(kept + one.z, 1u << colour);
        if (!(closing[CLOSING_PRESENT] >> colour & 1u))
            atomic_or(closing + CLOSING_PRESENT, 1u << colour);
    }
}

// ------------------------------------------------------------ what is needed

__kernel void note_lacks(NOTE_LACKS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    uint needed = colours_between(closing_colour, state_after(closing, closing_colour + 1).came);
    for (uint id = first; id < last; ++id)
        if (is_ghost(places[id].y) && (ghosts[id].y & needed) && ((ghosts[id].x & ~kept[id]) >> closing_colour & 1u))
            closing[CLOSING_LACKS + closing_colour] = 1;
}

static inline bool is_needed(__global const uint2 *places, __global const uint4 *ghosts, uint id, uint needed)
{
    return decides(places[id].y) || (is_ghost(places[id].y) && (ghosts[id].y & needed));
}

static inline void note_here(__global const uint2 *places, __global uint4 *ghosts, uint id, uint colour)
{
    if (is_ghost(places[id].y))
        atomic_or((volatile __global uint *)(ghosts + id) + GHOST_HERE, 1u << colour);
}

__kernel void take_needed(TAKE_NEEDED_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_border);
    uint colour = closing_colour;
    closing_state s = state_after(closing, colour + 1);
    if (s.taken >= every || closing[CLOSING_LACKS + colour]) {
        s.came = colour;
        s.taken = 0;
        s.brought |= 1u << colour;
    }
    uint needed = colours_between(colour, s.came);
    for (uint k = first; k < last; ++k) {
        uint4 one = border[k];
        if ((one.w & BORDER_COLOUR) != colour)
            continue;
        if (!is_needed(places, ghosts, one.y, needed) && !is_needed(places, ghosts, one.z, needed))
            continue;
        border[k].w = one.w | BORDER_SOLVED;
        note_here(places, ghosts, one.y, colour);
        note_here(places, ghosts, one.z, colour);
    }
    if (first == 0) {
        closing[CLOSING_CAME + colour] = s.came;
        closing[CLOSING_TAKEN + colour] = s.taken + (closing[CLOSING_PRESENT] >> colour & 1u);
        closing[CLOSING_BROUGHT + colour] = s.brought;
    }
}

__kernel void take_own(TAKE_OWN_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_border);
    for (uint k = first; k < last; ++k) {
        uint4 one = border[k];
        uint colour = one.w & BORDER_COLOUR;
        if (colour < closing_colour || !(decides(places[one.y].y) || decides(places[one.z].y)))
            continue;
        border[k].w = one.w | BORDER_SOLVED;
        note_here(places, ghosts, one.y, colour);
        note_here(places, ghosts, one.z, colour);
    }
}

// ------------------------------------------------------------ what comes of it

__kernel void end_contacts(END_CONTACTS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_border), foreign = 0;
    for (uint k = first; k < last; ++k) {
        uint4 one = border[k];
        uint colour = one.w & BORDER_COLOUR;
        uint2 kinds = (uint2)(places[one.y].y, places[one.z].y);
        bool is_solved = one.w & BORDER_SOLVED;
        foreign += is_solved && !(kinds.x & PLACE_OWN);
        if (decides(kinds.x) || decides(kinds.y))
            continue;
        colours[one.x] = is_solved ? colour : COLOUR_LEFT | colour;
        if (is_solved && (one.w & COLOUR_LEFT)) {
            uint asked = is_ghost(kinds.x) ? one.y : one.z;
            atomic_or((volatile __global uint *)(ghosts + asked) + GHOST_ASKED, 1u << colour);
        }
    }
    if (foreign)
        atomic_add(closing + CLOSING_FOREIGN, foreign);
}

// Leaves the times at which a ghost is wrong, of those at which it is needed.
static inline uint wrong_times(uint wanted, uint at_home, uint here)
{
    uint lost = at_home & ~here & BELOW_ALL, comes = 0;
    bool is_wrong = false;
    for (uint colour = 0; lost != 0 && colour <= LAST_COLOUR; ++colour) {
        is_wrong = is_wrong || (lost >> colour & 1u);
        if (is_wrong && (wanted >> colour & 1u)) {
            comes |= 1u << colour;
            is_wrong = false;
        }
    }
    return here != 0 && is_wrong ? comes | 1u << COLOUR_OVERFLOW : comes;
}

// Contacts of a ghost that are not known here are asked for: the next step may solve them.
__kernel void end_ghosts(END_GHOSTS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    uint brought = every == 1 ? BELOW_ALL : closing[CLOSING_BROUGHT];
    for (uint id = first; id < last; ++id) {
        uint4 ghost = ghosts[id];
        if (!is_ghost(places[id].y))
            continue;
        uint wanted = 0, before = LAST_COLOUR;
        for (uint left = brought; left != 0;) {
            uint colour = 31 - clz(left);
            wanted |= ghost.y & colours_between(colour, before) ? 1u << colour : 0;
            before = colour;
            left ^= 1u << colour;
        }
        ghosts[id].z = wrong_times(wanted, ghost.x, ghost.y);
        if (every > 1 && ghost.y != 0)
            ghosts[id].w = ghost.w | (ghost.x & ~kept[id] & BELOW_ALL);
    }
}
