// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "gen/field.h"
#include "gen/sandbox.h"

static const char *const names[] = {"n", "cell", "fixed", "name", "world", NULL};

typedef struct settings {
    int64_t n;
    double cell;
    bool fixed;
    const char *name;
    bool has_world;
} settings;

// Reads as a caller reads a def: one C function, called through script_call.
static int read_settings(lua_State *L)
{
    settings *s = lua_touserdata(L, 2);
    field_only(L, 1, "a scene", names);
    s->n = field_integer(L, 1, "n", 7);
    s->cell = field_number(L, 1, "cell", 0.5);
    s->fixed = field_boolean(L, 1, "fixed", true);
    s->name = field_string(L, 1, "name", "none");
    s->has_world = field_push(L, 1, "world", LUA_TTABLE);
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

TEST(a_table_is_read_with_fallbacks)
{
    script *s = kept(sandbox_open(NULL, ERR));
    settings found = {0};
    must(read(s, "return { n = 3.0, fixed = false, world = {} }", &found, ERR));
    assert_int_equal(found.n, 3);
    assert_true(found.cell == 0.5);
    assert_false(found.fixed);
    assert_string_equal(found.name, "none");
    assert_true(found.has_world);
}

TEST(what_is_wrong_is_told_with_its_line)
{
    static const char *const cases[][2] = {
        {"return {\n  cel = 1 }",
         "scene.lua:2: a scene has no field 'cel': there are n, cell, fixed, name, world"},
        {"return {\n\n  ['cel'] = 1 }", "scene.lua:3: a scene has no field 'cel'"},
        {"-- cel = 2\nlocal x = cel == 1\nreturn { excel = nil, cel = 1 }",
         "scene.lua:3: a scene has no field 'cel'"},
        {"local t = {}\nt.cel = 1\nreturn t", "scene.lua:2: a scene has no field 'cel'"},
        {"local a = { cel = 1 }\nreturn { cel = 1 }", "scene.lua: a scene has no field 'cel'"},
        {"return { 'n' }", "scene.lua: a scene has no field [1]: its fields have names"},
        {"return {\n n = 1.5 }", "scene.lua:2: n must be a whole number, is 1.5"},
        {"return {\n n = '4' }", "scene.lua:2: n must be a whole number, is '4'"},
        {"return {\n cell = 1 / 0 }", "scene.lua:2: cell must be a finite number, is inf"},
        {"return {\n cell = true }", "scene.lua:2: cell must be a finite number, is a boolean"},
        {"return {\n fixed = 1 }", "scene.lua:2: fixed must be true or false, is 1"},
        {"return {\n name = 12 }", "scene.lua:2: name must be a text in quotes, is 12"},
        {"return {\n world = 12 }", "scene.lua:2: world must be a table, is 12"},
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

TEST_MAIN(NULL, NULL)
