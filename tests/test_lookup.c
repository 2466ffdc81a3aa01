// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "support/test.h"

#include "profiles/fit.h"
#include "profiles/sql.h"
#include "runtime/base/rng.h"
#include "support/store.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct fixture {
    test_folder folder;
    store *s;
    profile_pair pair;
} fixture;

static fixture open_fixture(void)
{
    duet_error err = {0};
    fixture f = {.folder = test_folder_make(), .pair = test_pair()};
    f.s = store_open(f.folder.store, STORE_WRITE, &err);
    assert_ok(f.s, err);
    return f;
}

static void close_fixture(fixture *f)
{
    store_close(f->s);
    test_folder_remove(&f->folder);
}

static void tune(fixture *f, uint64_t n)
{
    profile_workload workload = test_workload(n);
    test_tune(f->s, &f->pair, &workload);
}

static profile_found look(store *s, const profile_request *request)
{
    profile_found found;
    duet_error err = {0};
    text why = {0};
    assert_ok(profile_lookup(s, request, &found, &why, &err), err);
    text_free(&why);
    return found;
}

static profile_found look_for(fixture *f, const profile_pair *pair, uint64_t n)
{
    profile_workload workload = test_workload(n);
    profile_request request = test_request(pair, &workload);
    return look(f->s, &request);
}

static void change(fixture *f, const char *statements)
{
    duet_error err = {0};
    assert_ok(sql_script(f->s, statements, &err), err);
}

// ----------------------------------------------------------------------- the rungs

static void what_was_measured_here_is_exact(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    profile_found found = look_for(&f, &f.pair, 100000);
    assert_int_equal(found.grade, PROFILE_EXACT);
    assert_int_equal(found.plan.share, 8192);
    assert_int_equal(found.share_low, 8192);
    assert_string_equal(found.plan.mode, "own");
    assert_string_equal(found.plan.level, "certified");
    assert_string_equal(found.plan.variant_a, "rows");
    assert_string_equal(found.plan.variant_b, "rows sort=radix");
    assert_string_equal(found.verdict, "faster");
    assert_true(found.gain == 0.12);
    assert_int_equal(strlen(found.session), PROFILE_ID - 1);
    close_fixture(&f);
}

static void an_empty_store_gives_the_default(void **state)
{
    (void)state;
    fixture f = open_fixture();
    assert_int_equal(look_for(&f, &f.pair, 1000).grade, PROFILE_DEFAULT);
    close_fixture(&f);
}

static void another_driver_is_said(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    profile_pair newer = f.pair;
    newer.b.driver = "560.1";
    newer.b.platform_version = "OpenCL 3.0 CUDA 12.6";
    profile_found found = look_for(&f, &newer, 100000);
    assert_int_equal(found.grade, PROFILE_OTHER_DRIVER);
    assert_int_equal(found.plan.share, 8192);
    close_fixture(&f);
}

// The rule above all: nothing measured on other devices is handed out.
static void another_devices_row_is_never_handed_out(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
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
    close_fixture(&f);
}

// Where both of test_time's devices end together.
static double best_share(uint64_t n)
{
    (void)n; // both begin and pass over all objects alike
    return 10.0 / 60.0;
}

static void a_size_between_two_is_interpolated(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    tune(&f, 400000);
    profile_found found = look_for(&f, &f.pair, 200000);
    assert_int_equal(found.grade, PROFILE_INTERPOLATED);
    double share = found.plan.share / 65536.0;
    assert_true(fabs(share - best_share(200000)) < 0.01);
    assert_in_range(found.plan.share, found.share_low, found.share_high);
    assert_true(found.share_low < found.share_high);
    double expected = test_time(1, 200000, best_share(200000));
    assert_true(fabs(found.median_ns / expected - 1) < 0.03);
    assert_string_equal(found.verdict, "faster");
    assert_true(found.gain_low > 0 && found.gain_low < found.gain && found.gain < found.gain_high);
    assert_string_equal(found.plan.variant_b, "rows sort=radix");
    assert_string_equal(found.uid, "");
    close_fixture(&f);
}

