// SPDX-License-Identifier: MIT
// Contacts that a domain left to their homes, and needs again (closure.cl): it asks for each by a ghost and a colour
// that it has at home.
//
//   read_asked  the contacts that others ask for
//   take_asked  those that came
//
//   asked    [n_ids] place and colour
//   gathered [n_ids] ids of owner and other, touches, and the record

__kernel void read_asked(READ_ASKED_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_ids);
    for (uint j = first; j < last; ++j) {
        const body_row all = row_of(starts, return_starts, returns, asked[j].x);
        uint row = NO_PLACE;
        for (uint k = 0; k < all.n; ++k)
            row = colours[contact_of(&all, k)] == asked[j].y ? contact_of(&all, k) : row;
        __global uint *to = gathered + (size_t)j * (ASKED_RECORD + row_words);
        to[0] = row == NO_PLACE ? NO_PLACE : places[links[row].x].x;
        to[1] = row == NO_PLACE ? NO_PLACE : places[links[row].y].x;
        to[2] = row == NO_PLACE ? 0 : touches[row];
        for (uint k = 0; row != NO_PLACE && k < row_words; ++k)
            to[ASKED_RECORD + k] = as_uint(contacts[(size_t)row * row_words + k]);
    }
}

// A contact that was mistaken for the one that came is unknown from now on, and one that is taken as solved by another
// colour than it has was mistaken, too. One that is not solved here is left at home in this step.
__kernel void take_asked(TAKE_ASKED_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n_ids);
    for (uint j = first; j < last; ++j) {
        const body_row all = row_of(starts, return_starts, returns, asked[j].x);
        uint row = NO_PLACE;
        __global const uint *from = gathered + (size_t)j * (ASKED_RECORD + row_words);
        for (uint k = 0; k < all.n; ++k) {
            uint i = contact_of(&all, k);
            if (places[links[i].x].x == from[0] && places[links[i].y].x == from[1]) {
                row = i;
            } else if (colours[i] == asked[j].y) {
                colours[i] = COLOUR_LEFT | COLOUR_NONE;
                atomic_inc(closing + CLOSING_MISTAKEN);
            }
        }
        if (row == NO_PLACE)
            continue;
        touches[row] = from[2];
        for (uint k = 0; k < row_words; ++k)
            contacts[(size_t)row * row_words + k] = as_float(from[ASKED_RECORD + k]);
        if (colours[row] != asked[j].y) {
            if (colours[row] <= COLOUR_OVERFLOW)
                atomic_inc(closing + CLOSING_MISTAKEN);
            colours[row] = COLOUR_LEFT | asked[j].y;
        }
    }
}
