// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "support/golden.h"
#include "support/test.h"

#include "base/text.h"
#include "gen/gen.h"

#include <sha256.h>

static const gen_limits gpu = {.max_group = 1024, .local_bytes = 48 << 10, .fp64 = true};
static const gen_limits cpu = {
    .max_group = 4096, .local_bytes = 1 << 20, .fp64 = true, .cpu = true};

static gen *open_test_kernels(void)
{
    own(text) dir = {0};
    text_add(&dir, "%s/kernels", getenv("DUET_TEST_DATA"));
    gen *g = kept(gen_open(dir.chars, ERR));
    return g;
}

// ------------------------------------------------------- a folder of its own

static char folder[64];
static char made[4096]; // the text that make_with made

static void write_file(const char *name, const char *chars)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    test_write_file(path, chars);
}

// A kernel k in a folder of its own; returns what making it with the settings
// says.
static duet_error make_with(const char *card, const char *body_file, const char *body)
{
    test_make_folder(folder);
    write_file("common.clh", "// shared\n");
    write_file("k.lua", card);
    write_file(body_file, body);
    duet_error err = {0};
    gen *g = kept(gen_open(folder, ERR));
    own(gen_variant) v;
    bool ok = gen_make(g, "k", NULL, 0, &gpu, &v, &err);
    assert_int_equal(ok, v.text != NULL);
    snprintf(made, sizeof made, "%s", ok ? v.text : "");
    return err;
}

// The same where it must succeed.
static void make_well(const char *card, const char *body_file, const char *body)
{
    *ERR = make_with(card, body_file, body);
    if (ERR->status != DUET_STATUS_OK)
        fail_msg("%s", ERR->text);
}

static void expect(duet_error err, duet_status status, const char *wanted)
{
    if (err.status != status || !strstr(err.text, wanted))
        fail_msg("%s %s, wanted %s", duet_status_name(err.status), err.text, wanted);
}

#define CARD(params, rest)                          \
    "return {\n  params = { " params " },\n  " rest \
    "\n  launch = function(p) return { group = 1, per_item = 1 } end,\n}\n"

// ------------------------------------------------------- texts

TEST(the_same_config_gives_the_same_bytes)
{
    gen_setting settings[] = {{"FACTOR", 2}, {"WG", 256}};
    gen_variant first, second;
    gen *g = open_test_kernels();
    gen *other = open_test_kernels();
    must(gen_make(g, "plain", settings, 2, &gpu, &first, ERR));
    must(gen_make(g, "plain", NULL, 0, &gpu, &second, ERR));
    gen_variant_free(&second);
    must(gen_make(other, "plain", settings, 2, &gpu, &second, ERR));
    assert_string_equal(first.text, second.text);
    assert_string_equal(first.sha256, second.sha256);
    assert_int_equal(strlen(first.sha256), 64);
    gen_variant_free(&first);
    gen_variant_free(&second);
}

// In any order, and for both kinds of device: as a gen makes it that never made another.
TEST(what_was_made_before_changes_no_text)
{
    duet_error err = {0};
    rng r = rng_seed(test_seed());
    gen *g = kept(gen_open(NULL, ERR));
    static const char *const names[] = {"pair_search_simd", "hash", "scan"};
    for (int i = 0; i < 30; ++i) {
        const char *name = names[rng_below(&r, 3)];
        const gen_limits *limits = rng_below(&r, 2) ? &gpu : &cpu;
        gen_setting config[64];
        own(gen_variant) used, fresh;
        const gen_param *params;
        uint32_t n;
        uint64_t count;
        gen *other = gen_open(NULL, &err);
        must(other && gen_params(g, name, limits, &params, &n, ERR) &&
             gen_count(g, name, limits, &count, ERR) &&
             gen_config(g, name, limits, rng_below(&r, count < 4 ? count : 4), config, ERR));
        must(gen_make(g, name, config, n, limits, &used, ERR));
        must(gen_make(other, name, config, n, limits, &fresh, ERR));
        assert_string_equal(used.text, fresh.text);
        assert_string_equal(used.sha256, fresh.sha256);
        assert_string_equal(used.name, fresh.name);
        assert_int_equal(used.n_entries, fresh.n_entries);
        gen_close(other);
    }
}

