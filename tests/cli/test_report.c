// SPDX-License-Identifier: MIT
// duet report: what the page holds. tests/browser opens one in a browser.
#include "support/program.h"
#include "support/store.h"
#include "support/test.h"

#include "profiles/sql.h"

#define PAGE "test_report.html"
#define RESULTS "test_report.json"
#define LEVELS "test_report.levels.json"
#define EFFECTS "test_report.effects.json"

static test_folder folder;

static void make_store(void)
{
    folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(100000);
    workload.name = "<b>boxes</b> & more";
    test_tune(s, &pair, &workload);
    must(sql_script(s, "UPDATE profile SET watched = 400, disturbed = 300", ERR));
    store_close(s);
    static const char results[] =
        "{\"type\":\"duet bench\",\"version\":1,\"duet\":\"1.0.0\",\"time\":\"then\","
        "\"devices\":[{\"name\":\"first\"},{\"name\":\"second\"}],\"cases\":["
        "{\"scene\":\"s\",\"objects\":9,\"share\":0,\"mode\":\"own\",\"variant_a\":\"auto\","
        "\"variant_b\":\"auto\",\"hash\":\"0\",\"median_ms\":2,\"low_ms\":1,\"high_ms\":3,"
        "\"a_ms\":0,\"b_ms\":2,\"samples_ms\":[1,2,3],"
        "\"stages\":[{\"name\":\"hash\",\"device\":\"B\",\"ms\":0.75},"
        "{\"name\":\"hash\",\"device\":\"B\",\"ms\":0.5}]},"
        "{\"scene\":\"s\",\"objects\":9,\"share\":1,\"mode\":\"own\",\"variant_a\":\"auto\","
        "\"variant_b\":\"auto\",\"failed\":\"it did not build\"}]}";
    static const char levels[] =
        "{\"type\":\"duet accuracy\",\"scene\":\"s\",\"objects\":9,\"pairs\":5,\"a\":\"x:0\","
        "\"b\":\"x:1\",\"levels\":[{\"level\":\"aabb\",\"device\":\"A\",\"step_ms\":1.5,"
        "\"relative\":0.75,\"missed\":0,\"false\":1234,\"front\":true}]}";
    static const char effects[] =
        "{\"type\":\"duet explain\",\"scene\":\"s\",\"objects\":9,\"steps\":3,\"step_ms\":2.5,"
        "\"effects\":[{\"effect\":\"gravity\",\"active\":true,\"called_by\":\"gravity\","
        "\"bytes\":0,\"ms\":0.375},{\"effect\":\"drag\",\"active\":false,"
        "\"called_by\":\"drag\",\"bytes\":0}]}";
    test_write_file(RESULTS, results);
    test_write_file(LEVELS, levels);
    test_write_file(EFFECTS, effects);
}

static text make_page(void)
{
    program p =
        program_run("report --profile %s -o " PAGE " " RESULTS " " RESULTS " " LEVELS " " EFFECTS,
                    folder.store);
    if (p.exit_code != 0)
        fail_msg("%s", p.err);
    return test_read_file(PAGE);
}

TEST(the_page_shows_profile_search_stages_and_history)
{
    const text page = make_page();
    static const char *const has[] = {"&lt;b&gt;boxes&lt;/b&gt; &amp; more, 100 000",
                                      "<h2>Searches</h2>",
                                      "share of A",
                                      "hash: 1.250 ms",
                                      "stroke-dasharray",
                                      "first",
                                      "<h2>Standard set: history</h2>",
                                      "1 234",
                                      "1.5 ms  0.75×",
                                      "2.500 ms a step with all of them",
                                      "0.375 ms",
                                      "s, 9 objects: the fastest step takes 2 ms, with 0 % of the "
                                      "work on A.",
                                      "On first and second.",
                                      "data-head=\"gain, %\"",
                                      "data-head=\"waited, %\">75<",
                                      "<h2>What the words mean</h2>",
                                      "1.25 ms</text>",
                                      NULL};
    assert_says_all(page.chars, has);
    assert_null(strstr(page.chars, ">drag<"));
}

