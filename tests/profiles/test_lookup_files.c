// SPDX-License-Identifier: MIT
// An application looks into two files and leaves no trace, says why, and goes by
// an index.
#define _GNU_SOURCE
#include "support/test.h"

#include "base/text_file.h"
#include "profiles/sql.h"
#include "support/look.h"

#include <dirent.h>
#include <unistd.h>

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

TEST(a_look_up_leaves_no_trace)
{
    look_fixture f = look_open();
    look_tune(&f, 100000);
    test_give_back(f.s);
    const text before = test_read_file(f.folder.store);
    usleep(100000); // until the file counts as settled
    int entries = count_entries(f.folder.path);
    assert_int_equal(look_in_files(f.folder.store, NULL, 100000).grade, PROFILE_EXACT);
    assert_int_equal(count_entries(f.folder.path), entries);
    const text after = test_read_file(f.folder.store);
    assert_int_equal(after.length, before.length);
    assert_memory_equal(after.chars, before.chars, before.length);
    f.s = NULL;
}

TEST(a_look_up_sees_what_a_tuner_at_work_has_stored)
{
    look_fixture f = look_open();
    look_tune(&f, 100000); // still open: the rows are in the side file
    assert_int_equal(look_in_files(f.folder.store, NULL, 100000).grade, PROFILE_EXACT);
}

TEST(missing_files_give_the_default_without_failure)
{
    profile_request request = test_usual_request(1000);
    profile_found found;
    own(text) why = {0};
    must(profile_lookup_files("no/such.db", "nor/this.db", &request, &found, &why, ERR));
    assert_int_equal(found.grade, PROFILE_DEFAULT);
    assert_says(text_chars(&why), "no/such.db", "nor/this.db");
}

TEST(the_users_row_comes_before_the_systems)
{
    look_fixture user = look_open();
    look_fixture system = look_open();
    look_tune(&user, 100000);
    look_tune(&system, 100000);
    look_tune(&system, 700000);
    look_change(&system, "UPDATE profile SET share = 1");
    profile_found found = look_in_files(user.folder.store, system.folder.store, 100000);
    assert_int_equal(found.plan.share, 8192);
    found = look_in_files(user.folder.store, system.folder.store, 700000);
    assert_int_equal(found.grade, PROFILE_EXACT);
    assert_int_equal(found.plan.share, 1);
}

TEST(a_broken_user_file_leaves_the_systems)
{
    look_fixture user = look_open();
    look_fixture system = look_open();
    look_tune(&system, 100000);
    test_give_back(user.s);
    must(text_write_file(user.folder.store, "rubbish", 7, ERR));
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&user.pair, &workload);
    profile_found found;
    must_fail(
        profile_lookup_files(user.folder.store, system.folder.store, &request, &found, NULL, ERR),
        DUET_STATUS_STORE_FAILED, user.folder.store);
    assert_int_equal(found.grade, PROFILE_EXACT);
}

// ------------------------------------------------------------------------------ why

TEST(why_says_what_is_missing)
{
    look_fixture f = look_open();
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    look_assert_why(f.s, &request, "exact        no: device A was never measured");
    look_tune(&f, 100000);
    look_assert_why(f.s, &request, "exact        yes: measured 20");
    look_assert_why(f.s, &request, "on this machine");
    request.kernels = "another";
    look_assert_why(f.s, &request, "exact        no: the kernels changed since");
    look_assert_why(f.s, &request, "stale        yes: ");
    request.kernels = TEST_KERNELS;
    request.objective = "energy";
    look_assert_why(f.s, &request, "measured for another objective");
    request.objective = "time";
    request.max_missed_rate = -1;
    look_assert_why(f.s, &request,
                    "no: for each true pair it misses 0 and adds 0 false ones, above -1 or inf");
    request.max_missed_rate = INFINITY;
    workload = test_workload(300000);
    look_assert_why(f.s, &request, "exact        no: no such workload");
    profile_pair pair = f.pair;
    pair.a.part = "0-1";
    request.pair = &pair;
    look_assert_why(f.s, &request, "transferred  no: one of the devices was never measured");
}

TEST(why_says_when_the_row_is_of_another_machine)
{
    look_fixture f = look_open();
    look_tune(&f, 100000);
    look_change(&f, "UPDATE session SET host = 'elsewhere'");
    profile_workload workload = test_workload(100000);
    profile_request request = test_request(&f.pair, &workload);
    look_assert_why(f.s, &request, "another machine with such devices");
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
    own(text) query = {0};
    text_add(&query, "EXPLAIN QUERY PLAN %s", statement);
    sql q = sql_make(s, text_chars(&query), ERR);
    while (sql_row(&q))
        text_add(plan, "%s\n", sql_get_text(&q, 3));
    must(sql_close(&q));
}

// No rung may read a table from end to end, however many profiles there are.
TEST(every_look_up_goes_by_an_index)
{
    look_fixture f = look_open();
    test_fill(f.s, 100);
    statements kept = {0};
    sqlite3_trace_v2(f.s->db, SQLITE_TRACE_STMT, keep_statement, &kept);
    profile_workload workload = test_workload(7);
    profile_request request = test_request(&f.pair, &workload);
    profile_found found;
    must(profile_lookup(f.s, &request, &found, NULL, ERR));
    sqlite3_trace_v2(f.s->db, 0, NULL, NULL);
    assert_int_equal(found.grade, PROFILE_DEFAULT); // so that all grades were tried
    assert_in_range(kept.n, 6, 32);
    own(text) plan = {0};
    for (int i = 0; i < kept.n; ++i) {
        explain(f.s, kept.texts[i], &plan);
        free(kept.texts[i]);
    }
    assert_says(text_chars(&plan), "USING INDEX profile_live");
    if (strstr(text_chars(&plan), "SCAN"))
        fail_msg("%s", text_chars(&plan));
}

TEST(one_of_ten_thousand_is_found)
{
    look_fixture f = look_open();
    test_fill(f.s, 10000);
    assert_int_equal(test_count(f.s, "profile WHERE live = 1"), 10000);
    for (uint32_t i = 0; i < 10000; i += 1111) {
        profile_workload workload = test_workload(1000 + i);
        profile_request request = test_request(&f.pair, &workload);
        profile_found found = look_up(f.s, &request);
        assert_int_equal(found.grade, PROFILE_EXACT);
        assert_int_equal(found.plan.share, i);
    }
}
