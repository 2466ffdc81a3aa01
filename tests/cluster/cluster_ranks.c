// SPDX-License-Identifier: MIT
// What must hold for any number of ranks, in one job: its ranks are cut into smaller groups,
// each a cluster of its own, and what these find is compared with the plain C reference.
//
// Every rank runs this; a fact that does not hold on one ends the job with a line.
#define _GNU_SOURCE // sched_setaffinity
#include "cluster/cluster.h"
#include "cluster/job.h"

#include "base/error.h"
#include "base/rng.h"
#include "base/text_file.h"
#include "cluster/object_skim.h"
#include "cluster/owner.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/narrowphase/sat_frame.h"
#include "runtime/opencl/device_pair.h"

#include <inttypes.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static const int groups[] = {1, 2, 3, 4, 8};

enum { N_GROUPS = sizeof groups / sizeof groups[0], MOST_OBJECTS = 300 };

// ---------------------------------------------------------------- objects

// Objects of a test, the same on all ranks, and what the reference finds among them.
typedef struct crowd {
    duet_world_def world;
    uint32_t n;
    char name[64];
    duet_pose poses[MOST_OBJECTS];
    duet_bounds bounds[MOST_OBJECTS];
    duet_large_pose large[MOST_OBJECTS];
    duet_rounded_box rounded[MOST_OBJECTS];
    duet_sphere spheres[MOST_OBJECTS];
    duet_pair *pairs;
    uint64_t n_pairs;
} crowd;

static duet_object_kind kind_of(const crowd *c)
{
    object_form form = object_form_of(&c->world);
    return object_form_kind(&form);
}

static const void *objects_of(const crowd *c)
{
    const void *const objects[] = {[DUET_OBJECT_POSES] = c->poses,
                                   [DUET_OBJECT_BOUNDS] = c->bounds,
                                   [DUET_OBJECT_LARGE_POSES] = c->large,
                                   [DUET_OBJECT_ROUNDED_BOXES] = c->rounded,
                                   [DUET_OBJECT_SPHERES] = c->spheres};
    return objects[kind_of(c)];
}

// It begins with its centre, unless it is of bounds.
static float *row_of(const crowd *c, uint64_t id)
{
    object_form form = object_form_of(&c->world);
    return (float *)((uintptr_t)objects_of(c) + id * form.bytes);
}

static uint64_t hash_of(const crowd *c)
{
    return duet_pairs_hash(c->pairs, c->n_pairs);
}