TEST(of_one_device_the_page_shows_no_share)
{
    static const char results[] =
        "{\"type\":\"duet bench\",\"version\":1,\"duet\":\"1.0.0\",\"time\":\"then\","
        "\"devices\":[{\"selector\":\"x:0\",\"name\":\"only\"},{\"selector\":\"x:0\","
        "\"name\":\"only\"}],\"cases\":[{\"scene\":\"s\",\"objects\":9,\"share\":0,"
        "\"mode\":\"own\",\"variant_a\":\"simd\",\"variant_b\":\"gpu\",\"hash\":\"0\","
        "\"median_ms\":2,\"low_ms\":1,\"high_ms\":3,\"a_ms\":0,\"b_ms\":2,\"samples_ms\":[2],"
        "\"stages\":[{\"name\":\"hash\",\"device\":\"B\",\"ms\":0.75}]}],\"accuracy\":["
        "{\"type\":\"duet accuracy\",\"scene\":\"s\",\"objects\":9,\"pairs\":5,\"a\":\"x:0\","
        "\"b\":\"x:0\",\"levels\":[{\"level\":\"certified\",\"device\":\"B\","
        "\"step_ms\":1.5,\"relative\":1,\"missed\":0,\"false\":0,\"front\":true}]}]}";
    static const char *const has[] = {"<p>On only (x:0).</p>",
                                      "<p>x:0, only",
                                      "s, 9 objects: the fastest step takes 2 ms.",
                                      "the exact step takes 1.5 ms; no other",
                                      "gpu: 2.000 ms",
                                      "5 pairs; x:0",
                                      NULL};
    static const char *const lacks[] = {"no work", "Standard set: shares",  "A: x:0",
                                        "B: x:0",  "Standard set: history", "What became of"};
    test_write_file(RESULTS, results);
    program_done(program_run("report --profile %s -o " PAGE " " RESULTS, folder.store));
    text page = test_read_file(PAGE);
    assert_says_all(page.chars, has);
    for (size_t i = 0; i < sizeof lacks / sizeof lacks[0]; ++i)
        if (strstr(page.chars, lacks[i]))
            fail_msg("'%s' is on the page", lacks[i]);
}

// Gives what the page says of its only profile, from the share on; the caller frees it.
static text profile_row_of(double share)
{
    own(text) change = {0};
    text row = {0};
    text_add(&change, "UPDATE profile SET share = %d, verdict = 'slower', gain = -0.2611",
             (int)(share * 65536));
    test_store_run(folder.store, text_chars(&change));
    program_done(program_run("report --profile %s -o " PAGE, folder.store));
    const text page = test_read_file(PAGE);
    const char *from = strstr(page.chars, "data-head=\"share of A\"");
    assert_non_null(from);
    text_add_bytes(&row, from, (size_t)(strstr(from, "</tr>") - from));
    return row;
}

TEST(a_plan_of_one_device_has_no_gain_and_no_verdict)
{
    static const char *const plans[] = {"B alone", "A alone"};
    for (int share = 0; share < 2; ++share) {
        own(text) row = profile_row_of(share);
        assert_says(row.chars, plans[share]);
        assert_null(strstr(row.chars, "-26.1"));
        assert_null(strstr(row.chars, "slower"));
    }
    own(text) shared = profile_row_of(0.5);
    assert_says(shared.chars, "50.0 %", "-26.1", "slower");
}

TEST(a_page_without_a_name_is_told_of)
{
    program p = program_done(program_run("report --profile %s", folder.store));
    assert_string_equal(p.out, "-> duet-report.html\n");
    assert_int_equal(remove("duet-report.html"), 0);
}

