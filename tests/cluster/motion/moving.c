// SPDX-License-Identifier: MIT
#include "cluster/motion/moving.h"

// FNV-1a of bytes.
static uint64_t add_bytes(uint64_t hash, const void *bytes, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        hash = (hash ^ ((const uint8_t *)bytes)[i]) * 0x100000001B3u;
    return hash;
}

static uint64_t begin_hash(uint64_t step, uint64_t kind, uint32_t a, uint32_t b)
{
    const uint64_t words[] = {step, kind, a, b};
    return add_bytes(0xCBF29CE484222325u, words, sizeof words);
}

static uint64_t hash_of_hit(uint64_t step, const duet_hit_event *h)
{
    uint64_t hash = begin_hash(step, 3, h->a, h->b);
    hash = add_bytes(hash, h->point, sizeof h->point);
    hash = add_bytes(hash, h->normal, sizeof h->normal);
    hash = add_bytes(hash, &h->speed, sizeof h->speed);
    return add_bytes(hash, &h->impulse, sizeof h->impulse);
}

// Both kinds of result have these lists.
#define ADD_TOLD(o, step, result)                                                                \
    add_lists(o, step, (result)->events, (result)->n_events, (result)->stays, (result)->n_stays, \
              (result)->hits, (result)->n_hits)

static void add_lists(outcome *o, uint64_t step, const duet_event *events, uint64_t n_events,
                      const duet_pair *stays, uint64_t n_stays, const duet_hit_event *hits,
                      uint64_t n_hits)
{
    for (uint64_t i = 0; i < n_events; ++i) {
        const duet_event *e = &events[i];
        MUST(i == 0 || e[-1].a < e->a || (e[-1].a == e->a && e[-1].b < e->b), "events ascend");
        o->told += begin_hash(step, e->begins, e->a, e->b);
    }
    for (uint64_t i = 0; i < n_stays; ++i)
        o->told += begin_hash(step, 2, stays[i].a, stays[i].b);
    for (uint64_t i = 0; i < n_hits; ++i)
        o->told += hash_of_hit(step, &hits[i]);
    o->events += n_events;
    o->stays += n_stays;
    o->hits += n_hits;
}

void add_told(outcome *o, uint64_t step, const duet_cluster_motion_result *result)
{
    ADD_TOLD(o, step, result);
}

void must_tell_alike(outcome all, const outcome *expected, duet_cluster *c, const char *what)
{
    ranks_sum(&c->ranks, &all.hash, sizeof all / sizeof(uint64_t));
    MUST(all.events == expected->events, what);
    MUST(all.stays == expected->stays, what);
    MUST(all.hits == expected->hits, what);
    MUST(all.told == expected->told, what);
}

// ---------------------------------------------------------------- one motion

static const char *path_of(const moving_scene *s)
{
    static char path[4096];
    if (!strstr(s->name, ".lua"))
        return s->name;
    snprintf(path, sizeof path, "%s/../cluster/motion/scenes/%s", getenv("DUET_TEST_DATA"),
             s->name);
    return path;
}

static uint32_t n_settings(const moving_scene *s)
{
    return !s->settings[0].name ? 0 : !s->settings[1].name ? 1 : 2;
}

static outcome one_motions_outcome(const moving_scene *s, const char *from)
{
    outcome o = {0};
    duet_motion_result result;
    duet_device_pair *pair = must(duet_device_pair_open(NULL, ERR));
    duet_scene *scene = must(duet_scene_load(path_of(s), s->settings, n_settings(s), ERR));
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    duet_motion *motion = must(duet_motion_create_from_scene(&def, scene, NULL, ERR));
    must(!from || duet_motion_load(motion, from, ERR));
    for (uint32_t i = from ? s->saved_at : 0; i < s->steps; ++i) {
        must(duet_motion_advance(motion, &result, ERR));
        ADD_TOLD(&o, i, &result);
    }
    must(duet_motion_get_hash(motion, &o.hash, ERR));
    duet_motion_destroy(motion);
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return o;
}

outcome expected_outcome(const moving_scene *s)
{
    outcome o = {0};
    if (rank == 0)
        o = one_motions_outcome(s, NULL);
    MPI_Bcast(&o, sizeof o, MPI_BYTE, 0, MPI_COMM_WORLD);
    return o;
}

uint64_t expected_hash(const moving_scene *s)
{
    return expected_outcome(s).hash;
}

uint64_t one_motions_hash(const moving_scene *s, const char *from)
{
    return one_motions_outcome(s, from).hash;
}

// ---------------------------------------------------------------- ranks

static void begin(duet_cluster *c, const moving_scene *s, const char *file)
{
    must(duet_cluster_begin_motion(c, path_of(s), s->settings, n_settings(s), file, ERR));
}

duet_cluster *begin_from(int n, uint32_t parts, uint32_t colours, const moving_scene *s,
                         const char *file)
{
    duet_cluster_def def = duet_default_cluster_def();
    def.parts = parts;
    if (colours > 0)
        snprintf(def.world.plan.variant_b, sizeof def.world.plan.variant_b,
                 "auto motion.colours=%u", colours);
    duet_cluster *c = cluster_of(n, def);
    if (c) {
        begin(c, s, file);
        c->moving->least_inner = 1;
    }
    return c;
}

duet_cluster *begin_on(int n, uint32_t parts, uint32_t colours, const moving_scene *s)
{
    return begin_from(n, parts, colours, s, NULL);
}

duet_cluster_motion_result advance(duet_cluster *c, uint32_t steps)
{
    duet_cluster_motion_result result = {0};
    for (uint32_t i = 0; i < steps; ++i)
        must(duet_cluster_advance(c, &result, ERR));
    return result;
}

uint64_t state_hash(duet_cluster *c)
{
    uint64_t hash = 0;
    must(duet_cluster_get_state_hash(c, &hash, ERR));
    return hash;
}

void save_and_resume(duet_cluster *cluster, const moving_scene *s)
{
    static const char file[] = "cluster_motion_at.ck";
    must(duet_cluster_save_motion(cluster, file, ERR));
    begin(cluster, s, file);
    MUST(duet_cluster_get_motion_step(cluster) == s->saved_at, "the step that was saved");
    if (rank == 0)
        remove(file);
}

duet_cluster *two_domains_after_steps(const char *n, uint32_t colours, uint32_t steps)
{
    const moving_scene s = {"falling", {{"n", n}}, .steps = 0};
    duet_cluster *cluster = begin_on(ALONE, 2, colours, &s);
    advance(cluster, steps);
    return cluster;
}

float *kept_bounds_of(const moving_domain *d)
{
    const size_t n = 6 * (size_t)d->bodies.n;
    float *bounds = must(malloc((n + 1) * sizeof *bounds));
    must(domain_make_bounds(d->motion, ERR));
    must(n == 0 || motion_fetch(d->motion, "fat_aabbs", BOXES, 0, bounds, n * sizeof *bounds, ERR));
    return bounds;
}

float *bounds_of(const moving_domain *d)
{
    domain_forget_bounds(d->motion);
    return kept_bounds_of(d);
}
