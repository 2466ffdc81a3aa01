// SPDX-License-Identifier: MIT
// The domains among which a scene's bodies are divided.
//
// Invariants:
//   - Each body is one domain's own. Domain d is of rank d / parts, and the box that held the
//     body's centre when bodies were last exchanged is its own domain's.
//   - A domain has, as ghosts, all bodies of others whose bounds then met its reach: the box around
//     those of its own that act, that move or are sensors. Bodies are exchanged before one takes a
//     step whose bounds have left its domain's reach, or meet one that they did not meet then. So
//     all contacts of its own bodies that act are there, and right.
//   - A ghost has its own domain's bits at the step's beginning, and in a sweep of colours whenever
//     a contact that is solved here needs it
//     (kernels/dynamics/closure.cl).
//   - Between steps a contact of two ghosts has the bits that it has at home, or it was left there:
//     then COLOUR_LEFT says so, and it comes from there before it is solved here again.
//   - Ids ascend with places in each domain, so nothing that decides a bit depends on borders.
#ifndef CLUSTER_MOVING_DOMAINS_H
#define CLUSTER_MOVING_DOMAINS_H

#include "cluster/bisection.h"
#include "cluster/halo.h"
#include "cluster/list.h"
#include "cluster/moving.h"
#include "cluster/moving_events.h"
#include "cluster/moving_every.h"
#include "cluster/moving_phases.h"
#include "cluster/work.h"
#include "kernels/dynamics/border.h"
#include "runtime/dynamics/domain_motion.h"

// A body of a domain's motion.
typedef struct moving_body {
    uint32_t id;       // its place among all bodies
    uint32_t own;      // the domain whose own it is
    uint32_t next;     // and is to be, while bodies are exchanged; of a ghost only if all travel
    uint16_t acts;     // whether it has contacts with what does not
    uint16_t complete; // whether its own domain has all its contacts: those of what acted since
                       // bodies were exchanged
} moving_body;

typedef LIST_OF(moving_body, rows) body_list;

// A body as it travels. Its state (domain_state_bytes) lies behind.
typedef struct moving_traveller {
    uint32_t domain; // that it goes to
    moving_body body;
    float far_box[6]; // that ghosts are chosen by
    duet_pose pose;   // as given
    duet_body given;
} moving_traveller;

// A contact of the last step. Its record lies behind.
typedef struct moving_contact {
    uint32_t domain;
    uint32_t owner, other; // ids; n_all + k for what never moves
    uint32_t touch, colour;
    uint32_t told_by; // the id of the end whose domain tells that it touches
} moving_contact;

#define TOLD_BY_NONE UINT32_MAX

// The first place of each stretch of ids, and behind the last; empty: bodies are searched as a
// whole.
typedef struct id_index {
    uint32_t *firsts;
    uint64_t n;
    uint32_t shift;
} id_index;

typedef struct moving_domain {
    duet_motion *motion;
    uint32_t number;  // of all ranks' domains
    body_list bodies; // ascending by id; the motion's, place by place
    id_index index;   // of them
    row_list gone;    // places of those that are not to stay, ascending; while bodies are exchanged
    item_list came;   // travellers that the motion is to get, its own ones first, and so many
    uint64_t n_came_own;
    extent reach;       // of own bodies that act and stay
    extent fitted;      // its reach when the grid of its pairs was last fitted
    item_list shared;   // contacts of ghosts that came, while they are shared
    item_list contacts; // ascending; those that travelled and the next step begins with, until that
                        // begins
    uint32_t n_own;
    domain_place *places; // [bodies + FIXED], apart from the long rows of bodies
    row_list in_order;    // its contacts of COLOUR_OVERFLOW: ascending places among those of all
    row_list neighbours;  // domains whose reaches meet its own
    domain_contacts told; // contacts of the step that waited for a colour, or are solved in order
    row_list waiting;     // those of them that waited
} moving_domain;

// Whether ranks have equal work.
typedef struct moving_balance {
    work_model model;
    work_row done;     // by this rank, in steps that were not compared yet
    uint32_t steps;    // in these
    uint64_t since_ns; // of the time that this rank is busy
    double most, mean; // work of the rank that has most of it, and of the mean one
    double lost;       // steps that the mean rank waited for it, since the last cut
} moving_balance;

