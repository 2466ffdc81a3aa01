// SPDX-License-Identifier: MIT
// Failures of one rank, which are those of all of them, in one line; and what is refused.
#include "cluster/cluster.h"
#include "cluster/crowd.h"

#include "base/error.h"

#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

// ---------------------------------------------------------------- a rank that fails

static void *(*extend_in_truth)(worker *, uint32_t, uint32_t, duet_error *);

static void *extend_by_nothing(worker *w, uint32_t n, uint32_t kept, duet_error *err)
{
    (void)w, (void)n, (void)kept;
    error_set(err, DUET_STATUS_NO_MEMORY, "none in this test");
    return NULL;
}

// One rank has no memory for its owned objects at first: later its objects lie like those of the
// others.
static void objects_go_on_after_one_rank_had_no_memory(duet_cluster *cluster, const crowd *c,
                                                       rng *r)
{
    duet_cluster_result result;
    worker *w = cluster->workers[0];
    cluster->migration.imbalance = 1e9; // the cut stays as it is made here
    hand_over(cluster, c, 0, 5);
    extend_in_truth = w->extend;
    w->extend = rank == 1 ? extend_by_nothing : w->extend;
    must_fail(duet_cluster_step(cluster, &result, ERR), DUET_STATUS_NO_MEMORY, "rank 1 on ");
    w->extend = extend_in_truth;
    for (int at = 0; at < 5; ++at) {
        deal_anew(cluster, false, r);
        must_find(cluster, c);
    }
}

static bool (*find_in_truth)(worker *, const global_ids *, worker_found *, duet_error *);
static int finds_left;

static bool find_some_times(worker *w, const global_ids *ids, worker_found *found, duet_error *err)
{
    return finds_left-- > 0 ? find_in_truth(w, ids, found, err)
                            : error_set(err, DUET_STATUS_DEVICE_FAILED, "not in this test");
}

// Whichever part it fails in, ghosts leave the places of the owned objects behind it.
static void a_search_that_fails_leaves_objects_as_they_were(duet_cluster *cluster, const crowd *c,
                                                            rng *r)
{
    (void)r;
    duet_cluster_result result;
    hand_over(cluster, c, 0, 5);
    find_in_truth = cluster->workers[0]->find;
    for (int at = 0; at < 5; ++at) {
        for (int i = 0; i < 2; ++i)
            cluster->workers[i]->find = rank == 1 ? find_some_times : find_in_truth;
        finds_left = at;
        must_fail(duet_cluster_step(cluster, &result, ERR), DUET_STATUS_DEVICE_FAILED, "");
        for (int i = 0; i < 2; ++i)
            cluster->workers[i]->find = find_in_truth;
        must_find(cluster, c);
    }
}

