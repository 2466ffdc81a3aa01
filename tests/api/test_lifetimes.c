// SPDX-License-Identifier: MIT
// Owners are closed in any order. Each order of closing a device pair and what was made
// on it ends without a leak, and what is still open goes on as before.
#include "support/test.h"

#include "runtime/opencl/device.h"
#include "tuner/duet_tune.h"

typedef enum owner { PAIR, SCENE, WORLD, ONLINE, MOTION, TEST, OWNERS } owner;

typedef struct owners {
    duet_device_pair *pair;
    duet_scene *scene;
    duet_world *world;
    duet_online *online;
    duet_motion *motion;
    duet_pair_query *test;
} owners;

enum { N = 40 };

static duet_pose poses[2 * N];
static uint64_t right;           // hash of the pairs
static uint64_t right_colliding; // the test's own

static void open_world(owners *o)
{
    duet_world_def def = duet_scene_world_def(o->scene, o->pair);
    o->world = must(duet_world_create(&def, ERR));
    must(duet_world_set_scene(o->world, o->scene, ERR));
    duet_online_def online = duet_default_online_def();
    online.world = o->world;
    o->online = must(duet_online_create(&online, ERR));
}

static void open_motion(owners *o)
{
    duet_motion_def def = duet_scene_motion_def(o->scene, o->pair);
    def.wants = DUET_EFFECT_CONTACT;
    duet_body bodies[N];
    for (int i = 0; i < N; ++i)
        bodies[i] = duet_default_body();
    bodies[0].velocity[0] = 1.0f;
    o->motion = must(duet_motion_create_from_scene(&def, o->scene, bodies, ERR));
}

static void open_all(owners *o)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.cache_dir = "test_lifetimes.cache";
    o->pair = must(duet_device_pair_create(&def, ERR));
    o->scene = must(duet_scene_create(DUET_OBJECT_POSES, poses, N, 3, 0, ERR));
    open_world(o);
    open_motion(o);
    duet_pair_query_def test = duet_default_pair_query_def();
    test.pair = o->pair;
    test.share = DUET_SHARE_ONE / 2;
    o->test = must(duet_pair_query_create(&test, ERR));
}

static void close_one(owners *o, owner which)
{
    switch (which) {
    case PAIR:
        duet_device_pair_destroy(o->pair);
        break;
    case SCENE:
        duet_scene_destroy(o->scene);
        break;
    case WORLD:
        duet_world_destroy(o->world);
        o->world = NULL;
        break;
    case ONLINE:
        must(duet_online_destroy(o->online, ERR));
        o->online = NULL;
        break;
    case MOTION:
        duet_motion_destroy(o->motion);
        o->motion = NULL;
        break;
    default:
        duet_pair_query_destroy(o->test);
        o->test = NULL;
    }
}

// Each open object works.
static void use(owners *o)
{
    duet_result result;
    duet_motion_result moved;
    duet_pair_query_result tested;
    uint8_t answers[N];
    if (o->world) {
        must(duet_world_step(o->world, &result, ERR));
        assert_true(duet_result_get_hash(&result) == right);
    }
    if (o->online) {
        must(duet_online_step(o->online, &result, ERR));
        assert_true(duet_result_get_hash(&result) == right);
    }
    if (o->motion)
        must(duet_motion_advance(o->motion, &moved, ERR));
    if (o->test) {
        must(duet_pair_query_run(o->test, poses, N, answers, NULL, &tested, ERR));
        assert_true(tested.colliding == right_colliding);
    }
}

static void make_poses(void)
{
    duet_error err = {0};
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 2 * N; ++i) {
        poses[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0, 1}};
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 0, 3);
    }
    duet_scene *scene = duet_scene_create(DUET_OBJECT_POSES, poses, N, 3, 0, &err);
    duet_pair *pairs = NULL;
    uint64_t n = 0;
    must(scene && duet_reference(scene, DUET_LEVEL_CERTIFIED, &pairs, &n, ERR));
    right = duet_pairs_hash(pairs, n);
    assert_true(n > 0);
    duet_free(pairs);
    duet_scene_destroy(scene);
    for (int i = 0; i < N; ++i)
        right_colliding += duet_poses_collide(&poses[2 * i], &poses[2 * i + 1], 3);
}

static void close_in(const owner order[OWNERS], bool with_use)
{
    owners o;
    open_all(&o);
    for (int i = 0; i < OWNERS; ++i) {
        if (with_use)
            use(&o);
        close_one(&o, order[i]);
    }
    assert_int_equal(device_live_objects(), 0);
}

// The rest is used after each closing of each 60th order; with --all the others end, too.
static void visit(const owner order[OWNERS], int place)
{
    if (place % 60 == 7 || test_takes_all())
        close_in(order, place % 60 == 7);
}

// Calls visit for each of the 720 orders; place counts them.
static void for_orders(owner order[OWNERS], int from, int *place)
{
    if (from == OWNERS)
        visit(order, (*place)++);
    for (int i = from; i < OWNERS; ++i) {
        owner first = order[from];
        order[from] = order[i];
        order[i] = first;
        for_orders(order, from + 1, place);
        order[i] = order[from];
        order[from] = first;
    }
}

TEST(what_is_open_goes_on_in_any_order_of_closing)
{
    owner order[OWNERS] = {PAIR, SCENE, WORLD, ONLINE, MOTION, TEST};
    int n_orders = 0;
    close_in(order, true);
    for_orders(order, 0, &n_orders);
    assert_int_equal(n_orders, 720);
}

TEST_BEGIN(make_poses)