TEST(one_slow_step_does_not_flatten_the_others)
{
    own(text) results = {0};
    text_add(&results, "{\"type\":\"duet bench\",\"version\":1,\"duet\":\"1.0.0\",\"time\":"
                       "\"then\",\"devices\":[{},{}],\"cases\":[");
    for (int i = 0; i < 5; ++i)
        text_add(&results,
                 "%s{\"scene\":\"s\",\"objects\":9,\"share\":%g,\"mode\":\"own\","
                 "\"variant_a\":\"auto\",\"variant_b\":\"auto\",\"hash\":\"0\","
                 "\"median_ms\":%d,\"low_ms\":1,\"high_ms\":3,\"a_ms\":1,\"b_ms\":2,"
                 "\"samples_ms\":[2],\"stages\":[]}",
                 i ? "," : "", i / 4.0, i == 2 ? 700 : 2);
    text_add(&results, "]}");
    test_write_file(RESULTS, text_chars(&results));
    program_done(program_run("report --profile %s -o " PAGE " " RESULTS, folder.store));
    const text page = test_read_file(PAGE);
    assert_says(page.chars, "1 above, up to 700 ms",
                ">1.5</text>"); // a tick of an axis that ends near 2
}

TEST(the_page_loads_nothing)
{
    const text page = make_page();
    static const char *const outside[] = {"http:", "https:", "url(", "src=", "<script", "@import"};
    for (size_t i = 0; i < sizeof outside / sizeof outside[0]; ++i)
        if (strstr(page.chars, outside[i]))
            fail_msg("'%s' is on the page", outside[i]);
}

TEST(names_are_words_and_no_markup)
{
    const text page = make_page();
    assert_null(strstr(page.chars, "<b>"));
    assert_says(page.chars, "&lt;b&gt;boxes&lt;/b&gt; &amp; more");
}

TEST(what_cannot_be_read_or_written_is_one_line)
{
    program_assert_refused(program_run("report --profile no/such.db -o " PAGE), 1, "no/such.db");
    program_assert_refused(program_run("report -o " PAGE " no/such.json"), 1, "no/such.json");
    program_assert_refused(program_run("report -o " PAGE " %s", folder.store), 1,
                           "so this is no text");
    static const char unmeasured[] = "{\"type\":\"duet explain\",\"scene\":\"s\",\"objects\":1,"
                                     "\"steps\":0,\"effects\":[]}";
    test_write_file(PAGE, unmeasured);
    program_assert_refused(program_run("report -o x.html " PAGE), 1,
                           PAGE ": no times; 'duet explain --measure' takes them");
    program_assert_refused(program_run("report --profile %s -o no/such/folder.html", folder.store),
                           1, "no/such/folder.html");
}

// Each is a result with one number that nothing measures.
TEST(numbers_that_nothing_measures_are_refused)
{
    static const char accuracy[] =
        "{\"type\":\"duet accuracy\",\"scene\":\"s\",\"objects\":9,\"pairs\":%s,\"a\":\"x\","
        "\"b\":\"y\",\"levels\":[{\"level\":\"aabb\",\"device\":\"A\",\"step_ms\":%s,"
        "\"relative\":1,\"missed\":%s,\"false\":0}]}";
    static const struct {
        const char *pairs, *step_ms, *missed, *says;
    } wrong[] = {
        {"1e120", "1", "0", "'pairs' is not a whole number from 0 to 2^53"},
        {"-1", "1", "0", "'pairs' is not a whole number from 0 to 2^53"},
        {"1.5", "1", "0", "'pairs' is not a whole number from 0 to 2^53"},
        {"1e999", "1", "0", "'pairs' is not a whole number from 0 to 2^53"},
        {"1", "1e999", "0", "level 0: 'step_ms' is not a number from 0 to 2^53"},
        {"1", "-1", "0", "level 0: 'step_ms' is not a number from 0 to 2^53"},
        {"1", "1", "1e19", "level 0: 'missed' is not a whole number from 0 to 2^53"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        char results[512];
        snprintf(results, sizeof results, accuracy, wrong[i].pairs, wrong[i].step_ms,
                 wrong[i].missed);
        test_write_file(PAGE, results);
        program_assert_refused(program_run("report -o x.html " PAGE), 1, wrong[i].says);
    }
}

TEST_BEGIN(make_store)
