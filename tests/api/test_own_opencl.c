// SPDX-License-Identifier: MIT
// Duet inside a program that has contexts, queues, buffers and events of its own: same pairs as
// with the host's arrays, nothing of the program's is kept or lost, and each misuse ends in a line.
#include "support/own_program.h"
#include "support/test.h"

#include "support/devices.h"

#include "runtime/broadphase/world.h"
#include "runtime/selection/profile_subject.h"

enum { N = 600 };

static duet_pose poses[N];

// ------------------------------------------------------------ the program

static void open_program(void)
{
    own_program_open();
    rng r = {test_seed()};
    for (int i = 0; i < N; ++i) {
        for (int k = 0; k < 3; ++k) {
            poses[i].centre[k] = (float)rng_between(&r, 0.0, 12.0);
            poses[i].half_extents[k] = (float)rng_between(&r, 0.2, 0.5);
        }
        poses[i].rotation[2] = (float)rng_normal(&r);
        poses[i].rotation[3] = (float)rng_normal(&r);
    }
    // These just touch, which float cannot decide.
    for (int i = N - 20; i < N; ++i)
        poses[i] = (duet_pose){.centre = {(float)(i % 2), (float)(i / 2 % 5) * 2.5f, 20.0f},
                               .half_extents = {0.5f, 0.5f, 0.5f},
                               .rotation = {0, 0, 0, 1}};
}

static cl_uint context_references(void)
{
    cl_uint n = 0;
    clGetContextInfo(own.context, CL_CONTEXT_REFERENCE_COUNT, sizeof n, &n, NULL);
    return n;
}

static duet_device_pair *open_queues(cl_command_queue a, cl_command_queue b)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = def.b = NULL;
    return kept(duet_device_pair_create_on_queues(&def, a, b, ERR));
}

static duet_world *make_world(duet_device_pair *pair, duet_world_def def)
{
    def.pair = pair;
    return create_world(&def);
}

static uint64_t hash_of(duet_world *world)
{
    duet_result result = step_world(world);
    return duet_result_get_hash(&result);
}

static void set_plan(duet_world *world, duet_mode mode, uint32_t share)
{
    duet_plan plan = *duet_world_get_plan(world);
    plan.mode = mode;
    plan.share = share;
    must(duet_world_set_plan(world, &plan, ERR));
}

// ------------------------------------------------------------ device pairs

TEST(a_pair_holds_what_it_uses_and_lets_all_of_it_go)
{
    const cl_uint before = context_references();
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    assert_true(context_references() > before);
    assert_int_equal(own_queue_references(0), 2);
    assert_ptr_equal(pair->devices[0].context, own.context);
    assert_ptr_not_equal(pair->devices[0].queue, own.queues[0]);
    assert_int_equal(duet_device_pair_is_one(pair), !own.cut);
    const char *selector = duet_device_pair_get_info(pair, 0)->selector;
    assert_int_equal(strstr(selector, "[1 unit]") != NULL, own.cut);
    test_give_back(pair);
    assert_int_equal(context_references(), before);
    assert_int_equal(own_queue_references(0), 1);
}

TEST(one_queue_is_a_pair_of_one)
{
    for (int i = 0; i < 2; ++i) {
        duet_device_pair *pair = open_queues(i ? NULL : own.queues[0], i ? own.queues[0] : NULL);
        assert_true(duet_device_pair_is_one(pair));
        assert_int_equal(duet_default_plan(pair).share, 0);
        test_give_back(pair);
    }
}

TEST(a_device_without_a_queue_is_opened_by_its_selector)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.a = "cpu";
    duet_device_pair *pair =
        kept(duet_device_pair_create_on_queues(&def, NULL, own.queues[1], ERR));
    assert_ptr_not_equal(pair->devices[0].context, own.context);
    assert_ptr_equal(pair->devices[1].context, own.context);
    test_give_back(pair);
    def.a = "nowhere";
    must_fail(duet_device_pair_create_on_queues(&def, NULL, own.queues[1], ERR),
              DUET_STATUS_BAD_ARGUMENT, "no device 'nowhere'");
    must_fail(duet_device_pair_create_on_queues(&def, NULL, NULL, ERR), DUET_STATUS_BAD_ARGUMENT,
              "queue is NULL");
}

