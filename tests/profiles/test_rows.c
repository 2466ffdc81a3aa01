// SPDX-License-Identifier: MIT
// A store keeps devices, workloads, trials, profiles.
#include "support/test.h"

#include "profiles/sql.h"
#include "support/store.h"

// ------------------------------------------------------------------------- rows

TEST(a_pair_and_a_workload_are_stored_once)
{
    store *s = test_store_fresh();
    profile_pair pair = test_pair();
    profile_pair swapped = {.a = pair.b, .b = pair.a};
    profile_workload workload = test_workload(1000);
    int64_t ids[6] = {0};
    must(profile_pair_put(s, &pair, &ids[0], ERR));
    must(profile_pair_put(s, &pair, &ids[1], ERR));
    must(profile_pair_put(s, &swapped, &ids[2], ERR));
    must(profile_workload_put(s, &workload, &ids[3], ERR));
    must(profile_workload_put(s, &workload, &ids[4], ERR));
    assert_int_equal(ids[0], ids[1]);
    assert_int_not_equal(ids[0], ids[2]);
    assert_int_equal(ids[3], ids[4]);
    assert_int_equal(test_count(s, "device"), 2);
    assert_int_equal(test_count(s, "env"), 2);
}

TEST(every_field_of_a_device_tells_devices_apart)
{
    profile_env env = test_pair().b;
    profile_env others[12];
    for (int i = 0; i < 12; ++i)
        others[i] = env;
    // Two names that differ only past the fiftieth character.
    env.device.name = "A device whose name is longer than fifty characters, model X";
    others[0].device.name = "A device whose name is longer than fifty characters, model Y";
    others[1].device.vendor = "another";
    others[2].device.kind = "accel";
    others[3].device.units = 1;
    others[4].device.max_group = 1;
    others[5].device.local_bytes = 1;
    others[6].device.global_bytes = 1;
    others[7].platform = "another";
    others[8].driver = "another";
    others[9].part = "0-1";
    others[10].part_units = 2;
    others[11].limits = "power 200 W";
    char keys[13][PROFILE_SHA];
    profile_env_key(&env, keys[12]);
    for (int i = 0; i < 12; ++i) {
        profile_env_key(&others[i], keys[i]);
        for (int j = 0; j < i; ++j)
            assert_string_not_equal(keys[i], keys[j]);
        assert_string_not_equal(keys[i], keys[12]);
    }
}

TEST(a_drivers_version_changes_the_key_and_not_the_seat)
{
    profile_env env = test_pair().b;
    profile_env newer = env;
    newer.driver = "560.1";
    char keys[4][PROFILE_SHA];
    profile_env_keys(&env, keys[0], keys[2]);
    profile_env_keys(&newer, keys[1], keys[3]);
    assert_string_not_equal(keys[0], keys[1]);
    assert_string_equal(keys[2], keys[3]);
}

TEST(a_hosts_memory_does_not_change_its_cpu)
{
    profile_device cpu = test_pair().a.device;
    char keys[2][PROFILE_SHA];
    profile_device_key(&cpu, keys[0]);
    cpu.global_bytes /= 2;
    profile_device_key(&cpu, keys[1]);
    assert_string_equal(keys[0], keys[1]);
}

TEST(two_draws_of_one_scene_are_one_workload)
{
    profile_workload w = test_workload(1000000);
    profile_workload other = w;
    other.occ_mean *= 1.001;
    other.cells[0] += 1;
    other.name = "mine";
    char keys[2][PROFILE_SHA];
    must(profile_workload_key(&w, keys[0], ERR));
    must(profile_workload_key(&other, keys[1], ERR));
    assert_string_equal(keys[0], keys[1]);
}

TEST(the_order_of_effects_does_not_matter_and_the_effects_do)
{
    static const char *const effects[] = {"gravity motion", " motion  gravity motion", "motion"};
    char keys[3][PROFILE_SHA];
    for (int i = 0; i < 3; ++i) {
        profile_workload w = test_workload(1000);
        w.effects = effects[i];
        must(profile_workload_key(&w, keys[i], ERR));
    }
    assert_string_equal(keys[0], keys[1]);
    assert_string_not_equal(keys[0], keys[2]);
}

