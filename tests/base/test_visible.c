// SPDX-License-Identifier: MIT
// Text of strangers, on its way to a terminal, into JSON and into a page.
#define _GNU_SOURCE
#include "support/json.h"
#include "support/test.h"

#include "base/visible.h"
#include "support/store.h"

// Decodes by the definition: how many bits each byte adds, then what a code
// point may be and how short it could have been. 0 where it is none.
static size_t length_by_definition(const unsigned char *u, size_t n, uint32_t *point)
{
    size_t ones = 0;
    while (ones < 8 && u[0] & 0x80 >> ones)
        ++ones;
    size_t length = ones == 0 ? 1 : ones;
    if (ones == 1 || ones > 4 || length > n)
        return 0;
    *point = ones == 0 ? u[0] : u[0] & 0xffu >> (ones + 1);
    for (size_t i = 1; i < length; ++i) {
        if (u[i] >> 6 != 2)
            return 0;
        *point = *point << 6 | (u[i] & 0x3f);
    }
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    bool right = *point >= least[length] && *point <= 0x10ffff && !(*point >> 11 == 0x1b);
    return right ? length : 0;
}

TEST(characters_are_those_of_the_definition)
{
    rng r = rng_seed(test_seed());
    uint32_t n_right = 0;
    for (int round = 0; round < 300000; ++round) {
        char bytes[5] = {0};
        uint32_t point = 0;
        uint32_t first = rng_below(&r, 256);
        bytes[0] = (char)first;
        for (int i = 1; i < 4; ++i)
            bytes[i] = (char)(rng_below(&r, 4) ? 0x80 + rng_below(&r, 64) : rng_below(&r, 256));
        size_t length = length_by_definition((unsigned char *)bytes, 4, &point);
        assert_int_equal(utf8_length(bytes), length);
        n_right += length > 1;
    }
    assert_true(n_right > 1000);
}

static void write_in(char *line, size_t size, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    visible_write(line, size, format, args);
    va_end(args);
}

TEST(a_long_line_of_no_text_is_cut_within_its_space)
{
    char given[3001], guarded[101];
    memset(given, 0x80, sizeof given - 1);
    given[sizeof given - 1] = '\0';
    memset(guarded, 'G', sizeof guarded);
    write_in(guarded + 1, sizeof guarded - 1, "%s", given);
    assert_int_equal(guarded[0], 'G');
    assert_true(strlen(guarded + 1) < sizeof guarded - 1);
    assert_non_null(strstr(guarded + 1, "..."));
}

TEST(nothing_that_a_terminal_obeys_comes_through)
{
    rng r = rng_seed(test_seed());
    for (int round = 0; round < 20000; ++round) {
        char bytes[24];
        own(text) shown = {0}, valid = {0};
        size_t n = 1 + rng_below(&r, sizeof bytes);
        for (size_t i = 0; i < n; ++i)
            bytes[i] = (char)rng_below(&r, 256);
        text_add_visible(&shown, bytes, n, "");
        bytes[n - 1] = '\0';
        text_add_json(&valid, bytes);
        const unsigned char *u = (const unsigned char *)shown.chars;
        for (size_t i = 0, length = 0; i < shown.length; i += length) {
            uint32_t point = 0;
            length = length_by_definition(u + i, shown.length - i, &point);
            assert_true(length > 0 && point >= 0x20 && !(point >= 0x7f && point < 0xa0));
        }
        u = (const unsigned char *)valid.chars;
        for (size_t i = 0, length = 0; i < valid.length; i += length) {
            uint32_t point = 0;
            length = length_by_definition(u + i, valid.length - i, &point);
            assert_true(length > 0 && !(point >= 0x7f && point < 0xa0));
        }
    }
}

TEST(what_is_harmless_stays_as_it_is)
{
    static const char plain[] = "a b\\x \"c\" \xc3\xa9\xe2\x82\xac\xf0\x9f\xa6\x86";
    static const char odd[] = "\x1b[2J\n\t\x7f\xc2\x9b\xff\xc3";
    text shown = {0};
    text_add_visible(&shown, plain, strlen(plain), "");
    assert_string_equal(shown.chars, plain);
    assert_true(utf8_is_valid(plain) && !utf8_is_valid(odd));
    text_free(&shown);
    text_add_visible(&shown, odd, strlen(odd), "\n\t");
    assert_string_equal(shown.chars, "\\x1b[2J\n\t\\x7f\\xc2\\x9b\\xff\\xc3");
    text_free(&shown);
    text_add_json(&shown, odd + 6);
    assert_string_equal(shown.chars, "\\u007f\\u009b\xef\xbf\xbd\xef\xbf\xbd");
    text_free(&shown);
}

TEST(an_error_line_is_visible_and_whole)
{
    duet_error err = {0};
    error_set(&err, DUET_STATUS_NOT_FOUND, "\x1b]0;x\x07 and\ntwo \xff: %s", "\xc3\xa9");
    assert_string_equal(err.text, "\\x1b]0;x\\x07 and two \\xff: \xc3\xa9");
    for (int i = 0; i < 4; ++i) {
        char longest[600];
        memset(longest, 'x', sizeof longest);
        for (size_t k = 470 + (size_t)i; k + 2 < sizeof longest; k += 2)
            memcpy(longest + k, "\xc3\xa9", 2);
        longest[599] = '\0';
        err = (duet_error){0};
        error_set(&err, DUET_STATUS_NOT_FOUND, "%s", longest);
        assert_true(utf8_is_valid(err.text));
        assert_null(strstr(err.text, "\\x"));
    }
}