// A profile that was measured on the device by its selector is one for the caller's queue.
TEST(profiles_are_those_of_the_device)
{
    cl_device_id root = own.root;
    cl_context context = clCreateContext(NULL, 1, &root, NULL, NULL, NULL);
    cl_command_queue queue = clCreateCommandQueue(context, root, 0, NULL);
    duet_device_pair *pair = open_queues(queue, NULL);
    clReleaseCommandQueue(queue);
    clReleaseContext(context);
    duet_device_pair *named =
        kept(duet_device_pair_open(duet_device_pair_get_info(pair, 0)->selector, ERR));
    duet_device_pair *pairs[] = {pair, named};
    profile_subject subjects[2];
    uint64_t hashes[2];
    for (int i = 0; i < 2; ++i) {
        duet_profile profile;
        duet_world *world = make_world(pairs[i], duet_default_world_def());
        must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
        must(profile_subject_read(world, &subjects[i], ERR));
        must(duet_world_load_profile(world, NULL, &profile, ERR));
        hashes[i] = hash_of(world); // the program has released its queue and context
        test_give_back(world);
    }
    assert_true(hashes[0] == hashes[1]);
    assert_string_equal(subjects[0].pair.a.device.name, subjects[1].pair.a.device.name);
    assert_int_equal(subjects[0].pair.a.device.units, subjects[1].pair.a.device.units);
    assert_null(subjects[0].pair.b.part);
    test_give_back(named);
}

// Parts that the program cut off are described as those that Duet cuts off.
TEST(profiles_are_those_of_the_parts)
{
    if (!own.cut)
        skip();
    char selectors[2 * sizeof((duet_device_info *)0)->selector];
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    const char *whole = duet_device_pair_get_info(pair, 0)->selector;
    int length = (int)strcspn(whole, "[");
    snprintf(selectors, sizeof selectors, "%.*s[0-0],%.*s[1-1]", length, whole, length, whole);
    duet_device_pair *named = kept(duet_device_pair_open(selectors, ERR));
    duet_device_pair *pairs[] = {pair, named};
    duet_world *worlds[2];
    profile_subject subjects[2];
    for (int i = 0; i < 2; ++i) {
        worlds[i] = make_world(pairs[i], duet_default_world_def());
        must(duet_world_set_objects(worlds[i], DUET_OBJECT_POSES, poses, N, ERR));
        must(profile_subject_read(worlds[i], &subjects[i], ERR));
    }
    for (int side = 0; side < 2; ++side) {
        const profile_env *ours = side ? &subjects[0].pair.b : &subjects[0].pair.a;
        const profile_env *theirs = side ? &subjects[1].pair.b : &subjects[1].pair.a;
        assert_string_equal(ours->part, side ? "1-1" : "0-0");
        assert_string_equal(ours->part, theirs->part);
        assert_string_equal(ours->device.name, theirs->device.name);
        assert_string_equal(ours->driver, theirs->driver);
        assert_int_equal(ours->part_units, theirs->part_units);
        assert_int_equal(ours->device.units, theirs->device.units);
        assert_int_equal(ours->device.max_group, theirs->device.max_group);
        test_give_back(worlds[side]);
    }
    test_give_back(named);
}

// ------------------------------------------------------------ objects

typedef struct given {
    duet_object_kind kind;
    size_t bytes;
    const void *rows;
} given;

static duet_bounds bounds[N];
static duet_transform transforms[N];
static duet_size sizes[N];
static duet_compact_transform compact[N];
static duet_large_pose large[N];

