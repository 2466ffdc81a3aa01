// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "support/look.h"

static look_fixture f; // the test's

static void begin(void)
{
    f = look_open();
}

// ----------------------------------------------------------------------- the grades

TEST(what_was_measured_here_is_exact)
{
    look_tune(&f, 100000);
    profile_found found = look_for(&f, &f.pair, 100000);
    assert_int_equal(found.grade, PROFILE_EXACT);
    assert_int_equal(found.plan.share, 8192);
    assert_int_equal(found.share_low, 8192);
    assert_string_equal(found.plan.mode, "own");
    assert_string_equal(found.plan.level, "certified");
    assert_string_equal(found.plan.variant_a, "auto");
    assert_string_equal(found.plan.variant_b, "auto sort=radix");
    assert_string_equal(found.verdict, "faster");
    assert_true(found.gain == 0.12);
    assert_int_equal(strlen(found.session), PROFILE_ID - 1);
}

TEST(an_empty_store_gives_the_default)
{
    assert_int_equal(look_for(&f, &f.pair, 1000).grade, PROFILE_DEFAULT);
}

TEST(another_driver_is_said)
{
    look_tune(&f, 100000);
    profile_pair newer = f.pair;
    newer.b.driver = "560.1";
    newer.b.platform_version = "OpenCL 3.0 CUDA 12.6";
    profile_found found = look_for(&f, &newer, 100000);
    assert_int_equal(found.grade, PROFILE_OTHER_DRIVER);
    assert_int_equal(found.plan.share, 8192);
}

// The rule above all: nothing measured on other devices is handed out.
TEST(another_devices_row_is_never_handed_out)
{
    look_tune(&f, 100000);
    profile_pair others[6];
    for (int i = 0; i < 6; ++i)
        others[i] = f.pair;
    others[0].b.device.name = "NVIDIA H100";
    others[1].a.part = "1-1";
    others[2].a.part_units = 2;
    others[3].b.limits = "power 200 W";
    others[4].a = f.pair.b;
    others[4].b = f.pair.a;
    others[5].b.platform = "another platform";
    for (int i = 0; i < 6; ++i) {
        profile_found found = look_for(&f, &others[i], 100000);
        assert_int_not_equal(found.grade, PROFILE_EXACT);
        assert_int_not_equal(found.grade, PROFILE_OTHER_DRIVER);
        assert_int_not_equal(found.grade, PROFILE_STALE);
        assert_string_equal(found.uid, "");
        // Swapped devices are known from the fits of each, in their own places.
        if (i == 4)
            assert_int_equal(found.grade, PROFILE_TRANSFERRED);
        else
            assert_int_equal(found.grade, PROFILE_DEFAULT);
    }
}

// A is also B; or B is another device that nothing tells from A.
static profile_pair equal_pair(bool two)
{
    profile_pair pair = {f.pair.a, f.pair.a};
    pair.b.part = two ? PROFILE_SECOND : pair.a.part;
    return pair;
}

TEST(two_equal_devices_are_not_one_of_them)
{
    f.pair = equal_pair(true);
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    profile_pair one = equal_pair(false);
    assert_int_equal(look_for(&f, &f.pair, 100000).grade, PROFILE_EXACT);
    assert_int_equal(look_for(&f, &one, 100000).grade, PROFILE_DEFAULT);
    assert_int_equal(look_for(&f, &one, 200000).grade, PROFILE_DEFAULT);
}

// The share at which both of test_time's devices end together.
static double best_share(uint64_t n)
{
    (void)n; // both begin and pass over all objects alike
    return 10.0 / 60.0;
}

static void assert_why(uint64_t n, const char *says)
{
    profile_workload workload = test_workload(n);
    profile_request request = test_request(&f.pair, &workload);
    look_assert_why(f.s, &request, says);
}

