// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "gen/sandbox.h"

static const script_limits tight = {.memory_bytes = 4 << 20, .instructions = 2000000, .seconds = 5};

static bool run(script *s, const char *chars, int n_results, duet_error *err)
{
    return script_run(s, "card.lua", chars, strlen(chars), n_results, err);
}

// Runs a chunk that must fail with one line that holds `why`, and then one
// that must still work.
static void refuse(script *s, const char *chars, const char *why)
{
    print_message("%s\n", chars);
    must_fail(run(s, chars, 0, ERR), DUET_STATUS_BAD_INPUT, why);
    assert_int_equal(lua_gettop(script_lua(s)), 0);
    must(run(s, "return 1 + 1", 1, ERR));
    assert_int_equal(lua_tointeger(script_lua(s), -1), 2);
    lua_pop(script_lua(s), 1);
}

static void refuse_each(const script_limits *limits, const char *const *chunks, size_t n,
                        const char *why)
{
    for (size_t i = 0; i < n; ++i) {
        script *s = kept(sandbox_open(limits, ERR));
        refuse(s, chunks[i], why);
    }
}

#define REFUSE_EACH(limits, chunks, why) \
    refuse_each(limits, chunks, sizeof(chunks) / sizeof(chunks)[0], why)

TEST(results_are_left_on_the_stack)
{
    script *s = kept(sandbox_open(NULL, ERR));
    must(run(s, "return 'a', math.maxinteger", 2, ERR));
    assert_string_equal(lua_tostring(script_lua(s), 1), "a");
    assert_int_equal(lua_tointeger(script_lua(s), 2), INT64_MAX);
}

TEST(an_endless_script_ends_with_its_line)
{
    static const char *const chunks[] = {
        "\nwhile true do end",
        "\nrepeat until false",
        "\n::again:: goto again",
        "\nfor i = 1, math.huge do end",
        "\nfor i = 1, math.maxinteger do local t = i * 2 end",
        "\nlocal function f() return f() end return f()",
        "\ntable.sort({ 3, 2, 1, 4 }, function() while true do end end)",
        "\ntable.move({}, 1, math.maxinteger - 1, 2)",
    };
    REFUSE_EACH(&tight, chunks, "card.lua:2: runs for more than the 2000000 instructions");
}

TEST(a_greedy_script_ends_at_its_memory)
{
    static const char *const chunks[] = {
        "local s = ('x'):rep(1 << 30)",
        "local s = 'x' while true do s = s .. s end",
        "local t = {} for i = 1, math.huge do t[i] = i end",
        "local t = {} while true do t = { t, {}, {} } end",
        "return table.concat({ ('x'):rep(2e6), ('y'):rep(2e6), ('z'):rep(2e6) })",
        "return string.pack('!16 c1000000000', '')",
        "local s = ('f(){}'):rep(1e6)",
    };
    REFUSE_EACH(&tight, chunks, "card.lua:1: needs more than the 4 MiB of memory");
}

TEST(a_search_takes_what_it_looks_at)
{
    script *s = kept(sandbox_open(&tight, ERR));
    must(run(s,
             "local s, at, n = (('x'):rep(99) .. '\\n'):rep(2000), 1, 0\n"
             "while at do at, n = s:find('\\n', at + 1, true), n + 1 end\n"
             "assert(n == 2001)",
             0, ERR));
    refuse(s, "local s = ('x'):rep(2e5) for i = 1, 1000 do s:find('\\n', 1, true) end",
           "instructions");
}

TEST(deep_recursion_is_an_error_and_no_crash)
{
    static const char *const chunks[] = {
        "local function f() return 1 + f() end f()",
        "local function f() table.sort({ 1, 2 }, f) end f()",
    };
    script_limits roomy = script_default_limits();
    roomy.memory_bytes = (size_t)256 << 20;
    REFUSE_EACH(&roomy, chunks, "overflow");
}

TEST(deep_nesting_of_the_text_is_an_error)
{
    static char nested[20000];
    memset(nested, '(', sizeof nested - 1);
    const char *chunk = nested;
    refuse_each(&tight, &chunk, 1, "overflow");
}