static void a_size_next_to_one_that_was_measured_takes_its_plan(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    profile_found found = look_for(&f, &f.pair, 104000);
    profile_found measured = look_for(&f, &f.pair, 100000);
    assert_int_equal(found.grade, PROFILE_INTERPOLATED);
    assert_int_equal(found.plan.share, measured.plan.share);
    assert_true(found.gain == measured.gain);
    assert_true(fabs(found.median_ns / measured.median_ns - 1.04) < 1e-9);
    profile_workload crowded = test_workload(104000);
    crowded.occ_mean *= 2; // as many, but elsewhere
    profile_request request = test_request(&f.pair, &crowded);
    assert_string_equal(look(f.s, &request).uid, "");
    close_fixture(&f);
}

// The pair was measured and one device was the best choice: its fits still say
// how the two would share another size.
static void a_tie_does_not_hide_what_was_measured(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    tune(&f, 400000);
    change(&f, "UPDATE profile SET share = 0, mode = 'shared', verdict = 'same'");
    profile_found found = look_for(&f, &f.pair, 200000);
    assert_int_equal(found.grade, PROFILE_INTERPOLATED);
    assert_true(found.plan.share > 0);
    close_fixture(&f);
}

static void a_size_far_beyond_those_measured_is_a_guess_at_most(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    profile_grade grade = look_for(&f, &f.pair, 100000000).grade;
    assert_true(grade == PROFILE_TRANSFERRED || grade == PROFILE_DEFAULT);
    assert_int_equal(look_for(&f, &f.pair, 1000).grade, PROFILE_DEFAULT);
    close_fixture(&f);
}

static void devices_measured_apart_are_transferred(void **state)
{
    (void)state;
    fixture f = open_fixture();
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
    close_fixture(&f);
}

static void fits_of_two_machines_are_not_joined(void **state)
{
    (void)state;
    fixture f = open_fixture();
    profile_pair first = f.pair;
    profile_pair second = f.pair;
    first.b.device.name = "GPU one";
    second.a.part = "1-1";
    profile_workload workload = test_workload(100000);
    test_tune(f.s, &first, &workload);
    change(&f, "UPDATE session SET host = 'elsewhere'; UPDATE fit SET host = 'elsewhere'");
    test_tune(f.s, &second, &workload);
    assert_int_equal(look_for(&f, &f.pair, 100000).grade, PROFILE_DEFAULT);
    close_fixture(&f);
}

static void changed_kernels_make_a_row_a_starting_point(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    request.kernels = "another";
    profile_found found = look(f.s, &request);
    assert_int_equal(found.grade, PROFILE_STALE);
    assert_int_equal(found.plan.share, 8192);
    close_fixture(&f);
}

static void a_workload_of_another_kind_is_not_a_neighbour(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
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
        assert_int_equal(look(f.s, &request).grade, PROFILE_DEFAULT);
    }
    close_fixture(&f);
}

// --------------------------------------------------------------------- accuracy

static void more_accuracy_than_was_given_is_not_served(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    change(&f, "UPDATE profile SET missed_rate = 0.001, false_rate = 0.02");
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    request.max_missed_rate = 0.001;
    request.max_false_rate = 0.02;
    assert_int_equal(look(f.s, &request).grade, PROFILE_EXACT);
    request.max_false_rate = 0.019;
    assert_int_equal(look(f.s, &request).grade, PROFILE_DEFAULT);
    request.max_false_rate = 0.02;
    request.max_missed_rate = 0;
    assert_int_equal(look(f.s, &request).grade, PROFILE_DEFAULT);
    close_fixture(&f);
}

// With level "auto" several levels have a live profile; the quickest that is
// accurate enough is taken.
static void a_budget_takes_the_quickest_level_that_meets_it(void **state)
{
    (void)state;
    fixture f = open_fixture();
    duet_error err = {0};
    profile_workload workload = test_workload(100000);
    workload.level = "auto";
    test_tune(f.s, &f.pair, &workload);
    profile_row row = {
        .pair_id = 1,
        .workload_id = 1,
        .kernels = TEST_KERNELS,
        .objective = "time",
        .plan = test_plan(0.125),
        .median_ns = 100,
        .low_ns = 99,
        .high_ns = 101,
        .verdict = "faster",
        .false_rate = 0.1,
        .origin = "manual",
        .trial_number = -1,
    };
    strcpy(row.plan.level, "sat6");
    assert_ok(profile_put(f.s, &row, "tuned again", &err), err);
    assert_int_equal(test_count(f.s, "profile WHERE live = 1"), 2);
    profile_request request = test_request(&f.pair, &workload);
    request.max_missed_rate = 0;
    request.max_false_rate = 0.2;
    assert_string_equal(look(f.s, &request).plan.level, "sat6");
    request.max_false_rate = 0.05;
    assert_string_equal(look(f.s, &request).plan.level, "certified");
    close_fixture(&f);
}