static void fill_kinds(void)
{
    for (int i = 0; i < N; ++i) {
        const double at[3] = {poses[i].centre[0], poses[i].centre[1], poses[i].centre[2]};
        for (int k = 0; k < 3; ++k) {
            bounds[i].lower[k] = poses[i].centre[k];
            bounds[i].upper[k] = poses[i].centre[k] + poses[i].half_extents[k];
        }
        memcpy(transforms[i].centre, poses[i].centre, sizeof poses[i].centre);
        memcpy(transforms[i].rotation, poses[i].rotation, sizeof poses[i].rotation);
        memcpy(sizes[i].half_extents, poses[i].half_extents, sizeof sizes[i]);
        assert_true(duet_compact_transform_set(&compact[i], &transforms[i], NULL));
        large[i].pose = poses[i];
        assert_true(duet_large_pose_set(&large[i], at, 4.0f, NULL));
    }
}

static void set_by_buffer(duet_world *world, given g)
{
    cl_mem mem = own_buffer(g.rows, N * g.bytes, CL_MEM_READ_ONLY);
    must(duet_world_set_objects_buffer(world, g.kind, mem, N, 0, NULL, ERR));
}

static void steps_are_those_of_the_host(duet_device_pair *pair, duet_world_def def, given g)
{
    static const struct {
        duet_mode mode;
        uint32_t share;
    } plans[] = {{DUET_MODE_OWN, 0},
                 {DUET_MODE_OWN, DUET_SHARE_ONE / 3},
                 {DUET_MODE_OWN, DUET_SHARE_ONE},
                 {DUET_MODE_SLAB, DUET_SHARE_ONE / 2},
                 {DUET_MODE_SHARED, DUET_SHARE_ONE / 2}};
    duet_world *host = make_world(pair, def), *world = make_world(pair, def);
    const given apart = {DUET_OBJECT_SIZES, sizeof *sizes, sizes};
    must(duet_world_set_objects(host, g.kind, g.rows, N, ERR));
    if (def.pose_form) {
        must(duet_world_set_objects(host, DUET_OBJECT_SIZES, sizes, N, ERR));
        set_by_buffer(world, apart);
    }
    set_plan(host, DUET_MODE_OWN, 0);
    duet_result right = step_world(host);
    assert_true(right.pairs > 10 && (def.shape == DUET_SHAPE_BOUNDS || right.undecided > 0));
    for (size_t p = 0; p < sizeof plans / sizeof *plans; ++p) {
        set_by_buffer(world, g);
        set_plan(world, plans[p].mode, plans[p].share);
        assert_true(hash_of(world) == duet_result_get_hash(&right));
        assert_true(hash_of(world) == duet_result_get_hash(&right)); // the pairs are as they were
    }
}

static void every_kind(duet_device_pair *pair, uint32_t dims)
{
    duet_world_def def = duet_default_world_def();
    def.dims = dims;
    steps_are_those_of_the_host(pair, def, (given){DUET_OBJECT_POSES, sizeof *poses, poses});
    def.shape = DUET_SHAPE_BOUNDS;
    steps_are_those_of_the_host(pair, def, (given){DUET_OBJECT_BOUNDS, sizeof *bounds, bounds});
    if (dims == 2)
        return;
    def.shape = DUET_SHAPE_POSES;
    def.pose_form = DUET_POSE_TRANSFORM;
    steps_are_those_of_the_host(pair, def,
                                (given){DUET_OBJECT_TRANSFORMS, sizeof *transforms, transforms});
    def.pose_form = DUET_POSE_COMPACT;
    steps_are_those_of_the_host(pair, def,
                                (given){DUET_OBJECT_COMPACT_TRANSFORMS, sizeof *compact, compact});
    def.pose_form = DUET_POSE_WHOLE;
    def.origin_edge = 4.0f;
    steps_are_those_of_the_host(pair, def, (given){DUET_OBJECT_LARGE_POSES, sizeof *large, large});
}

static void set_host_memory(duet_device_pair *pair, bool a, bool b)
{
    pair->devices[0].info.host_memory = a;
    pair->devices[1].info.host_memory = b;
}

