// SPDX-License-Identifier: MIT
// Random commands to a motion over any number of ranks: the states, events and refusals of one
// motion that is given the same, with saves and loads between them.
//
// Every rank runs this; a fact that does not hold on one ends the job with a line.
#include "cluster/cluster.h"
#include "cluster/must.h"

#include "base/rng.h"
#include "base/text.h"
#include "base/text_file.h"

#include <inttypes.h>
#include <string.h>

#define SCENE "cluster_commands.lua"
#define PART "cluster_commands.ck"

enum { BODIES = 60, STEPS = 30, MOST_IDS = 1024, MOST_AT_ONCE = 8, MOST_STEPS = 64 };

// The first n ranks of the job; MPI_COMM_NULL on the others.
static MPI_Comm group_of(int n)
{
    MPI_Comm comm;
    MPI_Comm_split(MPI_COMM_WORLD, rank < n ? 0 : MPI_UNDEFINED, rank, &comm);
    return comm;
}

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
    double at[3]; // where it lies
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
    duet_error err = {0};
    text scene = {0};
    if (rank == 0) {
        text_add(&scene,
                 "local x0, y0, n = %.17g, %.17g, 0\n"
                 "for i = 0, %d do\n"
                 "  local x, y, z = i %% 5, i // 5 %% 4, i // 20\n"
                 "  add { centre = { x0 + 1.1 * x + 0.5, y0 + 1.3 * y + 0.5, 0.6 + 1.1 * z },\n"
                 "        half_extents = { 0.4, 0.3 + 0.02 * x, 0.3 }, velocity = { 0.1 * y, 0, "
                 "0.2 },\n"
                 "        group = 1 << i %% 3, mass = i %% 9 == 4 and 0 or 1 }\n"
                 "end\n"
                 "return { dims = 3, gravity = { 0, 0, -9.81 }, %s\n"
                 "         body = { friction = 0.5, restitution = 0.1 } }\n",
                 w->at[0], w->at[1], BODIES - 1, w->def);
        MUST_OK(text_write_file(SCENE, scene.chars, scene.length, &err), err);
        text_free(&scene);
    }
    MPI_Barrier(MPI_COMM_WORLD);
}

// ---------------------------------------------------------------- who is commanded

// One motion, or a cluster's, in which only rank 0 has arguments.
typedef struct target {
    duet_motion *motion;
    duet_cluster *cluster;
} target;

typedef enum verb {
    ADD,
    REMOVE,
    SET,
    SET_POSES,
    FORCE,
    IMPULSE,
    AIM,
    DISABLE,
    ENABLE,
    PUT_TO_SLEEP,
    WAKE,
    NAME,
    CHANGE,
    VERBS
} verb;

// The arguments of one command.
typedef struct order {
    uint32_t n;
    uint64_t ids[MOST_AT_ONCE], data[MOST_AT_ONCE];
    duet_pose poses[MOST_AT_ONCE];
    duet_body bodies[MOST_AT_ONCE];
    duet_force forces[MOST_AT_ONCE];
    duet_impulse impulses[MOST_AT_ONCE];
    duet_transform targets[MOST_AT_ONCE];
    uint32_t fields;
    double gravity[3];
} order;

