// SPDX-License-Identifier: MIT
#include "cluster/crowd.h"

#include "cluster/cluster.h"

#include <inttypes.h>

const int groups[N_GROUPS] = {1, 2, 3, 4, 8};

duet_object_kind kind_of(const crowd *c)
{
    object_form form = object_form_of(&c->world);
    return object_form_kind(&form);
}

const void *objects_of(const crowd *c)
{
    const void *const objects[] = {[DUET_OBJECT_POSES] = c->poses,
                                   [DUET_OBJECT_BOUNDS] = c->bounds,
                                   [DUET_OBJECT_LARGE_POSES] = c->large,
                                   [DUET_OBJECT_ROUNDED_BOXES] = c->rounded,
                                   [DUET_OBJECT_SPHERES] = c->spheres};
    return objects[kind_of(c)];
}

// It begins with its centre, unless it is of bounds.
float *row_of(const crowd *c, uint64_t id)
{
    object_form form = object_form_of(&c->world);
    return (float *)((uintptr_t)objects_of(c) + id * form.bytes);
}

uint64_t hash_of(const crowd *c)
{
    return duet_pairs_hash(c->pairs, c->n_pairs);
}

// By rank 0, for all of the job.
void find_expected(crowd *c)
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

void make_crowd(crowd *c, rng *r, uint32_t i)
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

uint32_t n_parts = 1;

duet_cluster *open_cluster(int n_ranks, const duet_world_def *world, double weight)
{
    duet_cluster_def def = duet_default_cluster_def();
    def.world = *world;
    def.plain = true;
    def.weight = weight;
    def.parts = n_parts;
    return cluster_of(n_ranks, def);
}

// Each object is some rank's to bring, at random: `salt` says whose.
void hand_over(duet_cluster *cluster, const crowd *c, uint64_t first_id, uint32_t salt)
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

duet_cluster_result step(duet_cluster *cluster)
{
    duet_cluster_result result;
    must(duet_cluster_step(cluster, &result, ERR));
    return result;
}

void must_find(duet_cluster *cluster, const crowd *c)
{
    duet_cluster_result result = step(cluster);
    if (result.pairs != c->n_pairs || result.hash != hash_of(c) || result.objects != c->n) {
        char why[200];
        snprintf(why, sizeof why, "%s, %d ranks: %" PRIu64 " pairs for %" PRIu64, c->name,
                 duet_cluster_get_rank_count(cluster), result.pairs, c->n_pairs);
        end_job("the pairs are the reference's", __FILE__, __LINE__, why);
    }
}

// Any planes at all, or some of a lattice, the same on all ranks of the group.
void deal_anew(duet_cluster *cluster, bool on_lattice, rng *r)
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

// ---------------------------------------------------------------- facts

// A fact about a cluster of n ranks, for poses in 3D.
void on_ranks(int n, void (*fact)(duet_cluster *c))
{
    duet_world_def world = duet_default_world_def();
    duet_cluster *c = open_cluster(n, &world, 1);
    if (c)
        fact(c);
    duet_cluster_destroy(c);
}

void on_crowd(int n, uint64_t seed, double weight, crowd_fact *fact)
{
    static crowd c;
    rng r = rng_seed(seed);
    make_crowd(&c, &r, 3);
    duet_cluster *cluster = open_cluster(n, &c.world, weight);
    if (cluster)
        fact(cluster, &c, &r);
    duet_cluster_destroy(cluster);
}
