// SPDX-License-Identifier: MIT
// Bodies while a step is solved, from the domains whose own they are to those that have them as
// ghosts. Lists of both sides ascend alike, so no message says which is which: items as long as
// bodies stay in their domains, and in each step those of them that come after a colour.
#ifndef CLUSTER_HALO_H
#define CLUSTER_HALO_H

#include "cluster/closure.h"
#include "cluster/list.h"
#include "cluster/parcels.h"
#include "runtime/dynamics/motion.h"

// A ghost, at the side that sends it or at the one that has it.
typedef struct halo_item {
    uint32_t rank;     // the other side's
    uint32_t to, from; // domains
    uint32_t id;
    uint32_t domain, place; // at this side, of this rank's domains
} halo_item;

// Lists of ghosts: those that come after a colour, which have numbers from 0; after all colours;
// those that any contact leaves wrong; and those that have contacts at home and none here, which
// nobody asks for before the step ends.
enum { HALO_COLOURS = CLOSURE_COLOURS, HALO_END = CLOSURE_END, HALO_ANY, HALO_LATE, HALO_LISTS };

// The items at one side.
typedef struct halo_side {
    item_list items;                  // halo_item
    ghost_colours *colours;           // [items], of the step
    row_list comes_after[HALO_LISTS]; // items that are then to be sent
    uint32_t *places;                 // [items] of those that travel
    parcels rows;
} halo_side;

typedef struct halo {
    halo_side sent, received;
    MPI_Request *requests;
    uint64_t n_exchanges; // so far, in which this rank had rows to send or to receive
} halo;

struct moving;

void halo_end(halo *h);
void halo_clear(halo *h);
void halo_add(item_list *items, const halo_item *item);

// Sorts both lists, finds places, and reserves what all exchanges of a step need. Collective.
bool halo_settle(halo *h, struct moving *m, duet_error *own);

// Makes all ghosts' rows of a buffer by object those of their own domains. A rank that has failed,
// or fails, sends rows all the same, so that no exchange of a step needs agreement.
void halo_exchange(halo *h, struct moving *m, motion_buffer which, duet_error *own);

// Tells those that have ghosts the colours that these have at home, as domains know them of their
// bodies (moving_domain.used); and those whose own they are when they are to come back. Both are
// collective and need agreement.
void halo_tell_home(halo *h, struct moving *m);
void halo_ask(halo *h, struct moving *m, duet_error *own);

// Makes velocities, and the impulses to warm start with, those of the ghosts' own domains after
// contacts of a colour, or of all (HALO_END); HALO_ANY: of all that any contact leaves wrong.
void halo_exchange_after(halo *h, struct moving *m, uint32_t colour, bool warm, duet_error *own);

// Makes all of the bodies of HALO_LATE those of their own domains.
void halo_exchange_late(halo *h, struct moving *m, duet_error *own);

// Whether this rank sends or receives something then.
bool halo_comes(const halo *h, uint32_t colour);

#endif
