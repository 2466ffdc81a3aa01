// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "runtime/selection/profile_subject.h"
#include "support/simulated_pair.h"
#include "tuner/online.h"
#include "tuner/record.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define STORE "test_online.db"

// Frames by a model; gives the longest, in units of what the share that was
// kept before would take.
static double run_frames(online *o, const simulated_pair *model, rng *r, uint32_t n)
{
    double longest = 0;
    for (uint32_t i = 0; i < n; ++i) {
        duet_error err = {0};
        uint32_t share, kept = o->share;
        assert_ok(online_share(o, &share, &err), err);
        search_sample frame = simulated_launch(model, share, r);
        assert_ok(online_tell(o, &frame, &err), err);
        double plain = (double)simulated_launch(model, kept, NULL).total_ns;
        longest = fmax(longest, (double)frame.total_ns / plain);
    }
    return longest;
}

static void a_device_that_slows_down_gets_less_work(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    simulated_pair even = {.ratio = 1, .sigma = 0.03}, slowed = {.ratio = 5, .sigma = 0.03};
    online o = online_begin(SEARCH_ONE / 2, 0.1);
    run_frames(&o, &even, &r, 100);
    assert_int_equal(o.tunings, 0);
    assert_int_equal(o.share, SEARCH_ONE / 2);
    run_frames(&o, &slowed, &r, 60);
    assert_true(o.tunings >= 1);
    assert_true(simulated_excess(&slowed, o.share) < 0.08);
    run_frames(&o, &even, &r, 60);
    assert_true(simulated_excess(&even, o.share) < 0.08);
    online_end(&o);
}

static void a_steady_machine_is_seldom_tuned_again(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    simulated_pair model = {.ratio = 3, .sigma = 0.05, .spike_chance = 0.03, .spike_most = 3};
    online o = online_begin(SEARCH_ONE / 4, 0.1);
    run_frames(&o, &model, &r, 5000);
    print_message("%u tunings in 5000 frames\n", o.tunings);
    assert_true(o.tunings <= 10);
    assert_true(simulated_excess(&model, o.share) < 0.1);
    online_end(&o);
}

static void a_trial_costs_no_more_than_was_allowed(void **state)
{
    (void)state;
    static const double ratios[] = {0.1, 0.5, 3, 10};
    for (int i = 0; i < 4; ++i) {
        simulated_pair even = {.ratio = 1}, moved = {.ratio = ratios[i]};
        online o = online_begin(SEARCH_ONE / 2, 0.1);
        run_frames(&o, &even, NULL, 40);
        assert_true(run_frames(&o, &moved, NULL, 100) <= 1.11);
        assert_true(simulated_excess(&moved, o.share) < 0.1);
        online_end(&o);
    }
}

static void a_plan_of_one_device_stays(void **state)
{
    (void)state;
    simulated_pair fast = {.ratio = 4}, slow = {.ratio = 4, .fixed = {0, 0}};
    online o = online_begin(0, 0.1);
    run_frames(&o, &fast, NULL, 50);
    slow.waves[1] = 3;
    run_frames(&o, &slow, NULL, 50);
    assert_int_equal(o.share, 0);
    assert_int_equal(o.tunings, 0);
    online_end(&o);
}

// ---------------------------------------------------------------- on a world

enum { BOXES = 500 };

typedef struct fixture {
    duet_device_pair *pair;
    duet_world *world;
} fixture;

static void remove_store(void)
{
    static const char *const files[] = {STORE, STORE "-wal", STORE "-shm"};
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i)
        remove(files[i]);
}

static void make_world(fixture *f)
{
    duet_error err = {0};
    duet_device_pair_def devices = duet_default_device_pair_def();
    duet_world_def def = duet_default_world_def();
    assert_ok((f->pair = duet_device_pair_create(&devices, &err)), err);
    def.pair = f->pair;
    def.plan.share = DUET_SHARE_ONE / 2;
    assert_ok((f->world = duet_world_create(&def, &err)), err);
    rng r = rng_seed(test_seed());
    duet_pose *poses = duet_world_map_objects(f->world, DUET_OBJECT_POSES, BOXES, &err);
    assert_non_null(poses);
    for (int i = 0; i < BOXES; ++i) {
        poses[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0, 1}};
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 0, 8);
    }
}