TEST(the_hash_is_of_the_text)
{
    gen *g = open_test_kernels();
    own(gen_variant) v;
    must(gen_make(g, "plain", NULL, 0, &gpu, &v, ERR));
    char sum[65];
    SHA256Data((const uint8_t *)v.text, strlen(v.text), sum);
    assert_string_equal(v.sha256, sum);
}

TEST(texts_are_as_expected)
{
    gen *g = open_test_kernels();
    gen_variant v;
    for (int64_t dims = 2; dims <= 3; ++dims) {
        gen_setting setting = {"DIMS", dims};
        must(gen_make(g, "shaped", &setting, 1, &gpu, &v, ERR));
        golden_check(dims == 2 ? "shaped.2d.cl" : "shaped.3d.cl", v.text);
        gen_variant_free(&v);
    }
    must(gen_make(g, "plain", NULL, 0, &gpu, &v, ERR));
    golden_check("plain.gpu.cl", v.text);
    gen_variant_free(&v);
}

TEST(a_variant_is_named_by_what_varies)
{
    gen_setting settings[] = {{"SHIFT", 5}, {"PER_ITEM", 1}, {"FACTOR", 3}};
    gen *g = open_test_kernels();
    own(gen_variant) v;
    must(gen_make(g, "plain", settings, 3, &cpu, &v, ERR));
    assert_string_equal(v.name, "plain.FACTOR3.WG1.PER_ITEM1");
    assert_says(v.text, "#define SHIFT 5\n");
    assert_int_equal(v.group, 1);
    assert_int_equal(v.per_item, 1);
}

// ------------------------------------------------------- configs

TEST(settings_that_do_not_fit_are_refused)
{
    static const struct {
        const char *kernel;
        gen_setting setting;
        duet_status status;
        const char *wanted;
    } cases[] = {
        {"plane",
         {"WG", 1},
         DUET_STATUS_BAD_ARGUMENT,
         "/tests/data/kernels: there are plain, shaped"},
        {"plain",
         {"WGG", 1},
         DUET_STATUS_BAD_ARGUMENT,
         "plain: no parameter 'WGG': there are FACTOR, SHIFT, WG, PER_ITEM"},
        {"plain", {"WG", 7}, DUET_STATUS_BAD_ARGUMENT, "plain: WG=7 is not one of 1, 64, 256"},
        {"plain", {"SHIFT", 9}, DUET_STATUS_BAD_ARGUMENT, "plain: SHIFT=9 is not in -8 .. 8"},
        {"plain",
         {"FACTOR", 3},
         DUET_STATUS_BAD_ARGUMENT,
         "plain: not a valid config: 3 is done one by one"},
    };
    gen *g = open_test_kernels();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        gen_variant v;
        must_fail(gen_make(g, cases[i].kernel, &cases[i].setting, 1, &gpu, &v, ERR),
                  cases[i].status, cases[i].wanted);
        assert_null(v.text);
    }
}

TEST(a_kernel_takes_the_offers_that_are_for_it)
{
    bool taken[5] = {false};
    const gen_offer offers[] = {
        {NULL, "SHIFT", 5, GEN_OFFERED, &taken[0]},   {"", "SHIFT", 3, GEN_OFFERED, &taken[1]},
        {NULL, "DIMS", 2, GEN_OFFERED, &taken[2]},    {"plain", "WG", 1000, GEN_CAPPED, &taken[3]},
        {"shaped", "WG", 1, GEN_REQUIRED, &taken[4]},
    };
    const bool meant[5] = {true, true, false, true, false};
    const gen_setting settings[] = {{"SHIFT", 3}, {"WG", 256}};
    gen *g = open_test_kernels();
    own(gen_variant) offered, set;
    must(gen_make_offered(g, "plain", offers, 5, &gpu, &offered, ERR));
    must(gen_make(g, "plain", settings, 2, &gpu, &set, ERR));
    assert_string_equal(offered.text, set.text);
    assert_string_equal(offered.name, set.name);
    assert_memory_equal(taken, meant, sizeof taken);
}

