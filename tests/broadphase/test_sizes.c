// SPDX-License-Identifier: MIT
// Sizes apart from transforms: the pairs of whole poses, and sizes travel once.
#include "support/devices.h"
#include "support/test.h"

#include "base/budget.h"
#include "runtime/broadphase/world.h"

enum { CAPACITY = 3000 };

static bool have_host_memory[2];
static duet_pose poses[CAPACITY];
static bool compact; // worlds have compact transforms

static void begin(void)
{
    for (int side = 0; side < 2; ++side)
        have_host_memory[side] = default_pair()->devices[side].info.host_memory;
}

// Devices that work on host memory borrow what others are sent; they can be told
// that they do not.
static void tell_of_memory(bool host)
{
    for (int side = 0; side < 2; ++side)
        default_pair()->devices[side].info.host_memory = host && have_host_memory[side];
}

static void fill(rng *r, uint32_t n, uint32_t dims)
{
    double edge = dims == 3 ? 1.6 * cbrt(n) : 1.4 * sqrt(n);
    for (uint32_t i = 0; i < n; ++i) {
        poses[i] = (duet_pose){0};
        for (int k = 0; k < 3; ++k) {
            poses[i].centre[k] = (float)rng_between(r, 0.0, edge);
            poses[i].half_extents[k] = (float)rng_between(r, 0.3, 0.6);
        }
        turn_at_random(&poses[i], r);
        // Has any length; the last word is odd, so that none is zero.
        for (int k = 0; compact && k < 4; ++k)
            poses[i].rotation[k] =
                (float)((int16_t)(rng_next(r) >> 16 >> rng_below(r, 16)) | (k == 3));
    }
}

static duet_world *make_world(uint32_t dims, duet_mode mode, const char *text)
{
    duet_world_def def = devices_def(dims);
    def.plan = plan_of(mode, DUET_SHARE_ONE / 3, text, text);
    def.pose_form = compact ? DUET_POSE_COMPACT : DUET_POSE_TRANSFORM;
    return create_world(&def);
}

static void map_compact_transforms(duet_world *world, uint32_t n)
{
    duet_compact_transform *to =
        must(duet_world_map_objects(world, DUET_OBJECT_COMPACT_TRANSFORMS, n, ERR));
    for (uint32_t i = 0; i < n; ++i) {
        memcpy(to[i].centre, poses[i].centre, sizeof to->centre);
        for (int k = 0; k < 4; ++k)
            to[i].rotation[k] = (int16_t)poses[i].rotation[k];
    }
}

static void map_transforms(duet_world *world, uint32_t n)
{
    if (compact) {
        map_compact_transforms(world, n);
        return;
    }
    duet_transform *to = must(duet_world_map_objects(world, DUET_OBJECT_TRANSFORMS, n, ERR));
    for (uint32_t i = 0; i < n; ++i) {
        memcpy(to[i].centre, poses[i].centre, sizeof to->centre);
        memcpy(to[i].rotation, poses[i].rotation, sizeof to->rotation);
    }
}

static duet_size *map_sizes(duet_world *world, uint32_t n)
{
    duet_size *to = must(duet_world_map_objects(world, DUET_OBJECT_SIZES, n, ERR));
    for (uint32_t i = 0; i < n; ++i)
        memcpy(to[i].half_extents, poses[i].half_extents, sizeof to->half_extents);
    return to;
}

static void assert_step_is_the_reference(duet_world *world, uint32_t n)
{
    assert_step_finds(world, known_pairs_of(DUET_OBJECT_POSES, poses, n, world->def.dims));
}

// ------------------------------------------------------------ facts

// Transforms move, sizes stay, then sizes change too.
static void follow(uint32_t dims, duet_mode mode, const char *text, rng *r)
{
    static const uint32_t numbers[] = {1, 7, 1031, CAPACITY};
    duet_world *world = make_world(dims, mode, text);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        uint32_t n = numbers[i];
        fill(r, n, dims);
        map_sizes(world, n);
        map_transforms(world, n);
        assert_step_is_the_reference(world, n);
        for (uint32_t k = 0; k < n; ++k)
            poses[k].centre[k % 2] += (float)rng_between(r, -0.5, 0.5);
        map_transforms(world, n);
        assert_step_is_the_reference(world, n);
    }
    for (uint32_t k = 0; k < CAPACITY; ++k)
        poses[k].half_extents[k % 3] *= 1.5f;
    map_sizes(world, CAPACITY);
    assert_step_is_the_reference(world, CAPACITY);
}

static void follow_plans(void)
{
    static const struct {
        duet_mode mode;
        const char *variant;
    } plans[] = {
        {DUET_MODE_OWN, "gpu"},
        {DUET_MODE_SLAB, "simd"},
        {DUET_MODE_SHARED, "gpu"},
        {DUET_MODE_OWN, "simd sort=radix"},
        {DUET_MODE_SLAB, "gpu send=packed"},
    };
    rng r = {test_seed()};
    for (int host = 0; host < 2; ++host) {
        tell_of_memory(host);
        for (size_t p = 0; p < sizeof plans / sizeof *plans; ++p)
            follow(p % 2 ? 2 : 3, plans[p].mode, plans[p].variant, &r);
    }
}