static void destroy_world(fixture *f)
{
    duet_world_destroy(f->world);
    duet_device_pair_destroy(f->pair);
}

static void steps_find_the_same_pairs_while_the_share_is_watched(void **state)
{
    (void)state;
    fixture f;
    duet_error err = {0};
    duet_result plain, watched;
    make_world(&f);
    assert_ok(duet_world_step(f.world, &plain, &err), err);
    uint64_t hash = duet_result_get_hash(&plain);
    duet_online_def def = duet_default_online_def();
    def.world = f.world;
    duet_online *watching = duet_online_create(&def, &err);
    assert_non_null(watching);
    for (int i = 0; i < 100; ++i) {
        assert_ok(duet_online_step(watching, &watched, &err), err);
        assert_true(duet_result_get_hash(&watched) == hash);
    }
    assert_ok(duet_online_destroy(watching, &err), err);
    destroy_world(&f);
}

// As a tuning leaves it.
static void put_tuned(record *r, const duet_plan *plan, const char *level)
{
    duet_error err = {0};
    profile_row row = {
        .pair_id = r->pair_id,
        .workload_id = r->workload_id,
        .kernels = r->request.kernels,
        .objective = r->request.objective,
        .plan = profile_subject_write_plan(plan, level),
        .median_ns = 3e6,
        .low_ns = 3e6,
        .high_ns = 3e6,
        .gain = 0.3,
        .gain_low = 0.2,
        .gain_high = 0.4,
        .verdict = "faster",
        .rounds = 20,
        .origin = "manual",
        .trial_number = -1,
    };
    assert_ok(profile_put(r->store, &row, NULL, "tuned again", NULL, &err), err);
}

// A share that nobody compared with one device alone is not followed.
static void what_was_learned_is_loaded_at_the_next_start_of_what_was_tuned(void **state)
{
    (void)state;
    fixture f;
    profile_subject known;
    record r;
    duet_profile profile;
    duet_error err = {0};
    remove_store();
    make_world(&f);
    assert_ok(profile_subject_read(f.world, &known, &err), err);
    profile_request request = profile_subject_request(&known);
    duet_plan plan = *duet_world_get_plan(f.world);
    for (int tuned = 0; tuned < 2; ++tuned) {
        plan.share = 12345;
        assert_ok(record_open(&r, STORE, &err) && record_aim(&r, &request, &err), err);
        if (tuned)
            put_tuned(&r, duet_world_get_plan(f.world), "certified");
        assert_ok(record_online(&r, &plan, 2e6, &err), err);
        record_close(&r);
        assert_ok(duet_world_load_profile(f.world, STORE, &profile, &err), err);
        assert_int_equal(profile.grade, tuned ? DUET_GRADE_EXACT : DUET_GRADE_DEFAULT);
        assert_int_equal(duet_world_get_plan(f.world)->share, tuned ? 12345 : DUET_SHARE_ONE / 2);
    }
    assert_string_equal(profile.verdict, "faster");
    destroy_world(&f);
    remove_store();
}

static void a_def_that_is_no_def_is_refused(void **state)
{
    (void)state;
    duet_online_def zero = {0};
    duet_error err = {0};
    assert_null(duet_online_create(&zero, &err));
    assert_int_equal(err.status, DUET_STATUS_BAD_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_device_that_slows_down_gets_less_work),
        cmocka_unit_test(a_steady_machine_is_seldom_tuned_again),
        cmocka_unit_test(a_trial_costs_no_more_than_was_allowed),
        cmocka_unit_test(a_plan_of_one_device_stays),
        cmocka_unit_test(steps_find_the_same_pairs_while_the_share_is_watched),
        cmocka_unit_test(what_was_learned_is_loaded_at_the_next_start_of_what_was_tuned),
        cmocka_unit_test(a_def_that_is_no_def_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
