// SPDX-License-Identifier: MIT
// Scenes that move over ranks, and what one motion of each comes to.
#ifndef TESTS_MOVING_H
#define TESTS_MOVING_H

#include "cluster/cluster.h"
#include "cluster/job.h"
#include "cluster/moving_domains.h"

typedef struct moving_scene {
    const char *name; // of a scene that comes with Duet, or of one in scenes/
    duet_setting settings[2];
    uint32_t steps;
    uint64_t least_contacts; // at the end
    uint32_t saved_at;       // the step at which it is saved, and goes on from the file; 0: none
    uint32_t colours;        // how many contacts have at most; 0: any
} moving_scene;

// A motion came to this: its state, and sums over all events of all steps.
typedef struct outcome {
    uint64_t hash;
    uint64_t events, stays, hits; // how many
    uint64_t told;                // a sum of hashes of them, each with its step
} outcome;

// One motion's, which rank 0 finds for all. one_motions_hash is that after the scene's steps, begun
// at its saved_at from a file, or from the beginning; for the rank that calls it.
outcome expected_outcome(const moving_scene *s);
uint64_t expected_hash(const moving_scene *s);
uint64_t one_motions_hash(const moving_scene *s, const char *from);

void add_told(outcome *o, uint64_t step, const duet_cluster_motion_result *result);
void must_tell_alike(outcome all, const outcome *expected, duet_cluster *c, const char *what);

// The motion on the first n ranks, or on this rank ALONE, from a file or the beginning; NULL on the
// others. Ghosts come after so many colours; 0: nobody says. However few contacts may be solved
// while ghosts travel, they are.
duet_cluster *begin_from(int n, uint32_t parts, uint32_t colours, const moving_scene *s,
                         const char *file);
duet_cluster *begin_on(int n, uint32_t parts, uint32_t colours, const moving_scene *s);

// Takes steps; returns what the last one says.
duet_cluster_motion_result advance(duet_cluster *c, uint32_t steps);
uint64_t state_hash(duet_cluster *c);

// A motion takes the other's place, as a job that is started again.
void save_and_resume(duet_cluster *cluster, const moving_scene *s);

// Two domains of this rank with boxes that fall.
duet_cluster *two_domains_after_steps(const char *n, uint32_t colours, uint32_t steps);

// The bounds of a domain's bodies, six numbers each, which the caller frees: made anew, or those of
// before while bodies are within them.
float *bounds_of(const moving_domain *d);
float *kept_bounds_of(const moving_domain *d);

#endif