// Nothing of another workload is handed over as this one's.
static void assert_nothing_of_another(const profile_found *found)
{
    assert_string_equal(found->uid, "");
    assert_string_equal(found->session, "");
    assert_string_equal(found->terms, "");
    assert_true(found->created_ns == 0 && found->low_ns == 0 && found->high_ns == 0);
    assert_true(found->missed_rate == 0 && found->false_rate == 0);
    assert_int_equal(found->true_pairs, -1);
    assert_int_equal(found->rounds, 0);
}

static void assert_figures_are_predicted(const profile_found *found)
{
    assert_nothing_of_another(found);
    assert_true(found->gain_low <= found->gain && found->gain <= found->gain_high);
    assert_in_range(found->plan.share, found->share_low, found->share_high);
}

static void assert_no_figures(const profile_found *found)
{
    assert_nothing_of_another(found);
    assert_string_equal(found->verdict, "");
    assert_true(found->median_ns == 0 && found->single_ns == 0 && found->whole_ns == 0);
    assert_true(found->gain == 0 && found->gain_low == 0 && found->gain_high == 0);
}

#define AT(n, changes) \
    "UPDATE profile SET " changes " WHERE workload_id = (SELECT id FROM workload WHERE n = " n ")"
#define AT_100000(changes) AT("100000", changes)

// Fits would say another share; the race at both sizes said this one.
TEST(a_size_between_two_is_interpolated)
{
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    profile_found found = look_for(&f, &f.pair, 200000);
    assert_int_equal(found.grade, PROFILE_INTERPOLATED);
    assert_int_equal(found.plan.share, 8192);
    assert_string_equal(found.plan.variant_b, "auto sort=radix");
    double expected = fmax(test_time(0, 200000, 0.125), test_time(1, 200000, 0.125));
    assert_true(fabs(found.median_ns / expected - 1) < 1e-3);
    assert_string_equal(found.verdict, "faster");
    assert_true(fabs(found.gain - 0.12) < 1e-9 && found.gain_low == 0.1 && found.gain_high == 0.14);
    assert_figures_are_predicted(&found);
}

// Two devices with straight lines for times end together at a share of
// x + y / n.
TEST(a_share_between_two_follows_both)
{
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    look_change(
        &f, "UPDATE profile SET best_mode = mode, share = 13107, best_share = 13107; " AT_100000(
                "share = 19661, best_share = 19661"));
    static const uint64_t sizes[] = {120000, 200000, 300000};
    for (int i = 0; i < 3; ++i) {
        profile_found found = look_for(&f, &f.pair, sizes[i]);
        double y = (19661.0 - 13107) / (1 / 1e5 - 1 / 4e5), x = 19661 - y / 1e5;
        assert_true(fabs(found.plan.share - (x + y / (double)sizes[i])) <= 1);
        assert_int_equal(found.share_low, 13107);
        assert_int_equal(found.share_high, 19661);
    }
}

TEST(a_size_next_to_one_that_was_measured_takes_its_plan)
{
    look_tune(&f, 100000);
    look_change(&f, "UPDATE profile SET missed_rate = 0.5, true_pairs = 6883, terms = '{\"a\":1}'");
    profile_found found = look_for(&f, &f.pair, 104000);
    profile_found measured = look_for(&f, &f.pair, 100000);
    assert_int_equal(found.grade, PROFILE_INTERPOLATED);
    assert_int_equal(found.plan.share, measured.plan.share);
    assert_true(found.gain == measured.gain);
    assert_true(fabs(found.gain_low - (1.1 / 1.04 - 1)) < 1e-9);
    assert_true(fabs(found.gain_high - (1.14 * 1.04 - 1)) < 1e-9);
    assert_true(fabs(found.median_ns / measured.median_ns - 1.04) < 1e-9);
    assert_figures_are_predicted(&found);
}

