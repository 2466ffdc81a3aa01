// SPDX-License-Identifier: MIT
// A rank's end of a cluster.
#ifndef CLUSTER_CLUSTER_H
#define CLUSTER_CLUSTER_H

#include "cluster/balance.h"
#include "cluster/duet_cluster.h"
#include "cluster/ghosts.h"
#include "cluster/migrate.h"
#include "cluster/own_pairs.h"

struct command;

// How far the objects are from being searched. Each state includes those before it; mapping,
// setting or loading objects goes back to the first.
//
//   CHANGED --settle--> SETTLED --search--> FOUND --list--> LISTED
//      ^                   |                  |               |
//      '------ map, set, load, partition -----+---------------'
typedef enum cluster_state {
    STATE_CHANGED, // objects may belong to other ranks; on one rank alone, or on all
    STATE_SETTLED, // all objects are where they belong, and ghosts have come
    STATE_FOUND,   // own counts this rank's pairs, and found has them
    STATE_LISTED,  // own lists them
} cluster_state;

// How the last step went.
typedef enum step_state {
    STEP_COLD, // the next one may have to build kernels
    STEP_ENDED,
    STEP_STOPPED, // a rank was asked to stop before the step ended, which is known to all
} step_state;

// The sets in which objects are searched. Chosen anew when objects are settled.
typedef enum cluster_search {
    SEARCH_WHOLE,      // sets[0], a single domain with its ghosts
    SEARCH_OVERLAPPED, // sets[0] without ghosts while these travel, and then its boundary, sets[1]
    SEARCH_COPIES,     // several domains in turn, each a copy with its ghosts
} cluster_search;

// A search by a worker, beside what its caller does.
typedef struct set_search {
    search_set *set;
    worker *worker;
    bool counts; // the argument of search_set_find
    worker_found found;
    duet_error err;
    bool ok;
    struct thread_pool *beside; // the threads of which one makes it; NULL: none is under way
} set_search;

struct duet_cluster {
    duet_cluster_def def;       // with this rank's pair
    duet_device_pair *own_pair; // NULL: the caller's
    ranks ranks;
    parallel threads;
    partition partition;
    owned owned;
    migration migration;
    balance balance;
    ghosts ghosts;
    worker *workers[2]; // the second one is of several domains, or of a boundary
    search_set sets[2];
    set_search searches[2];
    cluster_state state;
    cluster_search search;
    own_pairs own;
    step_state step;
    struct moving *moving; // NULL: nothing moves
    duet_scene_info scene;
    char *scene_name;       // NULL: no scene was loaded
    duet_cluster_rank last; // this rank's last step
};

// duet_cluster_create of simulated ranks; s, unless NULL, has to stay.
duet_cluster *cluster_create(const duet_cluster_def *def, const simulation *s, duet_error *err);

// Makes c->own list this rank's pairs of the last step; not collective.
bool cluster_list_pairs(duet_cluster *c, duet_error *err);

// duet_cluster_load_scene. With `whole` rank 0 reads all of the scene and hands it over, to be
// destroyed; the others get NULL.
bool cluster_load_scene(duet_cluster *c, const char *path, const duet_setting *settings,
                        uint32_t n_settings, duet_scene **whole, duet_error *err);

// Writes the objective of a profile that says how often ghosts come on so many ranks, domains and
// hosts. Collective.
enum { CLUSTER_OBJECTIVE = 96 };
#define CLUSTER_OVER_RANKS "time over " // that it begins with
void cluster_objective(duet_cluster *c, char objective[CLUSTER_OBJECTIVE]);

// ---------------------------------------------------------------- of its own files

// Opens the pair that the def names, else DUET_PAIR if that is set. A rank alone on its host gets
// the host's default pair. Several ranks get a GPU each, in turn; without a GPU, an equal part of
// the CPU's units.
bool cluster_open_pair(duet_cluster *c, duet_error *err);
// Returns whether this rank's devices leave the host's processors to others.
bool cluster_spares_host(const duet_cluster *c);
worker *cluster_open_worker(const duet_cluster *c, const duet_world_def *world, duet_error *err);
// Returns how many workers take turns: one is filled while the other searches.
int cluster_workers(const duet_cluster *c);
// Opens so many workers for this world def. On failure none is open.
bool cluster_open_workers(const duet_cluster *c, const duet_world_def *world, worker *workers[2],
                          duet_error *err);
void cluster_close_workers(worker *workers[2]);
// Replaces the workers. The new ones hold no objects.
void cluster_take_workers(duet_cluster *c, const duet_world_def *world, worker *workers[2]);
// Replaces the objects.
void cluster_take(duet_cluster *c, object_rows *rows);
// Makes a call's failure on one rank, NULL arguments included, the failure of all ranks.
bool cluster_agree_on(duet_cluster *c, const char *call, bool ok, duet_error *own, duet_error *err);
// Gives the motion a command, of which only rank 0's arguments count; all ranks name the op.
bool cluster_give(duet_cluster *c, struct command *k, duet_error *err);
// Copies the domain that has the most objects to each worker, so that it can look up its profile.
bool cluster_show_domain(duet_cluster *c, duet_error *err);

// The order of a search (search.c): chooses one of owned objects that are where they belong, and
// begins to search the inner ones if that may overlap with the exchange of ghosts, as it may on
// devices that leave the host to others; fills the other sets with ghosts; searches all and counts
// this rank's pairs.
void cluster_choose_search(duet_cluster *c, bool may_overlap);
bool cluster_fill_sets(duet_cluster *c, duet_error *err);
bool cluster_search_all(duet_cluster *c, duet_error *own);
void cluster_cancel_search(duet_cluster *c); // waits for what is under way

// Brings all objects where they belong: on all ranks, or on none. Fails on all ranks if `own` of
// one has a failure.
bool cluster_settle_all(duet_cluster *c, const char *call, duet_error *own, duet_error *err);
// The same, and then tidies and maps them, to be written. Where objects are bad all are where they
// were, to be mended.
bool cluster_open_owned(duet_cluster *c, const char *call, duet_error *own);

#endif