// ------------------------------------------------------------------ the program

// No control character but newline and tab, and UTF-8 throughout.
static void assert_fit(const char *what, const char *chars)
{
    own(text) shown = {0};
    text_add_visible(&shown, chars, strlen(chars), "\n\t");
    if (shown.chars && strcmp(shown.chars, chars) != 0)
        fail_msg("%s prints %s", what,
                 strstr(shown.chars, "\\x") ? strstr(shown.chars, "\\x") : shown.chars);
}

static void assert_json(const char *what, const char *chars)
{
    cJSON *o = json_of(chars);
    if (!cJSON_IsObject(o))
        fail_msg("%s is no JSON object: %s", what, chars);
}

// A store whose every text that may be any is hostile.
static void make_hostile(const char *path, const char *name)
{
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    store *s = test_store_open(path, STORE_WRITE);
    test_tune(s, &pair, &workload);
    store_close(s);
    own(text) sql = {0};
    static const char *const columns[] = {
        "device.name",          "device.vendor",   "device.key",
        "env.driver",           "env.part",        "env.platform_version",
        "workload.name",        "workload.family", "profile.variant_a",
        "profile.variant_b",    "profile.level",   "session.strategy",
        "session.tool_version", "trial.variant_a", "trial.reason"};
    for (size_t i = 0; i < sizeof columns / sizeof columns[0]; ++i) {
        const char *dot = strchr(columns[i], '.');
        text_add(&sql, "UPDATE %.*s SET %s = CAST(x'", (int)(dot - columns[i]), columns[i],
                 dot + 1);
        for (const char *c = name; *c; ++c)
            text_add(&sql, "%02x", (unsigned)(unsigned char)*c);
        text_add(&sql, "' AS TEXT)%s;", strcmp(dot, ".key") == 0 ? " || id" : "");
    }
    text_add(&sql, "UPDATE profile SET terms = '{\"x\":1},\"evil\":{\"a\":2}';"
                   "UPDATE trial SET terms = '{broken}';"
                   "UPDATE session SET options = '{} , {}';");
    test_store_run(path, text_chars(&sql));
}

static const char *const hostile[] = {
    "\x1b]0;owned\x07\x1b[2J",
    "\xff\xc3(\xe2\x82",
    "a\nb\tc",
    ("\xc2\x9b"
     "31m"),
    "</title><b>&\"\x7f",
};

TEST(names_from_a_store_do_no_harm_anywhere)
{
    static const char *const commands[] = {"list",  "list --json",  "list --dead",
                                           "check", "check --json", "export"};
    for (size_t i = 0; i < sizeof hostile / sizeof hostile[0]; ++i) {
        test_folder folder = test_folder_make();
        make_hostile(folder.store, hostile[i]);
        for (size_t k = 0; k < sizeof commands / sizeof commands[0]; ++k) {
            program p = program_run("profiles %s --profile %s", commands[k], folder.store);
            assert_fit(commands[k], p.out);
            assert_fit(commands[k], p.err);
            if (strstr(commands[k], "--json"))
                assert_json(commands[k], p.out);
            assert_int_equal(p.exit_code, strncmp(commands[k], "check", 5) == 0);
        }
    }
}

TEST(a_profile_is_shown_without_what_was_smuggled_in)
{
    for (size_t i = 0; i < sizeof hostile / sizeof hostile[0]; ++i) {
        test_folder folder = test_folder_make();
        make_hostile(folder.store, hostile[i]);
        program p = program_done(program_run("profiles show '' --profile %s --json", folder.store));
        assert_json("show", p.out);
        assert_fit("show", p.out);
        assert_null(strstr(p.out, "evil"));
        p = program_done(program_run("profiles show '' --profile %s", folder.store));
        assert_fit("show", p.out);
    }
}

TEST(a_page_of_such_a_store_is_utf8_and_holds_no_markup_of_it)
{
    for (size_t i = 0; i < sizeof hostile / sizeof hostile[0]; ++i) {
        test_folder folder = test_folder_make();
        make_hostile(folder.store, hostile[i]);
        program_done(program_run("report --profile %s -o %s/page.html", folder.store, folder.path));
        char path[96];
        snprintf(path, sizeof path, "%s/page.html", folder.path);
        const text page = test_read_file(path);
        assert_fit("the page", text_chars(&page));
        assert_null(strstr(text_chars(&page), "</title><b>"));
    }
}

TEST(a_scenes_name_is_shown_harmlessly)
{
    test_folder folder = test_folder_make();
    char path[160];
    for (size_t i = 0; i < 4; ++i) {
        snprintf(path, sizeof path, "%s/%s.csv", folder.path, hostile[i]);
        test_write_file(path, "0 0 0 1 1 1\n");
        duet_scene *scene = kept(duet_scene_load(path, NULL, 0, ERR));
        assert_fit("a scene's name", duet_scene_get_info(scene)->name);
        assert_null(strchr(duet_scene_get_info(scene)->name, '\n'));
    }
}