#define CALL(name, ...)                                     \
    (t->motion ? duet_motion_##name(t->motion, __VA_ARGS__) \
               : duet_cluster_##name(t->cluster, __VA_ARGS__))
#define GIVEN(rows) (rank == 0 ? (rows) : NULL)

static bool change(const target *t, const order *o, duet_error *err)
{
    duet_motion_def def =
        *(t->motion ? duet_motion_get_def(t->motion) : duet_cluster_get_motion_def(t->cluster));
    memcpy(def.gravity, o->gravity, sizeof def.gravity);
    return CALL(set_def, GIVEN(&def), err);
}

static bool obey(const target *t, verb what, const order *o, uint64_t *came, duet_error *err)
{
    const uint32_t n = rank == 0 ? o->n : 0, fields = rank == 0 ? o->fields : 0;
    const duet_body_list list = {.ids = GIVEN(o->ids), .n = n};
    switch (what) {
    case ADD:
        return CALL(add_bodies, GIVEN(o->poses), GIVEN(o->bodies), o->n, came, err);
    case REMOVE:
        return CALL(remove_bodies, list, err);
    case SET:
        return CALL(set_bodies, list, fields, GIVEN(o->bodies), err);
    case SET_POSES:
        return CALL(set_poses, list, GIVEN(o->poses), err);
    case FORCE:
        return CALL(apply_forces, list, GIVEN(o->forces), err);
    case IMPULSE:
        return CALL(apply_impulses, list, GIVEN(o->impulses), err);
    case AIM:
        return CALL(set_targets, list, GIVEN(o->targets), err);
    case DISABLE:
        return CALL(disable_bodies, list, err);
    case ENABLE:
        return CALL(enable_bodies, list, err);
    case PUT_TO_SLEEP:
        return CALL(sleep_bodies, list, err);
    case WAKE:
        return CALL(wake_bodies, list, err);
    case NAME:
        return CALL(set_user_data, list, GIVEN(o->data), err);
    default:
        return change(t, o, err);
    }
}

// ---------------------------------------------------------------- a play

// Results of each step, with all that was said since the last one.
typedef struct scene_step {
    uint64_t state, refusals, told, user_data;
} scene_step;

typedef struct play {
    const world *world;
    target target;
    rng r; // the same for all targets, as are ids
    uint64_t ids[MOST_IDS], stale[MOST_IDS];
    uint32_t n_ids, n_stale, n_done, n_refused;
    scene_step steps[MOST_STEPS];
} play;

static float between(play *p, double from, double to)
{
    return (float)rng_between(&p->r, from, to);
}

// Anywhere, so that bodies change domains.
static duet_pose random_pose(play *p)
{
    duet_pose pose = {.rotation = {between(p, -1, 1), between(p, -1, 1), between(p, -1, 1), 1}};
    for (int k = 0; k < 3; ++k) {
        pose.centre[k] = (float)p->world->at[k] + between(p, 0.5, k == 2 ? 6 : 5.5);
        pose.half_extents[k] = between(p, 0.1, 0.4);
    }
    return pose;
}

static duet_body random_body(play *p)
{
    duet_body b = duet_default_body();
    for (int k = 0; k < 3; ++k) {
        b.velocity[k] = between(p, -3, 3);
        b.angular_velocity[k] = p->world->sleeps ? between(p, -3, 3) : 0;
    }
    b.mass = rng_below(&p->r, 5) ? between(p, 0.5, 3) : 0;
    if (b.mass == 0 && rng_below(&p->r, 2))
        memset(b.velocity, 0, sizeof b.velocity);
    if (!p->world->sleeps)
        return b;
    b.sensor = rng_below(&p->r, 10) == 0;
    b.friction = between(p, 0, 1);
    b.restitution = between(p, 0, 0.5);
    b.group = 1u << rng_below(&p->r, 3);
    return b;
}

static order random_order(play *p)
{
    order o = {.n = 1 + rng_below(&p->r, MOST_AT_ONCE),
               .fields = rng_below(&p->r, DUET_BODY_FILTER << 1),
               .gravity = {between(p, -2, 2), between(p, -2, 2), between(p, -10, 0)}};
    uint32_t at = rng_below(&p->r, p->n_ids);
    for (uint32_t i = 0; i < o.n; ++i) {
        o.ids[i] = p->ids[(at + 7 * i) % p->n_ids];
        o.data[i] = rng_next(&p->r);
        o.poses[i] = random_pose(p);
        o.bodies[i] = random_body(p);
        for (int k = 0; k < 3; ++k) {
            o.forces[i].force[k] = between(p, -30, 30);
            o.forces[i].torque[k] = p->world->sleeps ? between(p, -3, 3) : 0;
            o.impulses[i].impulse[k] = between(p, -2, 2);
            o.impulses[i].anchor[k] = between(p, -0.3, 0.3);
            o.targets[i].centre[k] = o.poses[i].centre[k];
        }
        memcpy(o.targets[i].rotation, o.poses[i].rotation, sizeof o.targets[i].rotation);
    }
    return o;
}

static void forget_ids(play *p, const order *o)
{
    for (uint32_t i = 0; i < o->n; ++i) {
        uint32_t at = 0;
        while (p->ids[at] != o->ids[i])
            ++at;
        p->ids[at] = p->ids[--p->n_ids];
        p->stale[p->n_stale++ % MOST_IDS] = o->ids[i];
    }
}

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
    const verb what = (verb)rng_below(&p->r, VERBS);
    uint64_t came[MOST_AT_ONCE] = {0};
    duet_error err = {0};
    order o = random_order(p);
    if (what == AIM)
        o.n = 1;
    if ((what == ADD && p->n_ids > BODIES + 20) || (what == REMOVE && p->n_ids < BODIES - 20) ||
        (!p->world->sleeps && (what == WAKE || what == PUT_TO_SLEEP)))
        return;
    if (!obey(&p->target, what, &o, came, &err)) {
        note_refusal(p, s, &err);
        return;
    }
    ++p->n_done;
    if (what == REMOVE)
        forget_ids(p, &o);
    for (uint32_t i = 0; what == ADD && i < o.n; ++i)
        p->ids[p->n_ids++] = came[i];
}

