// SPDX-License-Identifier: MIT
#include "cli/report/rendering.h"

#include "base/blob.h"
#include "base/budget.h"
#include "base/text.h"
#include "base/text_file.h"
#include "cli/draw/canvas.h"
#include "cli/say.h"
#include "gen/sandbox.h"

#include <langinfo.h>
#include <lauxlib.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

// The argument of a C function that pushes an object; its text outlives what Lua raises.
typedef struct pushing {
    const cJSON *shown;
    const char *keep; // control characters that stay
    text words;
} pushing;

// Untrusted strings, with control characters made visible.
static void push_words(lua_State *L, pushing *p, const char *chars)
{
    p->words.length = 0;
    text_add_visible(&p->words, chars, strlen(chars), p->keep);
    lua_pushlstring(L, text_chars(&p->words), p->words.length);
}

static void push(lua_State *L, pushing *p, const cJSON *item)
{
    if (cJSON_IsString(item)) {
        push_words(L, p, item->valuestring);
    } else if (cJSON_IsNumber(item)) {
        lua_pushnumber(L, item->valuedouble);
    } else if (cJSON_IsArray(item) || cJSON_IsObject(item)) {
        const cJSON *one;
        lua_Integer place = 0;
        luaL_checkstack(L, 8, "results");
        lua_newtable(L);
        cJSON_ArrayForEach(one, item)
        {
            push(L, p, one);
            if (one->string)
                lua_setfield(L, -2, one->string);
            else
                lua_rawseti(L, -2, ++place);
        }
    } else {
        lua_pushboolean(L, cJSON_IsTrue(item));
    }
}

static int push_shown(lua_State *L)
{
    pushing *p = lua_touserdata(L, 1);
    lua_pushboolean(L, strcmp(nl_langinfo(CODESET), "UTF-8") == 0);
    lua_setglobal(L, "in_utf8");
    if (say_terminal_width(STDOUT_FILENO) > 0)
        lua_pushinteger(L, say_terminal_width(STDOUT_FILENO));
    else
        lua_pushnil(L);
    lua_setglobal(L, "terminal_width");
    push(L, p, p->shown);
    return 1;
}

static bool load_parts(script *s, const char *const *parts, duet_error *err)
{
    bool ok = true;
    for (size_t i = 0; ok && parts[i]; ++i) {
        const blob *b = blob_find(parts[i]);
        ok = script_load(s, parts[i], b->bytes, b->length, err);
        if (ok && i > 0)
            lua_insert(script_lua(s), -2);
        ok = ok && script_call(s, i > 0, 1, err);
    }
    return ok;
}

// Leaves what the last part's function returns on the stack of a script; NULL on failure. The
// scripts are ours, and bounded only by how much there is to show: what was done is told also after
// it was stopped.
static script *call_parts(const char *const *parts, const cJSON *shown, const char *keep,
                          duet_error *err)
{
    const script_limits limits = {.memory_bytes = (size_t)4 << 30,
                                  .instructions = (uint64_t)1 << 40,
                                  .seconds = 3600,
                                  .failure = DUET_STATUS_BAD_INPUT};
    pushing p = {.shown = shown, .keep = keep};
    budget_watch *watch = budget_set_watch(NULL);
    script *s = sandbox_open(&limits, err);
    bool ok = s && load_parts(s, parts, err);
    if (ok) {
        lua_pushcfunction(script_lua(s), push_shown);
        lua_pushlightuserdata(script_lua(s), &p);
        ok = script_call(s, 1, 1, err) && script_call(s, 1, 1, err);
    }
    budget_set_watch(watch);
    text_free(&p.words);
    if (ok)
        return s;
    script_close(s);
    return NULL;
}

bool rendering_write(const char *path, const char *const *parts, const cJSON *shown,
                     duet_error *err)
{
    size_t n = 0;
    script *s = call_parts(parts, shown, "\n\t", err);
    if (!s)
        return false;
    const char *chars = lua_tolstring(script_lua(s), -1, &n);
    bool ok = text_write_file(path, chars, n, err);
    script_close(s);
    return ok;
}

// ---------------------------------------------------------------- plots

// A number of the table on top of the stack.
static double number_of(lua_State *L, const char *name)
{
    lua_getfield(L, -1, name);
    const double number = lua_tonumber(L, -1);
    lua_pop(L, 1);
    return number;
}

static colour colour_of(lua_State *L)
{
    double parts[3];
    lua_getfield(L, -1, "colour");
    for (int i = 0; i < 3; ++i) {
        lua_rawgeti(L, -1, i + 1);
        parts[i] = lua_tonumber(L, -1);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return (colour){parts[0], parts[1], parts[2], 1};
}

static void draw_box(canvas *c, point at, point far, colour fill)
{
    const point corners[] = {at, {far.x, at.y}, far, {at.x, far.y}};
    canvas_polygon(c, corners, 4, fill, fill);
}

// The shape on top of the stack (cli/report/shapes.lua).
static void draw_shape(lua_State *L, canvas *c)
{
    const point at = {number_of(L, "x"), number_of(L, "y")};
    const double width = number_of(L, "width");
    const colour ink = colour_of(L);
    lua_getfield(L, -1, "words");
    lua_getfield(L, -2, "kind");
    const char *kind = lua_tostring(L, -1), *words = lua_tostring(L, -2);
    lua_pop(L, 2);
    if (strcmp(kind, "line") == 0)
        canvas_line(c, at, (point){number_of(L, "to_x"), number_of(L, "to_y")}, ink, width);
    else if (strcmp(kind, "box") == 0)
        draw_box(c, at, (point){at.x + width, at.y + number_of(L, "height")}, ink);
    else if (strcmp(kind, "dot") == 0)
        canvas_dot(c, at, number_of(L, "radius"), ink);
    else
        canvas_words(c, at, number_of(L, "size"), ink, words);
}

bool rendering_draw(const char *path, const char *name, const cJSON *shown, duet_error *err)
{
    const char *const parts[] = {"cli/report/read.lua", "cli/report/words.lua",
                                 "cli/report/shapes.lua", name, NULL};
    script *s = call_parts(parts, shown, "", err);
    if (!s)
        return false;
    lua_State *L = script_lua(s);
    const lua_Integer n = (lua_Integer)lua_rawlen(L, -1);
    canvas *c = canvas_open(path, number_of(L, "width"), number_of(L, "height"), err);
    for (lua_Integer i = 1; c && i <= n; ++i) {
        lua_rawgeti(L, -1, i);
        draw_shape(L, c);
        lua_pop(L, 1);
    }
    script_close(s);
    return canvas_close(c, true, err);
}

// ---------------------------------------------------------------- reports

bool rendering_print(const char *name, const cJSON *shown, duet_error *err)
{
    const char *const parts[] = {"cli/report/read.lua", "cli/report/words.lua", name,
                                 "cli/report/layout.lua", NULL};
    size_t n = 0;
    script *s = call_parts(parts, shown, "", err);
    if (!s)
        return false;
    const char *chars = lua_tolstring(script_lua(s), -1, &n);
    fwrite(chars, 1, n, stdout);
    script_close(s);
    return true;
}

bool rendering_tell(cJSON *o, bool json, const char *name, duet_error *err)
{
    if (json)
        return say_json(o, err);
    bool ok = rendering_print(name, o, err);
    cJSON_Delete(o);
    return ok;
}