TEST(objects_of_a_buffer_are_those_of_the_host)
{
    fill_kinds();
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    every_kind(pair, 3);
    every_kind(pair, 2);
}

TEST(a_device_of_another_context_gets_them_through_the_host)
{
    duet_world_def def = duet_default_world_def();
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    pair_def.a = pair_def.b = own.cut ? "cpu[1/1]" : "cpu";
    for (int side = 0; side < 2; ++side) {
        duet_device_pair *pair = kept(duet_device_pair_create_on_queues(
            &pair_def, side ? NULL : own.queues[0], side ? own.queues[1] : NULL, ERR));
        steps_are_those_of_the_host(pair, def, (given){DUET_OBJECT_POSES, sizeof *poses, poses});
        test_give_back(pair);
    }
}

// Such devices are told of them here; the CPU does what they would.
TEST(devices_with_memory_of_their_own_find_the_same)
{
    fill_kinds();
    duet_world_def def = duet_default_world_def();
    for (int i = 0; i < 2; ++i) {
        duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
        set_host_memory(pair, i, false);
        steps_are_those_of_the_host(pair, def, (given){DUET_OBJECT_POSES, sizeof *poses, poses});
        duet_world_def apart = def;
        apart.pose_form = DUET_POSE_COMPACT;
        steps_are_those_of_the_host(
            pair, apart, (given){DUET_OBJECT_COMPACT_TRANSFORMS, sizeof *compact, compact});
        set_host_memory(pair, true, true);
        test_give_back(pair);
    }
}

TEST(objects_are_checked_as_the_hosts)
{
    duet_error own_err;
    duet_result result;
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    duet_world *host = make_world(pair, duet_default_world_def());
    duet_world *world = make_world(pair, duet_default_world_def());
    const given g = {DUET_OBJECT_POSES, sizeof *poses, poses};
    set_by_buffer(world, g);
    const uint64_t right = hash_of(world);
    float *const numbers[] = {&poses[7].centre[1], &poses[9].half_extents[0], &poses[11].centre[0]};
    const float bad[] = {NAN, -1.0f, INFINITY};
    for (int i = 0; i < 3; ++i) {
        const float kept = *numbers[i];
        *numbers[i] = bad[i];
        set_by_buffer(world, g);
        must(duet_world_set_objects(host, g.kind, poses, N, ERR));
        must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "");
        own_err = *ERR;
        must_fail(duet_world_step(host, &result, ERR), DUET_STATUS_BAD_OBJECT, own_err.text);
        assert_string_equal(ERR->text, own_err.text);
        *numbers[i] = kept;
    }
    // One that outgrows its cells makes the grid be laid anew.
    const float kept = poses[3].half_extents[1];
    poses[3].half_extents[1] = 5.0f;
    set_by_buffer(world, g);
    must(duet_world_set_objects(host, g.kind, poses, N, ERR));
    assert_true(hash_of(world) == hash_of(host));
    assert_true(hash_of(world) != right);
    poses[3].half_extents[1] = kept;
    set_by_buffer(world, g);
    assert_true(hash_of(world) == right);
}

TEST(a_step_reads_objects_once_what_it_waits_for_is_over)
{
    duet_result result;
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    duet_world *world = make_world(pair, duet_default_world_def());
    cl_mem mem = own_buffer(poses, sizeof poses, CL_MEM_READ_WRITE);
    must(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, mem, N, 0, NULL, ERR));
    const uint64_t right = hash_of(world);
    // Nonsense is there until the program's own event lets the poses come.
    const cl_uint nothing = 0;
    for (int by_event = 0; by_event < 2; ++by_event) {
        cl_event gate = clCreateUserEvent(own.context, NULL), written = NULL;
        assert_int_equal(clEnqueueFillBuffer(own.queues[0], mem, &nothing, sizeof nothing, 0,
                                             sizeof poses, 0, NULL, NULL),
                         CL_SUCCESS);
        clFinish(own.queues[0]);
        assert_int_equal(clEnqueueWriteBuffer(own.queues[0], mem, CL_FALSE, 0, sizeof poses, poses,
                                              1, &gate, &written),
                         CL_SUCCESS);
        clFlush(own.queues[0]);
        must(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, mem, N, (cl_uint)by_event,
                                           by_event ? &written : NULL, ERR));
        must(duet_world_step_begin(world, ERR));
        clSetUserEventStatus(gate, CL_COMPLETE);
        must(duet_world_step_end(world, &result, ERR));
        assert_true(duet_result_get_hash(&result) == right);
        clReleaseEvent(written);
        clReleaseEvent(gate);
    }
    assert_true(own_references(mem) == 2);
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    assert_true(own_references(mem) == 1);
    assert_true(hash_of(world) == right);
}