struct moving {
    ranks *ranks;
    duet_motion_def def; // as are, of the whole scene
    effect_facts facts;
    double extent;
    uint32_t parts;       // domains of each rank
    uint32_t every;       // colours after which ghosts come at the latest
    uint32_t least_inner; // contacts of a colour that are solved while ghosts travel, if any are
    uint32_t n_domains, n_all;
    cl_int4 base;        // the origin cell that all count from
    bool keeps_commands; // states have what commands left
    uint64_t n_commands; // since the last step
    size_t traveller_bytes, contact_bytes;
    bisection cuts;
    extent *reaches;        // [n_domains], when bodies were last exchanged
    moving_domain *domains; // [parts]
    halo halo;
    moving_events events;
    uint64_t n_ghosts; // of this rank
    uint64_t next_cut; // the first step after which the world may be cut anew
    moving_balance balance;
    uint64_t n_in_order; // contacts of COLOUR_OVERFLOW, of all ranks
    moving_counts counts;
    moving_phases phases;
    every_trial trial;
};

static inline moving_traveller *moving_traveller_at(const moving *m, const item_list *rows,
                                                    uint64_t i)
{
    return (moving_traveller *)(void *)((char *)rows->items + i * m->traveller_bytes);
}

static inline moving_contact *moving_contact_at(const moving *m, const item_list *contacts,
                                                uint64_t i)
{
    return (moving_contact *)(void *)((char *)contacts->items + i * m->contact_bytes);
}

static inline char *moving_state(moving_traveller *t)
{
    return (char *)(t + 1);
}

static inline bool moving_is_own(const moving_domain *d, const moving_body *b)
{
    return b->own == d->number;
}

// Returns the body at a place; NULL: a wall, or the ground.
static inline const moving_body *moving_body_or_wall(const moving_domain *d, uint32_t place)
{
    return place < d->bodies.n ? &d->bodies.rows[place] : NULL;
}

// Whether the domain owns the body at a place, or wall, and it acts.
static inline bool moving_decides_at(const moving_domain *d, uint32_t place)
{
    const uint32_t kind = d->places[place].kind;
    return (kind & PLACE_OWN) && (kind & (PLACE_MOVES | PLACE_SENSOR));
}

// Whether the domain owns an end that acts, of a contact of two places.
static inline bool moving_decides_contact(const moving_domain *d, const uint32_t ends[2])
{
    return moving_decides_at(d, ends[0]) || moving_decides_at(d, ends[1]);
}

// Whether events tell of a contact of two places by its other end: by the lesser one that acts, in
// whose domain all is known of it, though commands change who owns it; else by the owner.
static inline bool moving_other_tells(const moving_domain *d, uint32_t owner, uint32_t other)
{
    const moving_body *a = moving_body_or_wall(d, owner), *b = moving_body_or_wall(d, other);
    return b && b->acts && !(a && a->acts && a->id < b->id);
}

// Whether the body at a place, as moving_place found it, is the domain's own; UINT32_MAX: none is.
static inline bool moving_owns(const moving_domain *d, uint32_t place)
{
    return place != UINT32_MAX && moving_is_own(d, &d->bodies.rows[place]);
}

static inline uint32_t moving_id(const moving *m, const moving_domain *d, uint32_t place)
{
    const moving_body *b = moving_body_or_wall(d, place);
    return b ? b->id : m->n_all + (place - (uint32_t)d->bodies.n);
}

// Returns whether bodies push each other.
static inline bool moving_pushes(const moving *m)
{
    return m->domains[0].motion->effects & DUET_EFFECT_CONTACT_RESPONSE;
}

// Returns whether events tell of what touches.
static inline bool moving_tells(const moving *m)
{
    return m->domains[0].motion->effects & DUET_EFFECT_EVENTS;
}

// Lets a domain count cells from that of all, whatever the cell of its first body is.
static inline void moving_keep_base(const moving *m, duet_motion *motion)
{
    if (motion->cells)
        motion->cells[0] = m->base;
}

// Returns whether it is known where bodies touch: then there are ghosts, and contacts travel.
static inline bool moving_touches(const moving *m)
{
    return m->domains[0].motion->effects & DUET_EFFECT_CONTACT;
}

// Whether all bodies travel when they are exchanged, also those that stay: they do if commands left
// more than motions have, and without contacts, for nothing says then which bodies leave.
static inline bool moving_all_travel(const moving *m)
{
    return m->keeps_commands || !moving_touches(m);
}

// Whether all contacts of a domain travel when bodies are exchanged, also those that stay there:
// they do if they tell something.
static inline bool moving_sends_all(const moving *m)
{
    return moving_tells(m) || !moving_pushes(m);
}

// ---------------------------------------------------------------- of its files, from the lowest up

// moving_places.c: the place of a body in a domain; UINT32_MAX: it is not there.
uint32_t moving_place(const moving_domain *d, uint32_t id);
// The same of a contact's end, which may be a wall or the ground.
uint32_t moving_end_place(const moving *m, const moving_domain *d, uint32_t id);
// The same of the body that carries the mesh, which may not be here yet.
uint32_t moving_carrier_place(const moving *m, const moving_domain *d);
// Makes the index that these three look into, after bodies were replaced or added.
void moving_index_places(const moving *m, moving_domain *d, duet_error *own);

