// SPDX-License-Identifier: MIT
// Devices that go away in the middle: of every kind of step, and of a motion from its
// making to its file, each call to OpenCL in turn is the first that fails, for ever or
// once, of both devices or of one. None of it crashes, hangs, leaks or gives wrong
// pairs; each failure is one line, and no device is left with commands. --points N takes
// so many calls of each kind of life and way to fail, evenly; 0 takes all.
#define _POSIX_C_SOURCE 200809L
#include "lost/lost.h"
#include "support/test.h"

#include "runtime/broadphase/world.h"

#include <time.h>

enum { N = 3000, MOVING = 12, STEPS = 3 };

static duet_device_pair *pair;
static duet_pose even[N], mixed[N]; // scenes of one size, of many
static const char saved[] = "saved", scratch[] = "scratch";
static uint64_t moved_right; // hash of the motion after its steps
static uint32_t n_points;
static uint32_t n_wanted = 1; // points of each scenario and way; 0: all
static const char *only = ""; // scenarios whose name begins so

// Objects that live from their making to their end while calls fail. At the end of a life in which
// a call failed once, the device is there again: all goes right.
typedef struct scenario {
    const char *name;
    void (*live)(const struct scenario *s, lost_way way, uint32_t k);
    duet_mode mode;
    const char *variant;
    const duet_pose *poses;
    uint32_t share; // out of 4
    bool copies;    // acts like devices with memory of their own
    uint32_t wants; // effects of a motion
    uint64_t *right;
} scenario;

static char what[160]; // name of what runs, for messages

static bool told(bool ok, const duet_error *err)
{
    if (!ok && (err->status == DUET_STATUS_OK || !err->text[0] || strchr(err->text, '\n')))
        fail_msg("%s: told as %s '%s'", what, duet_status_name(err->status), err->text);
    return ok;
}

static bool have_host_memory[2];

// A device that works on host memory can be told that it does not.
static void set_memory(bool copies)
{
    for (int side = 0; side < 2; ++side)
        pair->devices[side].info.host_memory = have_host_memory[side] && !copies;
}

// Nothing holds a queue but its device, so nothing waits in it.
static void assert_idle(void)
{
    const struct timespec moment = {.tv_nsec = 1000000};
    for (int i = 0; i < 4; ++i) {
        const device *d = &pair->devices[i / 2];
        cl_command_queue queue = i % 2 ? d->beside : d->queue;
        cl_uint users = 2;
        for (int k = 0; users > 1 && k < 10000; ++k) {
            clGetCommandQueueInfo(queue, CL_QUEUE_REFERENCE_COUNT, sizeof users, &users, NULL);
            if (users > 1)
                nanosleep(&moment, NULL);
        }
        if (users > 1)
            fail_msg("%s: after %s a queue of %s still has commands", what, lost_call(),
                     d->info.selector);
    }
}

// ------------------------------------------------------------ worlds

static void live_as_ordered_world(const scenario *s, lost_way way, uint32_t k);

static duet_world *open_world(const scenario *s, duet_error *err)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.ordered = s->live == live_as_ordered_world;
    def.plan.mode = s->mode;
    def.plan.share = s->share * (DUET_SHARE_ONE / 4);
    snprintf(def.plan.variant_a, sizeof def.plan.variant_a, "%s", s->variant);
    snprintf(def.plan.variant_b, sizeof def.plan.variant_b, "%s", s->variant);
    duet_world *world = duet_world_create(&def, err);
    if (!told(world, err))
        return NULL;
    world->lists.least_chunk = 64;
    world->parts[0].least_chunk = world->parts[1].least_chunk = 64;
    return world;
}

static bool step_world(duet_world *world, const scenario *s, duet_error *err)
{
    duet_result result;
    bool ok = duet_world_set_objects(world, DUET_OBJECT_POSES, s->poses, N, err) &&
              duet_world_step(world, &result, err);
    if (told(ok, err) && duet_result_get_hash(&result) != *s->right)
        fail_msg("%s: wrong pairs", what);
    return ok;
}

// The second step finds all space made.
static void use_new_world(const scenario *s, lost_way way)
{
    duet_error err = {0};
    duet_world *world = open_world(s, &err);
    for (int i = 0; world && i < 2; ++i) {
        step_world(world, s, &err);
        err = (duet_error){0};
    }
    if (world && way == LOST_ONCE) {
        lost_end();
        must(step_world(world, s, ERR));
    }
    duet_world_destroy(world);
}

static void live_as_world(const scenario *s, lost_way way, uint32_t k)
{
    lost_begin(way, k);
    use_new_world(s, way);
}