TEST(what_was_waited_for_in_vain_is_told)
{
    duet_result result;
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    duet_world *world = make_world(pair, duet_default_world_def());
    cl_mem mem = own_buffer(poses, sizeof poses, CL_MEM_READ_WRITE);
    cl_event gate = clCreateUserEvent(own.context, NULL);
    must(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, mem, N, 1, &gate, ERR));
    clSetUserEventStatus(gate, -5);
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_DEVICE_FAILED,
              "an event that the objects wait for has failed");
    clReleaseEvent(gate);
}

// ------------------------------------------------------------ pairs

static uint64_t hash_of_buffers(const duet_pair_buffers *b)
{
    cl_ulong n = 0;
    duet_pair *pairs = test_alloc((size_t)b->n * sizeof *pairs + 1);
    own_read(0, b->count, &n, sizeof n, NULL);
    assert_true(n == b->n);
    if (n > 0)
        own_read(0, b->pairs, pairs, (size_t)n * sizeof *pairs, NULL);
    return duet_pairs_hash(pairs, n);
}

static void leave_everywhere(duet_device_pair *pair)
{
    static const uint32_t shares[] = {0, DUET_SHARE_ONE / 3, DUET_SHARE_ONE};
    duet_world *world = make_world(pair, duet_default_world_def());
    const given g = {DUET_OBJECT_POSES, sizeof *poses, poses};
    set_by_buffer(world, g);
    const duet_result right = step_world(world);
    const uint64_t hash = duet_result_get_hash(&right), n = right.pairs;
    cl_mem pairs = own_buffer(NULL, n * sizeof(duet_pair), CL_MEM_READ_WRITE);
    cl_mem count = own_buffer(NULL, sizeof(cl_ulong), CL_MEM_READ_WRITE);
    for (int i = 0; i < 12; ++i) {
        bool mine = i % 2;
        duet_pair_buffers buffers;
        must(duet_world_leave_pairs(world, i / 2 % 2, mine ? pairs : NULL, mine ? count : NULL,
                                    ERR));
        set_plan(world, DUET_MODE_OWN, shares[i / 4]);
        duet_result result = step_world(world);
        assert_int_equal(result.pairs, n);
        assert_int_equal(result.spans[0].n + result.spans[1].n, n);
        assert_null(result.spans[0].pairs);
        assert_true(duet_result_get_hash(&result) == 0);
        assert_int_equal(duet_result_get_pair(&result, 0).b, 0);
        must(duet_world_get_pair_buffers(world, &buffers, ERR));
        assert_int_equal(mine, buffers.pairs == pairs);
        assert_int_equal(mine, buffers.count == count);
        assert_true(hash_of_buffers(&buffers) == hash);
    }
    must(duet_world_bring_pairs(world, ERR));
    assert_int_equal(own_references(pairs), 1);
    assert_int_equal(own_references(count), 1);
    assert_true(hash_of(world) == hash);
}

TEST(pairs_are_left_in_buffers)
{
    for (int i = 0; i < 3; ++i) {
        duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
        set_host_memory(pair, i > 1, i > 0);
        leave_everywhere(pair);
        set_host_memory(pair, true, true);
        test_give_back(pair);
    }
}

