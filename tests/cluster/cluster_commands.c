// SPDX-License-Identifier: MIT
// Random commands to a motion over any number of ranks: the states, events and refusals of one
// motion that is given the same, with saves and loads between them.
//
// Every rank runs this; a fact that does not hold on one ends the job with a line.
#include "cluster/cluster.h"
#include "cluster/job.h"
#include "support/orders.h"

#include "base/text.h"

#include <inttypes.h>

#define SCENE "cluster_commands.lua"
#define PART "cluster_commands.ck"

enum { BODIES = 60, STEPS = 30, MOST_AT_ONCE = 8 };

static uint64_t add_bytes(uint64_t hash, const void *bytes, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        hash = (hash ^ ((const uint8_t *)bytes)[i]) * 0x100000001B3u;
    return hash;
}

static uint64_t hash_of(const void *bytes, size_t n)
{
    return add_bytes(0xCBF29CE484222325u, bytes, n);
}

// ---------------------------------------------------------------- worlds

// The head and the def of a scene, and which commands it takes.
typedef struct world {
    const char *name, *def;
    double at[3]; // it lies there
    bool sleeps;
} world;

static const world worlds[] = {
    {"a walled pile",
     "boundary = 'walls', world = { lower = { 0, 0, 0 }, upper = { 6, 6, 30 } },\n"
     "event_mask = 3, hit_speed = 0.5,\n"
     "wants = { 'contact_response', 'forces', 'sleep', 'filter', 'sensors', 'events',\n"
     "          'angular_velocity', 'friction' }, sleep_after = 0.1,\n",
     {0},
     true},
    {"origin cells",
     "origin = 'cell', origin_edge = 4,\n"
     "wants = { 'contact_response', 'forces', 'sleep', 'filter', 'sensors', 'events',\n"
     "          'angular_velocity', 'friction' }, sleep_after = 0.1,\n",
     {1e7, -2e7, 0},
     true},
    {"touches",
     "wants = { 'forces', 'filter', 'sensors', 'events', 'angular_velocity' },\n",
     {0},
     false},
    {"free flight", "wants = { 'forces' },\n", {0}, false},
};

static void write_scene(const world *w)
{
    text scene = {0};
    text_add(
        &scene,
        "local x0, y0, n = %.17g, %.17g, 0\n"
        "for i = 0, %d do\n"
        "  local x, y, z = i %% 5, i // 5 %% 4, i // 20\n"
        "  add { centre = { x0 + 1.1 * x + 0.5, y0 + 1.3 * y + 0.5, 0.6 + 1.1 * z },\n"
        "        half_extents = { 0.4, 0.3 + 0.02 * x, 0.3 }, velocity = { 0.1 * y, 0, 0.2 },\n"
        "        group = 1 << i %% 3, mass = i %% 9 == 4 and 0 or 1 }\n"
        "end\n"
        "return { dims = 3, gravity = { 0, 0, -9.81 }, %s\n"
        "         body = { friction = 0.5, restitution = 0.1 } }\n",
        w->at[0], w->at[1], BODIES - 1, w->def);
    job_write(SCENE, scene.chars);
    text_free(&scene);
}

// ---------------------------------------------------------------- who is commanded

// One motion, or a cluster's, in which only rank 0 has arguments.
typedef struct target {
    duet_motion *motion;
    duet_cluster *cluster;
} target;

