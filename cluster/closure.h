// SPDX-License-Identifier: MIT
// Which contacts near the borders of domains are solved there as well as at home, so that ghosts
// need not come after each colour: all that what a domain's own bodies become, between two times
// that ghosts come, follows from.
//
// A sweep takes one colour after the other. At its beginning all ghosts are right that a contact
// here has. An own body is right after a colour if all its contacts so far were solved, each of
// ends that were right; so from the last colour back each contact that is needed makes its ends
// needed, until ghosts come.
#ifndef CLUSTER_CLOSURE_H
#define CLUSTER_CLOSURE_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

enum { CLOSURE_COLOURS = 31, CLOSURE_END = CLOSURE_COLOURS };

#define CLOSURE_NONE UINT32_MAX

// Bits for colours. Those of `comes` are colours after which the ghost is to be sent; CLOSURE_END:
// after all.
typedef struct ghost_colours {
    uint32_t at_home; // of all its contacts
    uint32_t here;    // of those that are solved here
    uint32_t comes;
    uint32_t watched; // 1: or its neighbour has contacts that are solved here; the caller's
} ghost_colours;

typedef struct border_contact {
    uint32_t ghosts[2]; // CLOSURE_NONE: this end is the domain's own, or never moves
    uint32_t colour;    // CLOSURE_COLOURS: solved in order, after all colours
    uint32_t row;       // the caller's
    bool is_solved;     // as it has an own end; and found of the others
} border_contact;

typedef struct closure {
    uint32_t every;        // ghosts come after so many colours at the latest
    ghost_colours *ghosts; // [n_ghosts] whose colours at home are known
    uint64_t n_ghosts;
    border_contact *contacts; // of one colour no two share a ghost
    uint64_t n_contacts;
} closure;

// Finds what is solved here, and after which colours ghosts come. Where a ghost's contact is not
// here ghosts come sooner, so that own bodies are right whatever is there.
bool closure_find(closure *c, duet_error *err);

#endif