// The caller knows the context of a pair that Duet opened by a buffer that a step left, and there
// is no queue of the caller's to wait for.
TEST(buffers_come_from_the_context_of_a_pair_without_queues)
{
    duet_device_pair *pair = kept(duet_device_pair_open(NULL, ERR));
    duet_world *world = make_world(pair, duet_default_world_def());
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    const uint64_t hash = hash_of(world);
    duet_pair_buffers left;
    must(duet_world_leave_pairs(world, 1, NULL, NULL, ERR));
    step_world(world);
    must(duet_world_get_pair_buffers(world, &left, ERR));
    cl_context context = NULL;
    clGetMemObjectInfo(left.pairs, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    cl_int code = CL_SUCCESS;
    cl_mem mem = clCreateBuffer(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, sizeof poses,
                                poses, &code);
    assert_int_equal(code, CL_SUCCESS);
    must(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, mem, N, 0, NULL, ERR));
    clReleaseMemObject(mem);
    must(duet_world_bring_pairs(world, ERR));
    assert_true(hash_of(world) == hash);
}

TEST(a_buffer_too_small_for_the_pairs_is_left_as_it_was)
{
    duet_result result;
    duet_pair_buffers buffers;
    duet_device_pair *pair = open_queues(own.queues[0], NULL);
    duet_world *world = make_world(pair, duet_default_world_def());
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    const uint64_t n = step_world(world).pairs;
    duet_pair kept[3] = {{1, 2}, {3, 4}, {5, 6}}, now[3];
    cl_mem pairs = own_buffer(kept, sizeof kept, CL_MEM_READ_WRITE);
    must(duet_world_leave_pairs(world, 1, pairs, NULL, ERR));
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_TOO_MANY,
              "the caller's buffer holds 3; expected one of");
    assert_int_equal(result.pairs, n);
    own_read(0, pairs, now, sizeof now, NULL);
    assert_memory_equal(now, kept, sizeof now);
    must_fail(duet_world_get_pair_buffers(world, &buffers, ERR), DUET_STATUS_BAD_ARGUMENT,
              "no step has left its pairs");
}

// ------------------------------------------------------------ two halves