// --------------------------------------------------------------------------- fits

static void a_fit_finds_the_times_it_was_made_from(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    fit_point points[60];
    for (int i = 0; i < 60; ++i) {
        fit_point p = {.n = exp(rng_between(&r, log(1e4), log(1e7)))};
        p.own = p.n * rng_between(&r, 0.05, 0.95);
        p.occupancy = rng_between(&r, 0.2, 3);
        p.time_ns = 2e5 + 1.5 * p.n + 20 * p.own + 8 * p.own * p.occupancy;
        p.time_ns *= exp(0.02 * rng_normal(&r));
        points[i] = p;
    }
    fit f;
    fit_make(points, 60, &f);
    int outside = 0;
    for (int i = 0; i < 60; ++i) {
        fit_time t = fit_predict(&f, points[i].n, points[i].own, points[i].occupancy);
        outside += fabs(t.ns - points[i].time_ns) > 2 * t.sd_ns;
    }
    assert_in_range(outside, 0, 8);
    assert_true(f.residual > 0.01 && f.residual < 0.04);
    assert_true(fabs(f.terms[2] - 20) < 3 && fabs(f.terms[3] - 8) < 2);
}

// A third of the times is disturbed, by up to the tenfold.
static void a_fit_heeds_no_disturbed_times(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 50; ++round) {
        fit_point points[45];
        for (int i = 0; i < 45; ++i) {
            double own = 1e6 * rng_between(&r, 0.1, 0.9);
            points[i] = (fit_point){.n = 1e6, .own = own, .occupancy = 0.66};
            points[i].time_ns = (1e6 + 30 * own) * exp(0.02 * rng_normal(&r));
            if (i % 3 == 0)
                points[i].time_ns *= rng_between(&r, 1, 10);
        }
        fit f;
        fit_make(points, 45, &f);
        assert_true(f.residual < 0.1);
        fit_time t = fit_predict(&f, 1e6, 5e5, 0.66);
        assert_true(fabs(t.ns / 16e6 - 1) < 0.04);
    }
}

static void a_fit_knows_what_it_does_not_know(void **state)
{
    (void)state;
    fit_point points[9]; // of one size and one occupancy
    for (int i = 0; i < 9; ++i)
        points[i] = (fit_point){
            .n = 1e6, .own = 1e5 * (i + 1), .occupancy = 0.66, .time_ns = 1e6 + 3e6 * (i + 1)};
    fit f;
    fit_make(points, 9, &f);
    fit_time here = fit_predict(&f, 1e6, 3.3e5, 0.66);
    fit_time larger = fit_predict(&f, 1e7, 3.3e6, 0.66);
    fit_time denser = fit_predict(&f, 1e6, 3.3e5, 6);
    assert_true(here.sd_ns / here.ns < 0.05);
    assert_true(larger.sd_ns / larger.ns > 0.05);
    assert_true(denser.sd_ns / denser.ns > 0.2);
}

// ------------------------------------------------------------------------ two files

static int count_entries(const char *path)
{
    DIR *dir = opendir(path);
    assert_non_null(dir);
    int n = 0;
    while (readdir(dir))
        ++n;
    closedir(dir);
    return n;
}

static void a_look_up_leaves_no_trace(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    store_close(f.s);
    duet_error err = {0};
    text before = {0};
    text after = {0};
    assert_ok(text_read_file(&before, f.folder.store, &err), err);
    usleep(100000); // until the file counts as settled
    int entries = count_entries(f.folder.path);
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    profile_found found;
    assert_ok(profile_lookup_files(f.folder.store, NULL, &request, &found, NULL, &err), err);
    assert_int_equal(found.grade, PROFILE_EXACT);
    assert_int_equal(count_entries(f.folder.path), entries);
    assert_ok(text_read_file(&after, f.folder.store, &err), err);
    assert_int_equal(after.length, before.length);
    assert_memory_equal(after.chars, before.chars, before.length);
    text_free(&before);
    text_free(&after);
    f.s = NULL;
    close_fixture(&f);
}

