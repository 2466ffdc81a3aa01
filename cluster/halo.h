// SPDX-License-Identifier: MIT
// Bodies while a step is solved, from the domains whose own they are to those that have them as
// ghosts. Lists of both sides are made once a step, and ascend alike: no message says which is
// which.
#ifndef CLUSTER_HALO_H
#define CLUSTER_HALO_H

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

typedef struct halo {
    item_list sent, received; // halo_item
    parcels out, in;
    MPI_Request *requests;
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

#endif
