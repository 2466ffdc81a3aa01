// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "runtime/selection/profile_subject.h"
#include "support/simulated_pair.h"
#include "tuner/online.h"
#include "tuner/record.h"

#define STORE "test_online.db"

// Two devices that are only arithmetic, with a model for each mode, and kernels that take so many
// times as long on each device.
typedef struct machine {
    simulated_pair modes[PLAN_MODES];
    double kernels[2][PLAN_VARIANTS];
    double slower[2]; // slowdown by what the devices do besides
    double switch_ns; // that a frame takes longer after one with other kernels
    listed_plan last;
    rng *r;          // NULL: without noise
    uint32_t frames; // so far
} machine;

enum { KERNELS = 2 };

static machine make_machine(const simulated_pair *model, rng *r)
{
    machine m = {.r = r, .slower = {1, 1}};
    for (int i = 0; i < PLAN_MODES; ++i)
        m.modes[i] = *model;
    for (int i = 0; i < 2 * PLAN_VARIANTS; ++i)
        m.kernels[i / PLAN_VARIANTS][i % PLAN_VARIANTS] = 1;
    return m;
}

static bool launch(void *context, const listed_plan *plan, search_sample *frame)
{
    machine *m = context;
    simulated_pair model = m->modes[plan->mode];
    ++m->frames;
    if (plan->share == 0 || plan->share == SEARCH_ONE)
        model = m->modes[DUET_MODE_OWN];
    *frame = simulated_launch(&model, plan->share, m->r);
    frame->a_ns = (uint64_t)((double)frame->a_ns * m->slower[0] * m->kernels[0][plan->variant[0]]);
    frame->b_ns = (uint64_t)((double)frame->b_ns * m->slower[1] * m->kernels[1][plan->variant[1]]);
    frame->total_ns = frame->a_ns > frame->b_ns ? frame->a_ns : frame->b_ns;
    if (m->last.mode != plan->mode || memcmp(m->last.variant, plan->variant, sizeof plan->variant))
        frame->total_ns += (uint64_t)m->switch_ns;
    m->last = *plan;
    return true;
}

// Without noise.
static double time_of(const machine *m, const listed_plan *plan)
{
    machine quiet = *m;
    search_sample frame;
    quiet.r = NULL;
    quiet.switch_ns = 0;
    launch(&quiet, plan, &frame);
    return (double)frame.total_ns;
}

// Goes over all modes, kernels and shares.
static double best_time(const machine *m)
{
    double best = INFINITY;
    for (uint32_t i = 0; i < PLAN_MODES * KERNELS * KERNELS; ++i) {
        listed_plan plan = {0, i / (KERNELS * KERNELS), {i / KERNELS % KERNELS, i % KERNELS}};
        if (plan.mode == DUET_MODE_SHARED && plan.variant[0] != plan.variant[1])
            continue;
        for (; plan.share <= SEARCH_ONE; plan.share += 64)
            best = fmin(best, time_of(m, &plan));
    }
    return best;
}

static double excess_of(const machine *m, const online *o)
{
    return time_of(m, &o->plan) / best_time(m) - 1;
}

// The cost of other plans than the kept one, in units of what that one takes.
typedef struct trials {
    double longest;
    uint32_t n;
    uint32_t long_ones; // longer than was allowed
} trials;

static trials run_on(online *o, machine *m, uint32_t n)
{
    trials tried = {.longest = 1};
    for (uint32_t i = 0; i < n; ++i) {
        listed_plan plan, kept = o->plan;
        search_sample frame;
        must(online_plan(o, &plan, ERR));
        launch(m, &plan, &frame);
        must(online_tell(o, &frame, ERR));
        double ratio =
            fmax(time_of(m, &plan), m->r ? 0 : (double)frame.total_ns) / time_of(m, &kept);
        tried.longest = fmax(tried.longest, ratio);
        tried.n += memcmp(&plan, &kept, sizeof plan) != 0;
        tried.long_ones += ratio > 1.12;
    }
    return tried;
}