TEST(transforms_and_sizes_have_the_pairs_of_their_poses)
{
    follow_plans();
}

TEST(compact_transforms_have_the_pairs_of_their_poses)
{
    compact = true;
    follow_plans();
    compact = false;
}

// The angle between two rotations, in double.
static double turned(const float q[4], const int16_t c[4])
{
    double dot = 0, qq = 0, cc = 0;
    for (int k = 0; k < 4; ++k) {
        dot += (double)q[k] * c[k];
        qq += (double)q[k] * (double)q[k];
        cc += (double)c[k] * c[k];
    }
    double across = 0; // |q|^2 |c|^2 - (q c)^2, as a sum of squares
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < i; ++k)
            across += pow((double)q[i] * c[k] - (double)q[k] * c[i], 2);
    return 2 * atan2(sqrt(across), fabs(dot)) * (qq > 0 && cc > 0);
}

TEST(the_nearest_compact_transform_is_as_near_as_is_said)
{
    rng r = {test_seed()};
    double worst = 0;
    for (int i = 0; i < 200000; ++i) {
        duet_transform t = {.centre = {1, 2, 3}};
        double length = exp(rng_between(&r, -60, 60));
        for (int k = 0; k < 4; ++k)
            t.rotation[k] = (float)(length * (rng_below(&r, 5) ? rng_normal(&r) : i % 3 - 1));
        t.rotation[rng_below(&r, 4)] = (float)length;
        duet_compact_transform c;
        must(duet_compact_transform_set(&c, &t, ERR));
        assert_memory_equal(c.centre, t.centre, sizeof c.centre);
        worst = fmax(worst, turned(t.rotation, c.rotation));
    }
    assert_true(worst <= 5.3e-5);
    assert_true(worst > 3e-5); // else less could be said
}

TEST(what_has_no_rotation_has_no_compact_one)
{
    static const float wrong[][4] = {{0, 0, 0, 0}, {NAN, 0, 0, 1}, {0, 0, INFINITY, 1}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        duet_transform t = {{0}, {0}};
        duet_compact_transform c;
        memcpy(t.rotation, wrong[i], sizeof t.rotation);
        must_fail(duet_compact_transform_set(&c, &t, ERR), DUET_STATUS_BAD_OBJECT, "");
    }
    // The same pose in a compact world is a bad object of the step.
    compact = true;
    duet_result result;
    duet_world *world = make_world(3, DUET_MODE_OWN, "gpu");
    const duet_pose still = {.half_extents = {1, 1, 1}};
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, &still, 1, ERR));
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "");
    compact = false;
}

TEST(sizes_are_sent_once)
{
    duet_error err = {0};
    duet_result result;
    rng r = {test_seed()};
    tell_of_memory(false);
    duet_world *world = make_world(3, DUET_MODE_OWN, "gpu");
    fill(&r, CAPACITY, 3);
    duet_size *sizes = map_sizes(world, CAPACITY);
    map_transforms(world, CAPACITY);
    assert_step_is_the_reference(world, CAPACITY);
    // A change behind the world's back is not looked at.
    for (uint32_t i = 0; i < CAPACITY; ++i)
        sizes[i] = (duet_size){{-1.0f, -1.0f, -1.0f}};
    map_transforms(world, CAPACITY);
    assert_step_is_the_reference(world, CAPACITY);
    assert_true(duet_world_map_objects(world, DUET_OBJECT_SIZES, CAPACITY, &err) == sizes);
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT, "");
}

TEST(poses_are_taken_apart)
{
    rng r = {test_seed()};
    tell_of_memory(true);
    duet_world *world = make_world(3, DUET_MODE_OWN, "simd");
    fill(&r, CAPACITY, 3);
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, poses, CAPACITY, ERR));
    assert_step_is_the_reference(world, CAPACITY);
}

// Cubes that touch, all turned the same way: float cannot tell, and the host
// decides with the sizes.
TEST(what_float_leaves_open_is_decided)
{
    enum { SIDE = 10, N = SIDE * SIDE * SIDE };
    duet_result result;
    for (uint32_t i = 0; i < N; ++i) {
        float x = (float)(i % SIDE), y = (float)(i / SIDE % SIDE), z = (float)(i / SIDE / SIDE);
        poses[i] = (duet_pose){{0.6f * x - 0.8f * y, 0.8f * x + 0.6f * y, z},
                               {0.5f, 0.5f, 0.5f},
                               {0.0f, 0.0f, 1.0f, 2.0f}};
    }
    tell_of_memory(false);
    duet_world *world = make_world(3, DUET_MODE_OWN, "gpu");
    map_transforms(world, N);
    map_sizes(world, N);
    assert_step_is_the_reference(world, N);
    must(duet_world_step(world, &result, ERR));
    assert_true(result.undecided > 0);
}