// The world is told that its objects are in order, and they are not: the first step runs twice.
static void live_as_ordered_world(const scenario *s, lost_way way, uint32_t k)
{
    live_as_world(s, way, k);
}

// B alone has whole objects in the place of packed ones, and wants other kernels.
static void live_as_replanned_world(const scenario *s, lost_way way, uint32_t k)
{
    duet_error err = {0};
    duet_world *world = open_world(s, &err);
    must(world && step_world(world, s, ERR));
    assert_int_equal(kernel_param(part_kernel(&world->parts[1], "hash"), "PACKED"), 1);
    duet_plan plan = *duet_world_get_plan(world);
    plan.share = 0;
    must(duet_world_set_plan(world, &plan, ERR));
    lost_begin(way, k);
    for (int i = 0; i < 2; ++i) {
        step_world(world, s, &err);
        err = (duet_error){0};
    }
    if (way == LOST_ONCE) {
        lost_end();
        must(step_world(world, s, ERR));
    }
    duet_world_destroy(world);
}

static void live_as_pair(const scenario *s, lost_way way, uint32_t k)
{
    lost_begin(way, k);
    duet_error err = {0};
    duet_device_pair *before = pair;
    duet_device_pair_def def = duet_default_device_pair_def();
    def.cache_dir = "test_lost_device.cache";
    pair = duet_device_pair_create(&def, &err);
    lost_know(pair);
    if (told(pair, &err))
        use_new_world(s, way);
    duet_device_pair_destroy(pair);
    pair = before;
    lost_know(pair);
}

// ------------------------------------------------------------ motions

static duet_motion *open_motion(const scenario *s, duet_error *err)
{
    duet_pose boxes[MOVING];
    duet_body bodies[MOVING];
    duet_motion_def def = duet_default_motion_def();
    def.pair = pair;
    def.plan.share = s->share * (DUET_SHARE_ONE / 4);
    def.wants = s->wants;
    def.gravity[2] = -9.81;
    def.skin = s->copies ? 0.0 : 0.2;
    def.boundary = DUET_BOUNDARY_WALLS;
    for (int k = 0; k < 3; ++k) {
        def.lower[k] = -1.6;
        def.upper[k] = 5.0;
    }
    for (int i = 0; i < MOVING; ++i) {
        boxes[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0.02f, 1}};
        boxes[i].centre[0] = 0.99f * (float)(i % 2);
        boxes[i].centre[1] = 0.99f * (float)(i / 2 % 2);
        boxes[i].centre[2] = 0.99f * (float)(i / 4) - 1.1f;
        bodies[i] = duet_default_body();
        bodies[i].friction = 0.5f;
    }
    duet_motion *m = duet_motion_create(&def, boxes, bodies, MOVING, err);
    told(m, err);
    return m;
}

static bool advance(duet_motion *m, int steps, duet_error *err)
{
    duet_motion_result result;
    bool ok = true;
    for (int i = 0; ok && i < steps; ++i)
        ok = told(duet_motion_advance(m, &result, err), err);
    return ok;
}

// Steps, the file, and what was found; calls after a failed one fail as well, or not.
static void use_motion(duet_motion *m)
{
    duet_error errs[6] = {{0}};
    duet_contact *contacts = NULL;
    uint64_t n, hash;
    advance(m, STEPS, &errs[0]);
    advance(m, 1, &errs[1]);
    if (told(duet_motion_get_contacts(m, &contacts, &n, &errs[2]), &errs[2]))
        duet_free(contacts);
    told(duet_motion_save(m, scratch, &errs[3]), &errs[3]);
    told(duet_motion_load(m, saved, &errs[4]), &errs[4]);
    told(duet_motion_get_hash(m, &hash, &errs[5]), &errs[5]);
    advance(m, 1, &errs[5]);
}

// A saved motion makes whole what failed half-way.
static void assert_heals(duet_motion *m)
{
    uint64_t hash = 0;
    lost_end();
    must(duet_motion_load(m, saved, ERR));
    must(advance(m, STEPS, ERR));
    must(duet_motion_get_hash(m, &hash, ERR));
    if (hash != moved_right)
        fail_msg("%s: the loaded motion goes another way", what);
}

static void live_as_motion(const scenario *s, lost_way way, uint32_t k)
{
    lost_begin(way, k);
    duet_error err = {0};
    duet_motion *m = open_motion(s, &err);
    if (m)
        use_motion(m);
    if (m && way == LOST_ONCE)
        assert_heals(m);
    duet_motion_destroy(m);
}