TEST(offers_that_do_not_fit_are_refused)
{
    static const struct {
        gen_offer offer;
        const char *wanted;
    } cases[] = {
        {{NULL, "DIMS", 2, GEN_REQUIRED, NULL}, "plain: no parameter 'DIMS': there are FACTOR"},
        {{NULL, "SHIFT", 9, GEN_OFFERED, NULL}, "plain: SHIFT=9 is not in -8 .. 8"},
        {{"plain", "WG", 7, GEN_CAPPED, NULL}, "plain: WG=7 is not one of 1, 64, 256"},
    };
    gen *g = open_test_kernels();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        gen_variant v;
        must_fail(gen_make_offered(g, "plain", &cases[i].offer, 1, &gpu, &v, ERR),
                  DUET_STATUS_BAD_ARGUMENT, cases[i].wanted);
        assert_null(v.text);
    }
}

TEST(a_group_above_the_device_is_never_valid)
{
    gen_limits small = gpu;
    small.max_group = 32;
    gen *g = open_test_kernels();
    gen_variant v;
    must_fail(gen_make(g, "plain", NULL, 0, &small, &v, ERR), DUET_STATUS_BAD_ARGUMENT,
              "a group of 64 is above the device's 32");
}

TEST(defaults_follow_the_limits)
{
    const gen_param *params = NULL;
    uint32_t n = 0;
    gen *g = open_test_kernels();
    must(gen_params(g, "plain", &gpu, &params, &n, ERR));
    assert_int_equal(n, 4);
    assert_string_equal(params[2].name, "WG");
    assert_int_equal(params[2].fallback, 64);
    assert_int_equal(params[2].n_values, 3);
    assert_int_equal(params[2].values[1], 64);
    assert_string_equal(params[1].about, "what is added");
    assert_true(params[1].is_range);
    assert_int_equal(params[1].fallback, -1);
    assert_int_equal(params[0].fallback, 1); // the first value
    must(gen_params(g, "plain", &cpu, &params, &n, ERR));
    assert_int_equal(params[2].fallback, 1);
}

// Every config by number, against three loops.
TEST(configs_are_counted_and_found_by_number)
{
    gen_limits small = gpu;
    small.local_bytes = 256; // no group of 256
    gen *g = open_test_kernels();
    uint64_t count = 0, index = 0;
    must(gen_count(g, "plain", &small, &count, ERR));
    gen_setting config[4];
    for (int64_t factor = 1; factor <= 3; ++factor)
        for (int64_t wg = 1; wg <= 64; wg += 63)
            for (int64_t per_item = 1; per_item <= (factor == 3 ? 1 : 4); per_item += 3) {
                must(gen_config(g, "plain", &small, index++, config, ERR));
                assert_int_equal(config[0].value, factor);
                assert_string_equal(config[1].name, "SHIFT");
                assert_int_equal(config[1].value, -1);
                assert_int_equal(config[2].value, wg);
                assert_int_equal(config[3].value, per_item);
            }
    assert_int_equal(count, index);
    must_fail(gen_config(g, "plain", &small, count, config, ERR), DUET_STATUS_BAD_ARGUMENT,
              "plain: config 10 of 10");
}