TEST(a_workload_that_cannot_be_is_refused)
{
    profile_workload bad[4] = {test_workload(1), test_workload(1), test_workload(1),
                               test_workload(1)};
    bad[0].dims = 4;
    bad[1].n = 0;
    bad[2].size_ratio = 0.5;
    bad[3].occ_mean = 0.0 / 0.0;
    for (int i = 0; i < 4; ++i) {
        char key[PROFILE_SHA];
        must_fail(profile_workload_key(&bad[i], key, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    }
}

typedef struct tally {
    int trials;
    int launches;
    profile_trial last;
    int64_t last_total;
} tally;

static bool count_trial(void *context, int64_t number, const profile_trial *trial)
{
    tally *t = context;
    assert_int_equal(number, t->trials);
    ++t->trials;
    t->launches += (int)trial->n_samples;
    t->last = *trial;
    t->last_total = trial->samples[trial->n_samples - 1].total_ns;
    return t->trials < 5;
}

TEST(a_trial_comes_back_as_it_went_in)
{
    store *s = test_store_tuned();
    duet_error why = {0};
    sql q = sql_make(s, "SELECT id FROM session", &why);
    assert_true(sql_row(&q));
    tally t = {0};
    must(profile_trial_each(s, sql_get_text(&q, 0), count_trial, &t, ERR));
    assert_true(sql_close(&q));
    assert_int_equal(t.trials, 5); // stopped when the visitor said so
    assert_int_equal(t.launches, 20);
    assert_int_equal(t.last.plan.share, 32768);
    assert_string_equal(t.last.plan.mode, "own");
    assert_string_equal(t.last.plan.variant_b, "auto sort=radix");
    assert_true(t.last.a_ns == test_time(0, 1000, 0.5));
    assert_int_equal(t.last_total, (int64_t)test_time(0, 1000, 0.5) + 3);
}

TEST(a_trial_without_measurements_needs_a_reason_and_no_times)
{
    store *s = test_store_tuned();
    profile_session session = test_session(1, 1);
    char id[PROFILE_ID];
    must(profile_session_begin(s, &session, id, ERR));
    profile_trial trial = {.plan = test_plan(0.5),
                           .outcome = "build",
                           .reason = "no local memory",
                           .scope = PROFILE_SHARE_ONE};
    must(profile_trial_add(s, id, 0, &trial, ERR));
    assert_int_equal(test_count(s, "trial WHERE outcome = 'build' AND median_ns IS NULL"), 1);
    trial.outcome = "ok";
    must_fail(profile_trial_add(s, id, 1, &trial, ERR), DUET_STATUS_STORE_FAILED, "");
    assert_int_equal(test_count(s, "trial WHERE session_id <> ''"), 10);
}

TEST(a_replaced_profile_stays_dead_with_its_reason)
{
    store *s = test_store_tuned();
    test_tune_usual(s);
    assert_int_equal(test_count(s, "profile"), 2);
    assert_int_equal(test_count(s, "profile WHERE live = 1"), 1);
    assert_int_equal(test_count(s, "profile WHERE dead_reason = 'replaced by a later tuning'"), 1);
}

// ------------------------------------------------------------- which one is live

// A profile of one workload on one pair.
static profile_row gained(store *s, const char *verdict, double low, double high, uint32_t rounds)
{
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    profile_row row = {
        .kernels = TEST_KERNELS,
        .objective = "time",
        .plan = test_plan(0.25),
        .gain = (low + high) / 2,
        .gain_low = low,
        .gain_high = high,
        .verdict = verdict,
        .rounds = rounds,
        .origin = "manual",
        .trial_number = -1,
    };
    must(profile_pair_put(s, &pair, &row.pair_id, ERR));
    must(profile_workload_put(s, &workload, &row.workload_id, ERR));
    return row;
}

static profile_placed put(store *s, const profile_row *row, const char *unused)
{
    profile_placed placed;
    must(profile_put(s, row, unused, "replaced by a later tuning", &placed, ERR));
    assert_int_equal(test_count(s, "profile WHERE live = 1 AND verdict = 'ambiguous'"), 0);
    return placed;
}

TEST(a_live_profile_gives_way_only_to_one_that_is_founded_as_well)
{
    static const struct {
        struct {
            const char *verdict;
            double low, high;
            uint32_t rounds;
        } live, next;
        bool replaced;
    } cases[] = {
        {{"faster", 0.16, 0.31, 40}, {"ambiguous", -0.1, 0.1, 5}, false},
        {{"faster", 0.16, 0.31, 40}, {"same", 0, 0, 0}, false},          // nothing was raced
        {{"faster", 0.16, 0.31, 40}, {"same", -0.2, 0.5, 40}, false},    // says nothing
        {{"faster", 0.16, 0.31, 40}, {"same", -0.01, 0.02, 14}, true},   // says a lot
        {{"faster", 0.16, 0.31, 40}, {"faster", 0.02, 0.9, 8}, false},   // fewer and wider
        {{"faster", 0.16, 0.31, 40}, {"faster", 0.02, 0.9, 40}, true},   // the same number
        {{"faster", 0.16, 0.31, 40}, {"slower", -0.4, -0.35, 14}, true}, // narrower
        {{"same", -0.2, 0.5, 40}, {"faster", 0.1, 0.9, 40}, true},
        {{"same", -0.2, 0.5, 40}, {"same", -0.3, 0.9, 8}, false},
        {{"faster", 0.16, 0.31, 0}, {"faster", 0.02, 0.9, 8}, true}, // profile of an older version
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        store *s = test_store_fresh();
        profile_row live = gained(s, cases[i].live.verdict, cases[i].live.low, cases[i].live.high,
                                  cases[i].live.rounds);
        profile_row next = gained(s, cases[i].next.verdict, cases[i].next.low, cases[i].next.high,
                                  cases[i].next.rounds);
        profile_placed first = put(s, &live, NULL);
        assert_string_equal(first.unused, "");
        profile_placed second = put(s, &next, NULL);
        if ((*second.unused == '\0') != cases[i].replaced)
            fail_msg("case %zu: '%s'", i, second.unused);
        assert_int_equal(test_count(s, "profile WHERE live = 1"), 1);
        next.kernels = "newer";
        if (strcmp(next.verdict, "ambiguous") != 0)
            assert_string_equal(put(s, &next, NULL).unused, "");
    }
}

// Times that other programs disturbed are narrow and wrong.
TEST(quiet_comes_before_all_other_grounds)
{
    enum { UNKNOWN, DISTURBED, QUIET, N };
    static const struct {
        uint32_t watched, disturbed;
    } launches[N] = {{0, 0}, {100, 51}, {100, 50}};
    static const bool replaces[N][N] = {
        // by the live one's quietness; one that is as quiet has the narrower interval here
        [UNKNOWN] = {true, true, false},
        [DISTURBED] = {false, true, false},
        [QUIET] = {true, true, true},
    };
    for (int next = 0; next < N; ++next)
        for (int live = 0; live < N; ++live) {
            store *s = test_store_fresh();
            bool narrow = next == live || !replaces[next][live];
            profile_row rows[2] = {gained(s, "faster", 0.16, 0.31, 20),
                                   gained(s, narrow ? "slower" : "same", narrow ? -0.30 : -0.5,
                                          narrow ? -0.29 : 0.9, narrow ? 40 : 8)};
            rows[0].watched = launches[live].watched;
            rows[0].disturbed = launches[live].disturbed;
            rows[1].watched = launches[next].watched;
            rows[1].disturbed = launches[next].disturbed;
            assert_string_equal(put(s, &rows[0], NULL).unused, "");
            profile_placed placed = put(s, &rows[1], NULL);
            if ((*placed.unused == '\0') != replaces[next][live])
                fail_msg("next %d, live %d: '%s'", next, live, placed.unused);
        }
}

// Whether a search takes the place of one with 16 launches, by the times of their steps, least and
// greatest; both are as sure of what is gained.
static bool replaces(const char *options, const profile_row *gain, const double before_ns[2],
                     const double ns[2])
{
    store *s = test_store_fresh();
    char ids[2][PROFILE_ID];
    profile_row row = gained(s, gain->verdict, gain->gain_low, gain->gain_high, gain->rounds);
    profile_session session = test_session(row.pair_id, row.workload_id);
    must(profile_session_begin(s, &session, ids[0], ERR));
    session.options = options;
    must(profile_session_begin(s, &session, ids[1], ERR));
    row.origin = "measured";
    row.session = ids[0];
    row.low_ns = before_ns[0];
    row.median_ns = row.high_ns = before_ns[1];
    assert_string_equal(put(s, &row, NULL).unused, "");
    row.session = ids[1];
    row.low_ns = ns[0];
    row.median_ns = row.high_ns = ns[1];
    return *put(s, &row, NULL).unused == '\0';
}

// The plan of a search among fewer kernels is as sure, and a worse plan.
TEST(another_search_replaces_no_faster_plan)
{
    static const profile_row gain = {
        .verdict = "faster", .gain_low = 0.1, .gain_high = 0.2, .rounds = 20};
    static const double before[] = {3e6, 3e6}, slower[] = {9e6, 9e6}, faster[] = {2e6, 2e6};
    assert_true(replaces("{\"launches\":16}", &gain, before, slower)); // the machine has changed
    assert_false(replaces("{\"launches\":17}", &gain, before, slower));
    assert_true(replaces("{\"launches\":17}", &gain, before, faster));
}

// One device has nothing to race against.
TEST(another_search_of_one_device_replaces_no_better_measured_step)
{
    static const profile_row gain = {.verdict = "same"};
    static const double before[] = {2.9e6, 3.1e6}, wider[] = {2e6, 5e6},
                        narrower[] = {2.95e6, 3.05e6};
    assert_true(replaces("{\"launches\":16}", &gain, before, wider));
    assert_false(replaces("{\"launches\":17}", &gain, before, wider));
    assert_true(replaces("{\"launches\":17}", &gain, before, narrower));
}

static int64_t is_live(store *s, const profile_placed *placed)
{
    char query[128];
    snprintf(query, sizeof query, "profile WHERE live = 1 AND uid = '%s'", placed->uid);
    return test_count(s, query);
}

TEST(a_stored_profile_is_put_to_use_and_forgotten)
{
    store *s = test_store_fresh();
    profile_row row = gained(s, "faster", 0.1, 0.2, 20);
    profile_row unfounded = gained(s, "ambiguous", -0.1, 0.2, 3);
    profile_row elsewhere = row;
    elsewhere.kernels = "others";
    profile_placed kept = put(s, &row, NULL);
    profile_placed other = put(s, &elsewhere, NULL);
    profile_placed research = put(s, &row, "found by strategy 'grid' without --keep");
    assert_string_equal(research.unused, "found by strategy 'grid' without --keep");
    profile_placed few = put(s, &unfounded, NULL);
    assert_string_equal(few.unused, PROFILE_TOO_FEW_ROUNDS);
    assert_int_equal(is_live(s, &kept), 1);
    must(profile_use(s, research.uid, ERR));
    assert_int_equal(is_live(s, &research), 1);
    assert_int_equal(is_live(s, &kept), 0);
    assert_int_equal(is_live(s, &other), 1);
    must(profile_use(s, research.uid, ERR)); // again
    must_fail(profile_use(s, few.uid, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    must(profile_forget(s, research.uid, ERR));
    assert_int_equal(test_count(s, "profile"), 3);
    assert_int_equal(test_count(s, "profile WHERE live = 1"), 1);
    must_fail(profile_forget(s, research.uid, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    must_fail(profile_forget(s, "", ERR), DUET_STATUS_BAD_ARGUMENT,
              "an empty name is no profile's");
    assert_int_equal(test_count(s, "audit WHERE what IN ('use', 'forget')"), 3);
}

TEST(what_is_not_json_is_refused)
{
    store *s = test_store_fresh();
    static const char *const bad[] = {"", "[1]", "{\"a\":}", "{} trailing", "{\"a\":1"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        profile_session session = test_session(1, 1);
        char id[PROFILE_ID];
        session.options = bad[i];
        must_fail(profile_session_begin(s, &session, id, ERR), DUET_STATUS_BAD_ARGUMENT, "");
    }
}