static void a_failure_is_that_of_all_ranks(duet_cluster *c)
{
    duet_pose pose = {.half_extents = {1, 1, 1}, .rotation = {0, 0, 0, 1}};
    uint64_t ids[] = {7, 7};
    duet_pose two[] = {pose, pose};
    duet_cluster_result result;

    must_fail(duet_cluster_set_objects(c, rank == 1 ? DUET_OBJECT_BOUNDS : DUET_OBJECT_POSES, ids,
                                       two, 0, ERR),
              DUET_STATUS_BAD_ARGUMENT, "rank 1 on ");
    must_fail(duet_cluster_set_objects(c, DUET_OBJECT_POSES, ids, two, rank == 2 ? 2 : 0, ERR),
              DUET_STATUS_BAD_ARGUMENT, "object 7 is there twice");
    MUST(!duet_cluster_set_objects(c, DUET_OBJECT_POSES, ids, two, 2, NULL), "without an error");

    // On two ranks bad objects: all name the lesser.
    uint64_t own[] = {((uint64_t)1 << 40) + (uint64_t)(100 - 10 * rank), (uint64_t)rank};
    two[0].centre[1] = rank == 0 ? 0.0f : NAN;
    must(duet_cluster_set_objects(c, DUET_OBJECT_POSES, own, two, 2, ERR));
    must_fail(duet_cluster_step(c, &result, ERR), DUET_STATUS_BAD_OBJECT,
              "object 1099511627856 of 6 is not a number, infinite, negative or without rotation "
              "(2 such");
    two[0] = pose;
    must(duet_cluster_set_objects(c, DUET_OBJECT_POSES, own, two, 2, ERR));
    result = step(c);
    MUST(result.pairs == 15, "six boxes in one place, after a failure");
    const uint64_t *owned_ids;
    uint32_t n;
    for (int at = 0; at < 2; ++at) { // objects that became bad in place are mended in place
        duet_pose *mapped = must(duet_cluster_map_owned(c, DUET_OBJECT_POSES, &owned_ids, &n, ERR));
        for (uint32_t i = 0; i < n; ++i)
            mapped[i].centre[1] = at == 0 && owned_ids[i] % 2 ? NAN : pose.centre[1];
        if (at == 0)
            must_fail(duet_cluster_step(c, &result, ERR), DUET_STATUS_BAD_OBJECT, "object ");
    }
    MUST(step(c).pairs == 15, "six boxes in one place again");

    must_fail(duet_cluster_save_pairs(c, "no/such/folder/p.npy", true, ERR), DUET_STATUS_IO_FAILED,
              "no/such/folder/p.npy: cannot be written");
    must_fail(duet_cluster_save_pairs(c, "/dev/null", false, ERR), DUET_STATUS_IO_FAILED,
              "expected a plain file");
    must_fail(duet_cluster_load_scene(c, "papr", NULL, 0, ERR), DUET_STATUS_BAD_ARGUMENT,
              "rank 0 on ");
    MUST(duet_cluster_get_scene_info(c) == NULL, "there is no scene");
    MUST(step(c).pairs == 15, "what was there stays");

    duet_cluster_def def = duet_default_cluster_def();
    def.comm = &c->ranks.comm;
    def.plain = true;
    def.weight = rank == 2 ? -1 : 1;
    must_fail(duet_cluster_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT,
              "weight is -1; expected a number above 0");
    def.weight = rank == 2 ? 0 : 1;
    must_fail(duet_cluster_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT,
              "weight is 0 on 1 of 3 ranks; expected numbers above 0, or 0 on all");
}

enum { MOST_IDS = 120 };

// Ids of all ranks, [n], and whose they are; none is twice on one rank.
typedef struct dealt_ids {
    uint64_t ids[MOST_IDS];
    int ranks[MOST_IDS];
    uint32_t n;
} dealt_ids;

static bool has(const dealt_ids *d, uint64_t id, int of)
{
    for (uint32_t i = 0; i < d->n; ++i)
        if (d->ids[i] == id && d->ranks[i] == of)
            return true;
    return false;
}

// Ids are few, all that there are, or in a range for each rank, which the next one's may touch.
static void deal_ids(dealt_ids *d, rng *r, uint32_t round, int n_ranks)
{
    uint32_t n = rng_below(r, MOST_IDS);
    d->n = 0;
    for (uint32_t i = 0; i < n; ++i) {
        int of = (int)rng_below(r, (uint32_t)n_ranks);
        uint64_t id = round % 3 == 0   ? rng_below(r, 2000)
                      : round % 3 == 1 ? (uint64_t)rng_next(r) << 32 |
                                             (rng_below(r, 30) == 0 ? UINT64_MAX : rng_next(r))
                                       : (uint64_t)of * 300 + rng_below(r, 301);
        if (has(d, id, of))
            continue;
        d->ids[d->n] = id;
        d->ranks[d->n++] = of;
    }
}

// The least id of two ranks, in the line that all of them get; "" where there is none.
static void find_double(const dealt_ids *d, int n_ranks, char *line, size_t size)
{
    uint64_t least = UINT64_MAX;
    *line = '\0';
    for (uint32_t i = 0; i < d->n; ++i) {
        int holders = 0, first = 0, last = 0;
        for (int q = n_ranks - 1; q >= 0; --q)
            if (has(d, d->ids[i], q)) {
                last = holders++ == 0 ? q : last;
                first = q;
            }
        if (holders < 2 || d->ids[i] > least)
            continue;
        least = d->ids[i];
        snprintf(line, size, "object %" PRIu64 " is there twice: on rank %d and on rank %d", least,
                 first, last);
    }
}