static online begin_at(uint32_t share)
{
    listed_plan plan = {.share = share, .mode = DUET_MODE_OWN};
    return online_begin(&plan, 0.1);
}

// Does as create does where the world has objects.
static online begin_learned(const listed_plan *plan, machine *m)
{
    online o = online_begin(plan, 0.1);
    const plan_runner runner = {m, launch};
    search_sample frame;
    plan_times_learn(&o.times, KERNELS, (1u << PLAN_MODES) - 1, &runner);
    launch(m, plan, &frame);
    return o;
}

TEST(a_device_that_slows_down_gets_less_work)
{
    rng r = rng_seed(test_seed());
    machine m = make_machine(&(simulated_pair){.ratio = 1, .sigma = 0.03}, &r);
    online o = begin_at(SEARCH_ONE / 2);
    run_on(&o, &m, 100);
    assert_int_equal(o.tunings, 0);
    assert_int_equal(o.plan.share, SEARCH_ONE / 2);
    m.slower[0] = 5;
    run_on(&o, &m, 60);
    assert_true(o.tunings >= 1);
    assert_true(excess_of(&m, &o) < 0.08);
    m.slower[0] = 1;
    run_on(&o, &m, 60);
    assert_true(excess_of(&m, &o) < 0.08);
    online_end(&o);
}

TEST(a_steady_machine_is_seldom_tuned_again)
{
    rng r = rng_seed(test_seed());
    simulated_pair model = {.ratio = 3, .sigma = 0.05, .spike_chance = 0.03, .spike_most = 3};
    machine m = make_machine(&model, &r);
    online o = begin_at(SEARCH_ONE / 4);
    run_on(&o, &m, 5000);
    print_message("%u tunings in 5000 frames\n", o.tunings);
    assert_true(o.tunings <= 10);
    assert_true(excess_of(&m, &o) < 0.1);
    online_end(&o);
}

TEST(a_trial_costs_no_more_than_was_allowed)
{
    static const double slower[] = {0.1, 0.5, 3, 10};
    for (int i = 0; i < 4; ++i) {
        machine m = make_machine(&(simulated_pair){.ratio = 1}, NULL);
        online o = begin_at(SEARCH_ONE / 2);
        run_on(&o, &m, 40);
        m.slower[0] = slower[i];
        assert_true(run_on(&o, &m, 100).longest <= 1.11);
        assert_true(excess_of(&m, &o) < 0.1);
        online_end(&o);
    }
}

TEST(a_plan_of_one_device_stays_if_nothing_is_known_of_others)
{
    machine m = make_machine(&(simulated_pair){.ratio = 4}, NULL);
    online o = begin_at(0);
    run_on(&o, &m, 50);
    m.slower[1] = 3;
    run_on(&o, &m, 500);
    assert_int_equal(o.plan.share, 0);
    assert_int_equal(o.tunings, 0);
    online_end(&o);
}

// ---------------------------------------------------------------- modes, kernels, one device

static listed_plan any_plan(rng *r)
{
    static const uint32_t shares[] = {0, SEARCH_ONE / 16, SEARCH_ONE / 2, SEARCH_ONE};
    listed_plan plan = {.share = shares[rng_below(r, 4)], .mode = (uint32_t)rng_below(r, 3)};
    plan.variant[0] = (uint32_t)rng_below(r, KERNELS);
    plan.variant[1] = (uint32_t)rng_below(r, KERNELS);
    if (plan.share == 0 || plan.share == SEARCH_ONE || plan.variant[0] != plan.variant[1])
        plan.mode = DUET_MODE_OWN;
    return plan;
}

// Each mode has overheads of its own, and each device one kernel that is quicker.
static machine any_machine(rng *r, double sigma)
{
    simulated_pair model = {.ratio = pow(16, rng_between(r, -1, 1)), .sigma = sigma};
    machine m = make_machine(&model, r);
    for (int mode = 0; mode < PLAN_MODES; ++mode)
        for (int device = 0; device < 2; ++device)
            m.modes[mode].overhead[device] = rng_between(r, 0, 0.3) * fmin(model.ratio, 1);
    for (int device = 0; device < 2; ++device)
        m.kernels[device][rng_below(r, KERNELS)] = rng_between(r, 1, 2);
    return m;
}