TEST(an_error_of_any_kind_is_one_line_with_a_place)
{
    script *s = kept(sandbox_open(&tight, ERR));
    refuse(s, "\n\nerror('wrong')", "card.lua:3: wrong");
    refuse(s, "\n\nerror('two\\nlines')", "card.lua:3: two lines");
    refuse(s, "error('no level', 0)", "card.lua: no level");
    refuse(s, "error()", "card.lua: raises a nil as its error");
    refuse(s, "error({})", "card.lua: raises a table as its error");
    refuse(s, "\nassert(1 == 2)", "card.lua:2: assertion failed");
    refuse(s, "\nassert(nil, 'WG too large')", "card.lua:2: WG too large");
    refuse(s, "\nreturn ('x'):rep({})", "card.lua:2: bad argument #1 to 'rep'");
    refuse(s, "\nlocal x = nil + 1", "card.lua:2: attempt to perform arithmetic");
    refuse(s, "\nreturn {,}", "card.lua:2: unexpected symbol near ','");
    refuse(s, "return 'never closed", "card.lua:1: unfinished string");
    refuse(s, "\x1bLua", "card.lua: attempt to load a binary chunk");
    refuse(s, "\nfor k in pairs({ [{}] = 1 }) do end", "card.lua:2: pairs: a key is a table");
    refuse(s, "\nmath.randomseed()", "card.lua:2: bad argument #1 to 'randomseed'");
}

TEST(a_long_path_is_named_whole)
{
    script *s = kept(sandbox_open(NULL, ERR));
    const char *path = "some/folder/whose/name/goes/on/and/on/until/it/is/longer/than/sixty/x.lua";
    char wanted[200];
    snprintf(wanted, sizeof wanted, "%s:2: here", path);
    must_fail(script_run(s, path, "\nerror('here')", 14, 0, ERR), DUET_STATUS_BAD_INPUT, wanted);
    assert_string_equal(ERR->text, wanted);
}

TEST(nothing_dangerous_is_within_reach)
{
    static const char *const names[] = {
        "io",       "os",           "package",      "debug",  "require", "coroutine",      "load",
        "loadfile", "loadstring",   "dofile",       "print",  "warn",    "collectgarbage", "pcall",
        "xpcall",   "setmetatable", "getmetatable", "rawget", "rawset",  "rawequal",       "rawlen",
        "next",     "_G",           "string.dump"};
    script *s = kept(sandbox_open(NULL, ERR));
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char chunk[100];
        snprintf(chunk, sizeof chunk, "return %s == nil", names[i]);
        must(run(s, chunk, 1, ERR));
        if (!lua_toboolean(script_lua(s), -1))
            fail_msg("a script finds %s", names[i]);
        lua_pop(script_lua(s), 1);
    }
}

// Two states give the same answers.
TEST(every_run_gives_the_same)
{
    static const char chunk[] =
        "local t = { 3, 1, 2, [0.5] = 'half', [true] = 'yes', [false] = 'no' }\n"
        "for i = 1, 200 do t['k' .. math.random(1e6)] = i end\n"
        "local out = {}\n"
        "for k, v in pairs(t) do out[#out + 1] = tostring(k) .. '=' .. v end\n"
        "return table.concat(out, ',')";
    script *a = kept(sandbox_open(NULL, ERR));
    script *b = kept(sandbox_open(NULL, ERR));
    must(run(a, chunk, 1, ERR) && run(b, chunk, 1, ERR));
    const char *said = lua_tostring(script_lua(a), -1);
    assert_string_equal(said, lua_tostring(script_lua(b), -1));
    assert_int_equal(strncmp(said, "0.5=half,1=3,2=1,3=2,k", 22), 0);
    assert_says(said, "false=no,true=yes");
}

// Each call may take the whole limit; a script cannot use up the next one's.
TEST(limits_begin_again_with_each_call)
{
    script *s = kept(sandbox_open(&tight, ERR));
    for (int i = 0; i < 5; ++i)
        must(run(s, "for i = 1, 900000 do end", 0, ERR));
    refuse(s, "for i = 1, 9000000 do end", "instructions");
}

TEST(few_instructions_that_move_many_bytes_end_in_time)
{
    script_limits limits = {
        .memory_bytes = 64 << 20, .instructions = (uint64_t)1 << 60, .seconds = 0.2};
    script *s = kept(sandbox_open(&limits, ERR));
    refuse(s, "local s = ('x'):rep(1e6) for i = 1, 1e9 do local t = s:reverse() end",
           "card.lua:1: runs for more than the 0.2 s");
}

TEST(too_little_memory_for_a_state_is_an_error)
{
    for (size_t bytes = 0; bytes < 40000; bytes += 1000) {
        script_limits limits = {.memory_bytes = bytes, .instructions = 1000000, .seconds = 5};
        duet_error err = {0};
        script *s = sandbox_open(&limits, &err);
        assert_true(s || err.status != DUET_STATUS_OK);
        script_close(s);
    }
}

