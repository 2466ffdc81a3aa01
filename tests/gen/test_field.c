// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "gen/field.h"
#include "gen/sandbox.h"

#include <lauxlib.h>

typedef struct settings {
    int64_t n;
    double cell;
    bool fixed;
    const char *name;
    bool has_world;
    int kind;
    float centre[3];
    uint32_t rows[2];
    field_enum_list kinds;
    char letters[4];
    uint64_t given;
} settings;

static const char *kind_name(int kind)
{
    static const char *const names[] = {"still", "moving", NULL};
    return names[kind];
}

static const field pair_fields[] = {
    FIELD_AT("[1]", field_count, settings, rows[0]),
    FIELD_AT("[2]", field_count, settings, rows[1]),
    {0},
};

static void read_pair(lua_State *L, const field *f, void *at)
{
    field_read_row(L, -1, (field_table){f->name, 7, NULL}, pair_fields, at);
}

// items = { { 1, 2 }, ... }
static void read_items(lua_State *L, const field *f, void *at)
{
    settings *s = at;
    for (lua_Integer i = 1; i <= (lua_Integer)lua_rawlen(L, -1); ++i, lua_pop(L, 1)) {
        const field_table item = {"item", i, f->name};
        lua_rawgeti(L, -1, i);
        field_read_row(L, -1, item, pair_fields, s);
        if (s->rows[0] == s->rows[1])
            field_raise_in(L, &item, NULL, "expected two numbers");
    }
}

static const field fields[] = {
    FIELDS(settings, n),
    FIELD_WITHIN(settings, , cell, 0, 10, "a number from 0 to 10"),
    FIELDS(settings, fixed, name, centre),
    FIELD_AT("world", field_function, settings, has_world),
    FIELD_ENUM(settings, kind, kind_name),
    {.name = "pair", .type = &(const field_type){.read = read_pair}},
    FIELD_ENUMS(settings, kinds, kind_name),
    FIELDS(settings, letters),
    {.name = "items", .type = &(const field_type){.read = read_items}},
    {0},
};

// Reads as a caller reads a def: one C function, called through script_call.
static int read_settings(lua_State *L)
{
    settings *s = lua_touserdata(L, 2);
    s->given = field_read(L, 1, "a scene", fields, s);
    return 0;
}

static bool read(script *s, const char *chars, settings *found, duet_error *err)
{
    if (!script_run(s, "scene.lua", chars, strlen(chars), 1, err))
        return false;
    lua_State *L = script_lua(s);
    lua_pushcfunction(L, read_settings);
    lua_insert(L, 1);
    lua_pushlightuserdata(L, found);
    return script_call(s, 2, 0, err);
}

TEST(a_table_is_read_and_what_it_leaves_out_stays)
{
    script *s = kept(sandbox_open(NULL, ERR));
    settings found = {.n = 7, .cell = 0.5, .fixed = true, .name = "none"};
    must(read(s,
              "return { n = 3.0, fixed = false, world = function() end, kind = 'moving', centre = "
              "{1, 2}, "
              "pair = { 4, 5 }, kinds = 'moving', letters = 'abc', items = {} }",
              &found, ERR));
    assert_int_equal(found.n, 3);
    assert_true(found.cell == 0.5);
    assert_false(found.fixed);
    assert_string_equal(found.name, "none");
    assert_true(found.has_world);
    assert_int_equal(found.kind, 1);
    assert_true(found.centre[0] == 1 && found.centre[1] == 2 && found.centre[2] == 0);
    assert_true(found.rows[0] == 4 && found.rows[1] == 5);
    assert_int_equal(found.kinds.n, 1);
    assert_int_equal(found.kinds.values[0], 1);
    assert_string_equal(found.letters, "abc");
    assert_int_equal(found.given, 1 | 4 | 16 | 32 | 64 | 128 | 256 | 512 | 1024);
    assert_true(field_is_given(fields, found.given, "kind"));
    assert_false(field_is_given(fields, found.given, "cell"));
    must(read(s, "return { kinds = { 'moving', 'still' } }", &found, ERR));
    assert_int_equal(found.kinds.n, 2);
    assert_int_equal(found.kinds.values[0], 1);
    assert_int_equal(found.kinds.values[1], 0);
}

#define THERE_ARE \
    "its fields are n, cell, fixed, name, centre, world, kind, pair, kinds, letters, items"

