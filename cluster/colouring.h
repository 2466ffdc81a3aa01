// SPDX-License-Identifier: MIT
// The colours of contacts that begin to push, over all ranks: each takes the least colour that both
// its ends have free, after all contacts of greater rank. Ranks come from ids, so that is what the
// rounds of kernels/dynamics/graph_colour.cl lead to, wherever the domains' borders lie.
#ifndef CLUSTER_COLOURING_H
#define CLUSTER_COLOURING_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

// A contact that waits for a colour, as one domain knows it: an end that is not the domain's own
// has 0 as the colours taken.
typedef struct waiting_contact {
    uint32_t owner, other;           // ids; the owner moves
    uint32_t other_moves;            // 1, or 0
    uint32_t owner_used, other_used; // a bit for each colour that the end's contacts have
    uint32_t colour;                 // COLOUR_WAITS until it has one
    uint32_t is_decided_here;        // 1: all that waits of an end is known here; else 0
} waiting_contact;

// Sorts n contacts by owner and other, and merges those that two domains know. Returns how many
// there are.
uint64_t colouring_sort(waiting_contact *contacts, uint64_t n);

// Sorts them, and gives a colour to each that is decided here once all of greater rank which share
// an end with it have one; *n becomes how many there are, and *n_left how many that are decided
// here still wait.
bool colouring_run(waiting_contact *contacts, uint64_t *n, uint64_t *n_left, duet_error *err);

// Returns the place of a contact among sorted ones; n: it is not there.
uint64_t colouring_place(const waiting_contact *contacts, uint64_t n, uint32_t owner,
                         uint32_t other);

// Returns the contact's colour; COLOUR_NONE: it does not wait.
uint32_t colouring_find(const waiting_contact *contacts, uint64_t n, uint32_t owner,
                        uint32_t other);

#endif