// From 5.4.6 on Lua's stack cannot be looked at while it grows.
TEST(memory_that_ends_while_the_stack_grows_is_told_with_a_line)
{
    for (size_t bytes = 100000; bytes < 600000; bytes += 20000) {
        script_limits limits = {.memory_bytes = bytes, .instructions = 10000000, .seconds = 5};
        script *s = kept(sandbox_open(&limits, ERR));
        refuse(s, "\nlocal function f(n) return 1 + f(n + 1) end\nf(1)",
               "card.lua:2: needs more than the");
    }
}

// ---------------------------------------------------------------- what a sandbox has of Lua

static void assert_returns(const char *chunk, const char *wanted)
{
    duet_error err = {0};
    script *s = sandbox_open(NULL, &err);
    must(s && script_run(s, "card.lua", chunk, strlen(chunk), 1, ERR));
    assert_string_equal(lua_tostring(script_lua(s), -1), wanted);
    script_close(s);
}

TEST(find_finds_plain_text_as_lua_does)
{
    assert_returns(
        "local s, out = 'aXbXc', {}\n"
        "for i, row in ipairs({ { 'X' }, { 'X', 3 }, { 'X', -2 }, { 'X', -9 }, { '' },\n"
        "                       { '', 6 }, { '', 7 }, { 'Xc', 0 }, { 'x' },\n"
        "                       { 'c', math.mininteger }, { 'c', math.maxinteger } }) do\n"
        "  local from, to = s:find(row[1], row[2])\n"
        "  out[i] = tostring(from) .. '-' .. tostring(to)\n"
        "end\n"
        "return table.concat(out, ' ')",
        "2-2 4-4 4-4 2-2 1-0 6-5 nil-nil 4-5 nil-nil 5-5 nil-nil");
    assert_returns("return ('1+1'):find('+', 1, true) .. ''", "2");
}

TEST(patterns_are_refused_with_their_line)
{
    static const char *const chunks[] = {"('a'):find('a*')", "('a'):match('a')",
                                         "for x in ('a'):gmatch('a') do end",
                                         "string.gsub('a', 'a', 'b')"};
    for (size_t i = 0; i < sizeof chunks / sizeof *chunks; ++i) {
        script *s = kept(sandbox_open(NULL, ERR));
        must_fail(script_run(s, "card.lua", chunks[i], strlen(chunks[i]), 0, ERR),
                  DUET_STATUS_BAD_INPUT, "card.lua:1: ");
        assert_says(ERR->text, "find(s, text, 1, true) finds plain text");
    }
}

TEST(sort_keeps_equal_values_in_their_order)
{
    assert_returns("local t = {}\n"
                   "for i = 1, 1000 do t[i] = { key = i * 7 % 10, place = i } end\n"
                   "table.sort(t, function(a, b) return a.key < b.key end)\n"
                   "for i = 2, 1000 do\n"
                   "  local a, b = t[i - 1], t[i]\n"
                   "  assert(a.key < b.key or a.key == b.key and a.place < b.place)\n"
                   "end\n"
                   "return #t .. ''",
                   "1000");
    assert_returns("local t = { 3, 1.5, -2, 10, 1 } table.sort(t) return table.concat(t, ' ')",
                   "-2 1 1.5 3 10");
    assert_returns("local t = { 'b', 'a', 'ab', '' } table.sort(t) return table.concat(t, ' ')",
                   " a ab b");
}

TEST(move_moves_as_lua_does)
{
    assert_returns("local t = table.move({ 1, 2, 3, 4, 5 }, 1, 4, 2) return table.concat(t, ' ')",
                   "1 1 2 3 4");
    assert_returns("local t = table.move({ 1, 2, 3, 4, 5 }, 2.0, 5, 1) return table.concat(t, ' ')",
                   "2 3 4 5 5");
    assert_returns("local t = table.move({ 1, 2 }, 1, 2, 3, { 8, 9 }) return table.concat(t, ' ')",
                   "8 9 1 2");
}

TEST(no_address_is_shown)
{
    assert_returns("local t, f = {}, function() end\n"
                   "return table.concat({ tostring(t), tostring(f), tostring(t), tostring(print),\n"
                   "                      ('%s %5s %%s %q'):format({}, 'x', 'y') }, ', ')",
                   "table: 1, function: 2, table: 1, nil, table: 3     x %s \"y\"");
    assert_returns("return tostring(1) .. tostring(1.5) .. tostring('a') .. tostring(nil) ..\n"
                   "       tostring(true)",
                   "11.5aniltrue");
}

TEST(a_long_error_keeps_its_end)
{
    script *s = kept(sandbox_open(NULL, ERR));
    static const char chunk[] = "error(('x'):rep(5000) .. ' expected y')";
    must_fail(script_run(s, "long.lua", chunk, sizeof chunk - 1, 0, ERR), DUET_STATUS_BAD_INPUT,
              "x expected y");
}