TEST(a_large_space_is_counted_block_by_block)
{
    test_make_folder(folder);
    write_file("k.lua",
               CARD("{ 'A', values = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 } },"
                    "{ 'B', values = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 } },"
                    "{ 'C', values = { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 } }",
                    "valid = function(p) return (100 * p.A + 10 * p.B + p.C) % 7 == 3 end,"));
    write_file("common.clh", "\n");
    write_file("k.cl", "\n");
    gen *g = kept(gen_open(folder, ERR));
    uint64_t count = 0;
    must(gen_count(g, "k", &gpu, &count, ERR));
    assert_int_equal(count, 143); // 3, 10, .. 997
    for (uint64_t i = 0; i < count; ++i) {
        gen_setting p[3];
        must(gen_config(g, "k", &gpu, i, p, ERR));
        assert_int_equal(100 * p[0].value + 10 * p[1].value + p[2].value, 7 * i + 3);
    }
}

TEST(a_card_s_arguments_become_parameters)
{
    const char *card =
        CARD("{ 'DOUBLE', values = { 0, 1 }, default = 1 }, { 'A', values = { 1, 2 } }",
             "args = { take = [[\n volatile uint *counters\n const real4 *centres if A == 1\n"
             " constant grid_level *levels  if A ~= 1\n real h\n ]], put = [[ float4 *x ]] },");
    make_well(card, "k.cl", "struct { ARG_FIELDS };\n");
    assert_says(made,
                "#define PUT_ARGS \\\n    __global float4 *restrict x\n"
                "#define TAKE_ARGS \\\n"
                "    volatile __global uint *restrict counters, \\\n"
                "    __global const double4 *restrict centres, \\\n"
                "    double h\n",
                "#define PUT_VALUES \\\n    .x = x,\n",
                "#define ARG_FIELDS \\\n    __global float4 *x; \\\n"
                "    volatile __global uint *counters; \\\n"
                "    __global const double4 *centres; \\\n    double h; \\\n"
                "    __constant const grid_level *levels;\n");
}

TEST(an_argument_that_is_there_only_if_a_condition_holds_is_else_no_member)
{
    static const char *const args =
        "args = { take = [[\n float h only if A == 1\n float4 *x  only  if A == 1\n"
        " float w if A == 1\n uint n ]], put = [[ float4 *x only if B == 1 ]] },";
    for (int x = 0; x < 4; ++x) {
        char card[512], params[128];
        snprintf(
            params, sizeof params,
            "{ 'A', values = { 0, 1 }, default = %d }, { 'B', values = { 0, 1 }, default = %d }",
            x & 1, x >> 1);
        snprintf(card, sizeof card, CARD("%s", "%s"), params, args);
        make_well(card, "k.cl", "struct { ARG_FIELDS };\n");
        assert_true(!strstr(made, "float h;") == !(x & 1));
        assert_true(!strstr(made, "__global float4 *x;") == !x); // of either entry
        assert_says(made, "float w;", "uint n;");
    }
}

// ------------------------------------------------------- what is broken