#define CALL(name, ...)                                     \
    (t->motion ? duet_motion_##name(t->motion, __VA_ARGS__) \
               : duet_cluster_##name(t->cluster, __VA_ARGS__))
#define TARGET const target *t
#define DEF (t->motion ? duet_motion_get_def(t->motion) : duet_cluster_get_motion_def(t->cluster))
#define GIVEN(rows) (rank == 0 ? (rows) : NULL)
#include "support/obey.inl"

// ---------------------------------------------------------------- a play

// Results of each step, with all that was said since the last one.
typedef struct scene_step {
    uint64_t state, refusals, told, user_data;
} scene_step;

typedef struct play {
    const world *world;
    target target;
    orders orders; // the same for all targets, as are ids
    uint32_t n_done, n_refused;
    scene_step steps[STEPS];
} play;

// Lines of ranks begin with the rank, and calls have other names.
static void note_refusal(play *p, scene_step *s, const duet_error *err)
{
    const char *says = strstr(err->text, "body ");
    MUST(says && !strchr(err->text, '\n'), err->text);
    s->refusals = add_bytes(s->refusals, says, strlen(says));
    s->refusals = add_bytes(s->refusals, &err->status, sizeof err->status);
    ++p->n_refused;
}

static void command_once(play *p, scene_step *s)
{
    const verb what = orders_verb(&p->orders);
    const uint32_t n = p->orders.known.n;
    uint64_t came[MOST_AT_ONCE] = {0};
    duet_error err = {0};
    const order o = orders_draw(&p->orders, what);
    if ((what == ADD && n > BODIES + 20) || (what == REMOVE && n < BODIES - 20))
        return;
    if (!obey(&p->target, what, &o, came, &err)) {
        note_refusal(p, s, &err);
        return;
    }
    ++p->n_done;
    if (what == REMOVE)
        orders_removed(&p->orders, &o);
    if (what == ADD)
        orders_added(&p->orders, &o, came);
}

// An id of a body that was removed, or of none, behind one that is right.
static void command_in_vain(play *p, scene_step *s)
{
    duet_error err = {0};
    verb what = orders_verb(&p->orders);
    order o = orders_draw(&p->orders, SET);
    bool is_stale = p->orders.known.n_stale > 0 && rng_below(&p->orders.r, 2);
    o.n = 2;
    o.ids[1] = is_stale ? orders_stale_id(&p->orders) : 100000 + rng_below(&p->orders.r, 100);
    if (what == ADD || what == CHANGE)
        what = REMOVE;
    MUST(!obey(&p->target, what, &o, NULL, &err), "a wrong id is refused");
    MUST(err.status == DUET_STATUS_BAD_ARGUMENT, err.text);
    note_refusal(p, s, &err);
}

static void read_user_data(play *p, scene_step *s)
{
    uint64_t data[MOST_AT_ONCE] = {0};
    const target *t = &p->target;
    const duet_body_list list = {.ids = p->orders.known.ids, .n = MOST_AT_ONCE};
    must(CALL(get_user_data, list, data, ERR));
    s->user_data = hash_of(data, sizeof data);
}

// ---------------------------------------------------------------- steps

static void add_told(scene_step *s, const duet_event *events, uint64_t n_events,
                     const duet_pair *stays, uint64_t n_stays, const duet_hit_event *hits,
                     uint64_t n_hits)
{
    for (uint64_t i = 0; i < n_events; ++i) {
        const uint64_t words[] = {events[i].begins, events[i].a, events[i].b};
        s->told += hash_of(words, sizeof words);
    }
    for (uint64_t i = 0; i < n_stays; ++i)
        s->told += hash_of(&stays[i], sizeof stays[i]);
    for (uint64_t i = 0; i < n_hits; ++i)
        s->told += hash_of(&hits[i].point, sizeof hits[i].point) + hits[i].a + 7 * hits[i].b;
}

static void advance(play *p, scene_step *s)
{
    if (p->target.motion) {
        duet_motion_result r;
        must(duet_motion_advance(p->target.motion, &r, ERR));
        add_told(s, r.events, r.n_events, r.stays, r.n_stays, r.hits, r.n_hits);
        must(duet_motion_get_hash(p->target.motion, &s->state, ERR));
    } else {
        duet_cluster_motion_result r;
        must(duet_cluster_advance(p->target.cluster, &r, ERR));
        add_told(s, r.events, r.n_events, r.stays, r.n_stays, r.hits, r.n_hits);
        ranks_sum(&p->target.cluster->ranks, &s->told, 1);
        must(duet_cluster_get_state_hash(p->target.cluster, &s->state, ERR));
    }
}

// Goes on from a file that has commands which no step has seen.
static void save_and_load(play *p)
{
    if (p->target.motion) {
        must(duet_motion_save(p->target.motion, PART, ERR));
        must(duet_motion_load(p->target.motion, PART, ERR));
        return;
    }
    must(duet_cluster_save_motion(p->target.cluster, PART, ERR));
    if (rng_below(&p->orders.r, 2))
        must(duet_cluster_begin_motion(p->target.cluster, SCENE, NULL, 0, PART, ERR));
}

static void play_all(play *p)
{
    for (int step = 0; step < STEPS; ++step) {
        scene_step *s = &p->steps[step];
        for (uint32_t n = rng_below(&p->orders.r, 5); n > 0; --n)
            command_once(p, s);
        command_in_vain(p, s);
        rng before = p->orders.r;
        if (step % 7 == 3)
            save_and_load(p);
        p->orders.r = before;
        for (uint32_t n = rng_below(&p->orders.r, 2); n > 0; --n)
            command_once(p, s);
        read_user_data(p, s);
        advance(p, s);
    }
}

// ---------------------------------------------------------------- on ranks

static play begin_play(const world *w, uint64_t seed)
{
    play p = {.world = w,
              .orders = {.r = rng_seed(seed),
                         .at = {w->at[0], w->at[1]},
                         .size = 6,
                         .turns = w->sleeps,
                         .touches = w->sleeps,
                         .most = MOST_AT_ONCE,
                         .fields = DUET_BODY_FILTER << 1,
                         .known.n = BODIES}};
    for (uint32_t i = 0; i < BODIES; ++i)
        p.orders.known.ids[i] = i;
    return p;
}

// The truth, which rank 0 finds.
static play play_on_one(const world *w, uint64_t seed)
{
    play p = begin_play(w, seed);
    if (rank == 0) {
        duet_device_pair *pair = must(duet_device_pair_open(NULL, ERR));
        duet_scene *scene = must(duet_scene_load(SCENE, NULL, 0, ERR));
        duet_motion_def def = duet_scene_motion_def(scene, pair);
        p.target.motion = must(duet_motion_create_from_scene(&def, scene, NULL, ERR));
        play_all(&p);
        duet_motion_destroy(p.target.motion);
        duet_scene_destroy(scene);
        duet_device_pair_destroy(pair);
    }
    MPI_Bcast(&p.steps, sizeof p.steps, MPI_BYTE, 0, MPI_COMM_WORLD);
    return p;
}

static void must_be(const play *p, const play *truth, int n_ranks, uint32_t parts)
{
    char what[200];
    for (int step = 0; step < STEPS; ++step) {
        const scene_step *a = &p->steps[step], *b = &truth->steps[step];
        snprintf(what, sizeof what, "%s on %d ranks of %u, step %d", p->world->name, n_ranks, parts,
                 step);
        MUST(a->refusals == b->refusals, what);
        MUST(a->user_data == b->user_data, what);
        MUST(a->state == b->state, what);
        MUST(a->told == b->told, what);
    }
}

static void play_on(const world *w, const play *truth, uint64_t seed, int n_ranks, uint32_t parts)
{
    duet_cluster_def def = duet_default_cluster_def();
    def.parts = parts;
    play p = begin_play(w, seed);
    p.target.cluster = cluster_of(n_ranks, def);
    if (!p.target.cluster)
        return;
    must(duet_cluster_begin_motion(p.target.cluster, SCENE, NULL, 0, NULL, ERR));
    play_all(&p);
    must_be(&p, truth, n_ranks, parts);
    duet_cluster_destroy(p.target.cluster);
}

FACT(commands_have_one_motions_bits)
{
    static const int shapes[][2] = {{1, 1}, {1, 3}, {2, 1}, {3, 2}, {4, 1}, {5, 1}};
    const size_t n_shapes = sizeof shapes / sizeof *shapes;
    for (size_t i = 0; i < sizeof worlds / sizeof *worlds; ++i) {
        write_scene(&worlds[i]);
        const play truth = play_on_one(&worlds[i], job_seed + i);
        MUST(rank != 0 || (truth.n_done > STEPS && truth.n_refused >= STEPS &&
                           truth.orders.known.n_stale > 0),
             "much is done, and some refused");
        for (size_t k = i > 0; k<n_shapes; k += i> 0 ? 2 : 1)
            play_on(&worlds[i], &truth, job_seed + i, shapes[k][0], (uint32_t)shapes[k][1]);
    }
    job_remove(SCENE);
    job_remove(PART);
}

JOB_MAIN(5, 20261128, "all facts hold on 1, 2, 3, 4 and 5 ranks")