TEST(any_start_leads_to_the_best_mode_kernels_and_share)
{
    rng r = rng_seed(test_seed());
    double worst = 0, sum = 0;
    uint32_t near = 0;
    enum { MACHINES = 200 };
    for (int i = 0; i < MACHINES; ++i) {
        machine m = any_machine(&r, 0.02);
        listed_plan start = any_plan(&r);
        online o = begin_learned(&start, &m);
        run_on(&o, &m, 1500);
        double excess = excess_of(&m, &o);
        sum += excess;
        worst = fmax(worst, excess);
        near += excess < 0.05;
        online_end(&o);
    }
    print_message("above the best plan: mean %.2f %%, most %.2f %%\n", 100 * sum / MACHINES,
                  100 * worst);
    assert_true(sum / MACHINES < 0.02);
    assert_true(near >= MACHINES * 95 / 100);
}

// A device slows down and recovers; plans of one device are left and come back.
TEST(other_plans_are_followed_when_devices_change)
{
    rng r = rng_seed(test_seed());
    uint32_t alone = 0, shared = 0, near = 0;
    enum { MACHINES = 100, CHANGES = 4 };
    for (int i = 0; i < MACHINES; ++i) {
        machine m = any_machine(&r, 0.02);
        listed_plan start = any_plan(&r);
        online o = begin_learned(&start, &m);
        for (int change = 0; change < CHANGES; ++change) {
            m.slower[rng_below(&r, 2)] = pow(8, rng_between(&r, -1, 1));
            bool was_shared = plan_is_shared(&o.plan);
            run_on(&o, &m, 4000);
            alone += was_shared && !plan_is_shared(&o.plan);
            shared += !was_shared && plan_is_shared(&o.plan);
            near += excess_of(&m, &o) < 0.05;
        }
        online_end(&o);
    }
    print_message("%u times one device, %u times both; %u of %d within 5 %% of the best\n", alone,
                  shared, near, MACHINES * CHANGES);
    assert_true(alone > 0 && shared > 0);
    assert_true(near >= MACHINES * CHANGES * 9 / 10);
}

// The machine has no noise: what is expected is what a frame takes, unless a device that nothing
// used has changed meanwhile.
TEST(no_frame_is_longer_than_was_allowed)
{
    rng r = rng_seed(test_seed());
    trials all = {0};
    uint32_t unseen = 0;
    enum { MACHINES = 100, CHANGES = 3, FRAMES = 3000 };
    for (int i = 0; i < MACHINES; ++i) {
        machine m = any_machine(&r, 0);
        m.r = NULL;
        m.switch_ns = rng_between(&r, 0, 0.2) * best_time(&m);
        listed_plan start = any_plan(&r);
        online o = begin_learned(&start, &m);
        trials still = run_on(&o, &m, FRAMES);
        all.longest = fmax(all.longest, still.longest);
        for (int change = 0; change < CHANGES; ++change) {
            m.slower[rng_below(&r, 2)] = pow(8, rng_between(&r, -1, 1));
            unseen += run_on(&o, &m, FRAMES).long_ones;
        }
        online_end(&o);
    }
    print_message("the longest trial takes %.3f of the frame before; %u of %d after changes more\n",
                  all.longest, unseen, MACHINES * CHANGES * FRAMES);
    assert_true(all.longest <= 1.1001);
    assert_true(unseen < MACHINES * CHANGES * FRAMES / 1000);
}