// At the level at which nobody compares ids in a step, of objects far from each other.
static void an_id_that_two_ranks_bring_is_refused(uint64_t seed)
{
    static const int some_groups[] = {2, 3, 8};
    for (int g = 0; g < 3; ++g) {
        rng r = rng_seed(seed + (uint64_t)g);
        duet_world_def world = duet_default_world_def();
        duet_cluster *c = open_cluster(some_groups[g], &world, 1);
        if (!c)
            continue;
        uint64_t there = 0;
        int refused = 0, taken = 0;
        for (uint32_t round = 0; round < 36; ++round) {
            dealt_ids d;
            duet_error err = {0};
            char says[100];
            uint64_t ids[MOST_IDS];
            duet_pose poses[MOST_IDS];
            uint32_t n = 0;
            deal_ids(&d, &r, round, some_groups[g]);
            find_double(&d, some_groups[g], says, sizeof says);
            for (uint32_t i = 0; i < d.n; ++i)
                if (d.ranks[i] == rank) {
                    poses[n] = (duet_pose){.centre = {(float)i * 9}, .rotation = {0, 0, 0, 1}};
                    ids[n++] = d.ids[i];
                }
            bool ok = duet_cluster_set_objects(c, DUET_OBJECT_POSES, ids, poses, n, &err);
            MUST(ok == !*says && strcmp(err.text, says) == 0, ok ? says : err.text);
            there = ok ? d.n : there;
            refused += !ok;
            taken += ok;
            MUST(round % 4 > 0 || step(c).objects == there, "all or none of them");
        }
        MUST(refused > 5 && taken > 5, "some of both");
        duet_cluster_destroy(c);
    }
}

static void calls_in_another_order_are_refused(duet_cluster *c)
{
    duet_cluster_rank rows[3];
    duet_cluster_result result;
    must_fail(rank == 1 ? duet_cluster_get_ranks(c, rows, ERR) : duet_cluster_step(c, &result, ERR),
              DUET_STATUS_BAD_ARGUMENT,
              rank == 1 ? "duet_cluster_get_ranks, and another rank makes another call"
                        : "duet_cluster_step, and another rank makes another call");
    MUST(step(c).pairs == 0, "and all goes on");
    duet_plan plan = duet_default_plan(NULL);
    for (int i = 0; i < 2; ++i) {
        must_fail(rank != 1 ? duet_cluster_step(c, &result, ERR)
                  : i == 0  ? duet_cluster_set_level(c, DUET_LEVEL_AABB, ERR)
                            : duet_cluster_set_plan(c, &plan, ERR),
                  DUET_STATUS_BAD_ARGUMENT, ", and another rank makes another call");
        MUST(step(c).pairs == 0, "no rank waits for others in the next step");
    }
}

// A rank that has no cluster is alone.
static void each_call_that_fails_gives_its_own_line(void)
{
    const duet_error earlier = {
        .cl_code = -1, .status = DUET_STATUS_DEVICE_FAILED, .text = "an earlier call failed"};
    for (int i = 0; i < 11; ++i) {
        duet_error err = earlier, *e = &err;
        bool ok = i == 0   ? duet_cluster_create(NULL, e) != NULL
                  : i == 1 ? duet_cluster_load_scene(NULL, "x.lua", NULL, 0, e)
                  : i == 2 ? duet_cluster_set_objects(NULL, DUET_OBJECT_POSES, NULL, NULL, 0, e)
                  : i == 3 ? duet_cluster_map_owned(NULL, DUET_OBJECT_POSES, NULL, NULL, e) != NULL
                  : i == 4 ? duet_cluster_set_plan(NULL, NULL, e)
                  : i == 5 ? duet_cluster_load_profile(NULL, NULL, NULL, NULL, e)
                  : i == 6 ? duet_cluster_set_level(NULL, DUET_LEVEL_AABB, e)
                  : i == 7 ? duet_cluster_step(NULL, NULL, e)
                  : i == 8 ? duet_cluster_get_own_pairs(NULL, NULL, NULL, e)
                  : i == 9 ? duet_cluster_get_ranks(NULL, NULL, e)
                           : duet_cluster_save_pairs(NULL, "x.npy", false, e);
        MUST(!ok && err.status == DUET_STATUS_BAD_ARGUMENT && strstr(err.text, "luster") &&
                 !strchr(err.text, '\n'),
             err.text);
    }
}

