// SPDX-License-Identifier: MIT
#include "cli/report/rendering.h"

#include "base/blob.h"
#include "base/error.h"
#include "gen/sandbox.h"

#include <lauxlib.h>
#include <string.h>

// The argument of a C function that pushes an object; its text outlives what Lua raises.
typedef struct pushing {
    const cJSON *shown;
    text words;
} pushing;

// Untrusted strings, with what no page may hold made visible.
static void push_words(lua_State *L, pushing *p, const char *chars)
{
    p->words.length = 0;
    text_add_visible(&p->words, chars, strlen(chars), "\n\t");
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

static bool call_parts(script *s, const char *const *parts, pushing *p, text *out, duet_error *err)
{
    lua_State *L = script_lua(s);
    if (!load_parts(s, parts, err))
        return false;
    lua_pushcfunction(L, push_shown);
    lua_pushlightuserdata(L, p);
    if (!script_call(s, 1, 1, err) || !script_call(s, 1, 1, err))
        return false;
    size_t n = 0;
    const char *chars = lua_tolstring(L, -1, &n);
    text_add_bytes(out, chars, n);
    return text_ok(out, err);
}

// The script is ours, and bounded only by how much there is to show.
bool rendering_make(text *out, const char *const *parts, const cJSON *shown, duet_error *err)
{
    const script_limits limits = {.memory_bytes = (size_t)4 << 30,
                                  .instructions = (uint64_t)1 << 40,
                                  .seconds = 3600,
                                  .failure = DUET_STATUS_BAD_INPUT};
    pushing p = {.shown = shown};
    script *s = sandbox_open(&limits, err);
    bool ok = s && call_parts(s, parts, &p, out, err);
    text_free(&p.words);
    script_close(s);
    return ok;
}