// The motion of a scenario after its steps, saved when they begin.
static void save_motion(const scenario *s)
{
    duet_motion *m = must(open_motion(s, ERR));
    must(advance(m, STEPS, ERR));
    must(duet_motion_save(m, saved, ERR));
    must(advance(m, STEPS, ERR));
    must(duet_motion_get_hash(m, &moved_right, ERR));
    duet_motion_destroy(m);
}

// ------------------------------------------------------------ sweeps

static uint32_t live(const scenario *s, lost_way way, uint32_t k)
{
    snprintf(what, sizeof what, "%s, call %u fails %s", s->name, k, lost_way_name(way));
    set_memory(s->copies);
    s->live(s, way, k);
    uint32_t n_calls = lost_end();
    set_memory(false);
    return n_calls;
}

// A first life builds the kernels, which stay on the devices' program pool.
static void sweep(const scenario *s, rng *r)
{
    if (s->wants)
        save_motion(s);
    live(s, LOST_FOR_EVER, UINT32_MAX);
    assert_idle();
    int before = device_live_objects();
    uint32_t n_calls = live(s, LOST_FOR_EVER, UINT32_MAX), points = 0;
    uint32_t stride = n_wanted > 0 && n_calls > n_wanted ? n_calls / n_wanted : 1;
    for (int way = 0; way < LOST_WAYS; ++way)
        for (uint32_t k = rng_below(r, stride); k < n_calls; k += stride) {
            live(s, (lost_way)way, k);
            ++points;
            assert_idle();
            if (device_live_objects() != before)
                fail_msg("%s: %d objects of OpenCL are left", what, device_live_objects() - before);
        }
    assert_idle();
    print_message("%s: %u calls, %u points\n", s->name, n_calls, points);
    n_points += points;
}

static uint64_t right_of(const duet_pose objects[N])
{
    duet_error err = {0};
    duet_pair *pairs = NULL;
    uint64_t n = 0;
    duet_scene *scene = duet_scene_create(DUET_OBJECT_POSES, objects, N, 3, 0, &err);
    must(scene && duet_reference(scene, DUET_LEVEL_CERTIFIED, &pairs, &n, ERR));
    assert_true(n > 50);
    uint64_t right = duet_pairs_hash(pairs, n);
    duet_free(pairs);
    duet_scene_destroy(scene);
    return right;
}

TEST(nothing_crashes_hangs_or_leaks)
{
    uint64_t even_right = right_of(even), mixed_right = right_of(mixed);
    const uint32_t pile = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS;
    const duet_mode shared = DUET_MODE_SHARED, own = DUET_MODE_OWN, slab = DUET_MODE_SLAB;
    uint64_t *of_even = &even_right, *of_mixed = &mixed_right;
    const scenario scenarios[] = {
        {"shared dense", live_as_world, shared, "auto", even, 2, false, 0, of_even},
        {"own dense", live_as_world, own, "simd", even, 2, false, 0, of_even},
        {"slab dense", live_as_world, slab, "simd", even, 2, false, 0, of_even},
        {"shared dense, copied", live_as_world, shared, "gpu", even, 2, true, 0, of_even},
        {"own dense, copied", live_as_world, own, "gpu send=chunks", even, 2, true, 0, of_even},
        {"slab dense, packed", live_as_world, slab, "gpu send=packed", even, 2, true, 0, of_even},
        {"slab ordered", live_as_ordered_world, slab, "simd", even, 2, false, 0, of_even},
        {"slab ordered, copied", live_as_ordered_world, slab, "gpu", even, 2, true, 0, of_even},
        {"shared levelled, copied", live_as_world, shared, "auto", mixed, 1, true, 0, of_mixed},
        {"own levelled", live_as_world, own, "gpu", mixed, 2, false, 0, of_mixed},
        {"shared hashed", live_as_world, shared, "simd grid=hashed", even, 2, false, 0, of_even},
        {"own hashed, copied", live_as_world, own, "gpu grid=hashed", even, 3, true, 0, of_even},
        {"own radix, copied", live_as_world, own, "simd sort=radix", mixed, 2, true, 0, of_mixed},
        {"paper, copied", live_as_world, shared, "paper", even, 2, true, 0, of_even},
        {"A alone", live_as_world, own, "simd", even, 4, false, 0, of_even},
        {"B alone, copied", live_as_world, own, "gpu", even, 0, true, 0, of_even},
        {"replanned", live_as_replanned_world, slab, "gpu send=packed", even, 2, true, 0, of_even},
        {"contacts", live_as_motion, own, "", NULL, 2, false, DUET_EFFECT_CONTACT, NULL},
        {"pile", live_as_motion, own, "", NULL, 2, false, pile, NULL},
        {"pile, copied", live_as_motion, own, "", NULL, 2, true, pile, NULL},
        {"pair", live_as_pair, own, "simd", even, 2, false, 0, of_even},
    };
    rng r = rng_seed(test_seed());
    for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; ++i)
        if (strncmp(scenarios[i].name, only, strlen(only)) == 0)
            sweep(&scenarios[i], &r);
    print_message("%u points\n", n_points);
}

