// SPDX-License-Identifier: MIT
// A motion of one domain's bodies: its own and ghosts, which are other domains'. It takes each step
// stage by stage beside the motions of the other domains (cluster/moving_step.c), and its bodies
// are replaced between steps.
//
// Invariant: places ascend with the bodies' global ids, so rows, owners and ties are those of one
// motion of all bodies. A contact is right here if its end that moves is the domain's own.
#ifndef RUNTIME_DOMAIN_MOTION_H
#define RUNTIME_DOMAIN_MOTION_H

#include "runtime/dynamics/motion.h"

// Contacts by rows: owner and other, which is a place, or n + k of what never moves.
typedef struct domain_contacts {
    uint32_t n;
    uint32_t *rows;  // ascending, of those that the host is told of; NULL: all
    cl_uint2 *links; // ascending
    cl_uint *touches, *colours;
    float *records; // [n][layout.record]; NULL: not asked for
} domain_contacts;

void domain_contacts_free(domain_contacts *c);

// Memory for c->n contacts of the motion; freed also after a failure.
bool domain_contacts_reserve(domain_contacts *c, const duet_motion *m, bool with_records,
                             duet_error *err);

// Memory for what domain_read_rows reads of contacts that the host was told of.
bool domain_reserve_rows(domain_contacts *c, const duet_motion *m, duet_error *err);

// Makes a motion without bodies, as a part of one of a def whose substeps are chosen, and of bodies
// with these facts and this mean least extent.
duet_motion *domain_create(const duet_motion_def *def, const effect_facts *facts, double extent,
                           duet_error *err);

// Replaces all bodies by such that no step has moved.
bool domain_begin_bodies(duet_motion *m, const duet_pose *poses, const duet_body *bodies,
                         uint32_t n, duet_error *err);

// Bytes of a body's state: what a step changes of it, and if there were commands what these left.
size_t domain_state_bytes(const duet_motion *m);

// Finds where a state's centre is.
void domain_centre(const duet_motion *m, const char *state, double at[3]);

// Reads the states of bodies at n ascending places, [n][domain_state_bytes].
bool domain_read_states(duet_motion *m, const uint32_t *places, uint32_t n, char *states,
                        duet_error *err);

// Whether a contact's record of n points pushed in the last step.
bool domain_was_pushed(const duet_motion *m, const float *record, uint32_t n);

// Reads contacts, which the caller frees. A link of NO_PLACE is of none that is here.
bool domain_read_contacts(duet_motion *m, bool with_records, domain_contacts *c, duet_error *err);

// Reads the contacts of c->rows, all but their links.
bool domain_read_rows(duet_motion *m, domain_contacts *c, duet_error *err);

// Two parts of a row by object, in words: where they begin, how many are taken, and how many of
// every four of the first part; 0: all.
typedef struct row_parts {
    uint32_t at[2], words[2], of_four;
} row_parts;

// Reads parts of the rows of n places, each place once, one behind the other; and writes them.
// parts NULL: whole rows.
bool domain_pack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                      const uint32_t *places, uint32_t n, void *packed, duet_error *err);
bool domain_unpack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                        const uint32_t *places, uint32_t n, void *packed, duet_error *err);

// Places whose rows are moved. If a list of the device has them (SENT_IDS, RECEIVED_IDS), they lie
// there from `first` on; READ_IDS: none has.
typedef struct domain_ids {
    const uint32_t *places;
    uint32_t n;
    motion_buffer listed;
    uint32_t first;
    bool is_there; // READ_IDS has them already
} domain_ids;

// Writes places into a list of the device, from `at` on, behind those that stay.
bool domain_list_ids(duet_motion *m, motion_buffer list, uint32_t at, const uint32_t *places,
                     uint32_t n, duet_error *err);

// The same for listed places; GHOSTS have GHOST_WORDS a row.
bool domain_pack_listed(duet_motion *m, motion_buffer which, const row_parts *parts,
                        const domain_ids *ids, void *packed, duet_error *err);
bool domain_unpack_listed(duet_motion *m, motion_buffer which, const row_parts *parts,
                          const domain_ids *ids, void *packed, duet_error *err);

// Waits until the device has read what rows were written from: before, places and packed are to
// stay as they are. A read that was waited for since has waited for that, too.
bool domain_await_rows(duet_motion *m, duet_error *err);

// With events: sends for what touches, of contacts that a motion was given, as domain_finalize does
// in a step; and makes that what touches before the next step, which duet_motion_advance takes.
bool domain_note_touching(duet_motion *m, duet_error *err);
bool domain_note_events(duet_motion *m, duet_error *err); // of both
bool domain_recall_touching(duet_motion *m, duet_error *err);
bool domain_list_touching(duet_motion *m, duet_error *err); // of it

// Finds which contacts, by rows, touch and are told: told [n_contacts], 0 for all without events;
// and, after a step, this motion's hits, which last until the next one.
bool domain_read_told(duet_motion *m, uint8_t *told, duet_error *err);
bool domain_read_hits(duet_motion *m, const duet_hit_event **hits, size_t *n, duet_error *err);