// The same number of objects in as many cells, but eight times as crowded, as `clustered` beside
// `paper`; or of another density, other sizes, or in a flat world.
TEST(a_scene_that_is_not_alike_lends_no_figure)
{
    static const char *const says[] = {"objects in the fullest cells 3 there, 24 here",
                                       "objects a cell 0.66 there, 0.22 here",
                                       "layers of cells 42 there, 6 here"};
    look_tune(&f, 50000);
    look_tune(&f, 100000);
    look_tune(&f, 200000);
    for (int i = 0; i < 3; ++i) {
        profile_workload others[3] = {test_workload(100000), test_workload(100000),
                                      test_workload(100000)};
        others[0].occ_p99 *= 8;
        others[1].occ_mean /= 3;
        others[1].occ_p99 /= 3;
        others[2].cells[2] = 6;
        profile_request request = test_request(&f.pair, &others[i]);
        assert_int_equal(look_up(f.s, &request).grade, PROFILE_DEFAULT);
        look_assert_why(f.s, &request, says[i]);
        // Sharing gains so much that it surely does here, too; by how much is not known.
        look_change(&f, "UPDATE profile SET gain = 3, gain_low = 2.9, gain_high = 3.1");
        profile_found found = look_up(f.s, &request);
        assert_int_equal(found.grade, PROFILE_TRANSFERRED);
        assert_int_equal(found.plan.share, 8192);
        assert_no_figures(&found);
        look_change(&f, "UPDATE profile SET gain = 0.12, gain_low = 0.1, gain_high = 0.14");
    }
}

// A scene that is not alike hides none that is.
TEST(a_scene_beside_others_is_interpolated_from_its_own)
{
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    static const uint64_t sizes[] = {150000, 200000, 250000};
    for (int i = 0; i < 3; ++i) {
        profile_workload crowded = test_workload(sizes[i]);
        crowded.occ_p99 *= 8;
        test_tune(f.s, &f.pair, &crowded);
    }
    look_change(&f,
                "UPDATE profile SET share = 20000 WHERE workload_id IN (SELECT id FROM workload "
                "WHERE occ_p99 > 20)");
    profile_found found = look_for(&f, &f.pair, 200000);
    assert_int_equal(found.grade, PROFILE_INTERPOLATED);
    assert_int_equal(found.plan.share, 8192);
}

// However the fits see it: both sizes were raced.
TEST(what_two_sizes_agree_on_is_not_contradicted_between_them)
{
    look_tune(&f, 50000);
    look_tune(&f, 100000);
    look_tune(&f, 200000);
    look_change(&f,
                "UPDATE profile SET share = 0, gain = -0.05, gain_low = -0.1, gain_high = 0.01, "
                "verdict = 'same'");
    for (uint64_t n = 60000; n < 200000; n += 10000) {
        profile_found found = look_for(&f, &f.pair, n);
        assert_true(found.grade == PROFILE_EXACT || found.grade == PROFILE_INTERPOLATED);
        assert_int_equal(found.plan.share, 0);
        assert_string_equal(found.verdict, "same");
    }
}

// Sharing was 44 % faster: it still is where all else changes by less than the square of that.
TEST(one_size_lends_its_plan_as_far_as_it_is_surely_faster)
{
    look_tune(&f, 100000);
    look_change(&f, "UPDATE profile SET gain = 0.5, gain_low = 0.44, gain_high = 0.55");
    static const struct {
        uint64_t n;
        profile_grade grade;
    } cases[] = {{40000, PROFILE_DEFAULT},      {50000, PROFILE_TRANSFERRED},
                 {85000, PROFILE_TRANSFERRED},  {120000, PROFILE_TRANSFERRED},
                 {200000, PROFILE_TRANSFERRED}, {220000, PROFILE_DEFAULT}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        profile_found found = look_for(&f, &f.pair, cases[i].n);
        assert_int_equal(found.grade, cases[i].grade);
        if (found.grade == PROFILE_TRANSFERRED) {
            assert_int_equal(found.plan.share, 8192);
            assert_no_figures(&found);
        }
    }
}