// One of those kernels is not made; the next step runs none that are left of either kind.
TEST(kernels_that_were_not_made_are_made_again)
{
    uint64_t right = right_of(even);
    const scenario s = {
        "replanned", live_as_replanned_world, DUET_MODE_SLAB, "gpu send=packed", even, 2, true, 0,
        &right};
    uint32_t n_kernels = 0;
    live(&s, LOST_FOR_EVER, UINT32_MAX);
    for (uint32_t k = 0; k < 16; ++k) {
        live(&s, LOST_ONCE, k);
        n_kernels += strcmp(lost_call(), "clCreateKernel") == 0;
    }
    assert_true(n_kernels > 0);
}

static duet_tree *tree;

static bool into_tree(duet_motion *m, duet_error *err)
{
    return duet_tree_set_motion(tree, m, err);
}

static bool change_shape(duet_motion *m, duet_error *err)
{
    duet_pose flat = {.centre = {9, 9, 9}, .half_extents = {0.5f, 0.5f, 0.1f}, .rotation[3] = 1};
    return duet_motion_set_poses(m, (duet_body_list){.n = 1}, &flat, err);
}

// A command that calls for kernels that a motion lacks leaves it as it was where one of these is
// not made.
TEST(a_motion_goes_on_without_kernels_that_were_not_made)
{
    bool (*const calls[])(duet_motion *, duet_error *) = {into_tree, change_shape};
    const scenario s = {
        "pile", live_as_motion, DUET_MODE_OWN, "", NULL, 2, false, DUET_EFFECT_CONTACT_RESPONSE,
        NULL};
    duet_tree_def def = duet_default_tree_def();
    duet_error err = {0};
    def.pair = pair;
    def.share = 0;
    tree = kept(duet_tree_create(&def, ERR));
    save_motion(&s);
    for (int i = 0; i < 2; ++i) {
        uint32_t n_kernels = 0;
        for (uint32_t k = 7; k-- > 0;) {
            duet_error why = {0};
            uint64_t hash;
            duet_motion *m = must(open_motion(&s, ERR));
            lost_begin(LOST_ONCE, k == 6 ? UINT32_MAX : k);
            bool ok = calls[i](m, &why);
            lost_end();
            if (!ok && strcmp(lost_call(), "clCreateKernel") == 0) {
                ++n_kernels;
                assert_true(i == 1 || into_tree(m, &err));
                must(advance(m, 2 * STEPS, ERR));
                must(duet_motion_get_hash(m, &hash, ERR));
                assert_true(hash == moved_right);
            }
            duet_motion_destroy(m);
        }
        assert_true(n_kernels > 0);
    }
}

// Buffers that are new have nothing to wait for: they are cleared and written in
// one go.
TEST(what_is_made_waits_no_more_for_more_buffers)
{
    const scenario s = {.share = 2, .wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP};
    set_memory(false);
    lost_begin(LOST_ONCE, UINT32_MAX);
    duet_motion *m = must(open_motion(&s, ERR));
    uint32_t n_finishes = lost_finishes();
    lost_end();
    duet_motion_destroy(m);
    assert_true(!have_host_memory[1] || n_finishes <= 1);
}

// Parts are mapped, and writing one of them fails half-way: loading gives all back to the buffers
// that they are of, and the others' memory goes with those.
TEST(a_broken_motion_is_loaded_while_parts_are_mapped)
{
    const scenario s = {.share = 2,
                        .wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP |
                                 DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_MOTION};
    uint32_t n_broken = 0;
    save_motion(&s);
    for (int copies = 0; copies < 2; ++copies)
        for (uint32_t k = 0; k < 8; ++k) {
            duet_error why = {0};
            set_memory(copies);
            snprintf(what, sizeof what, "mapped, %s, call %u", copies ? "copied" : "in place", k);
            duet_motion *m = must(open_motion(&s, ERR));
            for (int i = 0; i < 4; ++i)
                must(duet_motion_map_states(m, (duet_state_part)i, DUET_MAP_WRITE, 0, MOVING, ERR));
            lost_begin(LOST_ONCE, k);
            if (!told(duet_motion_unmap_states(m, DUET_STATE_VELOCITIES, &why), &why)) {
                ++n_broken;
                assert_heals(m);
            }
            duet_motion_destroy(m);
            lost_end();
            if (lost_wrong_unmaps() > 0)
                fail_msg("%s: %u unmaps of other memory", what, lost_wrong_unmaps());
        }
    set_memory(false);
    assert_idle();
    assert_true(n_broken > 0);
}

