// SPDX-License-Identifier: MIT
// Contacts of a domain whose bodies get other places: those with a shared end travel, and the others
// stay where they lie.
//
//   places  [n + FIXED] before: id, and bits of border.h
//   moved   [n + FIXED] the places that they get
//   links   NO_PLACE twice: none is here any more
__kernel void keep_contacts(KEEP_CONTACTS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_contacts);
    for (uint i = first; i < last; ++i) {
        uint2 link = links[i];
        if (link.x == NO_PLACE)
            continue;
        bool travels = (places[link.x].y | places[link.y].y) & PLACE_SHARED;
        links[i] = travels ? (uint2)(NO_PLACE) : (uint2)(moved[link.x], moved[link.y]);
    }
}