// And one that comes back is seen, though nothing uses it.
TEST(an_idle_device_that_recovers_is_used_again)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 50; ++i) {
        machine m = make_machine(&(simulated_pair){.ratio = 1, .sigma = 0.02}, &r);
        listed_plan start = {.share = SEARCH_ONE / 2, .mode = DUET_MODE_OWN};
        online o = begin_learned(&start, &m);
        m.slower[i % 2] = 200;
        run_on(&o, &m, 2000);
        assert_int_equal(o.plan.share, i % 2 ? SEARCH_ONE : 0);
        m.slower[i % 2] = 1;
        run_on(&o, &m, 40000);
        assert_true(excess_of(&m, &o) < 0.1);
        online_end(&o);
    }
}

TEST(a_machine_that_does_not_change_is_left_alone)
{
    rng r = rng_seed(test_seed());
    uint32_t taken = 0, tried = 0;
    enum { MACHINES = 50, FRAMES = 10000 };
    for (int i = 0; i < MACHINES; ++i) {
        machine m = any_machine(&r, 0.03);
        listed_plan start = any_plan(&r);
        online o = begin_learned(&start, &m);
        run_on(&o, &m, 3000);
        uint32_t before = o.tunings;
        tried += run_on(&o, &m, FRAMES).n;
        taken += o.tunings - before;
        online_end(&o);
    }
    print_message("%u plans taken, %.2f %% of the frames tried others\n", taken,
                  100.0 * tried / (MACHINES * FRAMES));
    assert_true(taken <= MACHINES);
    assert_true(tried < 0.02 * MACHINES * FRAMES);
}

// But a plan of one device has the kernels of mode own.
TEST(kernels_that_take_too_long_to_change_are_left)
{
    machine m = make_machine(&(simulated_pair){.ratio = 1}, NULL);
    m.switch_ns = 0.5 * best_time(&m);
    m.kernels[0][0] = m.kernels[1][0] = 2;
    online o = begin_learned(&(listed_plan){.share = 0, .mode = DUET_MODE_OWN}, &m);
    trials tried = run_on(&o, &m, 3000);
    assert_true(tried.longest <= 1.1001);
    assert_true(plan_is_shared(&o.plan));
    assert_int_equal(o.plan.mode, DUET_MODE_OWN);
    assert_true(o.plan.variant[0] == 0 && o.plan.variant[1] == 0);
    online_end(&o);
}

TEST(a_rival_that_cannot_run_is_not_tried_again)
{
    machine m = make_machine(&(simulated_pair){.ratio = 1}, NULL);
    listed_plan start = {.share = 0, .mode = DUET_MODE_OWN};
    online o = begin_learned(&start, &m);
    uint32_t refused = 0;
    for (int i = 0; i < 20000; ++i) {
        listed_plan plan;
        search_sample frame;
        if (online_is_trial(&o)) {
            online_refuse(&o);
            ++refused;
        }
        assert_false(online_is_trial(&o));
        must(online_plan(&o, &plan, ERR));
        launch(&m, &plan, &frame);
        must(online_tell(&o, &frame, ERR));
    }
    assert_int_equal(o.plan.share, 0);
    assert_in_range(refused, 1, PLAN_MODES * KERNELS * KERNELS + 2 * KERNELS);
    online_end(&o);
}

// ---------------------------------------------------------------- on a world

enum { BOXES = 500 };

static duet_world *make_world(void)
{
    duet_world_def def = duet_default_world_def();
    def.pair = default_pair();
    def.plan.share = DUET_SHARE_ONE / 2;
    duet_world *world = kept(duet_world_create(&def, ERR));
    rng r = rng_seed(test_seed());
    duet_pose *poses = must(duet_world_map_objects(world, DUET_OBJECT_POSES, BOXES, ERR));
    for (int i = 0; i < BOXES; ++i) {
        poses[i] = (duet_pose){.half_extents = {0.5f, 0.5f, 0.5f}, .rotation = {0, 0, 0, 1}};
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, 0, 8);
    }
    return world;
}

