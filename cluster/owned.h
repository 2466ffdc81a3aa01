// SPDX-License-Identifier: MIT
// The objects that a rank owns, and the domains that they lie in.
//
// A domain is a box of the world. A rank has one, or several (--parts) that its devices search one
// after the other. A place is a domain among the domains of all ranks: rank * most_domains +
// domain.
//
//   rows   | those that were there, with leavers | newcomers | space for ghosts
//
// 1. Rows keep their places within a step, because devices may be reading them. An object that
//    leaves its rank stays as a leaver, which nobody searches; one that arrives is written behind
//    all others. owned_tidy closes the gaps before the next step.
// 2. An object lies in the domain whose box holds its centre, wherever its row is. Placing brings
//    the rows of each domain together; later they lie in runs.
// 3. The rows of a single domain lie in the memory of the worker that searches them. Several
//    domains lie in the rank's own memory, and workers get copies of one after the other.
#ifndef CLUSTER_OWNED_H
#define CLUSTER_OWNED_H

#include "cluster/list.h"
#include "cluster/owner.h"
#include "cluster/parallel.h"
#include "cluster/partition.h"
#include "cluster/worker.h"

// Rows [first, first + n) whose objects lie in one domain.
typedef struct row_run {
    uint32_t domain;
    uint32_t first, n;
    uint32_t at; // how many of the domain's rows come before, once runs are sorted by domain
} row_run;

typedef LIST_OF(row_run, runs) run_list;

static inline void run_list_add(run_list *l, row_run run)
{
    list_add(&l->list, &run, 1, sizeof run);
}

typedef struct domain {
    extent box;   // holds the centres of its objects
    uint32_t n;   // its objects, since they were last classified
    uint64_t run; // the first of its runs
    uint64_t n_runs;
} domain;

// Says how rows are placed; each state includes those before it. All ranks are in the same one, but
// for the last one, which a rank without memory lacks until it tries again.
typedef enum placement {
    PLACED_ANYHOW,    // the world is to be divided: all rows are in domain 0, which has no box
    PLACED_BY_RANK,   // each rank owns what lies in its box; all rows are in domain 0
    PLACED_BY_DOMAIN, // each domain has a box, and its rows were in an order that suits its worker
} placement;

typedef struct owned {
    object_form form;
    object_rows rows;
    placement placement;
    worker *holder; // rows.objects is its memory; NULL: the rows' own memory
    uint32_t n_domains;
    uint32_t most_domains; // the most of any rank
    domain *domains;       // [n_domains]
    level_boxes *boxes;    // [most_domains] around a domain's objects that others may touch
    bisection planes;      // between the domains
    double unevenness;     // the most objects of a domain by their mean, as the planes left it
    row_list leavers;      // ascending
    row_list boundary;     // rows that objects of other domains may touch
    run_list runs;         // of several domains
    // Rows whose id changed, arrived or left since owned_forget_renamed; failed: any may have.
    row_list renamed;
    double widest; // the widest of all ranks' objects, or a little more; 0: not known
    extent around; // all of this rank's objects, or a little more
    extent fitted; // around them when workers last fitted grids; 0: since they were placed anew
    parallel *threads;
} owned;

bool owned_begin(owned *o, uint32_t n_domains, uint32_t most_domains, parallel *threads,
                 duet_error *err);
// Takes these objects, and from here on owns the memory, wherever they lie.
void owned_take(owned *o, object_rows *rows);
void owned_end(owned *o);

// Returns how many objects there are.
static inline uint32_t owned_count(const owned *o)
{
    return o->rows.n - (uint32_t)o->leavers.n;
}

// Returns the domain of an object of this rank.
static inline uint32_t owned_domain_at(const owned *o, const double centre[3])
{
    return o->placement == PLACED_BY_DOMAIN ? bisection_part(&o->planes, centre) : 0;
}

// Moves the last rows into the rows of leavers.
void owned_tidy(owned *o);

// Gives all rows to the first domain, which has no box.
void owned_forget_domains(owned *o);

// Brings tidy rows that lie in the rank's box to their domains, each in the order that suits the
// worker that searches it. Planes between domains are made anew.
bool owned_place(owned *o, const extent *box, worker *const workers[2], duet_error *err);

// Returns whether a domain has so many objects that the planes are to be made anew.
bool owned_is_uneven(const owned *o);

// Sorts the runs by domain, and counts the objects of each. False without memory.
bool owned_sort_runs(owned *o, duet_error *err);

// Makes the holder's memory that of the rows as they are, and forgets what was sent ahead of them.
bool owned_map(owned *o, duet_error *err);

// Makes space for n more rows behind the rows.
bool owned_reserve(owned *o, uint64_t n, duet_error *err);

// Writes the objects in messages behind the rows.
bool owned_add_newcomers(owned *o, const parcels *messages, duet_error *err);

// The holder's devices know the ids of all rows.
void owned_forget_renamed(owned *o);

#endif