static void a_look_up_sees_what_a_tuner_at_work_has_stored(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000); // still open: the rows are in the side file
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    profile_found found;
    duet_error err = {0};
    assert_ok(profile_lookup_files(f.folder.store, NULL, &request, &found, NULL, &err), err);
    assert_int_equal(found.grade, PROFILE_EXACT);
    close_fixture(&f);
}

static void missing_files_give_the_default_without_failure(void **state)
{
    (void)state;
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    profile_request request = test_request(&pair, &workload);
    profile_found found;
    duet_error err = {0};
    text why = {0};
    assert_ok(profile_lookup_files("no/such.db", "nor/this.db", &request, &found, &why, &err), err);
    assert_int_equal(found.grade, PROFILE_DEFAULT);
    assert_non_null(strstr(text_chars(&why), "no/such.db"));
    assert_non_null(strstr(text_chars(&why), "nor/this.db"));
    text_free(&why);
}

static void the_users_row_comes_before_the_systems(void **state)
{
    (void)state;
    fixture user = open_fixture();
    fixture system = open_fixture();
    tune(&user, 100000);
    tune(&system, 100000);
    tune(&system, 700000);
    change(&system, "UPDATE profile SET share = 1");
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&user.pair, &workload);
    profile_found found;
    duet_error err = {0};
    assert_ok(
        profile_lookup_files(user.folder.store, system.folder.store, &request, &found, NULL, &err),
        err);
    assert_int_equal(found.plan.share, 8192);
    workload = test_workload(700000);
    assert_ok(
        profile_lookup_files(user.folder.store, system.folder.store, &request, &found, NULL, &err),
        err);
    assert_int_equal(found.grade, PROFILE_EXACT);
    assert_int_equal(found.plan.share, 1);
    close_fixture(&user);
    close_fixture(&system);
}

static void a_broken_user_file_leaves_the_systems(void **state)
{
    (void)state;
    fixture user = open_fixture();
    fixture system = open_fixture();
    tune(&system, 100000);
    store_close(user.s);
    user.s = NULL;
    duet_error err = {0};
    assert_ok(text_write_file(user.folder.store, "rubbish", 7, &err), err);
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&user.pair, &workload);
    profile_found found;
    assert_false(
        profile_lookup_files(user.folder.store, system.folder.store, &request, &found, NULL, &err));
    assert_non_null(strstr(err.text, user.folder.store));
    assert_int_equal(found.grade, PROFILE_EXACT);
    close_fixture(&user);
    close_fixture(&system);
}

// ------------------------------------------------------------------------------ why

static void assert_why(store *s, const profile_request *request, const char *says)
{
    profile_found found;
    duet_error err = {0};
    text why = {0};
    assert_ok(profile_lookup(s, request, &found, &why, &err), err);
    if (!strstr(text_chars(&why), says))
        fail_msg("'%s' is not in:\n%s", says, text_chars(&why));
    text_free(&why);
}

static void why_says_what_is_missing(void **state)
{
    (void)state;
    fixture f = open_fixture();
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    assert_why(f.s, &request, "exact        no: device A was never measured");
    tune(&f, 100000);
    assert_why(f.s, &request, "exact        yes: measured 20");
    assert_why(f.s, &request, "on this machine");
    request.kernels = "another";
    assert_why(f.s, &request, "exact        no: the kernels changed since");
    assert_why(f.s, &request, "stale        yes: ");
    request.kernels = TEST_KERNELS;
    request.objective = "energy";
    assert_why(f.s, &request, "measured for another objective");
    request.objective = "time";
    request.max_missed_rate = -1;
    assert_why(f.s, &request, "misses or invents more pairs than allowed");
    request.max_missed_rate = INFINITY;
    workload = test_workload(300000);
    assert_why(f.s, &request, "exact        no: no such workload");
    profile_pair pair = f.pair;
    pair.a.part = "0-1";
    request.pair = &pair;
    assert_why(f.s, &request, "transferred  no: one of the devices was never measured");
    close_fixture(&f);
}

static void why_says_when_the_row_is_of_another_machine(void **state)
{
    (void)state;
    fixture f = open_fixture();
    tune(&f, 100000);
    change(&f, "UPDATE session SET host = 'elsewhere'");
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    assert_why(f.s, &request, "another machine with such devices");
    close_fixture(&f);
}

// ---------------------------------------------------------------------------- speed

typedef struct statements {
    char *texts[32];
    int n;
} statements;

