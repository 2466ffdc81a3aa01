// SPDX-License-Identifier: MIT
// Which rank owns how much: cuts that follow the objects, the speeds and the weights of ranks.
#define _GNU_SOURCE // sched_setaffinity
#include "cluster/cluster.h"
#include "cluster/crowd.h"

#include <math.h>
#include <sched.h>

// Objects that moved away from the cut are cut anew.
static void a_cut_that_became_uneven_is_made_anew(duet_cluster *cluster, const crowd *c, rng *r)
{
    (void)r;
    hand_over(cluster, c, 0, 1);
    must_find(cluster, c);
    const uint64_t *ids;
    uint32_t n;
    duet_pose *own = must(duet_cluster_map_owned(cluster, DUET_OBJECT_POSES, &ids, &n, ERR));
    for (uint32_t i = 0; i < n; ++i)
        own[i].centre[0] = (float)(1000 + (double)ids[i]);
    step(cluster);
    own = must(duet_cluster_map_owned(cluster, DUET_OBJECT_POSES, &ids, &n, ERR));
    MUST(n > 70 && n < 80, "a quarter of 300 objects");
}

static int n_moves;

static void count_move(worker *w)
{
    (void)w;
    ++n_moves;
}

// A rank's grid follows its objects once they have left where it lies, and not each step.
static void grids_follow_objects_that_travel(duet_cluster *cluster, const crowd *c, rng *r)
{
    (void)r;
    cluster->workers[0]->forget_grids = count_move;
    hand_over(cluster, c, 0, 1);
    step(cluster);
    int before = n_moves;
    MUST(before > 0, "what is new has moved");
    extent box = cluster->owned.around;
    float little = (float)((box.upper[0] - box.lower[0]) / 18);
    for (int at = 1; at <= 12; ++at) {
        const uint64_t *ids;
        uint32_t n;
        duet_pose *own = must(duet_cluster_map_owned(cluster, DUET_OBJECT_POSES, &ids, &n, ERR));
        for (uint32_t i = 0; i < n; ++i)
            own[i].centre[0] += little;
        step(cluster);
        MUST(n_moves - before == at / 5, "past each quarter of the width");
    }
}

// Parts and their grids stay while owned objects do, and are made anew once owned objects crowd.
static void parts_stay_while_they_are_even(void)
{
    static crowd c;
    rng r = rng_seed(12);
    make_crowd(&c, &r, 3);
    n_parts = 3;
    duet_cluster *cluster = open_cluster(2, &c.world, 1);
    n_parts = 1;
    if (cluster)
        hand_over(cluster, &c, 0, 1);
    for (int at = 0; at < 6; ++at) {
        bool crowds = at == 3; // towards a corner
        for (uint32_t i = 0; at > 0 && i < c.n; ++i)
            for (int k = 0; k < 3; ++k)
                c.poses[i].centre[k] *= crowds && i % 4 != 0 ? 0.1f : 1.001f;
        find_expected(&c);
        if (!cluster)
            continue;
        const uint64_t *ids;
        uint32_t n;
        int before = n_moves;
        duet_pose *own = must(duet_cluster_map_owned(cluster, DUET_OBJECT_POSES, &ids, &n, ERR));
        for (uint32_t i = 0; i < n; ++i)
            own[i] = c.poses[ids[i]];
        for (int i = 0; i < 2; ++i)
            cluster->workers[i]->forget_grids = count_move;
        must_find(cluster, &c);
        MUST(at == 0 || n_moves == before + (crowds ? 2 : 0),
             "both workers fit grids anew once parts are cut");
    }
    duet_cluster_destroy(cluster);
}

static void ranks_get_objects_by_their_weights(void)
{
    static crowd c;
    rng r = rng_seed(6);
    make_crowd(&c, &r, 3);
    static const double weights[] = {5e307, 5e307, 1e308}; // weights with an infinite sum
    static const uint64_t due[] = {75, 75, 150};
    duet_cluster *cluster = open_cluster(3, &c.world, weights[rank % 3]);
    if (!cluster)
        return;
    duet_cluster_rank rows[3];
    hand_over(cluster, &c, 0, 1);
    duet_cluster_result result = step(cluster);
    must(duet_cluster_get_ranks(cluster, rows, ERR));
    uint64_t objects = 0, pairs = 0;
    for (int q = 0; q < 3; ++q) {
        MUST(rows[q].objects + 2 >= due[q] && rows[q].objects <= due[q] + 2, "its part");
        MUST(strcmp(rows[q].pair, "plain") == 0 && rows[q].host[0], "what it is");
        objects += rows[q].objects;
        pairs += rows[q].pairs;
    }
    MUST(objects == result.objects && pairs == result.pairs, "each is counted once");
    duet_cluster_destroy(cluster);
}

// Times that a store has of rank 0, and of others that are three times as quick, ghosts included.
static duet_cluster *asked;

static bool some_profile(worker *w, const char *path, duet_profile *profile, duet_error *err)
{
    double each = rank == 0 ? 0.3 : 0.1;
    (void)w, (void)err;
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT};
    if (!path || rank > 0)
        profile->step_ms = 1 + each * owned_count(&asked->owned);
    return true;
}

