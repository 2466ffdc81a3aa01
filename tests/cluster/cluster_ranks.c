// SPDX-License-Identifier: MIT
// What must hold for any number of ranks, in one job: its ranks are cut into smaller groups,
// each a cluster of its own, and what these find is compared with the plain C reference.
//
// Every rank runs this; a fact that does not hold on one ends the job with a line.
#include "cluster/cluster.h"
#include "cluster/crowd.h"

#include "base/text_file.h"
#include "runtime/opencl/device_pair.h"

#include <inttypes.h>
#include <math.h>

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

int main(int argc, char **argv)
{
    uint64_t seed = job_begin(&argc, &argv, 8, 20261122);
    random_crowds_have_the_same_pairs(seed);
    scenes_have_the_same_pairs();
    objects_that_move_have_the_references_pairs(seed);
    devices_that_count_have_the_references_pairs(seed, 1);
    devices_that_count_have_the_references_pairs(seed, 3);
    devices_find_the_pairs_of_parts_in_place(seed, 3, 2);
    devices_find_the_pairs_of_parts_in_place(seed, SPHERES, 5);
    objects_that_are_dealt_anew_change_nothing(seed);
    radii_that_touch_across_ranks_collide(seed);
    only_giants_travel_far();
    large_ids_have_one_hash();
    sorted_pairs_are_the_same_bytes();
    return job_end("all facts hold on 1, 2, 3, 4 and 8 ranks");
}
