// SPDX-License-Identifier: MIT
// Random commands to bodies, for motions that are all given the same.
#ifndef TESTS_ORDERS_H
#define TESTS_ORDERS_H

#include "runtime/duet.h"

#include "base/rng.h"

enum { ORDER_ROWS = 12, ORDER_IDS = 4096 };

typedef enum verb {
    ADD,
    REMOVE,
    SET,
    SET_POSES,
    FORCE,
    IMPULSE,
    AIM,
    DISABLE,
    ENABLE,
    PUT_TO_SLEEP,
    WAKE,
    NAME,
    CHANGE,
    VERBS
} verb;

// The arguments of one command.
typedef struct order {
    uint32_t n;
    uint64_t ids[ORDER_ROWS], data[ORDER_ROWS];
    duet_pose poses[ORDER_ROWS];
    duet_body bodies[ORDER_ROWS];
    duet_force forces[ORDER_ROWS];
    duet_impulse impulses[ORDER_ROWS];
    duet_transform targets[ORDER_ROWS];
    uint32_t fields;
    double gravity[3];
} order;

// The bodies that orders are for: those that there are, and those that were removed.
typedef struct known_ids {
    uint64_t ids[ORDER_IDS], stale[ORDER_IDS];
    uint32_t n, n_stale;
} known_ids;

// Draws orders.
typedef struct orders {
    rng r;
    known_ids known;
    double at[3], size; // bodies come there
    bool is_flat;
    bool turns;      // bodies turn
    bool touches;    // bodies touch, and sleep
    uint32_t most;   // rows of an order
    uint32_t fields; // that are set are below this
} orders;

duet_pose orders_pose(orders *o);
duet_body orders_body(orders *o);
verb orders_verb(orders *o); // that the world takes
order orders_draw(orders *o, verb what);
uint64_t orders_stale_id(orders *o); // one or more were removed

void orders_added(orders *o, const order *given, const uint64_t *came);
void orders_removed(orders *o, const order *given);

#endif