// One rank's disk is full: nothing appears, and all ranks know.
static void a_disk_that_is_full_is_told_of(duet_cluster *cluster, const crowd *c, rng *r)
{
    (void)r;
    struct rlimit before, little = {.rlim_cur = 200};
    hand_over(cluster, c, 0, 3);
    step(cluster);
    MUST(getrlimit(RLIMIT_FSIZE, &before) == 0, "a limit");
    little.rlim_max = before.rlim_max;
    signal(SIGXFSZ, SIG_IGN);
    MUST(rank != 2 || setrlimit(RLIMIT_FSIZE, &little) == 0, "a limit");
    must_fail(duet_cluster_save_pairs(cluster, "cluster_full.npy", true, ERR),
              DUET_STATUS_IO_FAILED, "rank 2 on ");
    MUST(strstr(ERR->text, "cluster_full.npy: cannot be written: File too large"), ERR->text);
    MUST(setrlimit(RLIMIT_FSIZE, &before) == 0, "a limit");
    MUST(access("cluster_full.npy", F_OK) != 0, "no file appears");
}

#define REFUSED(call) must_fail(call, DUET_STATUS_BAD_ARGUMENT, "")

// Every call refuses NULL; what is not a cluster has no ranks.
static void nothing_is_refused(void)
{
    duet_cluster_result result;
    duet_cluster_rank rows[8];
    duet_profile profile;
    duet_plan plan = duet_default_plan(NULL);
    const uint64_t *ids;
    const duet_pair64 *pairs;
    uint64_t n_pairs;
    uint32_t n;
    MUST(duet_cluster_get_rank(NULL) == -1 && duet_cluster_get_rank_count(NULL) == 0 &&
             duet_cluster_get_motion_step(NULL) == 0,
         "no ranks");
    MUST(!duet_cluster_get_scene_info(NULL), "no scene");
    duet_cluster_destroy(NULL);
    REFUSED(duet_cluster_create(NULL, ERR));
    REFUSED(duet_cluster_load_scene(NULL, "paper", NULL, 0, ERR));
    REFUSED(duet_cluster_set_objects(NULL, DUET_OBJECT_POSES, NULL, NULL, 0, ERR));
    REFUSED(duet_cluster_map_owned(NULL, DUET_OBJECT_POSES, &ids, &n, ERR));
    REFUSED(duet_cluster_set_plan(NULL, &plan, ERR));
    REFUSED(duet_cluster_set_level(NULL, DUET_LEVEL_AABB, ERR));
    REFUSED(duet_cluster_load_profile(NULL, NULL, &profile, NULL, ERR));
    REFUSED(duet_cluster_step(NULL, &result, ERR));
    REFUSED(duet_cluster_get_ranks(NULL, rows, ERR));
    REFUSED(duet_cluster_get_own_pairs(NULL, &pairs, &n_pairs, ERR));
    REFUSED(duet_cluster_save_pairs(NULL, "p.npy", true, ERR));
}

static void arguments_that_are_missing_or_wrong_are_refused(duet_cluster *c)
{
    const duet_pair64 *pairs;
    const uint64_t *ids;
    uint64_t id = 0, n_pairs;
    uint32_t n;
    REFUSED(duet_cluster_load_scene(c, NULL, NULL, 0, ERR));
    REFUSED(duet_cluster_set_objects(c, DUET_OBJECT_POSES, NULL, &id, 1, ERR));
    REFUSED(duet_cluster_set_objects(c, DUET_OBJECT_POSES, &id, NULL, 1, ERR));
    REFUSED(duet_cluster_map_owned(c, DUET_OBJECT_POSES, NULL, &n, ERR));
    REFUSED(duet_cluster_map_owned(c, DUET_OBJECT_POSES, &ids, NULL, ERR));
    REFUSED(duet_cluster_map_owned(c, DUET_OBJECT_SIZES, &ids, &n, ERR));
    REFUSED(duet_cluster_map_owned(c, DUET_OBJECT_SPHERES, &ids, &n, ERR));
    REFUSED(duet_cluster_set_plan(c, NULL, ERR));
    REFUSED(duet_cluster_set_level(c, (duet_level)99, ERR));
    REFUSED(duet_cluster_load_profile(c, NULL, NULL, NULL, ERR));
    REFUSED(duet_cluster_step(c, NULL, ERR));
    REFUSED(duet_cluster_get_ranks(c, NULL, ERR));
    REFUSED(duet_cluster_save_pairs(c, NULL, true, ERR));
    REFUSED(duet_cluster_get_own_pairs(c, &pairs, &n_pairs, ERR)); // there was no step
    step(c);
    REFUSED(duet_cluster_get_own_pairs(c, NULL, &n_pairs, ERR));
    REFUSED(duet_cluster_get_own_pairs(c, &pairs, NULL, ERR));
    must(duet_cluster_get_own_pairs(c, &pairs, &n_pairs, ERR));
    MUST(pairs && n_pairs == 0, "no pairs");
}