static int keep_statement(unsigned kind, void *context, void *stmt, void *unused)
{
    (void)kind;
    (void)unused;
    statements *kept = context;
    assert_in_range(kept->n, 0, 31);
    kept->texts[kept->n++] = strdup(sqlite3_sql(stmt));
    return 0;
}

// How SQLite goes about a statement, a line for each table.
static void explain(store *s, const char *statement, text *plan)
{
    text query = {0};
    duet_error err = {0};
    text_add(&query, "EXPLAIN QUERY PLAN %s", statement);
    sql q = sql_make(s, text_chars(&query), &err);
    while (sql_row(&q))
        text_add(plan, "%s\n", sql_get_text(&q, 3));
    assert_ok(sql_close(&q), err);
    text_free(&query);
}

// No rung may read a table from end to end, however many profiles there are.
static void every_look_up_goes_by_an_index(void **state)
{
    (void)state;
    fixture f = open_fixture();
    test_fill(f.s, 100);
    statements kept = {0};
    sqlite3_trace_v2(f.s->db, SQLITE_TRACE_STMT, keep_statement, &kept);
    profile_workload workload = test_workload(7);
    profile_request request = test_request(&f.pair, &workload);
    profile_found found;
    duet_error err = {0};
    assert_ok(profile_lookup(f.s, &request, &found, NULL, &err), err);
    sqlite3_trace_v2(f.s->db, 0, NULL, NULL);
    assert_int_equal(found.grade, PROFILE_DEFAULT); // so that all rungs were tried
    assert_in_range(kept.n, 6, 32);
    text plan = {0};
    for (int i = 0; i < kept.n; ++i) {
        explain(f.s, kept.texts[i], &plan);
        free(kept.texts[i]);
    }
    assert_non_null(strstr(text_chars(&plan), "USING INDEX profile_live"));
    if (strstr(text_chars(&plan), "SCAN"))
        fail_msg("%s", text_chars(&plan));
    text_free(&plan);
    close_fixture(&f);
}

static void one_of_ten_thousand_is_found(void **state)
{
    (void)state;
    fixture f = open_fixture();
    test_fill(f.s, 10000);
    assert_int_equal(test_count(f.s, "profile WHERE live = 1"), 10000);
    for (uint32_t i = 0; i < 10000; i += 1111) {
        profile_workload workload = test_workload(1000 + i);
        profile_request request = test_request(&f.pair, &workload);
        profile_found found = look(f.s, &request);
        assert_int_equal(found.grade, PROFILE_EXACT);
        assert_int_equal(found.plan.share, i);
    }
    close_fixture(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_measured_here_is_exact),
        cmocka_unit_test(an_empty_store_gives_the_default),
        cmocka_unit_test(another_driver_is_said),
        cmocka_unit_test(another_devices_row_is_never_handed_out),
        cmocka_unit_test(a_size_between_two_is_interpolated),
        cmocka_unit_test(a_size_next_to_one_that_was_measured_takes_its_plan),
        cmocka_unit_test(a_tie_does_not_hide_what_was_measured),
        cmocka_unit_test(a_size_far_beyond_those_measured_is_a_guess_at_most),
        cmocka_unit_test(devices_measured_apart_are_transferred),
        cmocka_unit_test(fits_of_two_machines_are_not_joined),
        cmocka_unit_test(changed_kernels_make_a_row_a_starting_point),
        cmocka_unit_test(a_workload_of_another_kind_is_not_a_neighbour),
        cmocka_unit_test(more_accuracy_than_was_given_is_not_served),
        cmocka_unit_test(a_budget_takes_the_quickest_level_that_meets_it),
        cmocka_unit_test(a_fit_finds_the_times_it_was_made_from),
        cmocka_unit_test(a_fit_heeds_no_disturbed_times),
        cmocka_unit_test(a_fit_knows_what_it_does_not_know),
        cmocka_unit_test(a_look_up_leaves_no_trace),
        cmocka_unit_test(a_look_up_sees_what_a_tuner_at_work_has_stored),
        cmocka_unit_test(missing_files_give_the_default_without_failure),
        cmocka_unit_test(the_users_row_comes_before_the_systems),
        cmocka_unit_test(a_broken_user_file_leaves_the_systems),
        cmocka_unit_test(why_says_what_is_missing),
        cmocka_unit_test(why_says_when_the_row_is_of_another_machine),
        cmocka_unit_test(every_look_up_goes_by_an_index),
        cmocka_unit_test(one_of_ten_thousand_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