TEST(a_broken_card_is_told_with_its_line)
{
    static const refusal cases[] = {
        {"return {\n  params = {", "k.lua:2: unexpected symbol"},
        {"return 5", "k.lua: the card returns a number, not a table"},
        {"return {}", "k.lua: the card has no params"},
        {"return { params = {} }", "k.lua: the card has no launch function, nor"},
        {CARD("", "parms = 1,"), "k.lua:3: the card has no field 'parms'"},
        {CARD("", "valid = true,"), "k.lua:3: valid is true; expected a function"},
        {CARD("7", ""), "k.lua:2: parameter 1 is a number, not a table"},
        {CARD("{ 'wg', values = { 1 } }", ""), "k.lua:2: parameter 1 begins with 'wg'"},
        {CARD("{ 'A', values = {1} }, { 'A', values = {1} }", ""),
         "k.lua:2: parameter A is there twice"},
        {CARD("{ 'A', vals = { 1 } }", ""), "k.lua:2: A has no field 'vals'"},
        {CARD("{ 'A', values = { 1 }, 2 }", ""), "k.lua: A has no field [2]"},
        {CARD("{ 'A' }", ""), "k.lua: A: neither values nor min and max"},
        {CARD("{ 'A', values = {} }", ""),
         "k.lua:2: A: values is a table; expected a list of 1 to 1000 whole"},
        {CARD("{ 'A', values = { 1, 1.5 } }", ""), "k.lua: A: value 2 is not a whole number"},
        {CARD("{ 'A', values = { 1, 2, 1 } }", ""), "k.lua: A: value 1 is there twice"},
        {CARD("{ 'A', values = { 1, 2 }, default = 3 }", ""),
         "k.lua: A: its default 3 is not one of its values"},
        {CARD("{ 'A', min = 2, max = 1 }", ""), "k.lua: A: min 2 is above max 1"},
        {CARD("{ 'A', values = { 1 }, default = function() return 'x' end }", ""),
         "k.lua: A: its default is x, none of its values"},
        {CARD("{ 'A', values = { 1 }, default = function(l) return l.wg.x end }", ""),
         "k.lua:2: attempt to index a nil value (field 'wg')"},
        {CARD("", "valid = function(p) return p.A > 1 end,"),
         "k.lua:3: attempt to compare number with nil"},
        {CARD("", "valid = function(p) while true do end end,"), "k.lua:3: runs for more than"},
        {CARD("", "uses = { '../x.clh' },"), "k.lua:3: uses has at most 24 names of files"},
        {CARD("", "args = { k = 1 },"), "k.lua:3: args: expected an entry's NAME = [[ its"},
        {CARD("", "args = { k = [[ float ]] },"), "k.lua:3: k: 'float' is no argument; expected"},
        {CARD("", "args = { k = [[ char c ]] },"), "k.lua:3: k: 'char c' is no argument"},
        {CARD("", "args = { k = [[ const uint c ]] },"), "k.lua:3: k: 'const uint c' is no"},
        {CARD("", "args = { k = [[ uint 2c ]] },"), "k.lua:3: k: 'uint 2c' is no argument"},
        {CARD("", "args = { k = [[ uint *c if A = ]] },"), "k.lua:3: k: 'if A =' is no condition"},
        {CARD("{ 'A', values = { 1 } }", "args = { k = [[ uint n if A ]] },"),
         "k: the condition of 'n' gives a number; expected a comparison"},
        {CARD("{ 'A', values = { 1 } }", "args = { k = [[ uint n if B == 1 ]] },"),
         "no parameter 'B'"},
        {CARD("", "emit = { 'nothing' },"), "gen/emit/nothing.lua: there is no such file"},
        {CARD("", "uses = { 'nothing.clh' },"), "/nothing.clh: "},
        {"return { params = {}, launch = function() end }",
         "k.lua: launch gives a nil, not { group = ..., per_item = ... }"},
        {"return { params = {}, launch = function() return { group = 0 } end }",
         "k.lua: launch gives no group of 1 or more"},
        {"return { params = {}, launch = function() return { group = 1 } end }",
         "k.lua: launch gives no per_item of 1 or more"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        duet_error err = make_with(cases[i].given, "k.cl.in", "int x;\n");
        bool is_file = strstr(cases[i].says, "nothing.clh");
        expect(err, is_file ? DUET_STATUS_NOT_FOUND : DUET_STATUS_BUILD_FAILED, cases[i].says);
    }
}

TEST(a_broken_template_is_told_with_its_line)
{
    static const refusal cases[] = {
        {"int a;\nint @{A +};\n", "k.cl.in:2: unexpected symbol near ')'"},
        {"int a;\n//@ for i = 1, 3 do\nint b;\n", "k.cl.in:3: 'end' expected"},
        {"int a;\n\nint @{B};\n", "k.cl.in:3: an expression in @{} gives a nil"},
        {"int a;\nint @{A;\n", "k.cl.in:2: '@{' has no '}' on its line"},
        {"int a;\n//@ error('stop')\n", "k.cl.in:2: stop"},
        {"int a;\n//@ while true do\nint b;\n//@ end\n", "k.cl.in:"},
        {"int a;\n//@ local s = ('x'):rep(1 << 40)\n", "k.cl.in"},
        {"int a;\n//@ io.open('x')\n", "k.cl.in:2: attempt to index a nil value (global 'io')"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const char *card = CARD("{ 'A', values = { 1 } }", "");
        expect(make_with(card, "k.cl.in", cases[i].given), DUET_STATUS_BUILD_FAILED, cases[i].says);
    }
}

TEST(a_template_without_lua_comes_out_as_it_went_in)
{
    const char *body = "a \"%d\\n\" @ {b}\n\n  \\\n]]\n";
    make_well(CARD("", ""), "k.cl.in", body);
    const char *begin = strstr(made, "a \"");
    assert_non_null(begin);
    assert_string_equal(begin, body);
}

TEST(lines_of_lua_choose_in_plain_text)
{
    static const struct {
        const char *body;
        const char *end; // end of the text
    } cases[] = {
        {"int a; // no //@ line\n//@ if A == 1 then\n  int @{b};\n//@ else\nint c;\n//@ end\nint "
         "d;",
         "#line 1 \"kernels/k.cl\"\nint a; // no //@ line\n  int @{b};\nint d;\n"},
        {"//@ if A ~= 1 then\nint b;\n  //@ end\n", "// shared\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        make_well(CARD("{ 'A', values = { 1 } }", ""), "k.cl", cases[i].body);
        assert_string_equal(strstr(made, i == 0 ? "#line 1 \"kernels/k" : "// shared"),
                            cases[i].end);
    }
    expect(make_with(CARD("{ 'A', values = { 1 } }", ""), "k.cl", "//@ if A then\n"),
           DUET_STATUS_BUILD_FAILED, "k and its headers:");
}

TEST(a_broken_kernel_does_not_stop_the_others)
{
    test_make_folder(folder);
    write_file("bad.lua", "return {");
    write_file("good.lua", CARD("", ""));
    write_file("good.cl", "int good;\n");
    write_file("common.clh", "\n");
    gen *g = kept(gen_open(folder, ERR));
    assert_string_equal(gen_kernel(g, 0), "bad");
    assert_string_equal(gen_kernel(g, 1), "good");
    assert_null(gen_kernel(g, 2));
    gen_variant v;
    must_fail(gen_make(g, "bad", NULL, 0, &gpu, &v, ERR), DUET_STATUS_BUILD_FAILED, "");
    must(gen_make(g, "good", NULL, 0, &gpu, &v, ERR));
    gen_variant_free(&v);
    write_file("bad.lua", CARD("", "")); // mended
    write_file("bad.cl", "int bad;\n");
    must(gen_make(g, "bad", NULL, 0, &gpu, &v, ERR));
    gen_variant_free(&v);
}

TEST(a_folder_takes_only_the_common_header_from_carried_files)
{
    must_fail(gen_open("no/such/folder", ERR), DUET_STATUS_NOT_FOUND,
              "kernel folder no/such/folder");
    test_make_folder(folder);
    must_fail(gen_open(folder, ERR), DUET_STATUS_NOT_FOUND, ": no card (*.lua) in it");
    assert_null(strstr(test_error.text, "DUET_KERNEL_DIR"));
    setenv("DUET_KERNEL_DIR", folder, 1);
    must_fail(gen_open(folder, ERR), DUET_STATUS_NOT_FOUND,
              ": no card (*.lua) in it; without DUET_KERNEL_DIR the built-in kernels are read");
    unsetenv("DUET_KERNEL_DIR");
    write_file("scan.lua", CARD("", ""));
    gen *g = must(gen_open(folder, ERR));
    gen_variant v;
    must_fail(gen_make(g, "scan", NULL, 0, &gpu, &v, ERR), DUET_STATUS_NOT_FOUND, "/scan.cl: ");
    write_file("scan.cl", "\n");
    must(gen_make(g, "scan", NULL, 0, &gpu, &v, ERR));
    assert_says(v.text, "FP_CONTRACT OFF");
    gen_variant_free(&v);
    write_file("common.clh", "// own\n");
    gen_close(g);
    must((g = gen_open(folder, ERR)));
    must(gen_make(g, "scan", NULL, 0, &gpu, &v, ERR));
    assert_says(v.text, "// own");
    assert_null(strstr(v.text, "FP_CONTRACT OFF"));
    gen_variant_free(&v);
    gen_close(g);
    must((g = gen_open(folder, ERR)));
    write_file("scan.cl.in", "\n");
    must_fail(gen_make(g, "scan", NULL, 0, &gpu, &v, ERR), DUET_STATUS_BUILD_FAILED,
              "scan.cl stands beside scan.cl.in: keep one of them");
    gen_close(g);
}

static void expect_same_text(gen *g, gen *other, const char *name)
{
    own(gen_variant) v, w;
    must(gen_make(g, name, NULL, 0, &gpu, &v, ERR));
    must(gen_make(other, name, NULL, 0, &gpu, &w, ERR));
    assert_string_equal(v.text, w.text);
    assert_string_equal(v.sha256, w.sha256);
}

TEST(an_added_kernel_is_the_kernel_of_a_folder)
{
    static const char card[] = CARD("{ 'A', values = { 1, 2 } }", ""), body[] = "int a = A;";
    duet_error err = {0};
    char of_ours[sizeof body];
    strcpy(of_ours, body);
    test_make_folder(folder);
    write_file("k.lua", card);
    write_file("k.cl", body);
    gen *g = kept(gen_open(folder, ERR)), *carried = kept(gen_open(NULL, ERR));
    assert_non_null(gen_built_ins(carried));
    must(gen_add(carried, "k", card, of_ours, ERR));
    memset(of_ours, 0, sizeof of_ours);
    assert_null(gen_built_ins(carried)); // it may call any
    expect_same_text(g, carried, "k");
    must(gen_add(carried, "k", card, "int other;\n", ERR)); // in the place of the first
    write_file("k.cl", "int other;\n");
    expect_same_text(kept(gen_open(folder, ERR)), carried, "k");
    must(gen_add(carried, "scan", card, body, ERR)); // and of a carried one
    gen_variant v;
    must(gen_make(carried, "scan", NULL, 0, &gpu, &v, ERR));
    assert_says(v.text, "int a = A;");
    gen_variant_free(&v);
    assert_false(gen_add(carried, "a/b", card, body, &err));
    expect(err, DUET_STATUS_BAD_ARGUMENT, "a kernel's name is 'a/b'");
    must(gen_add(carried, "bad", "return {", body, ERR));
    err = (duet_error){0};
    assert_false(gen_make(carried, "bad", NULL, 0, &gpu, &v, &err));
    expect(err, DUET_STATUS_BUILD_FAILED, "the card of bad:1");
}

// ------------------------------------------------------- damage

static void damage(char *chars, rng *r)
{
    static const char odd[] = "{}()[]\"'=,.-#%@\n\0\x1b 0fe";
    size_t n = strlen(chars);
    for (uint32_t i = rng_below(r, 3) + 1; i > 0; --i)
        chars[rng_below(r, (uint32_t)n)] = odd[rng_below(r, sizeof odd - 1)];
}

// A card and a template with a few wrong characters make a variant or one line
// that says why not.
TEST(damage_is_an_error_or_a_variant)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < 400; ++i) {
        char card[] = CARD("{ 'A', values = { 1, 2 }, default = function(l) return 1 end }",
                           "emit = { 'stencil' }, valid = function(p) return p.A > 0 end,");
        char body[] = "int a;\n//@ for i = 1, 3 do\nint @{(A + i) .. 'x'};\n//@ end\n";
        damage(i % 2 ? card : body, &r);
        duet_error err = make_with(card, "k.cl.in", body);
        if (err.status != DUET_STATUS_OK && err.status != DUET_STATUS_BUILD_FAILED)
            fail_msg("%s %s\n%s%s", duet_status_name(err.status), err.text, card, body);
        assert_null(strchr(err.text, '\n'));
    }
}