TEST(commands_that_wait_for_a_step_see_its_pairs)
{
    duet_result result;
    duet_pair_buffers buffers;
    cl_event done = NULL;
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    duet_world *world = make_world(pair, duet_default_world_def());
    cl_mem mem = own_buffer(poses, sizeof poses, CL_MEM_READ_WRITE);
    cl_mem count = own_buffer(NULL, sizeof(cl_ulong), CL_MEM_READ_WRITE);
    cl_ulong read = 0;
    must_fail(duet_world_step_begin_event(world, &done, ERR), DUET_STATUS_BAD_ARGUMENT,
              "pairs come to the host");
    must(duet_world_leave_pairs(world, 1, NULL, count, ERR));
    for (int i = 0; i < 3; ++i) {
        read = 0;
        must(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, mem, N, 0, NULL, ERR));
        must(duet_world_step_begin_event(world, &done, ERR));
        own_read(1, count, &read, sizeof read, &done);
        must(duet_world_step_end(world, &result, ERR));
        assert_int_equal(read, result.pairs);
        must(duet_world_get_pair_buffers(world, &buffers, ERR));
        assert_ptr_equal(buffers.count, count);
        clReleaseEvent(done);
    }
    // A step that fails has left no pairs.
    poses[5].centre[0] = NAN;
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    poses[5].centre[0] = 1.0f;
    must(duet_world_step_begin_event(world, &done, ERR));
    must_fail(duet_world_step_end(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "object 5 of");
    read = 9;
    own_read(1, count, &read, sizeof read, &done);
    assert_int_equal(read, 0);
    must_fail(duet_world_get_pair_buffers(world, &buffers, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    clReleaseEvent(done);
}

TEST(between_the_halves_of_a_step_nothing_else_is_taken)
{
    duet_result result;
    duet_pair_buffers buffers;
    duet_profile profile;
    char *why = NULL;
    cl_event done = NULL;
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    duet_world *world = make_world(pair, duet_default_world_def());
    cl_mem mem = own_buffer(poses, sizeof poses, CL_MEM_READ_WRITE);
    must_fail(duet_world_step_end(world, &result, ERR), DUET_STATUS_BAD_ARGUMENT,
              "no step is under way");
    // It is under way as long as its objects are not there.
    cl_event gate = clCreateUserEvent(own.context, NULL);
    const duet_plan plan = *duet_world_get_plan(world);
    must(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, mem, N, 1, &gate, ERR));
    must(duet_world_step_begin(world, ERR));
    assert_null(duet_world_get_plan(world));
    assert_int_equal(duet_world_get_level(world), DUET_LEVEL_CERTIFIED);
#define REFUSED(call) \
    must_fail(call, DUET_STATUS_BAD_ARGUMENT, "is under way; expected duet_world_step_end first")
    REFUSED(duet_world_step(world, &result, ERR));
    REFUSED(duet_world_step_begin(world, ERR));
    REFUSED(duet_world_step_begin_event(world, &done, ERR));
    REFUSED(duet_world_map_objects(world, DUET_OBJECT_POSES, N, ERR));
    REFUSED(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, N, ERR));
    REFUSED(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, mem, N, 0, NULL, ERR));
    REFUSED(duet_world_set_plan(world, &plan, ERR));
    REFUSED(duet_world_set_level(world, DUET_LEVEL_AABB, ERR));
    REFUSED(duet_world_leave_pairs(world, 0, NULL, NULL, ERR));
    REFUSED(duet_world_bring_pairs(world, ERR));
    REFUSED(duet_world_get_pair_buffers(world, &buffers, ERR));
    REFUSED(duet_world_load_profile(world, NULL, &profile, ERR));
    REFUSED(duet_world_explain_profile(world, NULL, &why, ERR));
    clSetUserEventStatus(gate, CL_COMPLETE);
    clReleaseEvent(gate);
    must(duet_world_step_end(world, &result, ERR));
    must(duet_world_step_begin(world, ERR));
}

// ------------------------------------------------------------ states

TEST(states_are_copied_into_a_buffer)
{
    enum { SOME = 20 };
    duet_motion_result result;
    duet_state states[SOME];
    float rows[SOME][4];
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    duet_motion_def def = duet_default_motion_def();
    def.pair = pair;
    def.gravity[1] = -10.0;
    duet_motion *motion = kept(duet_motion_create(&def, poses, NULL, SOME, ERR));
    cl_mem mem = own_buffer(NULL, sizeof rows, CL_MEM_READ_WRITE);
    cl_mem small = own_buffer(NULL, sizeof rows - 1, CL_MEM_READ_WRITE);
    for (int i = 0; i < 2; ++i) {
        cl_event gate = clCreateUserEvent(own.context, NULL), done = NULL;
        must(duet_motion_advance(motion, &result, ERR));
        clSetUserEventStatus(gate, CL_COMPLETE);
        must(duet_motion_copy_states(motion, DUET_STATE_CENTRES, mem, 1, &gate, i ? &done : NULL,
                                     ERR));
        own_read(0, mem, rows, sizeof rows, i ? &done : NULL);
        must(duet_motion_get_states(motion, states, ERR));
        for (int id = 0; id < SOME; ++id)
            for (int k = 0; k < 3; ++k)
                assert_true((double)rows[id][k] == states[id].centre[k]);
        clReleaseEvent(gate);
        if (done)
            clReleaseEvent(done);
    }
    must_fail(duet_motion_copy_states(motion, DUET_STATE_CENTRES, small, 0, NULL, NULL, ERR),
              DUET_STATUS_BAD_ARGUMENT, "rows has 319 bytes; expected at least 320");
    must_fail(
        duet_motion_copy_states(motion, DUET_STATE_ANGULAR_VELOCITIES, mem, 0, NULL, NULL, ERR),
        DUET_STATUS_BAD_ARGUMENT, "needs the effect angular_velocity");
    test_give_back(small);
    test_give_back(mem);
}