// Lets contacts of the last step stay, but for those that have a shared end: moved [n + FIXED] are
// the places that bodies get, in the same order, and what never moves. Without it replaced bodies
// have none of these contacts.
bool domain_keep_contacts(duet_motion *m, const uint32_t *moved, duet_error *err);
void domain_drop_contacts(duet_motion *m);

// Moves rows of some buffers by object to n places: from [n] are those that they had, or NO_PLACE.
bool domain_move_rows(duet_motion *m, const motion_buffer *list, int n_list, const uint32_t *from,
                      uint32_t n, duet_error *err);

// Bodies that take the place of others. If they were there before they keep all that they had.
typedef struct domain_bodies {
    uint32_t n, n_fresh;
    uint32_t *from;   // [n + FIXED] the places that they had, ascending; NO_PLACE: fresh, or never
                      // there
    uint32_t *fresh;  // [n_fresh] places of the fresh ones, ascending
    duet_pose *poses; // [n_fresh], as are bodies
    duet_body *bodies;
    char *states;     // [n_fresh][domain_state_bytes]
    float *far_boxes; // [n_fresh][6]; not looked at without contacts
} domain_bodies;

// Moves rows of the host in the same way; those of fresh ones are fresh_rows, one behind the other.
// Space is for those that there were as for those that there are.
void domain_splice(const domain_bodies *b, void *rows, const void *fresh_rows, size_t row);

// Far boxes are kept (domain_keep_far_boxes). Replaces all bodies, and adds contacts that they had
// in the last step. With commands all are fresh.
bool domain_replace_bodies(duet_motion *m, const domain_bodies *b, const domain_contacts *c,
                           duet_error *err);

// Says where the body is that carries the mesh, which each domain has.
void domain_set_carrier(duet_motion *m, uint32_t place);

// Makes the bounds that the next step has: those before it, while bodies are within them and they
// are not forgotten.
bool domain_make_bounds(duet_motion *m, duet_error *err);
void domain_forget_bounds(duet_motion *m);

// Makes rows of the contacts that bodies were replaced with: then two motions of the same bodies
// and contacts are saved as the same bytes. Bodies that do not touch yet are in none of them,
// within a skin neither, so the next step searches pairs.
bool domain_lay_rows(duet_motion *m, duet_error *err);

// Forgets what commands left behind if that is nothing.
void domain_forget_idle_commands(duet_motion *m);

// Whether the body at a place, which a state is of, was removed or is disabled.
bool domain_is_hidden(const duet_motion *m, const char *state);

// ---------------------------------------------------------------- a step's stages

// Before the first step of all bodies, takes those apart that begin deep in each other.
bool domain_begin_apart(duet_motion *m, duet_error *err);

// Without response bodies fly, and where they then touch is looked at, if it is to be known.
bool domain_fly(duet_motion *m, duet_error *err);
bool domain_find_contacts(duet_motion *m, duet_error *err);

// With response: manifolds of where the step begins, which may wake what leant on something that is
// gone (RESTS).
bool domain_begin_step(duet_motion *m, duet_error *err);
bool domain_find_manifolds(duet_motion *m, duet_error *err); // of it

// Once bodies know whether they sleep (UPDATE_SLEEP, ASLEEP), read the flags, and find manifolds of
// what woke; `fell`: something fell asleep or woke in any domain.
bool domain_read_flags(duet_motion *m, duet_error *err);
bool domain_wake_touched(duet_motion *m, bool fell, duet_error *err);

// Tells of all places and of what never moves, [n + FIXED], until bodies are replaced.
typedef struct domain_place {
    uint32_t id, kind; // bits of kernels/dynamics/border.h
} domain_place;
bool domain_mark_places(duet_motion *m, const domain_place *places, duet_error *err);

// Lists own bodies whose next bounds leave the first of n extents [6], or meet one of the others,
// in any order; the caller frees the list.
typedef struct domain_near {
    uint32_t place;
    float bounds[6];
    uint32_t spare;
} domain_near;
bool domain_list_near(duet_motion *m, const float *extents, uint32_t n, domain_near **list,
                      uint32_t *n_list, duet_error *err);

// Far boxes (FAR_BOXES) last until they are made again: the bounds of now, further by a margin and
// by the way of a time.
typedef struct domain_far {
    float time, margin;
    float home[6];
} domain_far;

// Makes far boxes, forgets the bounds of before, and lists own bodies whose bounds leave home, as
// above. Reach [6] becomes what all far boxes of other own bodies lie in that move or are sensors.
bool domain_make_far_boxes(duet_motion *m, const domain_far *far, float reach[6],
                           domain_near **list, uint32_t *n_list, duet_error *err);
bool domain_keep_far_boxes(duet_motion *m,
                           duet_error *err); // of it; without contacts there are none

// Lists own bodies whose far boxes meet one of n extents, as above.
bool domain_list_meeting(duet_motion *m, const float *extents, uint32_t n, domain_near **list,
                         uint32_t *n_list, duet_error *err);