// Tells of the places of a domain's motion as its bodies are now.
void moving_note_places(const moving *m, moving_domain *d, duet_error *own);
domain_place moving_place_of(const moving_domain *d, const moving_body *b, const duet_body *given);
bool moving_reserve_places(moving_domain *d, uint64_t n, duet_error *own);
void moving_note_fixed(const moving *m, moving_domain *d, uint64_t n);

// moving_cut.c: whether ranks' work is so unequal that a cut pays, and a cut anew by the bodies of
// n domains of this rank, before bodies change domains.
bool moving_cut_is_due(const moving *m);
bool moving_cut(moving *m, const moving_domain *domains, uint32_t n, duet_error *own);

// Cuts by points (bisection_point), for which one in so many of n bodies is enough.
bool moving_cut_by(moving *m, const item_list *points, duet_error *own);
uint64_t moving_sampled(uint64_t n);

// Returns the domain whose box holds a body of that state.
uint32_t moving_domain_of(const moving *m, const char *state);

// moving_reach.c: an extent in float, rounded inward or outward, so that what float says of bounds
// is right; in 2D all lies in it along z.
void moving_round_extent(const moving *m, const extent *e, bool inward, float to[6]);

// Finds how far each domain reaches, and its neighbours, once own bodies have come. Collective.
bool moving_find_reaches(moving *m, duet_error *own);

// Whether a domain's own body, whose bounds were `old` when bodies were last exchanged, still is in
// all domains that have what it may touch.
bool moving_stays(const moving *m, const moving_domain *d, const extent *old, const extent *now);

// Whether pairs that the next step searches are all among the domain's bodies.
bool moving_has_all_pairs(const moving *m, const moving_domain *d, duet_error *own);

// moving_rows.c: reads what a step and commands made of a domain's bodies at ascending places, and
// adds them as travellers to where they are to be own ones. Their far boxes are there. Not
// collective.
void moving_read_bodies(moving *m, moving_domain *d, const row_list *places, item_list *to,
                        duet_error *own);

// Writes a contact of a domain's motion, and its record behind, to where it has space.
void moving_write_contact(const moving *m, const moving_domain *d, const domain_contacts *from,
                          uint32_t i, moving_contact *row);

// Orders contacts by their ends, each once; false without memory.
bool moving_order_contacts(const moving *m, item_list *contacts);
// Adds a contact between two places to those that a motion is to get, which have space for it.
void moving_put_contact(const moving *m, const moving_contact *c, uint32_t owner, uint32_t other,
                        domain_contacts *to);

// Sends each row, which begins with the domain that it goes to, and adds those that came to their
// domains' lists. Collective.
typedef item_list *moving_list_of(moving_domain *d);
bool moving_deal(moving *m, item_list *rows, size_t bytes, moving_list_of *list, duet_error *own);

// moving_replace.c: sorts a domain's travellers and contacts, and makes them those of its motion
// instead of what is gone.
void moving_replace(moving *m, moving_domain *d, duet_error *own);

// moving_share.c: after an exchange, brings contacts of ghosts that may be solved here. Collective.
bool moving_share_contacts(moving *m, duet_error *own);

// moving_exchange.c: brings own bodies to their domains; then contacts and ghosts, too, and
// replaces all motions' bodies. Both are collective.
bool moving_migrate(moving *m, item_list *bodies, duet_error *own);
bool moving_exchange(moving *m, item_list *bodies, item_list *contacts, duet_error *own);

// moving_settle.c: reads all of a domain's bodies as moving_read_bodies, whose far boxes are made;
// places become all. Adds the contacts of its motion, each for the domains that own its ends.
void moving_read_all(moving *m, moving_domain *d, row_list *places, item_list *to, duet_error *own);
void moving_read_contacts(moving *m, const moving_domain *d, item_list *contacts, duet_error *own);

// Reads all domains' bodies and contacts, and exchanges them. Collective.
bool moving_settle(moving *m, duet_error *own);

// moving_balance.c: adds to a step's agreement what this rank had to do, and then what all had;
// both once a step.
void moving_note_work(moving *m, tally *t);
bool moving_compare_work(moving *m, const tally *t, duet_error *own);

// moving_colour.c: gives all contacts their colours, once manifolds are there.
bool moving_colour(moving *m, duet_error *own);

// moving_begin.c: makes a motion without bodies, as a part of all of them; and frees all that a
// domain has but its motion.
duet_motion *moving_create(const moving *m, duet_error *own);
void moving_end_domain(moving_domain *d);

// Returns a copy of rank 0's array on every rank, to be freed; NULL if it has no bytes. Without
// memory all ranks fail.
void *moving_tell(const moving *m, const void *of_rank_0, size_t bytes, duet_error *own);

#endif