// B alone was faster by as much; A alone may be slower than B elsewhere; a tie says nothing.
TEST(one_size_lends_one_device_only_if_that_is_sure)
{
    static const struct {
        const char *change;
        profile_grade grade;
    } cases[] = {
        {"share = 0, gain = -0.4, gain_low = -0.5, gain_high = -0.3", PROFILE_TRANSFERRED},
        {"share = 65536, gain = -0.4, gain_low = -0.5, gain_high = -0.3", PROFILE_DEFAULT},
        {"share = 0, gain = -0.1, gain_low = -0.3, gain_high = 0.1", PROFILE_DEFAULT},
        {"share = 8192, gain = 0.1, gain_low = -0.1, gain_high = 0.3", PROFILE_DEFAULT},
    };
    look_tune(&f, 100000);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char change[200];
        snprintf(change, sizeof change, "UPDATE profile SET %s", cases[i].change);
        look_change(&f, change);
        assert_int_equal(look_for(&f, &f.pair, 120000).grade, cases[i].grade);
    }
}

TEST(a_size_far_beyond_those_measured_is_a_guess_at_most)
{
    look_tune(&f, 100000);
    assert_int_equal(look_for(&f, &f.pair, 100000000).grade, PROFILE_DEFAULT);
    assert_int_equal(look_for(&f, &f.pair, 1000).grade, PROFILE_DEFAULT);
}

// Each has its own mode and kernels: the nearer one's are lent, with its share.
TEST(two_sizes_with_other_kernels_lend_those_of_the_nearer)
{
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    look_change(
        &f, AT("400000", "mode = 'slab', variant_a = 'simd', variant_b = 'simd', share = 9000"));
    profile_found low = look_for(&f, &f.pair, 150000), high = look_for(&f, &f.pair, 250000);
    assert_int_equal(low.grade, PROFILE_INTERPOLATED);
    assert_int_equal(high.grade, PROFILE_INTERPOLATED);
    assert_string_equal(low.plan.mode, "own");
    assert_int_equal(low.plan.share, 8192);
    assert_string_equal(high.plan.mode, "slab");
    assert_string_equal(high.plan.variant_a, "simd");
    assert_int_equal(high.plan.share, 9000);
}

// Sharing gains 12 % at one size and loses 30 % at the other: lines through both sides' times cross
// at 120 000, far from half the way.
TEST(predicted_times_decide_between_sharing_and_one_device)
{
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    look_change(&f, AT("400000", "share = 0, gain = -0.3, gain_low = -0.32, gain_high = -0.28, "
                                 "verdict = 'slower'"));
    profile_found shared = look_for(&f, &f.pair, 112000), one = look_for(&f, &f.pair, 128000);
    assert_int_equal(shared.grade, PROFILE_INTERPOLATED);
    assert_int_equal(shared.plan.share, 8192);
    assert_true(shared.gain > 0);
    assert_int_equal(one.grade, PROFILE_INTERPOLATED);
    assert_int_equal(one.plan.share, 0);
    assert_true(one.gain < 0);
    assert_string_equal(one.verdict, "same");
    assert_true(shared.median_ns < one.median_ns);
}

// Also without fits, as where both devices are one.
TEST(a_size_between_two_of_one_device_has_its_plan)
{
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    look_change(&f, "UPDATE profile SET share = 0; DELETE FROM trial; DELETE FROM fit");
    assert_why(200000, "yes: it lies between 100000 and 400000 objects");
    double low_ms = look_for(&f, &f.pair, 100000).median_ns * 1e-6;
    double high_ms = look_for(&f, &f.pair, 400000).median_ns * 1e-6;
    for (uint64_t n = 105000; n <= 400000; n += 59000) {
        profile_found found = look_for(&f, &f.pair, n);
        double ms = low_ms + (high_ms - low_ms) * ((double)n - 100000) / 300000;
        assert_int_equal(found.plan.share, 0);
        assert_true(fabs(found.median_ns * 1e-6 / ms - 1) < 1e-9);
    }
    look_change(&f, AT("400000", "variant_b = 'simd'"));
    assert_string_equal(look_for(&f, &f.pair, 150000).plan.variant_b, "auto sort=radix");
    assert_string_equal(look_for(&f, &f.pair, 300000).plan.variant_b, "simd");
}

