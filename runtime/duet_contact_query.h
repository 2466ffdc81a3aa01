// SPDX-License-Identifier: MIT
// Contact queries: normal, depth and points of pairs of still objects, which a world found or
// the caller brings.
#ifndef DUET_CONTACT_QUERY_H
#define DUET_CONTACT_QUERY_H

#include "duet_motion.h"

DUET_C_BEGIN

typedef struct duet_contact_query duet_contact_query;

typedef struct duet_contact_query_def {
    duet_device_pair *pair; // held until the query is destroyed
    uint32_t share;         // A's part of the pairs, out of DUET_SHARE_ONE; 0: B alone;
                            // DUET_SHARE_DEFAULT: the share of the pair's default plan
    uint32_t dims;          // 2 or 3
    duet_shape shape;       // shape of the objects: poses, rounded boxes or spheres
    float margin;           // greatest separation of a point
    int cookie;
} duet_contact_query_def;

DUET_API duet_contact_query_def duet_default_contact_query_def(void); // 3D poses, margin 0

typedef struct duet_contact_query_result {
    const duet_contact *contacts; // [n_contacts] the query's, until its next call
    uint64_t n_contacts;          // one for each pair, in the pairs' order
    uint64_t touching;            // contacts that have points
    double total_ms;              // wall clock
    double device_ms[2];          // time of each device's part
} duet_contact_query_result;

// Creates a query and builds its kernels.
DUET_API duet_contact_query *duet_contact_query_create(const duet_contact_query_def *def,
                                                       duet_error *err);
DUET_API void duet_contact_query_destroy(duet_contact_query *query);

// Finds where the pairs of both spans, such as a duet_result's, touch among n objects. kind is
// the kind of the def's shape.
//
// The normal points from a to b, and each anchor from a's centre to halfway between the two
// surfaces. A pair that collides has 1 to 4 points. A pair separated by less than the margin
// has points if faces or edges are opposite each other, and at least one point if an object has a
// radius; other pairs have no points, and normal 0. Impulses are 0.
// docs/accuracy.md, "Contacts", bounds the errors. A contact depends on its two objects alone: it
// is the same on every device and at every share, and (b, a) has the points of (a, b).
//
// BAD_ARGUMENT names the first pair with an id that is not below n, BAD_OBJECT the first pair with
// an object that is NaN, infinite, negative or without rotation.
DUET_API bool duet_contact_query_run(duet_contact_query *query, duet_object_kind kind,
                                     const void *objects, uint32_t n, const duet_span spans[2],
                                     duet_contact_query_result *result, duet_error *err);

DUET_C_END

#endif
