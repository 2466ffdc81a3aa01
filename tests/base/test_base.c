// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "base/budget.h"
#include "base/list.h"
#include "base/text_file.h"

TEST(the_first_failure_is_kept)
{
    duet_error err = {0};
    assert_false(error_set(&err, DUET_STATUS_NOT_FOUND, "a\nb"));
    assert_false(error_set_cl(&err, -5, "later"));
    assert_int_equal(err.status, DUET_STATUS_NOT_FOUND);
    assert_string_equal(err.text, "a b");
    assert_false(error_set(NULL, DUET_STATUS_NOT_FOUND, "nobody listens"));
}

// A public call that first does as another one, and goes on where that fails.
static bool call_twice(bool first, bool second, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!first)
        error_set(err, DUET_STATUS_NOT_FOUND, "the first");
    if (!second)
        error_set(err, DUET_STATUS_IO_FAILED, "the second");
    return first && second;
}

static bool call_within(bool before, bool first, bool second, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!before)
        error_set(err, DUET_STATUS_BAD_INPUT, "before");
    return call_twice(first, second, err) && before;
}

TEST(each_public_call_has_its_own_first_failure)
{
    duet_error err = {
        .cl_code = -5, .status = DUET_STATUS_DEVICE_FAILED, .text = "an earlier call"};
    const duet_error earlier = err;
    for (int i = 0; i < 8; ++i) {
        bool before = i & 1, first = i & 2, second = i & 4, ok = before && first && second;
        const char *says = ok        ? earlier.text
                           : !before ? "before"
                           : !first  ? "the first"
                                     : "the second";
        err = earlier;
        assert_int_equal(call_within(before, first, second, &err), ok);
        assert_string_equal(err.text, says);
        assert_int_equal(err.cl_code, ok ? -5 : 0);
        assert_int_equal(err.status == DUET_STATUS_DEVICE_FAILED, ok);
        assert_int_equal(call_within(before, first, second, NULL), ok);
    }
    assert_false(call_twice(false, true, &err));
    assert_string_equal(err.text, "the first");
    assert_false(call_twice(true, false, &err));
    assert_string_equal(err.text, "the second");
}

// Whatever a path's length, the line says what is wrong with it.
TEST(what_is_too_long_loses_its_middle)
{
    enum { MOST = 1200 };
    static const char *const letters[] = {"a", "\xc3\xa9", "\xe2\x82\xac"};
    char path[3 * MOST + 1] = "";
    for (int kind = 0; kind < 3; ++kind) {
        *path = '\0';
        for (int n = 0; n < MOST; ++n) {
            duet_error err = {0};
            error_set(&err, DUET_STATUS_NOT_FOUND, "in %s: no such file", path);
            size_t length = strlen(err.text);
            bool fits = strlen(path) + strlen("in : no such file") < sizeof err.text;
            assert_int_equal(strncmp(err.text, "in ", 3), 0);
            assert_string_equal(err.text + length - strlen(": no such file"), ": no such file");
            assert_int_equal(!strstr(err.text, "..."), fits);
            assert_null(strstr(err.text, "\\x")); // no character is cut
            strcat(path, letters[kind]);
        }
    }
}

TEST(an_opencl_failure_names_its_code)
{
    duet_error err = {0};
    error_set_cl(&err, -5, "clFinish on %s", "pocl:0");
    assert_string_equal(err.text, "clFinish on pocl:0: CL_OUT_OF_RESOURCES (-5)");
    assert_int_equal(err.cl_code, -5);
    assert_int_equal(err.status, DUET_STATUS_DEVICE_FAILED);
}

TEST(a_text_grows_and_survives_a_file)
{
    own(text) t = {0};
    for (int i = 0; i < 1000; ++i)
        text_add(&t, "%d,", i);
    must(text_write_file("test_base.tmp", t.chars, t.length, ERR));
    const text back = test_read_file("test_base.tmp");
    assert_int_equal(back.length, t.length);
    assert_memory_equal(back.chars, t.chars, t.length);
}

// Its items stay, whatever was taken from its end meanwhile.
TEST(a_list_has_space_for_one_item_more)
{
    uint32_t *list = NULL, n = 0;
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 20000; ++i) {
        if (rng_below(&r, 300) == 0)
            n -= rng_below(&r, n + 1);
        list = must(list_room(list, n, sizeof *list, ERR));
        list[n] = n;
        ++n;
    }
    for (uint32_t i = 0; i < n; ++i)
        assert_int_equal(list[i], i);
    free(list);
}

TEST(a_list_takes_no_more_than_a_script_may)
{
    budget none = {.deadline_ns = UINT64_MAX, .host_bytes = 1};
    budget_enter(&none);
    must_fail(list_room(NULL, 0, sizeof(double), ERR), DUET_STATUS_NO_MEMORY, "");
    budget_leave(&none);
}

TEST(a_missing_file_and_a_folder_are_named)
{
    own(text) t = {0};
    must_fail(text_read_file(&t, "no/such/file", ERR), DUET_STATUS_NOT_FOUND, "no/such/file");
    must_fail(text_read_file(&t, "/", ERR), DUET_STATUS_IO_FAILED, "");
}

TEST(random_numbers_are_the_same_everywhere)
{
    rng r = rng_seed(42);
    rng s = rng_seed(42);
    uint32_t counts[7] = {0};
    for (int i = 0; i < 70000; ++i) {
        uint32_t drawn = rng_below(&r, 7);
        assert_int_equal(drawn, rng_below(&s, 7));
        ++counts[drawn];
    }
    for (int i = 0; i < 7; ++i)
        assert_in_range(counts[i], 9500, 10500);
}