TEST(steps_find_the_same_pairs_while_the_share_is_watched)
{
    duet_result plain, watched;
    duet_world *world = make_world();
    must(duet_world_step(world, &plain, ERR));
    uint64_t hash = duet_result_get_hash(&plain);
    duet_online_def def = duet_default_online_def();
    def.world = world;
    duet_online *watching = must(duet_online_create(&def, ERR));
    for (int i = 0; i < 100; ++i) {
        must(duet_online_step(watching, &watched, ERR));
        assert_true(duet_result_get_hash(&watched) == hash);
    }
    must(duet_online_destroy(watching, ERR));
}

// Stores what a tuning leaves.
static void put_tuned(record *r, const duet_plan *plan, const char *level)
{
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
    must(profile_put(r->store, &row, NULL, "tuned again", NULL, ERR));
}

// A share that nobody compared with one device alone is not followed.
TEST(what_was_learned_is_loaded_at_the_next_start_of_what_was_tuned)
{
    profile_subject known;
    record r;
    duet_profile profile;
    duet_world *world = make_world();
    must(profile_subject_read(world, &known, ERR));
    profile_request request = profile_subject_request(&known);
    duet_plan plan = *duet_world_get_plan(world);
    for (int tuned = 0; tuned < 2; ++tuned) {
        plan.share = 12345;
        must(record_open(&r, STORE, ERR) && record_aim(&r, &request, ERR));
        if (tuned)
            put_tuned(&r, duet_world_get_plan(world), "certified");
        must(record_online(&r, &plan, 2e6, ERR));
        record_close(&r);
        must(duet_world_load_profile(world, STORE, &profile, ERR));
        assert_int_equal(profile.grade, tuned ? DUET_GRADE_EXACT : DUET_GRADE_DEFAULT);
        assert_int_equal(duet_world_get_plan(world)->share, tuned ? 12345 : DUET_SHARE_ONE / 2);
    }
    assert_string_equal(profile.verdict, "faster");
}

// ---------------------------------------------------------------- on a motion

enum { PHASES = 90 };

static duet_motion *drop(const duet_scene *scene, uint32_t share)
{
    duet_motion_def def = duet_scene_motion_def(scene, default_pair());
    def.plan.share = share;
    return kept(duet_motion_create_from_scene(&def, scene, NULL, ERR));
}

// The state's bits after bodies fell, crashed and lay down.
static uint64_t run_falling(duet_motion *m, duet_online *watching)
{
    duet_motion_result result;
    uint64_t hash = 0;
    for (int i = 0; i < PHASES; ++i)
        must(watching ? duet_online_advance(watching, &result, ERR)
                      : duet_motion_advance(m, &result, ERR));
    assert_true(result.contacts > 0);
    must(duet_motion_get_hash(m, &hash, ERR));
    return hash;
}

TEST(a_motion_keeps_its_bits_while_its_share_follows_the_searches)
{
    const duet_setting n = {"n", "600"};
    duet_scene *scene = kept(duet_scene_load("falling", &n, 1, ERR));
    duet_motion *plain = drop(scene, DUET_SHARE_ONE / 2);
    uint64_t hash = run_falling(plain, NULL);

    duet_motion *m = drop(scene, DUET_SHARE_ONE / 16 * 15);
    duet_online_def def = duet_default_online_def();
    def.motion = m;
    def.keep = true;
    must_fail(duet_online_create(&def, ERR), DUET_STATUS_BAD_ARGUMENT,
              "keep: expected none for a motion");
    def.keep = false;
    duet_online *watching = must(duet_online_create(&def, ERR));
    assert_true(run_falling(m, watching) == hash);
    duet_result still;
    must_fail(duet_online_step(watching, &still, ERR), DUET_STATUS_BAD_ARGUMENT,
              "the def had no world");
    must(duet_online_destroy(watching, ERR));
}

TEST(a_def_that_is_no_def_is_refused)
{
    duet_online_def zero = {0}, neither = duet_default_online_def();
    must_fail(duet_online_create(&zero, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    must_fail(duet_online_create(&neither, ERR), DUET_STATUS_BAD_ARGUMENT, "");
}