// By rank 0, for all of the job.
static void find_expected(crowd *c)
{
    duet_free(c->pairs);
    c->pairs = NULL;
    if (rank == 0) {
        duet_scene *scene = must(duet_scene_create(kind_of(c), objects_of(c), c->n, c->world.dims,
                                                   c->world.origin_edge, ERR));
        must(duet_reference(scene, c->world.level, &c->pairs, &c->n_pairs, ERR));
        duet_scene_destroy(scene);
    }
    MPI_Bcast(&c->n_pairs, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    if (rank > 0)
        c->pairs = malloc((c->n_pairs + 1) * sizeof *c->pairs);
    MUST(c->pairs || c->n_pairs == 0, "memory");
    MPI_Bcast(c->pairs, (int)(c->n_pairs * sizeof *c->pairs), MPI_BYTE, 0, MPI_COMM_WORLD);
}

// Sizes of many octaves, of which a few are as wide as all of it, or points.
static double some_half(rng *r, double edge)
{
    uint32_t kind = rng_below(r, 40);
    return kind == 0 ? edge : kind == 1 ? 0.0 : kind < 20 ? exp2(rng_between(r, -12, 1)) : 0.5;
}

static duet_pose some_pose(rng *r, double edge)
{
    duet_pose p = {.half_extents = {(float)some_half(r, edge), (float)some_half(r, edge),
                                    (float)some_half(r, edge)}};
    for (int k = 0; k < 3; ++k)
        p.centre[k] = (float)rng_between(r, -edge, edge);
    for (int k = 0; k < 4; ++k)
        p.rotation[k] = (float)rng_normal(r);
    return p;
}

// On a lattice, so that faces touch and cuts go through them; or huge.
static void change_pose(duet_pose *p, bool on_lattice, float scale)
{
    for (int k = 0; k < 3; ++k) {
        float centre = on_lattice ? rintf(p->centre[k]) : p->centre[k];
        float half = on_lattice ? ceilf(2 * p->half_extents[k]) / 2 : p->half_extents[k];
        p->centre[k] = scale * centre;
        p->half_extents[k] = scale * half;
        p->rotation[k] = on_lattice ? 0 : p->rotation[k];
    }
}

static float some_radius(rng *r, bool on_lattice, float scale)
{
    float radius = (float)some_half(r, rng_below(r, 30) ? 0.25 : 4);
    return scale * (on_lattice ? ceilf(2 * radius) / 2 : radius);
}

enum { SPHERES = 43, ROUNDED = 45, N_CROWDS = 55 }; // crowds from SPHERES on have radii

static duet_world_def world_of_crowd(uint32_t i)
{
    duet_world_def world = duet_default_world_def();
    world.dims = 2 + (i & 1);
    world.shape = i % 3 == 2 ? DUET_SHAPE_BOUNDS : DUET_SHAPE_POSES;
    world.origin_edge = i % 3 == 1 ? 0.25f : 0.0f;
    if (i >= SPHERES) {
        world.shape = i & 2 ? DUET_SHAPE_SPHERES : DUET_SHAPE_ROUNDED_BOXES;
        world.origin_edge = 0;
        world.level = i % 3 == 2 ? DUET_LEVEL_AABB : DUET_LEVEL_CERTIFIED;
    }
    return world;
}

static void make_crowd(crowd *c, rng *r, uint32_t i)
{
    static const uint32_t counts[] = {MOST_OBJECTS, 200, 40, 5, 1, 0};
    c->world = world_of_crowd(i);
    c->n = i % 5 == 4 ? counts[rng_below(r, 6)] : MOST_OBJECTS;
    double edge = i % 7 == 6 ? 0.0 : rng_between(r, 1, 8); // 0: all in one place
    for (uint32_t k = 0; k < c->n; ++k) {
        duet_pose p = some_pose(r, edge);
        float scale = i % 11 == 10 && i % 3 != 1 ? 0x1p40f : 1;
        change_pose(&p, i % 8 > 5, scale);
        c->poses[k] = p;
        c->rounded[k] = (duet_rounded_box){.pose = p};
        if (i >= SPHERES)
            c->rounded[k].radius = some_radius(r, i % 8 > 5, scale);
        c->spheres[k].radius = c->rounded[k].radius;
        memcpy(c->spheres[k].centre, p.centre, sizeof p.centre);
        duet_large_pose *large = &c->large[k];
        double far = k % 2 ? 1e7 : -1e7;
        double centre[3] = {(double)p.centre[0] + far, (double)p.centre[1], (double)p.centre[2]};
        *large = (duet_large_pose){.pose = p};
        MUST(c->world.origin_edge == 0 || duet_large_pose_set(large, centre, 0.25f, NULL),
             "a large pose");
        for (int d = 0; d < 3; ++d) {
            c->bounds[k].lower[d] = p.centre[d] - p.half_extents[d];
            c->bounds[k].upper[d] = p.centre[d] + p.half_extents[d];
        }
    }
    snprintf(c->name, sizeof c->name, "crowd %u of %u objects", i, c->n);
    find_expected(c);
}

// ---------------------------------------------------------------- clusters

static uint32_t n_parts = 1; // parts of the clusters that are opened

static duet_cluster *open_cluster(int n_ranks, const duet_world_def *world, double weight)
{
    duet_cluster_def def = duet_default_cluster_def();
    def.world = *world;
    def.plain = true;
    def.weight = weight;
    def.parts = n_parts;
    return cluster_of(n_ranks, def);
}

// Each object is some rank's to bring, at random: `salt` says whose.
static void hand_over(duet_cluster *cluster, const crowd *c, uint64_t first_id, uint32_t salt)
{
    object_form form = object_form_of(&c->world);
    uint64_t ids[MOST_OBJECTS];
    unsigned char *rows = malloc((size_t)MOST_OBJECTS * form.bytes);
    uint32_t n = 0;
    MUST(rows, "memory");
    for (uint32_t i = 0; i < c->n; ++i) {
        uint32_t k = c->n - 1 - i; // not in the order of ids
        if ((int)((k * 2654435761u ^ salt) >> 7) % duet_cluster_get_rank_count(cluster) !=
            duet_cluster_get_rank(cluster))
            continue;
        ids[n] = first_id + k;
        memcpy(rows + (size_t)n++ * form.bytes,
               (const char *)objects_of(c) + (size_t)k * form.bytes, form.bytes);
    }
    must(duet_cluster_set_objects(cluster, kind_of(c), ids, rows, n, ERR));
    free(rows);
}

static duet_cluster_result step(duet_cluster *cluster)
{
    duet_cluster_result result;
    must(duet_cluster_step(cluster, &result, ERR));
    return result;
}

static void must_find(duet_cluster *cluster, const crowd *c)
{
    duet_cluster_result result = step(cluster);
    if (result.pairs != c->n_pairs || result.hash != hash_of(c) || result.objects != c->n) {
        char why[200];
        snprintf(why, sizeof why, "%s, %d ranks: %" PRIu64 " pairs for %" PRIu64, c->name,
                 duet_cluster_get_rank_count(cluster), result.pairs, c->n_pairs);
        end_job("the pairs are the reference's", __FILE__, __LINE__, why);
    }
}

// ---------------------------------------------------------------- facts

// A fact about a cluster of n ranks, for poses in 3D.
static void on_ranks(int n, void (*fact)(duet_cluster *c))
{
    duet_world_def world = duet_default_world_def();
    duet_cluster *c = open_cluster(n, &world, 1);
    if (c)
        fact(c);
    duet_cluster_destroy(c);
}

// The same of one that has none of the crowd's objects yet.
typedef void crowd_fact(duet_cluster *cluster, const crowd *c, rng *r);

static void on_crowd(int n, uint64_t seed, double weight, crowd_fact *fact)
{
    static crowd c;
    rng r = rng_seed(seed);
    make_crowd(&c, &r, 3);
    duet_cluster *cluster = open_cluster(n, &c.world, weight);
    if (cluster)
        fact(cluster, &c, &r);
    duet_cluster_destroy(cluster);
}

static void random_crowds_have_the_same_pairs(uint64_t seed)
{
    static crowd c;
    rng r = rng_seed(seed);
    for (uint32_t i = 0; i < N_CROWDS; ++i) {
        make_crowd(&c, &r, i);
        double weight = exp2(rng_between(&r, -2, 2) * (i % 2 ? rank : 0));
        for (int g = 0; g < N_GROUPS; ++g) {
            n_parts = 1 + (i + (uint32_t)(g + rank)) * 7 % 13 % 6; // they differ from rank to rank
            duet_cluster *cluster = open_cluster(groups[g], &c.world, weight);
            n_parts = 1;
            if (!cluster)
                continue;
            hand_over(cluster, &c, 0, (uint32_t)rng_seed(i).state);
            must_find(cluster, &c);
            must_find(cluster, &c); // nothing moved
            duet_cluster_destroy(cluster);
        }
    }
}

typedef struct shipped {
    const char *name;
    duet_setting settings[3];
    duet_level level;
} shipped;

static void must_have_the_pairs_of(const shipped *s)
{
    uint64_t expected[3] = {0}; // objects, pairs and their hash
    if (rank == 0) {
        duet_pair *pairs = NULL;
        duet_scene *scene = must(duet_scene_load(s->name, s->settings, 3, ERR));
        must(duet_reference(scene, s->level, &pairs, &expected[1], ERR));
        expected[0] = duet_scene_get_info(scene)->n;
        expected[2] = duet_pairs_hash(pairs, expected[1]);
        duet_free(pairs);
        duet_scene_destroy(scene);
    }
    MPI_Bcast(expected, 3, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    for (int g = 0; g < N_GROUPS; ++g) {
        duet_world_def world = duet_default_world_def();
        duet_cluster *cluster = open_cluster(groups[g], &world, 1);
        if (!cluster)
            continue;
        must(duet_cluster_load_scene(cluster, s->name, s->settings, 3, ERR));
        must(duet_cluster_set_level(cluster, s->level, ERR));
        duet_cluster_result result = step(cluster);
        if (result.pairs != expected[1] || result.hash != expected[2])
            end_job("the pairs are the reference's", __FILE__, __LINE__, s->name);
        const duet_scene_info *info = duet_cluster_get_scene_info(cluster);
        size_t length = strcspn(s->name, ".");
        MUST(strncmp(info->name, s->name, length) == 0 && !info->name[length] &&
                 info->n == expected[0],
             s->name);
        duet_cluster_destroy(cluster);
    }
}

// Objects of each and others between them, in origin cells; the only one that is rotated is
// some rank's.
static const char mixed_scene[] =
    "local p = parameters { n = 10, seed = 1 }\n"
    "add(0, 0, 0, 2, 2, 2, 0, 0, 0, 1)\n"
    "each(p.n, function(i, random)\n"
    "  add(1e8 + random.uniform(0, 9), random.uniform(0, 9), i / 100, .5, .5, .5,\n"
    "    i == p.n and 1 or 0, 0, 0, 1)\n"
    "end)\n"
    "add(1e8, 0, 0, 3, 3, 3, 0, 0, 0, 1)\n"
    "each(p.n, function(_, random) add(1e8 + random.uniform(0, 9), 0, 0, 1, 1, 1, 0, 0, 0, 1) "
    "end)\n"
    "return { dims = 3, origin = 'cell' }\n";

static const char other_scene[] =
    "local p = parameters { n = 9, flat = false }\n"
    "each(p.n, function(i)\n"
    "  if p.flat then add(0, i, 1, 1, 0) else add(0, 0, i, 1, 1, i + 1) end\n"
    "end)\n"
    "return { dims = p.flat and 2 or 3 }\n";

// The file of one rank is another one.
static void objects_of_other_kinds_are_refused(duet_cluster *c)
{
    static const duet_setting settings[] = {{"n", "90"}, {"flat", "true"}};
    if (rank == 1)
        must(text_write_file("other.lua", other_scene, sizeof other_scene - 1, ERR));
    for (uint32_t is_flat = 0; is_flat < 2; ++is_flat) {
        const char *path = rank == 1 ? "other.lua" : "grains";
        must_fail(duet_cluster_load_scene(c, path, settings, 1 + (rank == 1 ? is_flat : 0), ERR),
                  DUET_STATUS_BAD_INPUT, "objects of another kind here than on other ranks");
    }
    if (rank == 1)
        remove("other.lua");
}

static duet_cluster_result step_of_scene(duet_cluster *cluster, const shipped *s)
{
    must(duet_cluster_load_scene(cluster, s->name, s->settings, 3, ERR));
    must(duet_cluster_set_level(cluster, s->level, ERR));
    return step(cluster);
}

// Memory of a step is used again in the next, but for rows of another size.
static void scenes_of_other_rows_may_follow(void)
{
    static const shipped poses = {
        "paper", {{"n", "900"}, {"world", "18"}, {"seed", "1"}}, DUET_LEVEL_DOUBLE};
    static const shipped large = {
        "cluster_ranks.lua", {{"n", "800"}, {"seed", "4"}, {"n", "800"}}, DUET_LEVEL_CERTIFIED};
    for (uint32_t k = 1; k < 4; k += 2) {
        n_parts = k;
        duet_world_def world = duet_default_world_def();
        duet_cluster *a = open_cluster(2, &world, 1), *b = open_cluster(2, &world, 1);
        n_parts = 1;
        if (!a)
            continue;
        step_of_scene(a, &poses);
        duet_cluster_result follows = step_of_scene(a, &large), first = step_of_scene(b, &large);
        MUST(follows.objects == 1602 && first.pairs > 100, "large poses");
        MUST(follows.pairs == first.pairs && follows.hash == first.hash,
             "the pairs of a first one");
        duet_cluster_destroy(a);
        duet_cluster_destroy(b);
    }
}

static void scenes_have_the_same_pairs(void)
{
    job_write("cluster_ranks.lua", mixed_scene);
    static const shipped scenes[] = {
        {"paper", {{"n", "900"}, {"world", "18"}, {"giants", "2"}}, DUET_LEVEL_CERTIFIED},
        {"paper", {{"n", "900"}, {"world", "18"}, {"tiny", ".5"}}, DUET_LEVEL_AABB},
        {"paper", {{"n", "900"}, {"world", "18"}, {"seed", "3"}}, DUET_LEVEL_SAT15},
        {"paper", {{"n", "900"}, {"world", "18"}, {"rotated", "false"}}, DUET_LEVEL_CERTIFIED},
        {"paper2d", {{"n", "900"}, {"world", "40"}, {"seed", "2"}}, DUET_LEVEL_CERTIFIED},
        {"mixed", {{"n", "900"}, {"ratio", "100"}, {"seed", "2"}}, DUET_LEVEL_CERTIFIED},
        {"clustered", {{"n", "900"}, {"clusters", "5"}, {"seed", "2"}}, DUET_LEVEL_CERTIFIED},
        {"planes", {{"n", "900"}, {"rotated", "true"}, {"n", "900"}}, DUET_LEVEL_CERTIFIED},
        {"paper",
         {{"n", "900"}, {"world", "20000"}, {"seed", "2"}},
         DUET_LEVEL_CERTIFIED}, // sparse
        {"grains", {{"n", "900"}, {"space", ".5"}, {"seed", "2"}}, DUET_LEVEL_CERTIFIED},
        {"grains", {{"n", "3"}, {"space", ".5"}, {"rotated", "false"}}, DUET_LEVEL_CERTIFIED},
        {"cluster_ranks.lua", {{"n", "300"}, {"seed", "4"}, {"seed", "4"}}, DUET_LEVEL_SAT15},
        {"orbit2d", {{"n", "5"}, {"n", "5"}, {"n", "5"}}, DUET_LEVEL_CERTIFIED},
        {"paper", {{"n", "0"}, {"world", "20"}, {"seed", "2"}}, DUET_LEVEL_CERTIFIED},
        {"spheres", {{"n", "900"}, {"world", "14"}, {"seed", "2"}}, DUET_LEVEL_SPHERE},
        {"rounded", {{"n", "900"}, {"seed", "2"}, {"seed", "2"}}, DUET_LEVEL_CERTIFIED},
        {"rounded", {{"n", "7"}, {"seed", "2"}, {"seed", "2"}}, DUET_LEVEL_AABB}, // a shape a rank
    };
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; ++i)
        must_have_the_pairs_of(&scenes[i]);
    scenes_of_other_rows_may_follow();
    on_ranks(3, objects_of_other_kinds_are_refused);
    job_remove("cluster_ranks.lua");
}

// An object's place at a step is known by its id alone.
static void move(float centre[3], uint64_t id, uint32_t at)
{
    rng r = rng_seed(id * 1000 + at);
    for (int k = 0; k < 3; ++k)
        centre[k] += (float)rng_between(&r, -1, 1);
    if (id % 50 == at % 50) // far away, and out of all parts
        centre[0] = (float)rng_between(&r, -40, 40);
}

static void move_crowd(crowd *c, uint32_t at)
{
    for (uint32_t id = 0; id < c->n; ++id)
        move(row_of(c, id), id, at);
}

// Homes become as the crowd's objects are.
static void move_owned(duet_cluster *cluster, const crowd *c)
{
    object_form form = object_form_of(&c->world);
    const uint64_t *ids;
    uint32_t n;
    unsigned char *own = must(duet_cluster_map_owned(cluster, kind_of(c), &ids, &n, ERR));
    for (uint32_t i = 0; i < n; ++i)
        memcpy(own + i * form.bytes, row_of(c, ids[i]), form.bytes);
}

// Takes one of each group, in parts or not, and the last but one at a level that rounds.
static void objects_that_move_have_the_references_pairs(uint64_t seed)
{
    static const uint32_t parts_of[N_GROUPS] = {16, 2, 5, 3, 1};
    enum { ROUNDS = 3 };
    static crowd c;
    rng r = rng_seed(seed);
    make_crowd(&c, &r, 3); // poses in 3D
    duet_cluster *clusters[N_GROUPS] = {NULL};
    for (int g = 0; g < N_GROUPS; ++g) {
        n_parts = g == 1 && rank == 0 ? 1 : parts_of[g];
        clusters[g] = open_cluster(groups[g], &c.world, 1 + rank % 2);
        n_parts = 1;
        if (!clusters[g])
            continue;
        hand_over(clusters[g], &c, 0, 7);
        must(g != ROUNDS || duet_cluster_set_level(clusters[g], DUET_LEVEL_DOUBLE, ERR));
    }
    uint64_t left = 0, n_runs = 0;
    for (uint32_t at = 0; at < 200; ++at) {
        for (uint32_t id = 0; id < c.n; ++id)
            move(c.poses[id].centre, id, at);
        find_expected(&c);
        for (int g = 0; g < N_GROUPS; ++g) {
            const uint64_t *ids;
            uint32_t n;
            if (!clusters[g])
                continue;
            duet_pose *own =
                must(duet_cluster_map_owned(clusters[g], DUET_OBJECT_POSES, &ids, &n, ERR));
            for (uint32_t i = 0; i < n; ++i)
                move(own[i].centre, ids[i], at);
            must_find(clusters[g], &c);
            const owned *o = &clusters[g]->owned;
            MUST(owned_count(o) == 0 || o->renamed.n == 0, "a list that grows no further");
            left += o->leavers.n;
            n_runs += o->runs.n;
        }
    }
    MPI_Allreduce(MPI_IN_PLACE, &left, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &n_runs, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    MUST(left > 100 && n_runs > 20 * 200, "objects changed ranks and domains");
    for (int g = 0; g < N_GROUPS; ++g)
        duet_cluster_destroy(clusters[g]);
}

// By the pairs that each rank hands out, when it is asked.
static void must_list(duet_cluster *cluster, const duet_cluster_result *result)
{
    const duet_pair64 *own;
    uint64_t n, sums[2];
    must(duet_cluster_get_own_pairs(cluster, &own, &n, ERR));
    MUST(n == cluster->last.pairs, "as many as were counted");
    sums[0] = n;
    sums[1] = 0;
    for (uint64_t i = 0; i < n; ++i)
        sums[1] += pair64_hash(own[i]);
    ranks_sum(&cluster->ranks, sums, 2);
    MUST(sums[0] == result->pairs && sums[1] == result->hash, "the pairs that were counted");
}

// How many pairs of two owned objects came to the host.
static uint64_t count_brought(const duet_cluster *cluster)
{
    const search_set *set = &cluster->sets[0];
    const worker_found *found = &cluster->searches[0].found;
    uint64_t brought = 0;
    for (int side = 0; side < 2; ++side)
        for (uint64_t i = 0; i < found->spans[side].n; ++i) {
            duet_pair p = found->spans[side].pairs[i];
            brought += p.a < set->n_own && p.b < set->n_own && search_set_owns(set, p);
        }
    return brought;
}

static void give_share(duet_cluster *cluster, uint32_t share)
{
    duet_plan plan = cluster->def.world.plan;
    plan.share = share;
    must(duet_cluster_set_plan(cluster, &plan, ERR));
}

// The last rank's devices have no such variant, and another share is none that all take.
static void must_keep_plans(duet_cluster *cluster, int n)
{
    worker *w = cluster->workers[0];
    duet_plan before = w->plan(w), other = before;
    char says[32];
    other.share = before.share == 0 ? DUET_SHARE_ONE : 0;
    if (rank == n - 1)
        snprintf(other.variant_a, sizeof other.variant_a, "abacus");
    snprintf(says, sizeof says, n > 1 ? "rank %d on " : "abacus", n - 1);
    must_fail(duet_cluster_set_plan(cluster, &other, ERR), DUET_STATUS_BAD_ARGUMENT, says);
    MUST(strstr(ERR->text, "abacus"), ERR->text);
    duet_plan after = w->plan(w);
    MUST(after.share == before.share && strcmp(after.variant_a, before.variant_a) == 0 &&
             cluster->def.world.plan.share != other.share,
         "all keep the plan they had");
}

// The last rank cannot open a world for it.
static void must_keep_objects(duet_cluster *cluster, int n)
{
    duet_cluster_result before = step(cluster);
    duet_plan *plan = &cluster->def.world.plan, right = *plan;
    if (rank == n - 1)
        snprintf(plan->variant_a, sizeof plan->variant_a, "abacus");
    must_fail(duet_cluster_load_scene(cluster, "paper2d", NULL, 0, ERR), DUET_STATUS_BAD_ARGUMENT,
              "abacus");
    *plan = right;
    MUST(!duet_cluster_get_scene_info(cluster), "there is no scene");
    duet_cluster_result after = step(cluster);
    MUST(after.pairs == before.pairs && after.hash == before.hash, "all objects are there");
}

// The CPU's parts are told that they have memory of their own, so they count the pairs of owned
// objects where these are found. Ids are far above 2^32, and objects change ranks and rows. A is
// left out of some steps, whose changes of ids it must hear of later.
static void devices_that_count_have_the_references_pairs(uint64_t seed, int n)
{
    static crowd c;
    const uint64_t first = UINT64_C(1) << 40;
    rng r = rng_seed(seed);
    make_crowd(&c, &r, 3);
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    duet_cluster_def def = duet_default_cluster_def();
    def.world = c.world;
    def.world.pair = must(duet_device_pair_create(&pair_def, ERR));
    def.world.pair->devices[0].info.host_memory = false;
    def.world.pair->devices[1].info.host_memory = rank == 2; // one counts, and the other does not
    duet_cluster *cluster = cluster_of(n, def);
    for (uint32_t at = 0; !cluster && at < 32; ++at)
        find_expected(&c);
    if (!cluster) {
        duet_device_pair_destroy(def.world.pair);
        return;
    }
    hand_over(cluster, &c, first, 7);
    uint64_t counted = 0, brought = 0, gone = 0;
    for (uint32_t at = 0; at < 32; ++at) {
        const uint64_t *ids;
        uint32_t n_owned;
        duet_pose *own =
            must(duet_cluster_map_owned(cluster, DUET_OBJECT_POSES, &ids, &n_owned, ERR));
        for (uint32_t id = at % 16; id < c.n; id += 16) // few, so that few ids change places
            move(c.poses[id].centre, id, at);
        for (uint32_t i = 0; i < n_owned; ++i)
            if ((ids[i] - first) % 16 == at % 16)
                move(own[i].centre, ids[i] - first, at);
        find_expected(&c);
        uint64_t expected = 0;
        for (uint64_t i = 0; i < c.n_pairs; ++i)
            expected += pair64_hash((duet_pair64){first + c.pairs[i].a, first + c.pairs[i].b});
        for (int again = 0; again < 2; ++again) { // nothing moved the second time
            if (at % 4 == 1)
                give_share(cluster, again ? DUET_SHARE_ONE / 2 : 0);
            duet_cluster_result result = step(cluster);
            MUST(result.pairs == c.n_pairs && result.hash == expected, "the reference's pairs");
            counted += cluster->searches[0].found.n_counted;
            brought += rank == 2 ? 0 : count_brought(cluster);
            gone += cluster->owned.leavers.n;
            if (at % 4 == 3)
                must_list(cluster, &result);
        }
    }
    ranks_sum(&cluster->ranks, &counted, 1);
    ranks_sum(&cluster->ranks, &gone, 1);
    ranks_sum(&cluster->ranks, &brought, 1);
    must_keep_plans(cluster, n);
    must_keep_objects(cluster, n);
    MUST(counted > 1000 && (gone > 20 || n == 1), "devices counted, while objects left");
    MUST(brought <= counted / 100,
         "of the pairs of owned objects only those that float cannot decide come");
    duet_cluster_destroy(cluster);
    duet_device_pair_destroy(def.world.pair);
}

// On two ranks, of whose devices one have memory of their own, to which parts travel while others
// are searched, and the others read parts where they lie. Pairs are counted by the first of these.
static void devices_find_the_pairs_of_parts_in_place(uint64_t seed, uint32_t crowd_at, uint32_t k)
{
    static crowd c;
    rng r = rng_seed(seed);
    make_crowd(&c, &r, crowd_at);
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    duet_cluster_def def = duet_default_cluster_def();
    def.world = c.world;
    def.world.plan.mode = DUET_MODE_OWN;
    def.parts = k;
    def.drops_pairs = true;
    def.world.pair = must(duet_device_pair_create(&pair_def, ERR));
    for (int i = 0; i < 2; ++i)
        def.world.pair->devices[i].info.host_memory = rank == 1;
    duet_cluster *cluster = cluster_of(2, def);
    if (cluster)
        hand_over(cluster, &c, 0, 7);
    for (uint32_t at = 0; at < 12; ++at) {
        move_crowd(&c, at);
        find_expected(&c);
        if (!cluster)
            continue;
        move_owned(cluster, &c);
        must_find(cluster, &c);
        must_find(cluster, &c); // nothing moved
    }
    duet_cluster_destroy(cluster);
    duet_device_pair_destroy(def.world.pair);
}

// Any planes at all, or some of a lattice, the same on all ranks of the group.
static void deal_anew(duet_cluster *cluster, bool on_lattice, rng *r)
{
    partition *p = &cluster->partition;
    bisection *b = &p->parts;
    owned *o = &cluster->owned;
    for (uint32_t i = 1; i < b->n; ++i) {
        double at = rng_between(r, -8, 8);
        b->planes[i] = (bisection_plane){on_lattice ? rint(at) : at, rng_below(r, 3)};
    }
    MPI_Bcast(b->planes, (int)(b->n * sizeof *b->planes), MPI_BYTE, 0, cluster->ranks.comm);
    p->box = bisection_box(b, (uint32_t)duet_cluster_get_rank(cluster), &extent_all);
    owned_tidy(o);
    o->placement = PLACED_BY_RANK; // left like a rank that could not bring them to its domains
    owned_forget_domains(o);
    cluster->state = STATE_CHANGED;
}

// The owner of an object never changes a result: all owned objects change at random before each
// step.
static void objects_that_are_dealt_anew_change_nothing(uint64_t seed)
{
    static crowd c;
    rng r = rng_seed(seed + 1);
    make_crowd(&c, &r, 3);
    for (int g = 1; g < N_GROUPS; ++g) {
        duet_cluster *cluster = open_cluster(groups[g], &c.world, 1);
        if (!cluster)
            continue;
        uint64_t least = UINT64_MAX, most = 0;
        cluster->migration.imbalance = 1e9; // the cut stays as it is made here
        hand_over(cluster, &c, 0, 5);
        must_find(cluster, &c);
        for (int at = 0; at < 40; ++at) {
            const uint64_t *ids;
            uint32_t n;
            must(duet_cluster_map_owned(cluster, DUET_OBJECT_POSES, &ids, &n, ERR));
            least = n < least ? n : least;
            most = n > most ? n : most;
            deal_anew(cluster, false, &r);
            must_find(cluster, &c);
        }
        MUST(most > least + 50, "owned objects went to and fro");
        duet_cluster_destroy(cluster);
    }
}

// ---------------------------------------------------------------- radii on a lattice

enum { LATTICE = 4 }; // from 0 to its ends

static float some_place(rng *r)
{
    return (float)rng_below(r, 2 * LATTICE + 1) - LATTICE;
}

// Many are points, and a few are as wide as all of it. Coordinates that do not count in 2D are NaN.
static void put_on_lattice(crowd *c, uint32_t id, rng *r)
{
    static const float halves[] = {0, 0, 0.5f, 1}, radii[] = {0, 0.5f, 0.5f, 1, 1.5f};
    bool is_flat = c->world.dims == 2;
    duet_rounded_box *box = &c->rounded[id];
    *box = (duet_rounded_box){.pose.rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k) {
        box->pose.centre[k] = some_place(r);
        box->pose.half_extents[k] = halves[rng_below(r, 4)];
    }
    if (is_flat)
        box->pose.centre[2] = box->pose.half_extents[2] = box->pose.rotation[0] = NAN;
    box->radius = rng_below(r, 100) ? radii[rng_below(r, 5)] : LATTICE + 0.5f;
    memcpy(c->spheres[id].centre, box->pose.centre, sizeof box->pose.centre);
    c->spheres[id].radius = box->radius;
}

// Twice all numbers are integers.
static int64_t twice(float x)
{
    return (int64_t)(2 * x);
}

// The square of the cores' distance, less that of what both radii are together.
static int64_t distance_on_lattice(const crowd *c, uint32_t a, uint32_t b)
{
    bool spheres = c->world.shape == DUET_SHAPE_SPHERES;
    const duet_rounded_box *p = &c->rounded[a], *q = &c->rounded[b];
    int64_t square = 0, radii = twice(p->radius) + twice(q->radius);
    for (uint32_t k = 0; k < c->world.dims; ++k) {
        int64_t gap = llabs(twice(p->pose.centre[k]) - twice(q->pose.centre[k]));
        if (!spheres)
            gap -= twice(p->pose.half_extents[k]) + twice(q->pose.half_extents[k]);
        square += gap > 0 ? gap * gap : 0;
    }
    return square - radii * radii;
}

// Each with each, in integers. Returns how many touch, and no more.
static uint64_t find_on_lattice(crowd *c)
{
    uint64_t touching = 0;
    duet_free(c->pairs);
    c->pairs = malloc((size_t)c->n * c->n * sizeof *c->pairs);
    MUST(c->pairs, "memory");
    c->n_pairs = 0;
    for (uint32_t a = 0; a < c->n; ++a)
        for (uint32_t b = a + 1; b < c->n; ++b) {
            int64_t distance = distance_on_lattice(c, a, b);
            touching += distance == 0;
            if (distance <= 0)
                c->pairs[c->n_pairs++] = (duet_pair){a, b};
        }
    return touching;
}

// Wherever the cuts lie, also through centres and where spheres touch.
static void radii_that_touch_across_ranks_collide(uint64_t seed)
{
    static crowd c;
    rng r = rng_seed(seed + 2);
    c.n = MOST_OBJECTS;
    for (uint32_t i = 0; i < 4; ++i) {
        c.world = duet_default_world_def();
        c.world.dims = 2 + i % 2;
        c.world.shape = i < 2 ? DUET_SHAPE_SPHERES : DUET_SHAPE_ROUNDED_BOXES;
        snprintf(c.name, sizeof c.name, "lattice %u", i);
        for (uint32_t id = 0; id < c.n; ++id)
            put_on_lattice(&c, id, &r);
        for (int g = 0; g < N_GROUPS; ++g) {
            rng own = rng_seed(seed + i + (uint32_t)g);
            n_parts = 1 + (i + (uint32_t)g) % 3;
            duet_cluster *cluster = open_cluster(groups[g], &c.world, 1);
            n_parts = 1;
            if (cluster) {
                cluster->migration.imbalance = 1e9; // the cut stays as it is made here
                hand_over(cluster, &c, 0, i);
            }
            for (int at = 0; at < 3; ++at) {
                MUST(find_on_lattice(&c) > 100 && c.n_pairs > 400, "many touch");
                if (cluster)
                    must_find(cluster, &c);
                for (uint32_t id = 0; id < c.n; ++id)
                    if (rng_below(&r, 4) == 0)
                        put_on_lattice(&c, id, &r);
                if (!cluster)
                    continue;
                move_owned(cluster, &c);
                deal_anew(cluster, true, &own);
            }
            duet_cluster_destroy(cluster);
        }
    }
    free(c.pairs);
    c.pairs = NULL;
}

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

// A giant as wide as the world touches objects of all ranks; it travels and they do not.
static void only_giants_travel_far(void)
{
    static crowd c;
    rng r = rng_seed(8);
    make_crowd(&c, &r, 3);
    for (uint32_t i = 0; i < c.n; ++i)
        for (int k = 0; k < 3; ++k) {
            c.poses[i].half_extents[k] = i == 0 ? 200.0f : 1e-3f;
            c.poses[i].centre[k] = i == 0 ? 0.0f : (float)rng_between(&r, -100, 100);
        }
    find_expected(&c);
    duet_cluster *cluster = open_cluster(8, &c.world, 1);
    hand_over(cluster, &c, 0, 1);
    must_find(cluster, &c);
    MUST(c.n_pairs >= c.n - 1u, "the giant touches all");
    MUST(cluster->last.ghosts <= 3, "of the small ones hardly any is a ghost");
    duet_cluster_destroy(cluster);
}

// 64 bits: the hash of ids from 2^40 on is the same for any number of ranks.
static void large_ids_have_one_hash(void)
{
    static crowd c;
    const uint64_t first = (uint64_t)1 << 40;
    rng r = rng_seed(4);
    make_crowd(&c, &r, 3);
    uint64_t expected = 0;
    for (uint64_t i = 0; i < c.n_pairs; ++i)
        expected += pair64_hash((duet_pair64){first + c.pairs[i].a, first + c.pairs[i].b});
    MUST(expected != hash_of(&c), "other ids, another hash");
    for (int g = 0; g < N_GROUPS; ++g) {
        duet_cluster *cluster = open_cluster(groups[g], &c.world, 1);
        if (!cluster)
            continue;
        hand_over(cluster, &c, first, 3);
        duet_cluster_result result = step(cluster);
        MUST(result.pairs == c.n_pairs && result.hash == expected, "the hash of large ids");
        const duet_pair64 *own;
        uint64_t n;
        must(duet_cluster_get_own_pairs(cluster, &own, &n, ERR));
        MUST(n == cluster->last.pairs, "as many as were counted");
        for (uint64_t i = 0; i < n; ++i)
            MUST(own[i].a >= first && own[i].a < own[i].b, "global ids, a < b");
        duet_cluster_destroy(cluster);
    }
}

// ---------------------------------------------------------------- files

static void read_file(text *t, const char *path)
{
    must(text_read_file(t, path, ERR));
}

static void sorted_pairs_are_the_same_bytes(void)
{
    static crowd c;
    static const char path[] = "cluster_ranks.npy";
    text first = {0};
    rng r = rng_seed(9);
    make_crowd(&c, &r, 3);
    MUST(c.n_pairs > 100, "a file worth writing");
    for (int g = 0; g < N_GROUPS; ++g) {
        duet_cluster *cluster = open_cluster(groups[g], &c.world, 1);
        if (!cluster)
            continue;
        hand_over(cluster, &c, 0, 3);
        step(cluster);
        must(duet_cluster_save_pairs(cluster, path, false, ERR));
        text unsorted = {0}, now = {0};
        if (rank == 0)
            read_file(&unsorted, path);
        MPI_Barrier(cluster->ranks.comm);
        must(duet_cluster_save_pairs(cluster, path, true, ERR));
        if (rank == 0) {
            read_file(&now, path);
            MUST(unsorted.length == now.length, "as many pairs unsorted");
            if (g == 0)
                first = now;
            else
                MUST(now.length == first.length && memcmp(now.chars, first.chars, now.length) == 0,
                     "the bytes of one rank");
            const uint64_t *values = (const uint64_t *)(const void *)(now.chars + 128);
            MUST(now.length == 128 + 16 * c.n_pairs, "a header and the pairs");
            for (uint64_t i = 0; i < c.n_pairs; ++i)
                MUST(values[2 * i] == c.pairs[i].a && values[2 * i + 1] == c.pairs[i].b,
                     "the reference's pairs, ascending");
            if (g > 0)
                text_free(&now);
            remove(path);
        }
        text_free(&unsorted);
        duet_cluster_destroy(cluster);
    }
    text_free(&first);
}

// ---------------------------------------------------------------- failures

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
    wrong.world.compact_transforms = true; // else they would be taken for poses
    REFUSED(duet_cluster_create(&wrong, ERR));
    wrong.world.compact_transforms = false;
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

// ---------------------------------------------------------------- levels

static void levels_are_octaves_below_the_widest(void)
{
    MUST(level_of(8, 8) == SIZE_LEVELS - 1 && level_of(7.9, 8) == SIZE_LEVELS - 2,
         "the widest has its own");
    MUST(level_of(0, 8) == 0 && level_of(0, 0) == SIZE_LEVELS - 1, "points");
    MUST(level_of(1e-30, 8) == 0 && level_of(INFINITY, INFINITY) == SIZE_LEVELS - 1, "the ends");
    MUST(level_of(1, INFINITY) == 0, "below what has no end");
    rng r = rng_seed(3);
    for (int i = 0; i < 1000; ++i) {
        double a = exp2(rng_between(&r, -20, 3)), b = exp2(rng_between(&r, -20, 3));
        MUST(!(a < b) || level_of(a, 8) <= level_of(b, 8), "wider is no lower");
    }
}

// ---------------------------------------------------------------- places

// Halves without points too have boxes that hold what is theirs and nothing else.
static void a_part_is_its_box(void)
{
    rng r = rng_seed(14);
    for (int round = 0; round < 200; ++round) {
        uint32_t n = 1 + rng_below(&r, 9);
        uint64_t n_points = rng_below(&r, 20);
        bisection b;
        bisection_point points[20] = {{{0}, 0}}, copy[20];
        must(bisection_begin(&b, n, ERR));
        for (uint64_t i = 0; i < n_points; ++i) {
            points[i].weight = 1;
            for (int k = 0; k < 3; ++k)
                points[i].at[k] = rng_below(&r, 3);
        }
        memcpy(copy, points, sizeof copy);
        bisection_cut(&b, NULL, copy, n_points);
        for (uint64_t i = 0; i < n_points; ++i)
            for (uint32_t part = 0; part < n; ++part) {
                bool inside = true;
                extent box = bisection_box(&b, part, &extent_all);
                for (int k = 0; k < 3; ++k)
                    inside &= points[i].at[k] >= box.lower[k] && points[i].at[k] < box.upper[k];
                MUST(inside == (bisection_part(&b, points[i].at) == part), "its box");
            }
        bisection_end(&b);
    }
}

// Each object passed over is sound and lies inside, and none is wider than is said.
static void what_is_skimmed_is_deep_inside(void)
{
    static crowd c;
    rng r = rng_seed(15);
    const extent inside = {{-2.5, -2.25, -3}, {2.5, 3, 2.7}};
    uint32_t skimmed = 0;
    for (uint32_t i = 0; i < 12; ++i) {
        make_crowd(&c, &r, i < 8 ? i : SPHERES - 8 + i);
        object_form form = object_form_of(&c.world);
        if (form.origin == 0 && form.shape == DUET_SHAPE_POSES && c.n > 9)
            c.poses[7].rotation[1] = NAN;
        const object_rows rows = {.objects = (void *)(uintptr_t)objects_of(&c), .n = c.n};
        for (uint32_t first = 0, end; first < c.n; first = end + 1) {
            skim s = skim_none;
            end = object_rows_skim(&rows, &form, first, c.n, &inside, &s);
            MUST(end >= first && end <= c.n, "a row");
            for (uint32_t k = first; k < end; ++k, ++skimmed) {
                double at[3];
                extent e = extent_of(&form, object_row(&rows, &form, k));
                object_centre(&form, object_row(&rows, &form, k), at);
                MUST(object_is_sound(&form, object_row(&rows, &form, k)), "sound");
                for (int d = 0; d < 3; ++d)
                    MUST(at[d] > inside.lower[d] && at[d] < inside.upper[d] &&
                             at[d] >= s.centres.lower[d] && at[d] <= s.centres.upper[d],
                         "inside");
                MUST(extent_widest(&e) <= skim_widest(&s, &form), "no wider");
            }
        }
    }
    MUST(skimmed > 200, "some were");
}

// Rounds as the plain C reference does, which the devices do in the same way.
static duet_bounds bounds_in_float(const crowd *c, uint32_t id)
{
    duet_rounded_box box = rounded_of_sphere(&c->spheres[id]);
    return c->world.shape == DUET_SHAPE_POSES
               ? sat_bounds(&c->poses[id], c->world.dims, c->world.rotated)
               : sat_rounded_bounds(c->world.shape == DUET_SHAPE_SPHERES ? &box : &c->rounded[id],
                                    c->world.dims, c->world.rotated);
}

// Covers boxes that turn and those that do not, of all sizes, and of points at 0.
static void extents_hold_what_devices_take(void)
{
    static crowd c;
    static const uint32_t crowds[] = {0, 3, 6, SPHERES, SPHERES + 1, ROUNDED, ROUNDED + 1, 54};
    rng r = rng_seed(19);
    for (uint32_t i = 0; i < 16; ++i) {
        make_crowd(&c, &r, crowds[i / 2]);
        c.world.rotated = i % 2;
        object_form form = object_form_of(&c.world);
        for (uint32_t id = 0; id < c.n; ++id) {
            uint32_t numbers = c.world.shape == DUET_SHAPE_SPHERES ? 4 : 6;
            memset(row_of(&c, id), 0, id == 0 ? numbers * sizeof(float) : 0);
            extent e = extent_of(&form, row_of(&c, id));
            duet_bounds b = bounds_in_float(&c, id);
            for (uint32_t k = 0; k < c.world.dims; ++k)
                MUST(e.lower[k] <= (double)b.lower[k] && e.upper[k] >= (double)b.upper[k], c.name);
        }
    }
}

enum { ROWS_OF_TIDY = 64, DOMAINS_OF_TIDY = 7 };

// Whether each row is that of its id, and in one run, of the domain whose box holds it. Returns how
// many runs there are.
static uint64_t must_be_in_domains(owned *o, classes *c, uint64_t there)
{
    uint64_t seen = 0;
    uint32_t n = 0;
    must(classify(c, o) && owned_sort_runs(o, ERR));
    for (uint32_t i = 0; i < o->n_domains; ++i) {
        const domain *d = &o->domains[i];
        uint32_t n_before = n;
        for (uint64_t k = d->run; k < d->run + d->n_runs; ++k) {
            const row_run *run = &o->runs.runs[k];
            MUST(run->domain == i && run->at == n - n_before, "behind each other");
            n += run->n;
            for (uint32_t row = run->first; row < run->first + run->n; ++row) {
                double centre[3];
                const duet_bounds *at = object_row(&o->rows, &o->form, row);
                object_centre(&o->form, at, centre);
                MUST(bisection_part(&o->planes, centre) == i, "each lies in its domain");
                MUST(at->upper[1] == (float)o->rows.ids[row], "rows stay whole");
                seen |= UINT64_C(1) << o->rows.ids[row];
            }
        }
        MUST(d->n == n - n_before, "counted");
    }
    MUST(n == o->rows.n && seen == there, "all are there, once");
    return o->runs.n;
}

static duet_bounds some_bounds(uint64_t id, rng *r)
{
    float x = (float)rng_between(r, 0, 9);
    return (duet_bounds){.lower = {x, -1, -1}, .upper = {x, (float)id, 1}};
}

// Rows come to their domains, some of which are empty, and stay there as random ones leave and
// come.
static void rows_come_to_their_domains(void)
{
    static const extent all = {{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}};
    rng r = rng_seed(16);
    parallel team;
    duet_world_def def = duet_default_world_def();
    def.shape = DUET_SHAPE_BOUNDS;
    worker *w = must(worker_open_plain(&def, NULL, ERR)), *const workers[2] = {w, w};
    must(parallel_begin(&team, 3, 1, ERR));
    for (int round = 0; round < 300; ++round) {
        owned o;
        classes c = {0};
        object_rows rows;
        uint32_t n_domains = 2 + rng_below(&r, DOMAINS_OF_TIDY - 1);
        uint32_t n = rng_below(&r, ROWS_OF_TIDY / 2);
        uint64_t there = 0;
        must(owned_begin(&o, n_domains, n_domains, &team, ERR));
        o.form = (object_form){.dims = 3, .shape = DUET_SHAPE_BOUNDS, .bytes = sizeof(duet_bounds)};
        must(object_rows_begin(&rows, &o.form, n, ERR));
        for (uint32_t i = 0; i < n; ++i) {
            duet_bounds b = some_bounds(i, &r);
            rows.ids[i] = i;
            memcpy(object_row(&rows, &o.form, i), &b, sizeof b);
            there |= UINT64_C(1) << i;
        }
        owned_take(&o, &rows);
        must(owned_place(&o, &all, workers, ERR));
        MUST(must_be_in_domains(&o, &c, there) <= n_domains, "placed together");
        for (int step = 0; step < 9; ++step) {
            unsigned char messages[ROWS_OF_TIDY][sizeof(uint64_t) + sizeof(duet_bounds)];
            parcels in = {.rows = messages, .row_bytes = sizeof *messages};
            uint32_t few = rng_below(&r, 3) > 0 ? 9 : 1; // or all
            for (uint32_t row = 0; row < o.rows.n; ++row)
                if (rng_below(&r, few) == 0) {
                    row_list_add(&o.leavers, row);
                    there &= ~(UINT64_C(1) << o.rows.ids[row]);
                }
            uint64_t taken = there;
            for (uint64_t id = 0; id < ROWS_OF_TIDY; ++id)
                if (!(taken >> id & 1) && rng_below(&r, 9) == 0) {
                    duet_bounds b = some_bounds(id, &r);
                    object_write_message(&o.form, messages[in.n++], id, &b);
                    there |= UINT64_C(1) << id;
                }
            must(owned_add_newcomers(&o, &in, ERR));
            owned_tidy(&o);
            must_be_in_domains(&o, &c, there);
        }
        owned_end(&o);
        classes_end(&c);
    }
    w->close(w);
    parallel_end(&team);
}

static void count_call(void *context)
{
    ++*(uint32_t *)context;
}

static void count_things(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    (void)part;
    atomic_fetch_add((_Atomic uint64_t *)context, end - first);
}

// Begun, and waited for, before, between and after loops, by threads that look for work or sleep.
static void calls_are_made_beside_loops(void)
{
    enum { CALLS = 100, MANY = 1 << 13 };
    static const uint32_t n_threads[] = {1, 2, 5};
    for (uint32_t i = 0; i < sizeof n_threads / sizeof *n_threads; ++i) {
        parallel team;
        _Atomic uint64_t things = 0;
        uint32_t calls = 0, loops = 0;
        must(parallel_begin(&team, n_threads[i], 1, ERR));
        for (uint32_t k = 0; k < CALLS; ++k) {
            parallel_stay_awake(&team, k % 3 == 0);
            parallel_call_begin(&team, count_call, &calls);
            for (uint32_t loop = 0; loop < k % 4; ++loop, ++loops)
                parallel_each(&team, MANY, count_things, &things);
            parallel_call_end(&team);
            MUST(calls == k + 1, "each call is made once");
            MUST(things == (uint64_t)loops * MANY, "and loops whole");
        }
        parallel_end(&team);
    }
}

int main(int argc, char **argv)
{
    uint64_t seed = job_begin(&argc, &argv, 8, 20261122);
    levels_are_octaves_below_the_widest();
    a_part_is_its_box();
    what_is_skimmed_is_deep_inside();
    extents_hold_what_devices_take();
    rows_come_to_their_domains();
    if (rank == 0)
        calls_are_made_beside_loops();
    nothing_is_refused();
    on_ranks(2, arguments_that_are_missing_or_wrong_are_refused);
    on_ranks(2, worlds_that_are_wrong_are_refused);
    on_ranks(3, a_failure_is_that_of_all_ranks);
    an_id_that_two_ranks_bring_is_refused(seed);
    on_ranks(3, calls_in_another_order_are_refused);
    each_call_that_fails_gives_its_own_line();
    on_crowd(3, 11, 1, a_disk_that_is_full_is_told_of);
    random_crowds_have_the_same_pairs(seed);
    scenes_have_the_same_pairs();
    objects_that_move_have_the_references_pairs(seed);
    devices_that_count_have_the_references_pairs(seed, 1);
    devices_that_count_have_the_references_pairs(seed, 3);
    devices_find_the_pairs_of_parts_in_place(seed, 3, 2);
    devices_find_the_pairs_of_parts_in_place(seed, SPHERES, 5);
    objects_that_are_dealt_anew_change_nothing(seed);
    radii_that_touch_across_ranks_collide(seed);
    on_crowd(3, 17, 1, objects_go_on_after_one_rank_had_no_memory);
    n_parts = 5;
    on_crowd(2, 18, 1, a_search_that_fails_leaves_objects_as_they_were);
    n_parts = 1;
    on_crowd(4, 5, 1, a_cut_that_became_uneven_is_made_anew);
    on_crowd(1, 12, 1, grids_follow_objects_that_travel);
    parts_stay_while_they_are_even();
    ranks_get_objects_by_their_weights();
    on_crowd(3, 6, 0, ranks_are_weighed_by_their_stored_times);
    on_crowd(3, 6, 0, ranks_that_prove_slow_get_fewer_objects);
    on_ranks(2, each_rank_has_its_part_of_the_processors);
    on_ranks(2, a_cut_must_pay);
    only_giants_travel_far();
    large_ids_have_one_hash();
    sorted_pairs_are_the_same_bytes();
    return job_end("all facts hold on 1, 2, 3, 4 and 8 ranks");
}