static void ranks_are_weighed_by_their_stored_times(duet_cluster *cluster, const crowd *c, rng *r)
{
    (void)r;
    asked = cluster;
    duet_cluster_rank rows[3];
    duet_profile profile;
    cluster->workers[0]->load_profile = some_profile;
    hand_over(cluster, c, 0, 1);
    must(duet_cluster_load_profile(cluster, "not of rank 0", &profile, NULL, ERR));
    MUST(owned_count(&cluster->owned) > 97 && owned_count(&cluster->owned) < 103,
         "alike while one is not known");
    must(duet_cluster_load_profile(cluster, NULL, &profile, NULL, ERR));
    must_find(cluster, c);
    must(duet_cluster_get_ranks(cluster, rows, ERR));
    double most_ms = 0, speeds = 0;
    for (int q = 0; q < 3; ++q) {
        double ms = 1 + (q == 0 ? 0.3 : 0.1) * (double)rows[q].objects;
        most_ms = fmax(most_ms, ms);
        speeds += (double)rows[q].objects / ms;
    }
    MUST(most_ms < 1.05 * MOST_OBJECTS / speeds, "the first step takes what their speeds sum to");
}

// The first of three ranks takes three times as long for each of its objects: it gets fewer, once
// that has cost more than a cut, and pairs stay as they are.
static bool (*find_pairs)(worker *w, const global_ids *ids, worker_found *found, duet_error *err);
static uint64_t told_ns;

// Nothing takes time but finding pairs.
static uint64_t tell_ns(void)
{
    return told_ns;
}

static bool find_slowly(worker *w, const global_ids *ids, worker_found *found, duet_error *err)
{
    told_ns += (rank == 0 ? 30 : 10) * 1000 * (uint64_t)owned_count(&asked->owned);
    return find_pairs(w, ids, found, err);
}

static void ranks_that_prove_slow_get_fewer_objects(duet_cluster *cluster, const crowd *c, rng *r)
{
    (void)r;
    asked = cluster;
    uint64_t (*now_ns)(void) = ranks_now_ns;
    ranks_now_ns = tell_ns;
    find_pairs = cluster->workers[0]->find;
    cluster->workers[0]->find = find_slowly;
    hand_over(cluster, c, 0, 1);
    must_find(cluster, c);
    uint64_t n = owned_count(&cluster->owned);
    MPI_Bcast(&n, 1, MPI_UINT64_T, 0, cluster->ranks.comm);
    MUST(n > 97 && n < 103, "alike at first");
    for (int at = 0; at < 160; ++at)
        must_find(cluster, c);
    n = owned_count(&cluster->owned);
    MPI_Bcast(&n, 1, MPI_UINT64_T, 0, cluster->ranks.comm);
    MUST(n > 40 && n < 47, "3 : 1 : 1 in speed is 43 of 300 objects");
    ranks_now_ns = now_ns;
}

// Processors that several ranks may use are divided among these.
static void each_rank_has_its_part_of_the_processors(duet_cluster *c)
{
    cpu_set_t all, own;
    CPU_ZERO(&own);
    MUST(sched_getaffinity(0, sizeof all, &all) == 0, "affinity");
    for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&own) <= rank; ++i)
        if (CPU_ISSET(i, &all))
            CPU_SET(i, &own); // the first for rank 0, and another one for rank 1
    MUST(sched_setaffinity(0, sizeof own, &own) == 0, "affinity");
    ranks of_two;
    must(ranks_begin(&of_two, &c->ranks.comm, NULL, ERR));
    double shared = 1.0 / of_two.n_on_host, expected = shared + CPU_COUNT(&own) - 1;
    MUST(fabs(of_two.processors - expected) < 1e-9, "the first one is shared");
    ranks_end(&of_two);
    MUST(sched_setaffinity(0, sizeof all, &all) == 0, "affinity");
}

// Small differences are no reason for a cut, nor are steps that were slow once; and weights that
// were given stay.
static void a_cut_must_pay(duet_cluster *of)
{
    ranks *of_two = &of->ranks;
    partition c;
    must(partition_begin(&c, of_two, 0, ERR));
    balance b;
    balance_begin(&b, rank == 0 ? 50 : 100);
    for (int at = 0; at < 800; ++at)
        MUST(!balance_note(&b, of_two, &c, rank == 0 ? 9.2 : 10, 1000), "4 in a hundred");
    for (int at = 0; at < 800; ++at)
        MUST(!balance_note(&b, of_two, &c, rank == 0 && at % 8 ? 1000 : 10, 1000), "accidents");
    int steps = 1;
    while (!balance_note(&b, of_two, &c, rank == 0 ? 10 : 30, 1000) && steps < 1000)
        ++steps;
    MUST(steps == 32,
         "10 ms are lost a step, and a cut takes 100: the first 8 steps past 3 of them");
    MUST(fabs(c.due - (rank == 0 ? 0.75 : 0.25)) < 1e-9, "by their speeds");
    partition_end(&c);
}

int main(int argc, char **argv)
{
    job_begin(&argc, &argv, 4, 20261122);
    on_crowd(4, 5, 1, a_cut_that_became_uneven_is_made_anew);
    on_crowd(1, 12, 1, grids_follow_objects_that_travel);
    parts_stay_while_they_are_even();
    ranks_get_objects_by_their_weights();
    on_crowd(3, 6, 0, ranks_are_weighed_by_their_stored_times);
    on_crowd(3, 6, 0, ranks_that_prove_slow_get_fewer_objects);
    on_ranks(2, each_rank_has_its_part_of_the_processors);
    on_ranks(2, a_cut_must_pay);
    return job_end("owned objects follow what ranks can do");
}