TEST(what_is_wrong_is_told_with_its_line)
{
    static const char *const cases[][2] = {
        {"return {\n  cel = 1 }", "scene.lua:2: a scene has no field 'cel'; " THERE_ARE},
        {"return {\n\n  ['cel'] = 1 }", "scene.lua:3: a scene has no field 'cel'"},
        {"-- cel = 2\nlocal x = cel == 1\nreturn { excel = nil, cel = 1 }",
         "scene.lua:3: a scene has no field 'cel'"},
        {"local t = {}\nt.cel = 1\nreturn t", "scene.lua:2: a scene has no field 'cel'"},
        {"local a = { cel = 1 }\nreturn { cel = 1 }", "scene.lua: a scene has no field 'cel'"},
        {"return { 'n' }", "scene.lua: a scene has no field [1]; " THERE_ARE},
        {"return { ['[1]'] = 1 }", "scene.lua: a scene has no field '[1]'"},
        {"return { ['n\\0x'] = 1 }", "scene.lua: a scene has no field 'n\\x00x'"},
        {"return { [true] = 1 }", "scene.lua: a scene has no field [true]"},
        {"return {\n n = 1.5 }", "scene.lua:2: n is 1.5; expected a whole number"},
        {"return {\n n = '4' }", "scene.lua:2: n is '4'; expected a whole number"},
        {"return {\n n = 2^63 }", "scene.lua:2: n is 9.2233720368548e+18; expected a whole"},
        {"return {\n cell = 1 / 0 }", "scene.lua:2: cell is inf; expected a number from 0 to 10"},
        {"return {\n cell = -(0 / 0) }", "scene.lua:2: cell is nan; expected a number from 0"},
        {"return {\n cell = 11 }", "scene.lua:2: cell is 11; expected a number from 0 to 10"},
        {"return {\n cell = true }", "scene.lua:2: cell is true; expected a number from 0"},
        {"return {\n fixed = 1 }", "scene.lua:2: fixed is 1; expected true or false"},
        {"return {\n name = 'a\\0b' }",
         "scene.lua:2: name is 'a\\x00b'; expected a string without NUL"},
        {"return {\n letters = 'a\\0b' }",
         "scene.lua:2: letters is 'a\\x00b'; expected a string without NUL"},
        {"return {\n letters = 'abcd' }",
         "scene.lua:2: letters has 4 characters; expected at most 3"},
        {"return {\n kind = 'still\\0' }",
         "scene.lua:2: kind is 'still\\x00'; expected one of still, moving"},
        {"return {\n kinds = { 'still', 'x' } }",
         "scene.lua:2: kinds is 'x'; expected one of still, moving"},
        {"return {\n kinds = {} }", "scene.lua:2: kinds is a table; expected one of still, moving"},
        {"return {\n name = 12 }", "scene.lua:2: name is 12; expected a string"},
        {"return {\n world = 12 }", "scene.lua:2: world is 12; expected a function"},
        {"return {\n kind = 3 }", "scene.lua:2: kind is 3; expected one of still, moving"},
        {"return {\n kind = 'x' }", "scene.lua:2: kind is 'x'; expected one of still, moving"},
        {"return {\n centre = { 1 } }", "scene.lua:2: centre is a list of 1; expected { x, y, z }"},
        {"return {\n centre = { 1, 'x' } }", "scene.lua:2: centre is 'x'; expected a number"},
        {"return {\n pair = 3 }", "scene.lua:2: pair 7 is 3; expected a table of [1], [2]"},
        {"return {\n pair = { 1, -2 } }",
         "scene.lua:2: pair 7: [2] is -2; expected a whole number from 0"},
        {"return {\n pair = { 1, 2, 3 } }", "scene.lua:2: pair 7 has no field [3]; its fields are"},
    };
    script *s = kept(sandbox_open(NULL, ERR));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        settings found;
        must_fail(read(s, cases[i][0], &found, ERR), DUET_STATUS_BAD_INPUT, "");
        if (strncmp(ERR->text, cases[i][1], strlen(cases[i][1])) != 0)
            fail_msg("%s, wanted %s", ERR->text, cases[i][1]);
        assert_int_equal(lua_gettop(script_lua(s)), 0);
    }
}