TEST(a_size_that_cannot_be_interpolated_is_told_the_true_reason)
{
    look_tune(&f, 100000);
    look_tune(&f, 400000);
    assert_why(40000, "no: the size is below those measured, the nearest of which is 100000");
    assert_why(900000, "no: the size is above those measured, the nearest of which is 400000");
    look_change(&f, "UPDATE profile SET share = 0; " AT_100000("share = 65536"));
    assert_why(200000,
               "no: at 100000 and at 400000 objects the work is divided in other ways, and which "
               "is the quicker one here is not known");
}

// However it came to be live no more.
TEST(a_plan_without_a_verdict_is_not_followed)
{
    look_tune(&f, 100000);
    look_change(&f, "UPDATE profile SET live = 0, dead_reason = 'too few rounds'");
    assert_int_not_equal(look_for(&f, &f.pair, 100000).grade, PROFILE_EXACT);
    assert_why(100000, " is not used: too few rounds");
}

TEST(devices_measured_apart_are_transferred)
{
    profile_pair first = f.pair;
    profile_pair second = f.pair;
    first.b.device.name = "GPU one";
    second.a.part = "1-1";
    profile_workload workload = test_workload(100000);
    test_tune(f.s, &first, &workload);
    test_tune(f.s, &second, &workload);
    profile_found found =
        look_for(&f, &f.pair, 100000); // part 0-0 from one, the GPU from the other
    assert_int_equal(found.grade, PROFILE_TRANSFERRED);
    assert_true(fabs(found.plan.share / 65536.0 - best_share(100000)) < 0.02);
}

TEST(fits_of_two_machines_are_not_joined)
{
    profile_pair first = f.pair;
    profile_pair second = f.pair;
    first.b.device.name = "GPU one";
    second.a.part = "1-1";
    profile_workload workload = test_workload(100000);
    test_tune(f.s, &first, &workload);
    look_change(&f, "UPDATE session SET host = 'elsewhere'; UPDATE fit SET host = 'elsewhere'");
    test_tune(f.s, &second, &workload);
    assert_int_equal(look_for(&f, &f.pair, 100000).grade, PROFILE_DEFAULT);
}

TEST(changed_kernels_make_a_row_a_starting_point)
{
    look_tune(&f, 100000);
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    request.kernels = "another";
    profile_found found = look_up(f.s, &request);
    assert_int_equal(found.grade, PROFILE_STALE);
    assert_int_equal(found.plan.share, 8192);
}

TEST(a_workload_of_another_kind_is_not_a_neighbour)
{
    look_tune(&f, 100000);
    profile_workload others[5];
    for (int i = 0; i < 5; ++i)
        others[i] = test_workload(100000);
    others[0].level = "sat15";
    others[1].effects = "gravity";
    others[2].rotated = false;
    others[3].size_ratio = 100;
    others[4].dims = 2;
    for (int i = 0; i < 5; ++i) {
        profile_request request = test_request(&f.pair, &others[i]);
        assert_int_equal(look_up(f.s, &request).grade, PROFILE_DEFAULT);
    }
}

// --------------------------------------------------------------------- accuracy

// A profile at a level of its own, as a tuning leaves it.
static void tune_at(const char *level, double ms, double missed, double invented)
{
    profile_workload workload = test_workload(100000);
    workload.level = level;
    profile_row row = {
        .kernels = TEST_KERNELS,
        .objective = "time",
        .plan = test_plan(0.125),
        .median_ns = ms * 1e6,
        .low_ns = ms * 1e6,
        .high_ns = ms * 1e6,
        .verdict = "faster",
        .missed_rate = missed,
        .false_rate = invented,
        .true_pairs = 1000,
        .origin = "manual",
        .trial_number = -1,
    };
    snprintf(row.plan.level, sizeof row.plan.level, "%s", level);
    must(profile_pair_put(f.s, &f.pair, &row.pair_id, ERR));
    must(profile_workload_put(f.s, &workload, &row.workload_id, ERR));
    must(profile_put(f.s, &row, NULL, "replaced by a later tuning", NULL, ERR));
}