// One cube lies on a floor, and then all others land in the same step, which makes buffers for
// their contacts.
static duet_motion *open_landing(void)
{
    enum { SIDE = 20, CUBES = SIDE * SIDE, ALL = CUBES + 2 };
    static duet_pose poses[ALL];
    static duet_body bodies[ALL];
    duet_motion_def def = duet_default_motion_def();
    def.pair = pair;
    def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    def.gravity[2] = -10;
    for (int i = 0; i < ALL; ++i) {
        poses[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation[3] = 1};
        bodies[i] = duet_default_body();
        poses[i].centre[0] = 1.5f * (float)(i % SIDE);
        poses[i].centre[1] = 1.5f * (float)(i / SIDE);
        poses[i].centre[2] = 0.56f;
    }
    poses[CUBES].centre[2] = 0.5f;
    poses[ALL - 1] =
        (duet_pose){.centre = {0, 0, -1}, .half_extents = {90, 90, 1}, .rotation[3] = 1};
    bodies[ALL - 1].mass = 0;
    return must(duet_motion_create(&def, poses, bodies, ALL, ERR));
}

// Steps until they land, of which the last one finds their contacts.
static int count_falling(void)
{
    duet_motion *m = open_landing();
    duet_motion_result result = {0};
    int steps = 0;
    for (; result.contacts < 100; ++steps)
        must(duet_motion_advance(m, &result, ERR));
    duet_motion_destroy(m);
    return steps;
}

// Space for contacts that was not to be had is known to be gone: the motion that is loaded then
// makes it again.
TEST(a_motion_that_found_no_memory_for_contacts_is_loaded_and_goes_on)
{
    uint32_t n_without = 0;
    uint64_t right, hash;
    set_memory(false);
    const int before = count_falling() - 1;
    duet_motion *m = open_landing();
    must(advance(m, 1, ERR));
    must(duet_motion_save(m, saved, ERR));
    must(advance(m, before - 1, ERR));
    lost_begin(LOST_ONCE, UINT32_MAX);
    must(advance(m, 1, ERR));
    const uint32_t n_calls = lost_end();
    must(advance(m, STEPS - 1, ERR));
    must(duet_motion_get_hash(m, &right, ERR));
    duet_motion_destroy(m);
    for (uint32_t k = 0; k < n_calls; ++k) {
        duet_error why = {0};
        m = open_landing();
        must(advance(m, before, ERR));
        lost_begin(LOST_ONCE, k);
        const bool ok = told(advance(m, 1, &why), &why);
        lost_end();
        if (!ok && strcmp(lost_call(), "clCreateBuffer") == 0) {
            ++n_without;
            must(duet_motion_load(m, saved, ERR));
            must(advance(m, before - 1 + STEPS, ERR));
            must(duet_motion_get_hash(m, &hash, ERR));
            if (hash != right)
                fail_msg("call %u: the loaded motion goes another way", k);
        }
        duet_motion_destroy(m);
    }
    assert_true(n_without > 0);
}

// ------------------------------------------------------------ what runs

static void open_devices(void)
{
    if (test_argument(2) && strcmp(test_argument(1), "--points") == 0)
        n_wanted = (uint32_t)strtoul(test_argument(2), NULL, 10);
    if (test_argument(3))
        only = test_argument(3);
    lost_begin(LOST_FOR_EVER, UINT32_MAX);
    pair = kept(duet_device_pair_open(NULL, ERR));
    for (int side = 0; side < 2; ++side)
        have_host_memory[side] = pair->devices[side].info.host_memory;
    lost_know(pair);
    rng r = rng_seed(7);
    for (int i = 0; i < N; ++i) {
        even[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}};
        for (int k = 0; k < 4; ++k) {
            even[i].rotation[k] = (float)rng_normal(&r);
            if (k < 3)
                even[i].centre[k] = (float)rng_between(&r, 0, 12);
        }
        mixed[i] = even[i];
        for (int k = 0; k < 3 && i % 8; ++k)
            mixed[i].half_extents[k] = 0.05f;
    }
}

TEST_BEGIN(open_devices)
