// SPDX-License-Identifier: MIT
// What a step makes of the bodies, each product from the one before it:
//
//     bodies -> bounds -> pairs -> rows -> awake -> manifolds -> colours
//       ^                                                           |
//       +--------------------- the end of a step -------------------+
//
// A product has a stamp, a new one each time it is made, and knows the stamp of what it was made
// from. It is right while its input still has that stamp. To have a product is to make it, after
// those before it, if it is not right (ensure in motion_step.c); nothing else says what is stale.
//
//   renew   it was made from its input as that is now, and what was made from it is stale
//   keep    a check found that it holds of its input as that is now, so what was made from it stays
//           right: bounds that no body left, colours if no contact begins or ceases to push
//   forget  it is wrong, and no check can help: pairs once commands altered a body, colours once
//           the rows are others, what is awake once something woke or fell asleep
//
// Bodies are made from bodies: those that a step leaves as it found them are right, and need no
// step. Manifolds depend on rows and on where bodies are, so they are forgotten when bodies move.
#ifndef RUNTIME_PRODUCTS_H
#define RUNTIME_PRODUCTS_H

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

typedef enum product_name {
    PRODUCT_BODIES,    // their poses
    PRODUCT_BOUNDS,    // a fat AABB of each
    PRODUCT_PAIRS,     // bodies whose bounds overlap
    PRODUCT_ROWS,      // the contacts of each body
    PRODUCT_AWAKE,     // lists of the bodies and contacts that a step may change
    PRODUCT_MANIFOLDS, // the points where contacts touch
    PRODUCT_COLOURS,   // a colour of each contact, and the contacts by colour
    PRODUCTS
} product_name;

typedef struct product {
    uint64_t stamp;     // 0: never made
    uint64_t made_from; // the input's stamp; 0: never made, or forgotten
} product;

typedef struct products {
    product of[PRODUCTS];
    uint64_t last;   // the greatest stamp
    uint64_t before; // the greatest stamp when the last step began
} products;

static inline uint64_t product_input(const products *p, product_name which)
{
    return p->of[which == PRODUCT_BODIES ? which : which - 1].stamp;
}

static inline bool product_is_right(const products *p, product_name which)
{
    return p->of[which].made_from != 0 && p->of[which].made_from == product_input(p, which);
}

static inline bool product_is_forgotten(const products *p, product_name which)
{
    return p->of[which].made_from == 0;
}

static inline bool product_was_made(const products *p, product_name which)
{
    return p->of[which].stamp != 0;
}

// Whether it was made in the last step, or is in this one.
static inline bool product_is_new(const products *p, product_name which)
{
    return p->of[which].stamp > p->before;
}

static inline void product_keep(products *p, product_name which)
{
    p->of[which].made_from = product_input(p, which);
}

static inline void product_renew(products *p, product_name which)
{
    p->of[which] = (product){.stamp = ++p->last, .made_from = product_input(p, which)};
}

static inline void product_forget(products *p, product_name which)
{
    p->of[which].made_from = 0;
}

// Forgets it as one that was never made.
static inline void product_drop(products *p, product_name which)
{
    p->of[which] = (product){0};
}

// Bodies are elsewhere.
static inline void products_move_bodies(products *p)
{
    product_renew(p, PRODUCT_BODIES);
    product_forget(p, PRODUCT_MANIFOLDS);
}

// Returns the products of a saved motion, with rows or without: its bodies may have left the bounds
// since.
static inline products products_of_saved(bool rows)
{
    products p = {.last = 1, .of[PRODUCT_BODIES].stamp = 1};
    for (int which = PRODUCT_BOUNDS; rows && which <= PRODUCT_ROWS; ++which)
        product_renew(&p, (product_name)which);
    products_move_bodies(&p);
    return p;
}

static inline void products_assert(const products *p)
{
    for (int which = 0; which < PRODUCTS; ++which) {
        const product *q = &p->of[which];
        assert(q->stamp <= p->last && q->made_from <= p->last);
        assert(q->made_from == 0 || q->stamp != 0);
        (void)q;
    }
    assert(p->before <= p->last);
}

#endif