static void worlds_that_are_wrong_are_refused(duet_cluster *of)
{
    duet_cluster_result result;
    const duet_pair64 *pairs;
    uint64_t n_pairs;
    duet_cluster_def wrong = duet_default_cluster_def();
    wrong.comm = &of->ranks.comm;
    wrong.plain = true;
    wrong.world.pose_form = DUET_POSE_COMPACT; // else they would be taken for poses
    REFUSED(duet_cluster_create(&wrong, ERR));
    wrong.world.pose_form = DUET_POSE_WHOLE;
    wrong.world.shape = (duet_shape)99;
    REFUSED(duet_cluster_create(&wrong, ERR));
    wrong.world.shape = DUET_SHAPE_POSES;
    wrong.world.dims = 7;
    REFUSED(duet_cluster_create(&wrong, ERR));
    wrong.world.dims = 3;
    wrong.world.level = (duet_level)99;
    REFUSED(duet_cluster_create(&wrong, ERR));
    wrong.world.level = DUET_LEVEL_CERTIFIED;
    wrong.world.origin_edge = 0.3f;
    REFUSED(duet_cluster_create(&wrong, ERR));
    wrong.world.origin_edge = 0;
    wrong.parts = rank == 0 ? 0 : 1;
    REFUSED(duet_cluster_create(&wrong, ERR));
    wrong.parts = 1;
    wrong.drops_pairs = true;
    duet_cluster *c = must(duet_cluster_create(&wrong, ERR));
    const duet_pose unit = {.half_extents = {1, 1, 1}, .rotation = {0, 0, 0, 1}};
    const uint64_t id = (uint64_t)rank;
    must(duet_cluster_set_objects(c, DUET_OBJECT_POSES, &id, &unit, 1, ERR));
    REFUSED(duet_cluster_set_level(c, rank == 0 ? DUET_LEVEL_AABB : (duet_level)99, ERR));
    MUST(c->def.world.level == DUET_LEVEL_CERTIFIED, "the level of all ranks stays");
    REFUSED(duet_cluster_set_level(c, rank == 0 ? DUET_LEVEL_AABB : DUET_LEVEL_SAT15, ERR));
    MUST(c->def.world.level == DUET_LEVEL_CERTIFIED, "the level of all ranks stays");
    result = step(c);
    MUST(result.pairs == 1, "a pair that is counted and not kept");
    REFUSED(duet_cluster_get_own_pairs(c, &pairs, &n_pairs, ERR));
    REFUSED(duet_cluster_save_pairs(c, "p.npy", true, ERR));
    duet_cluster_destroy(c);
}

int main(int argc, char **argv)
{
    uint64_t seed = job_begin(&argc, &argv, 8, 20261122);
    nothing_is_refused();
    on_ranks(2, arguments_that_are_missing_or_wrong_are_refused);
    on_ranks(2, worlds_that_are_wrong_are_refused);
    on_ranks(3, a_failure_is_that_of_all_ranks);
    an_id_that_two_ranks_bring_is_refused(seed);
    on_ranks(3, calls_in_another_order_are_refused);
    each_call_that_fails_gives_its_own_line();
    on_crowd(3, 11, 1, a_disk_that_is_full_is_told_of);
    on_crowd(3, 17, 1, objects_go_on_after_one_rank_had_no_memory);
    n_parts = 5;
    on_crowd(2, 18, 1, a_search_that_fails_leaves_objects_as_they_were);
    n_parts = 1;
    return job_end("what fails or is refused on one rank is so on all");
}