TEST(bad_sizes_are_named)
{
    duet_result result;
    rng r = {test_seed()};
    fill(&r, CAPACITY, 3);
    poses[77].half_extents[1] = -0.25f;
    poses[78].half_extents[0] = NAN;
    for (int host = 0; host < 2; ++host) {
        tell_of_memory(host);
        duet_world *world = make_world(3, DUET_MODE_SLAB, host ? "simd" : "gpu");
        map_transforms(world, CAPACITY);
        map_sizes(world, CAPACITY);
        must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_OBJECT,
                  "object 77 of 3000");
        assert_says(ERR->text, "(2 such objects)");
    }
}

TEST(as_many_sizes_as_transforms)
{
    duet_result result;
    rng r = {test_seed()};
    fill(&r, CAPACITY, 3);
    tell_of_memory(true);
    duet_world *world = make_world(3, DUET_MODE_OWN, "simd");
    map_transforms(world, 10);
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "10 objects have a transform and 0 a size; expected as "
                                   "many of each");
    duet_profile profile;
    must_fail(duet_world_load_profile(world, "test_sizes.none.db", &profile, ERR),
              DUET_STATUS_BAD_ARGUMENT, "");
    map_sizes(world, 10);
    must(duet_world_load_profile(world, "test_sizes.none.db", &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_DEFAULT);
    assert_step_is_the_reference(world, 10);
}

static void assert_has_no_sizes(duet_world *world)
{
    duet_result result;
    must_fail(duet_world_step(world, &result, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    assert_string_equal(ERR->text, "10 objects have a transform and 0 a size; expected as "
                                   "many of each");
    map_sizes(world, 10);
    assert_step_is_the_reference(world, 10);
}

static duet_world *make_world_of_ten(void)
{
    rng r = {test_seed()};
    fill(&r, CAPACITY, 3);
    tell_of_memory(true);
    duet_world *world = make_world(3, DUET_MODE_OWN, "simd");
    map_transforms(world, 10);
    map_sizes(world, 10);
    assert_step_is_the_reference(world, 10);
    return world;
}

// The number is as before, but their memory is gone.
TEST(sizes_without_memory_are_none)
{
    duet_error err = {0};
    duet_world *world = make_world_of_ten();
    budget none = {.deadline_ns = UINT64_MAX, .host_bytes = 1};
    for (int side = 0; side < 2; ++side)
        default_pair()->devices[side].info.host_memory =
            true; // plain memory, which a budget counts
    budget_enter(&none);
    void *sizes = duet_world_map_objects(world, DUET_OBJECT_SIZES, CAPACITY, &err);
    budget_leave(&none);
    tell_of_memory(true);
    assert_null(sizes);
    assert_int_equal(err.status, DUET_STATUS_NO_MEMORY);
    assert_has_no_sizes(world);
}

TEST(sizes_that_were_not_fetched_are_none)
{
    cl_int code = CL_SUCCESS;
    duet_world *world = make_world_of_ten();
    cl_context context = default_pair()->devices[1].context;
    cl_mem mem = clCreateBuffer(context, CL_MEM_READ_WRITE, 10 * sizeof(duet_size), NULL, &code);
    assert_int_equal(code, CL_SUCCESS);
    cl_event failed = clCreateUserEvent(context, &code);
    assert_int_equal(code, CL_SUCCESS);
    assert_int_equal(clSetUserEventStatus(failed, -1), CL_SUCCESS);
    must_fail(duet_world_set_objects_buffer(world, DUET_OBJECT_SIZES, mem, 10, 1, &failed, ERR),
              DUET_STATUS_DEVICE_FAILED, "");
    assert_has_no_sizes(world);
    clReleaseEvent(failed);
    clReleaseMemObject(mem);
}

static void refuse(duet_world_def def, const char *why)
{
    def.pose_form = DUET_POSE_TRANSFORM;
    must_fail(duet_world_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT, why);
}

TEST(only_what_has_sizes_has_them_apart)
{
    duet_world_def def = devices_def(3);
    duet_world_def other = def;
    other.pose_form = (duet_pose_form)7;
    must_fail(duet_world_create(&other, ERR), DUET_STATUS_BAD_ARGUMENT,
              "pose_form is 7; expected a duet_pose_form");
    other = def;
    other.shape = DUET_SHAPE_BOUNDS;
    refuse(other, "pose_form is for poses");
    other = def;
    other.origin_edge = 1.0f;
    refuse(other, "pose_form is for poses");
    other = def;
    strcpy(other.plan.variant_b, "paper");
    refuse(other, "the paper's search knows no sizes apart");
    duet_world *world = make_world(3, DUET_MODE_OWN, "simd");
    must_fail(duet_world_map_objects(world, DUET_OBJECT_POSES, 1, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_string_equal(ERR->text, "the world was made for transforms, not for poses");
    world = create_world(&def);
    must_fail(duet_world_map_objects(world, DUET_OBJECT_SIZES, 1, ERR), DUET_STATUS_BAD_ARGUMENT,
              "");
    assert_string_equal(ERR->text, "the world was made for poses, not for sizes");
}

TEST_BEGIN(begin)