// The line is that of the row, if the script writes the list out, whatever stands between.
TEST(a_row_of_a_list_has_its_line)
{
    static const char *const cases[][2] = {
        {"return {\n items = {\n  { 1, 2 },\n  { 1,\n    x = 2 },\n  { 1, 2, y = 3 },\n} }",
         "scene.lua:5: item 2 has no field 'x'; its fields are [1], [2]"},
        {"return {\n items = {\n  { 1, 2 },\n  { 3, 3 },\n} }",
         "scene.lua:4: item 2: expected two numbers"},
        {"return { items =\n {\n {1, 2}, 3 } }", "scene.lua:1: item 2 is 3; expected a table of"},
        {"return { items = { -- }\n {1, 2}, --[[ {9, 9}\n ]] {1,2}; {'\\'},{', 2} -- }\n , {3, 3} "
         "} }",
         "scene.lua:3: item 3: [1] is ''},{'; expected a whole number"},
        {"return { items = {\n {1, [2] = #[==[ ]] } ]==]},\n {3, 3} } }",
         "scene.lua:3: item 2: expected two numbers"},
        {"local row = {3, 3}\nreturn { items = {\n {1, 2},\n row } }",
         "scene.lua:2: item 2: expected two numbers"},
        {"local list = {}\nlist[1] = {3, 3}\nreturn { items = list }",
         "scene.lua:3: item 1: expected two numbers"},
    };
    script *s = kept(sandbox_open(NULL, ERR));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        settings found = {0};
        must_fail(read(s, cases[i][0], &found, ERR), DUET_STATUS_BAD_INPUT, "");
        if (strncmp(ERR->text, cases[i][1], strlen(cases[i][1])) != 0)
            fail_msg("%s, wanted %s", ERR->text, cases[i][1]);
    }
}

TEST(a_long_value_is_cut_and_not_the_sentence)
{
    script *s = kept(sandbox_open(NULL, ERR));
    settings found;
    must_fail(read(s, "return { kind = ('x'):rep(5000) }", &found, ERR), DUET_STATUS_BAD_INPUT,
              "x...'; expected one of still, moving");
    must_fail(read(s, "return { [('x'):rep(5000)] = 1 }", &found, ERR), DUET_STATUS_BAD_INPUT,
              "x...'; " THERE_ARE);
}

// Lua's own order changes from run to run: each state has a seed of its own.
TEST(the_first_unknown_key_in_the_alphabet_is_told)
{
    for (int i = 0; i < 20; ++i) {
        script *s = kept(sandbox_open(NULL, ERR));
        settings found;
        must_fail(read(s, "return { zeta = 1, beta = 1, n = 1, alpha = 1, gamma = 1, [true] = 1 }",
                       &found, ERR),
                  DUET_STATUS_BAD_INPUT, "a scene has no field 'alpha'");
        must_fail(read(s, "return { zeta = 1, [3] = 1, n = 1, [7] = 1 }", &found, ERR),
                  DUET_STATUS_BAD_INPUT, "a scene has no field [3]");
    }
}

TEST(an_error_with_a_nul_is_told_whole)
{
    script *s = kept(sandbox_open(NULL, ERR));
    settings found;
    must_fail(read(s, "error 'a\\0b'", &found, ERR), DUET_STATUS_BAD_INPUT, "a\\x00b");
}

static void refuse_in_any_state(const char *chars, const char *says)
{
    lua_State *L = luaL_newstate();
    settings found = {.n = 7};
    lua_pushcfunction(L, read_settings);
    assert_int_equal(luaL_dostring(L, chars), LUA_OK);
    lua_pushlightuserdata(L, &found);
    assert_int_equal(lua_pcall(L, 2, 0, 0), LUA_ERRRUN);
    assert_string_equal(lua_tostring(L, -1), says);
    lua_close(L);
}

TEST(a_state_that_is_no_scripts_has_no_line)
{
    refuse_in_any_state("return { n = true }", "n is true; expected a whole number");
    refuse_in_any_state("return { pair = { 1, x = 2 } }",
                        "pair 7 has no field 'x'; its fields are [1], [2]");
    refuse_in_any_state("return { pair = { 1, -1 } }",
                        "pair 7: [2] is -1; expected a whole number from 0");
}

static int raise_error(lua_State *L)
{
    return luaL_error(L, "asked");
}

TEST(metatables_are_not_asked)
{
    lua_State *L = luaL_newstate();
    settings found = {.n = 7};
    lua_newtable(L);
    lua_newtable(L);
    lua_pushcfunction(L, raise_error);
    lua_setfield(L, -2, "__index");
    lua_setmetatable(L, -2);
    assert_int_equal(field_read(L, 1, "a scene", fields, &found), 0);
    assert_int_equal(found.n, 7);
    lua_close(L);
}
