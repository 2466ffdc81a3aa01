// SPDX-License-Identifier: MIT
// Bodies while a step is solved, from the domains whose own they are to those that have them as
// ghosts. Lists of both sides ascend alike, so no message says which is which: items as long as
// bodies stay in their domains, and in each step those of them that come after a colour.
#ifndef CLUSTER_HALO_H
#define CLUSTER_HALO_H

#include "cluster/list.h"
#include "cluster/parcels.h"
#include "runtime/dynamics/domain_motion.h"

// A ghost, at the side that sends it or at the one that has it.
typedef struct halo_item {
    uint32_t rank;     // the other side's
    uint32_t to, from; // domains
    uint32_t id;
    uint32_t domain, place; // at this side, of this rank's domains
} halo_item;

// Lists of ghosts: all; those that come after a colour, which have numbers from 0; after all
// colours; none; those that any contact leaves wrong; and those that have contacts at home and none
// here, which nobody asks for before the step ends; and those that sleep deep in others, which
// alone have ways.
enum {
    HALO_COLOURS = 31,
    HALO_END = HALO_COLOURS,
    HALO_NONE,
    HALO_ANY,
    HALO_LATE,
    HALO_PRESSED,
    HALO_ALL,
    HALO_LISTS
};

// Bits for colours of a ghost's contacts. `comes` has colours after which the ghost is to be sent;
// HALO_END: after all.
typedef struct ghost_colours {
    uint32_t at_home; // of all its contacts
    uint32_t here;    // of those that are solved here
    uint32_t comes;
    uint32_t asked; // of those that are to be sent from its home
} ghost_colours;

// Items of one domain that follow each other in a list.
typedef struct halo_run {
    uint32_t domain;
    uint32_t first, n;
} halo_run;

typedef LIST_OF(halo_run, runs) halo_runs;

// The items at one side.
typedef struct halo_side {
    item_list items; // halo_item
    row_list places; // of all lists, that of all items first; each device has them
    uint32_t first[HALO_LISTS], n[HALO_LISTS]; // of each list in there
    halo_runs runs[HALO_LISTS];
    uint64_t *counts; // [HALO_LISTS][ranks] items of each list
    uint8_t *pressed; // [items] 1: it is to be pushed out of what it sleeps in; else 0
    host_block block; // memory that rows go and come by
    parcels rows;     // they lie in it
} halo_side;

typedef struct halo {
    halo_side sent, received;
    MPI_Request *requests;
    // so far: exchanges in which this rank had rows to send or to receive, rows that it sent, and
    // contacts that came as they were asked for
    uint64_t n_exchanges, n_rows, n_asked;
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

// Tells those that have ghosts the colours that these have at home; and those whose own they are
// when they are to come back, and which contacts with them. Both are collective and need agreement.
void halo_tell_home(halo *h, struct moving *m, duet_error *own);
void halo_ask(halo *h, struct moving *m, duet_error *own);

// Brings the contacts that were asked for. Collective; a rank may have failed alone after it.
bool halo_bring_asked(halo *h, struct moving *m, duet_error *own);

// Makes velocities those of the ghosts' own domains after contacts of a colour, or of all
// (HALO_END); HALO_ANY: of all that any contact leaves wrong.
void halo_exchange_after(halo *h, struct moving *m, uint32_t colour, duet_error *own);

// The same in two calls, between which devices work on bodies that are no ghost of any domain:
// begin returns how many requests end waits for.
int halo_begin_after(halo *h, struct moving *m, uint32_t colour, duet_error *own);
void halo_end_after(halo *h, struct moving *m, uint32_t colour, int n, duet_error *own);

// Makes flags of sleep (ASLEEP) those of the ghosts' own domains, and notes which are pressed.
void halo_exchange_asleep(halo *h, struct moving *m, duet_error *own);

// Makes the ways of all ghosts that are pressed, which are a vector of their bodies, those of a
// round.
void halo_exchange_ways(halo *h, struct moving *m, uint32_t round, duet_error *own);

// Makes of the bodies of HALO_LATE all that a step changes that of their own domains, in two calls
// between which no device works on bodies.
int halo_begin_late(halo *h, struct moving *m, duet_error *own);
void halo_end_late(halo *h, struct moving *m, int n, duet_error *own);

// Whether this rank sends or receives something then.
bool halo_comes(const halo *h, uint32_t colour);

// Contacts of a colour that are worth a launch beside a message, which takes longer to another
// host.
uint32_t halo_least_inner(const ranks *r);

#endif
