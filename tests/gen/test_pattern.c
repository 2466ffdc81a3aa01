// SPDX-License-Identifier: MIT
// What Duet's own part of the sandbox does is what Lua itself does.
#include "support/test.h"

#include "base/rng.h"
#include "base/text.h"
#include "gen/sandbox.h"

#include <lauxlib.h>
#include <lualib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Makes a text of what find, match, gmatch and gsub give for a text and a
// pattern, in a state that may lack pcall.
static const char asked[] =
    "local function join(...)\n"
    "  local out = {}\n"
    "  for i = 1, select('#', ...) do out[i] = tostring((select(i, ...))) end\n"
    "  return table.concat(out, ',')\n"
    "end\n"
    "return function(text, pattern, from)\n"
    "  local out = { join(text:find(pattern, from)), join(text:match(pattern, from)),\n"
    "                join(text:find(pattern, from, true)), join(text:gsub(pattern, '<%0>', 5)),\n"
    "                join(text:gsub(pattern, { a = 'A', b = false })),\n"
    "                join(text:gsub(pattern, function(x) return x ~= 'c' and x .. '!' end)) }\n"
    "  for x, y in text:gmatch(pattern, from) do out[#out + 1] = join(x, y) end\n"
    "  return table.concat(out, ';')\n"
    "end\n";

static const char *const pieces[] = {
    "a",   "b",    "c",     ".",    "%a",     "%A",   "%d",   "%w",   "%s",    "%p",     "%u",
    "%l",  "%x",   "%c",    "%g",   "[ab]",   "[^a]", "*",    "+",    "-",     "?",      "(",
    ")",   "()",   "%1",    "%2",   "^",      "$",    "%b()", "%bab", "%f[a]", "%f[%w]", "[a-c]",
    "[]]", "[^]]", "[%a-]", "[-a]", "[a%-z]", "%",    "[",    "%.",   "1",     " ",      "%z",
};

static const char letters[] = "aaabbbccc()1 .]-%A\t_\0";

static void add_random(text *out, rng *r, uint32_t most, bool pattern)
{
    uint32_t n = rng_below(r, most + 1);
    for (uint32_t i = 0; i < n; ++i)
        if (pattern)
            text_add(out, "%s", pieces[rng_below(r, sizeof pieces / sizeof pieces[0])]);
        else
            text_add_bytes(out, &letters[rng_below(r, sizeof letters - 1)], 1);
}

// function, text, pattern, from -> what it says
static int ask(lua_State *L)
{
    lua_call(L, 3, 1);
    return 1;
}

// Both states have the function at 1. Pushes what it says, or why it fails.
static void put_question(lua_State *L, const text *chars, const text *pattern, lua_Integer from)
{
    lua_pushcfunction(L, ask);
    lua_pushvalue(L, 1);
    lua_pushlstring(L, text_chars(chars), chars->length);
    lua_pushlstring(L, text_chars(pattern), pattern->length);
    lua_pushinteger(L, from);
}

// Behind "file:line: ".
static const char *message_of(const char *said)
{
    const char *at = strstr(said, "asked:");
    at = at ? strchr(at + 6, ':') : NULL;
    return at ? at + 2 : said;
}

static void patterns_match_what_lua_matches(void **state)
{
    (void)state;
    uint32_t seed = test_seed();
    print_message("DUET_TEST_SEED=%u\n", seed);
    rng r = rng_seed(seed);
    duet_error err = {0};
    script *s = sandbox_open(NULL, &err);
    lua_State *stock = luaL_newstate();
    luaL_openlibs(stock);
    assert_ok(s && script_run(s, "asked", asked, sizeof asked - 1, 1, &err), err);
    assert_int_equal(luaL_loadbuffer(stock, asked, sizeof asked - 1, "@asked"), LUA_OK);
    lua_call(stock, 0, 1);
    uint32_t answers = 0;
    for (int round = 0; round < 40000; ++round) {
        text chars = {0}, pattern = {0};
        add_random(&chars, &r, 12, false);
        add_random(&pattern, &r, 5, true);
        lua_Integer from = (lua_Integer)rng_below(&r, 20) - 8;
        put_question(stock, &chars, &pattern, from);
        put_question(script_lua(s), &chars, &pattern, from);
        bool right = lua_pcall(stock, 4, 1, 0) == LUA_OK;
        duet_error why = {0};
        bool ok = script_call(s, 4, 1, &why);
        const char *wanted = lua_tostring(stock, -1);
        const char *said = ok ? lua_tostring(script_lua(s), -1) : message_of(why.text);
        if (ok != right || strcmp(said, right ? wanted : message_of(wanted)) != 0)
            fail_msg("'%s' in '%s' from %d: '%s', and Lua says '%s'", text_chars(&pattern),
                     text_chars(&chars), (int)from, said, wanted);
        answers += ok;
        lua_pop(stock, 1);
        lua_settop(script_lua(s), 1);
        text_free(&chars);
        text_free(&pattern);
    }
    assert_true(answers > 10000);
    lua_close(stock);
    script_close(s);
}

// ---------------------------------------------------------------- tables

static void assert_says(const char *chunk, const char *wanted)
{
    duet_error err = {0};
    script *s = sandbox_open(NULL, &err);
    assert_ok(s && script_run(s, "card.lua", chunk, strlen(chunk), 1, &err), err);
    assert_string_equal(lua_tostring(script_lua(s), -1), wanted);
    script_close(s);
}

static void sort_keeps_equal_values_in_their_order(void **state)
{
    (void)state;
    assert_says("local t = {}\n"
                "for i = 1, 1000 do t[i] = { key = i * 7 % 10, place = i } end\n"
                "table.sort(t, function(a, b) return a.key < b.key end)\n"
                "for i = 2, 1000 do\n"
                "  local a, b = t[i - 1], t[i]\n"
                "  assert(a.key < b.key or a.key == b.key and a.place < b.place)\n"
                "end\n"
                "return #t .. ''",
                "1000");
    assert_says("local t = { 3, 1.5, -2, 10, 1 } table.sort(t) return table.concat(t, ' ')",
                "-2 1 1.5 3 10");
    assert_says("local t = { 'b', 'a', 'ab', '' } table.sort(t) return table.concat(t, ' ')",
                " a ab b");
}

static void move_moves_as_lua_does(void **state)
{
    (void)state;
    assert_says("local t = table.move({ 1, 2, 3, 4, 5 }, 1, 4, 2) return table.concat(t, ' ')",
                "1 1 2 3 4");
    assert_says("local t = table.move({ 1, 2, 3, 4, 5 }, 2.0, 5, 1) return table.concat(t, ' ')",
                "2 3 4 5 5");
    assert_says("local t = table.move({ 1, 2 }, 1, 2, 3, { 8, 9 }) return table.concat(t, ' ')",
                "8 9 1 2");
}

static void no_address_is_shown(void **state)
{
    (void)state;
    assert_says("local t, f = {}, function() end\n"
                "return table.concat({ tostring(t), tostring(f), tostring(t), tostring(print),\n"
                "                      ('%s %5s %%s %q'):format({}, 'x', 'y') }, ', ')",
                "table: 1, function: 2, table: 1, nil, table: 3     x %s \"y\"");
    assert_says("return tostring(1) .. tostring(1.5) .. tostring('a') .. tostring(nil) ..\n"
                "       tostring(true)",
                "11.5aniltrue");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patterns_match_what_lua_matches),
        cmocka_unit_test(sort_keeps_equal_values_in_their_order),
        cmocka_unit_test(move_moves_as_lua_does),
        cmocka_unit_test(no_address_is_shown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