TEST(more_accuracy_than_was_given_is_not_served)
{
    tune_at("sat15", 9, 0.001, 0.02);
    profile_workload workload = test_workload(100000);
    workload.level = "sat15";
    profile_request request = test_request(&f.pair, &workload);
    request.max_missed_rate = 0.001;
    request.max_false_rate = 0.02;
    assert_int_equal(look_up(f.s, &request).grade, PROFILE_EXACT);
    request.max_false_rate = 0.019;
    assert_int_equal(look_up(f.s, &request).grade, PROFILE_DEFAULT);
    request.max_false_rate = 0.02;
    request.max_missed_rate = 0;
    assert_int_equal(look_up(f.s, &request).grade, PROFILE_DEFAULT);
}

static profile_request request_within(const profile_workload *workload, double missed,
                                      double invented)
{
    static const char *const levels[] = {"certified", "aabb", "sat6", "sat15"};
    profile_request request = test_request(&f.pair, workload);
    request.levels = levels;
    request.n_levels = 4;
    request.max_missed_rate = missed;
    request.max_false_rate = invented;
    return request;
}

TEST(an_accuracy_takes_the_quickest_level_within_it)
{
    tune_at("certified", 10, 0, 0);
    tune_at("sat15", 9, 0.001, 0);
    tune_at("sat6", 8, 0, 0.01);
    tune_at("aabb", 7, 0, 1.5);
    static const struct {
        double missed, invented;
        const char *level;
    } cases[] = {{0, 0, "certified"},     {0.001, 0, "sat15"}, {0, 0.01, "sat6"},
                 {0, 0.009, "certified"}, {1, 2, "aabb"},      {0.0009, 0, "certified"}};
    profile_workload workload = test_workload(100000);
    workload.level = "auto";
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        profile_request request = request_within(&workload, cases[i].missed, cases[i].invented);
        profile_found found = look_up(f.s, &request);
        assert_int_equal(found.grade, PROFILE_EXACT);
        assert_string_equal(found.plan.level, cases[i].level);
    }
}

TEST(a_level_is_served_by_that_level_alone)
{
    tune_at("sat6", 8, 0, 0);
    tune_at("sat15", 8, 0, 0);
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    assert_int_equal(look_up(f.s, &request).grade, PROFILE_DEFAULT);
    workload.level = "sat15";
    assert_string_equal(look_up(f.s, &request).plan.level, "sat15");
}

// However fast it is: the rung decides before the time does.
TEST(a_better_ground_comes_before_a_quicker_level)
{
    tune_at("certified", 10, 0, 0);
    tune_at("sat6", 1, 0, 0.01);
    look_change(&f, "UPDATE profile SET kernels = 'older' WHERE level = 'sat6'");
    profile_workload workload = test_workload(100000);
    profile_request request = request_within(&workload, 0, 0.5);
    assert_string_equal(look_up(f.s, &request).plan.level, "certified");
}

TEST(a_profile_comes_back_with_all_that_was_measured)
{
    tune_at("sat6", 8, 0, 0.01);
    look_change(&f, "UPDATE profile SET single_ns = 9e6, best_share = 4096, best_mode = 'slab', "
                    "terms = '{\"T_1\":1.5}'");
    profile_workload workload = test_workload(100000);
    profile_request request = request_within(&workload, 0, 0.5);
    profile_found found = look_up(f.s, &request);
    assert_true(found.low_ns == 8e6 && found.high_ns == 8e6 && found.single_ns == 9e6);
    assert_true(found.missed_rate == 0 && found.false_rate == 0.01);
    assert_int_equal(found.true_pairs, 1000);
    assert_int_equal(found.best_share, 4096);
    assert_string_equal(found.best_mode, "slab");
    assert_string_equal(found.terms, "{\"T_1\":1.5}");
}

TEST_EACH(begin, NULL)