// An id of a body that was removed, or of none, behind one that is right.
static void command_in_vain(play *p, scene_step *s)
{
    duet_error err = {0};
    order o = random_order(p);
    o.n = 2;
    o.ids[1] = p->n_stale > 0 && rng_below(&p->r, 2)
                   ? p->stale[rng_below(&p->r, p->n_stale < MOST_IDS ? p->n_stale : MOST_IDS)]
                   : 100000 + rng_below(&p->r, 100);
    verb what = (verb)rng_below(&p->r, VERBS);
    if (what == ADD || what == CHANGE ||
        (!p->world->sleeps && (what == WAKE || what == PUT_TO_SLEEP)))
        what = REMOVE;
    MUST(!obey(&p->target, what, &o, NULL, &err), "a wrong id is refused");
    MUST(err.status == DUET_STATUS_BAD_ARGUMENT, err.text);
    note_refusal(p, s, &err);
}

static void read_user_data(play *p, scene_step *s)
{
    uint64_t data[MOST_AT_ONCE] = {0};
    const target *t = &p->target;
    duet_error err = {0};
    const duet_body_list list = {.ids = p->ids, .n = MOST_AT_ONCE};
    MUST_OK(CALL(get_user_data, list, data, &err), err);
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
    duet_error err = {0};
    if (p->target.motion) {
        duet_motion_result r;
        MUST_OK(duet_motion_advance(p->target.motion, &r, &err), err);
        add_told(s, r.events, r.n_events, r.stays, r.n_stays, r.hits, r.n_hits);
        MUST_OK(duet_motion_get_hash(p->target.motion, &s->state, &err), err);
    } else {
        duet_cluster_motion_result r;
        MUST_OK(duet_cluster_advance(p->target.cluster, &r, &err), err);
        add_told(s, r.events, r.n_events, r.stays, r.n_stays, r.hits, r.n_hits);
        ranks_sum(&p->target.cluster->ranks, &s->told, 1);
        MUST_OK(duet_cluster_get_state_hash(p->target.cluster, &s->state, &err), err);
    }
}

// Goes on from a file that has commands which no step has seen.
static void save_and_load(play *p)
{
    duet_error err = {0};
    if (p->target.motion) {
        MUST_OK(duet_motion_save(p->target.motion, PART, &err), err);
        MUST_OK(duet_motion_load(p->target.motion, PART, &err), err);
        return;
    }
    MUST_OK(duet_cluster_save_motion(p->target.cluster, PART, &err), err);
    if (rng_below(&p->r, 2))
        MUST_OK(duet_cluster_begin_motion(p->target.cluster, SCENE, NULL, 0, PART, &err), err);
}