// Colours contacts that begin to push, but for those which more than this domain's contacts decide.
// Tells of these, and of what is solved in order: rows, links and colours, which the caller frees.
// Contacts of ghosts alone push only if ghosts come less often than after each colour.
bool domain_colour_inner(duet_motion *m, uint32_t every, domain_contacts *told, duet_error *err);
bool domain_mark_border(duet_motion *m, duet_error *err);                         // of it
bool domain_list_waiting(duet_motion *m, domain_contacts *told, duet_error *err); // likewise

// Likewise tells of all contacts with points that have a shared end, or whose first end that moves
// is a shared own body.
bool domain_list_shared(duet_motion *m, domain_contacts *shared, duet_error *err);
bool domain_list_sent(duet_motion *m, domain_contacts *sent, duet_error *err);

// Adds contacts, by places, to those of the last step.
bool domain_add_contacts(duet_motion *m, const domain_contacts *c, duet_error *err);

// Reads the colours that contacts of places have, a bit for each.
bool domain_read_used(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t *used,
                      duet_error *err);
bool domain_pack_used(duet_motion *m, const domain_ids *ids, uint32_t *used, duet_error *err);

// Takes the colours of those that it told of.
bool domain_write_colours(duet_motion *m, const domain_contacts *told, duet_error *err);

// Memory for what is known of ghosts; until bodies are replaced.
bool domain_reserve_ghosts(duet_motion *m, duet_error *err);

// Finds which contacts of ghosts are solved here, if ghosts come after so many colours at the
// latest: each ghost's GHOSTS, of which colours at home are there. Others are left: their colours
// have COLOUR_LEFT from then on.
bool domain_close(duet_motion *m, uint32_t every, duet_error *err);
bool domain_list_ghosts(duet_motion *m, uint32_t *n, duet_error *err); // of it: on the device

// A contact that a domain asks another for: the ghost's place, or that of the body there, and the
// colour.
typedef struct asked_contact {
    uint32_t place, colour;
} asked_contact;

// Bytes of a contact that is asked for; reads n of them, [n][bytes]; and takes those that came.
size_t domain_asked_bytes(const duet_motion *m);
bool domain_read_asked(duet_motion *m, const asked_contact *asked, uint32_t n, void *rows,
                       duet_error *err);
bool domain_take_asked(duet_motion *m, const asked_contact *asked, uint32_t n, const void *rows,
                       duet_error *err);

// How many contacts are solved here that others own, and how many were taken as solved that do not
// push at home, or by another colour: then what is solved is to be found again.
typedef struct domain_closed {
    uint32_t n_foreign, n_mistaken;
} domain_closed;
bool domain_count_closed(duet_motion *m, domain_closed *found, duet_error *err);

// Lists contacts by colour, those of its border first: all that have a ghost or a body that is one
// elsewhere, and a few others; the inner ones are at least so many, or none. Then makes
// constraints.
bool domain_take_colours(duet_motion *m, uint32_t least_inner, duet_error *err);
bool domain_prepare_contacts(duet_motion *m, duet_error *err);

// A substep: velocities (INTEGRATE_VELOCITIES), contacts as soft springs, positions
// (INTEGRATE_POSITIONS), contacts relaxed. With shocks, before the contacts, sweeps come, up to
// SHOCK_SWEEPS, until none in any domain bounced; after all substeps restitution, which is of
// contacts, too.
bool domain_end_sweep(duet_motion *m, bool *bounced, duet_error *err);

// A pass does one of these to contacts: to a colour's inner ones; then to those of colours
// [from, to), but of the first one to the border's; and after the colours to one of those of
// COLOUR_OVERFLOW, the domain's i-th.
typedef enum domain_pass { PASS_SHOCKS, PASS_SOFT, PASS_RELAX, PASS_RESTORE } domain_pass;
bool domain_solve_border(duet_motion *m, domain_pass pass, uint32_t from, uint32_t to,
                         duet_error *err);
bool domain_solve_inner(duet_motion *m, domain_pass pass, uint32_t colour, duet_error *err);
bool domain_solve_in_order(duet_motion *m, domain_pass pass, uint32_t i, duet_error *err);

// Impulses as they are kept, which are of contacts alone; then events and bodies.
bool domain_store_impulses(duet_motion *m, duet_error *err);
bool domain_finalize(duet_motion *m, duet_error *err);

// Pushes bodies that sleep deep in others, in rounds from 0; in round PRESSED_ROUNDS all go where
// those before it brought them.
bool domain_push_sleepers(duet_motion *m, uint32_t round, duet_error *err);

bool domain_end_step(duet_motion *m, duet_error *err);

// After the step of either kind ends what commands were for it.
bool domain_end_commands(duet_motion *m, duet_error *err);

// Whether all bodies are within the bounds that pairs were searched by, so that the next step
// searches none.
bool domain_is_bounded(const duet_motion *m);

#endif
