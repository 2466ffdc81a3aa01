// SPDX-License-Identifier: MIT
// Contacts that wait for colours which several domains decide. A rank is told of those that have a
// body which it has, as its own or as a ghost: so it knows all that waits of its own bodies, and of
// the ghosts that these touch. Ranks colour in rounds, and tell what they found, until none waits.
#ifndef CLUSTER_WAITING_H
#define CLUSTER_WAITING_H

#include "cluster/colouring.h"
#include "cluster/list.h"

typedef LIST_OF(waiting_contact, contacts) waiting_list;

struct moving;

// `known` has those that this rank's domains decide, and becomes all that it knows of, sorted, with
// colours; of two ghosts, only if those are solved, too. Collective.
bool waiting_colour(struct moving *m, waiting_list *known, duet_error *own);

#endif