static void play_all(play *p)
{
    p->n_ids = BODIES;
    for (uint32_t i = 0; i < BODIES; ++i)
        p->ids[i] = i;
    for (int step = 0; step < STEPS; ++step) {
        scene_step *s = &p->steps[step];
        for (uint32_t n = rng_below(&p->r, 5); n > 0; --n)
            command_once(p, s);
        command_in_vain(p, s);
        rng before = p->r;
        if (step % 7 == 3)
            save_and_load(p);
        p->r = before;
        for (uint32_t n = rng_below(&p->r, 2); n > 0; --n)
            command_once(p, s);
        read_user_data(p, s);
        advance(p, s);
    }
}

// ---------------------------------------------------------------- on ranks

// The truth, which rank 0 finds.
static play play_on_one(const world *w, uint64_t seed)
{
    play p = {.world = w, .r = rng_seed(seed)};
    if (rank == 0) {
        duet_error err = {0};
        duet_device_pair_def pair_def = duet_default_device_pair_def();
        duet_device_pair *pair = duet_device_pair_create(&pair_def, &err);
        MUST_OK(pair, err);
        duet_scene *scene = duet_scene_load(SCENE, NULL, 0, &err);
        MUST_OK(scene, err);
        duet_motion_def def = duet_scene_motion_def(scene, pair);
        p.target.motion = duet_motion_create_from_scene(&def, scene, NULL, &err);
        MUST_OK(p.target.motion, err);
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
    MPI_Comm comm = group_of(n_ranks);
    if (comm == MPI_COMM_NULL)
        return;
    play p = {.world = w, .r = rng_seed(seed)};
    duet_error err = {0};
    duet_cluster_def def = duet_default_cluster_def();
    def.comm = &comm;
    def.parts = parts;
    p.target.cluster = duet_cluster_create(&def, &err);
    MUST_OK(p.target.cluster, err);
    MUST_OK(duet_cluster_begin_motion(p.target.cluster, SCENE, NULL, 0, NULL, &err), err);
    play_all(&p);
    must_be(&p, truth, n_ranks, parts);
    duet_cluster_destroy(p.target.cluster);
    MPI_Comm_free(&comm);
}

static void commands_have_one_motions_bits(uint64_t seed)
{
    static const int shapes[][2] = {{1, 1}, {1, 3}, {2, 1}, {3, 2}, {4, 1}, {5, 1}};
    const size_t n_shapes = sizeof shapes / sizeof *shapes;
    for (size_t i = 0; i < sizeof worlds / sizeof *worlds; ++i) {
        write_scene(&worlds[i]);
        const play truth = play_on_one(&worlds[i], seed + i);
        MUST(rank != 0 || (truth.n_done > STEPS && truth.n_refused >= STEPS && truth.n_stale > 0),
             "much is done, and some refused");
        for (size_t k = i > 0; k<n_shapes; k += i> 0 ? 2 : 1)
            play_on(&worlds[i], &truth, seed + i, shapes[k][0], (uint32_t)shapes[k][1]);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank == 0) {
        remove(SCENE);
        remove(PART);
    }
}

int main(int argc, char **argv)
{
    const char *given = getenv("DUET_TEST_SEED");
    uint64_t seed = given ? strtoull(given, NULL, 10) : 20261128;
    IGNORE_LEAKS(MPI_Init(&argc, &argv));
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    int n = 0;
    MPI_Comm_size(MPI_COMM_WORLD, &n);
    MUST(n == 5, "run by mpirun -np 5");
    if (rank == 0)
        printf("DUET_TEST_SEED=%" PRIu64 "\n", seed);
    commands_have_one_motions_bits(seed);
    if (rank == 0)
        printf("all facts hold on 1, 2, 3, 4 and 5 ranks\n");
    FIND_LEAKS(); // before MPI ends, which forgets some memory of its own
    MPI_Finalize();
    return 0;
}
