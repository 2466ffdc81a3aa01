// SPDX-License-Identifier: MIT
// Which pairs touch, over all domains: a contact is told by the domain whose own its owner was in
// the step. So what one rank tells is known to it alone, and all ranks together tell what one
// motion does.
#ifndef CLUSTER_MOVING_EVENTS_H
#define CLUSTER_MOVING_EVENTS_H

#include "runtime/dynamics/pair_list.h"

// Of all this rank's domains, by global ids.
typedef struct moving_events {
    pair_list before, now; // told pairs that touch
    pair_changes changes;
    duet_hit_event *hits;
    size_t n_hits, capacity;
} moving_events;

struct moving;
struct moving_domain;
struct domain_contacts;

void moving_events_end(moving_events *e);

// Notes what touched when the step began, while all domains have the contacts that it began with.
void moving_begin_events(struct moving *m, duet_error *own);

// Adds a domain's contacts that touch now: told [c->n], as domain_read_told has it.
void moving_add_touching(struct moving *m, const struct moving_domain *d,
                         const struct domain_contacts *c, const uint8_t *told, duet_error *own);

// Finds what changed, and what hit, before bodies change domains.
void moving_find_events(struct moving *m, duet_error *own);

#endif