// ------------------------------------------------------------ misuse

TEST(what_is_no_fit_buffer_is_refused_by_name)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    duet_device_pair *pair = open_queues(own.queues[0], own.queues[1]);
    duet_world *world = make_world(pair, duet_default_world_def());
    cl_context other = clCreateContext(NULL, 1, &own.root, NULL, NULL, NULL);
    cl_mem foreign = clCreateBuffer(other, CL_MEM_READ_WRITE, sizeof poses, NULL, NULL);
    cl_event event = clCreateUserEvent(other, NULL);
    cl_mem small = own_buffer(NULL, 79, CL_MEM_READ_WRITE);
    cl_mem tiny = own_buffer(NULL, 4, CL_MEM_READ_WRITE);
    cl_mem unread = own_buffer(NULL, sizeof poses, CL_MEM_WRITE_ONLY);
    cl_mem unwritten = own_buffer(NULL, sizeof poses, CL_MEM_READ_ONLY);
    cl_mem hidden = own_buffer(NULL, sizeof poses, CL_MEM_READ_WRITE | CL_MEM_HOST_NO_ACCESS);
    const struct {
        cl_mem objects;
        const char *says;
    } objects[] = {{NULL, "objects is NULL"},
                   {foreign, "objects is of another context; expected that of"},
                   {small, "objects has 79 bytes; expected at least 80"},
                   {unread, "objects cannot be read by devices"},
                   {hidden, "objects cannot be read by the host"}};
    for (size_t i = 0; i < sizeof objects / sizeof *objects; ++i) {
        must_fail(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, objects[i].objects, 2, 0,
                                                NULL, ERR),
                  DUET_STATUS_BAD_ARGUMENT, objects[i].says);
        assert_says(ERR->text, "duet_world_set_objects_buffer: ");
    }
    const struct {
        cl_mem pairs, count;
        const char *says;
    } outputs[] = {{foreign, NULL, "pairs is of another context"},
                   {tiny, NULL, "pairs has 4 bytes; expected at least 8"},
                   {unwritten, NULL, "pairs cannot be written by devices"},
                   {NULL, foreign, "count is of another context"},
                   {NULL, tiny, "count has 4 bytes; expected at least 8"},
                   {small, unwritten, "count cannot be written by devices"}};
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; ++i)
        must_fail(duet_world_leave_pairs(world, 0, outputs[i].pairs, outputs[i].count, ERR),
                  DUET_STATUS_BAD_ARGUMENT, outputs[i].says);
    must_fail(duet_world_leave_pairs(world, 2, NULL, NULL, ERR), DUET_STATUS_BAD_ARGUMENT,
              "device is 2; expected 0 for A, 1 for B");
    must_fail(duet_world_set_objects_buffer(world, DUET_OBJECT_POSES, unwritten, 2, 1, &event, ERR),
              DUET_STATUS_BAD_ARGUMENT, "event 0 of 1 is of another context");
    must_fail(duet_world_set_objects_buffer(world, DUET_OBJECT_BOUNDS, unwritten, 2, 0, NULL, ERR),
              DUET_STATUS_BAD_ARGUMENT, "the world was made for poses, not for bounds");
    def.cookie = 0;
    must_fail(duet_device_pair_create_on_queues(&def, own.queues[0], NULL, ERR),
              DUET_STATUS_BAD_ARGUMENT, "begins with duet_default_device_pair_def");
    test_give_back(world);
    test_give_back(pair);
    cl_mem mems[] = {foreign, small, tiny, unread, unwritten, hidden};
    for (size_t i = 0; i < sizeof mems / sizeof *mems; ++i)
        assert_int_equal(own_references(mems[i]), 1);
    clReleaseMemObject(foreign);
    clReleaseEvent(event);
    clReleaseContext(other);
}

TEST_EACH(NULL, test_leaves_no_object)
TEST_BEGIN(open_program)
