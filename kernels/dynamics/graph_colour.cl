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
// colour_contacts.cl does all of it in one launch. colouring.clh has what a round does.

__kernel void graph_colour_mark(GRAPH_COLOUR_MARK_ARGS)
{
    const colouring c = {GRAPH_COLOUR_MARK_VALUES};
    if (WAITS_FOR_AWAKE)
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
