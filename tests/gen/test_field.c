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
    field_read_row(L, -1, (field_table){f->name, 7}, pair_fields, at);
}

static const field fields[] = {
    FIELDS(settings, n),
    FIELD_WITHIN(settings, , cell, 0, 10, "a number from 0 to 10"),
    FIELDS(settings, fixed, name, centre),
    FIELD_AT("world", field_function, settings, has_world),
    FIELD_ENUM(settings, kind, kind_name),
    {.name = "pair", .type = &(const field_type){.read = read_pair}},
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
              "pair = { 4, 5 } }",
              &found, ERR));
    assert_int_equal(found.n, 3);
    assert_true(found.cell == 0.5);
    assert_false(found.fixed);
    assert_string_equal(found.name, "none");
    assert_true(found.has_world);
    assert_int_equal(found.kind, 1);
    assert_true(found.centre[0] == 1 && found.centre[1] == 2 && found.centre[2] == 0);
    assert_true(found.rows[0] == 4 && found.rows[1] == 5);
    assert_int_equal(found.given, 1 | 4 | 16 | 32 | 64 | 128);
}

#define THERE_ARE "its fields are n, cell, fixed, name, centre, world, kind, pair"

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
        {"return { ['n\\0x'] = 1 }", "scene.lua: a scene has no field 'n'"},
        {"return { [true] = 1 }", "scene.lua: a scene has no field [true]"},
        {"return {\n n = 1.5 }", "scene.lua:2: n is 1.5; expected a whole number"},
        {"return {\n n = '4' }", "scene.lua:2: n is '4'; expected a whole number"},
        {"return {\n n = 2^63 }", "scene.lua:2: n is 9.2233720368548e+18; expected a whole"},
        {"return {\n cell = 1 / 0 }", "scene.lua:2: cell is inf; expected a number from 0 to 10"},
        {"return {\n cell = -(0 / 0) }", "scene.lua:2: cell is nan; expected a number from 0"},
        {"return {\n cell = 11 }", "scene.lua:2: cell is 11; expected a number from 0 to 10"},
        {"return {\n cell = true }", "scene.lua:2: cell is true; expected a number from 0"},
        {"return {\n fixed = 1 }", "scene.lua:2: fixed is 1; expected true or false"},
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

TEST_MAIN(NULL, NULL)
