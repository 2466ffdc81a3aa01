// SPDX-License-Identifier: MIT
#include "cli/report/page.h"

#include "base/blob.h"
#include "base/text.h"
#include "cli/report/profile_report.h"
#include "gen/sandbox.h"
#include "runtime/duet.h"

#include <lauxlib.h>
#include <string.h>
#include <time.h>

// Each part of the script takes what the one before it returns; the last returns the page's
// function.
static const char *const parts[] = {"cli/report/page_read.lua", "cli/report/page_draw.lua",
                                    "cli/report/page_store.lua", "cli/report/page_bench.lua",
                                    "cli/report/page.lua"};

cJSON *page_begin(void)
{
    char when[40];
    time_t now = time(NULL);
    strftime(when, sizeof when, "%Y-%m-%d %H:%M UTC", gmtime(&now));
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "made", when);
    cJSON_AddStringToObject(o, "duet", duet_version());
    cJSON_AddArrayToObject(o, "levels");
    cJSON_AddArrayToObject(o, "effects");
    cJSON_AddArrayToObject(o, "bench");
    return o;
}

// ---------------------------------------------------------------- the store

typedef struct gathering {
    store *s;
    cJSON *profiles;
    bool ok;
    duet_error *err;
} gathering;

static bool gather(void *context, const profile_entry *e)
{
    gathering *g = context;
    cJSON *o = profile_report_json(e);
    cJSON_AddNumberToObject(o, "pair_id", (double)e->row.pair_id);
    cJSON_AddNumberToObject(o, "workload_id", (double)e->row.workload_id);
    cJSON_AddNumberToObject(o, "created_ns", (double)e->created_ns);
    cJSON_AddItemToArray(g->profiles, o);
    g->ok = e->dead_reason || profile_report_add_trials(o, g->s, e->session.id, g->err);
    return g->ok;
}

bool page_add_store(cJSON *shown, store *s, duet_error *err)
{
    cJSON *o = cJSON_AddObjectToObject(shown, "store");
    cJSON_AddStringToObject(o, "path", store_path(s));
    gathering g = {s, cJSON_AddArrayToObject(o, "profiles"), true, err};
    return profile_entry_each(s, NULL, true, gather, &g, err) && g.ok;
}

// ---------------------------------------------------------------- the script

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

static bool load_page(script *s, duet_error *err)
{
    bool ok = true;
    for (size_t i = 0; ok && i < sizeof parts / sizeof *parts; ++i) {
        const blob *b = blob_find(parts[i]);
        ok = script_load(s, parts[i], b->bytes, b->length, err);
        if (ok && i > 0)
            lua_insert(script_lua(s), -2);
        ok = ok && script_call(s, i > 0, 1, err);
    }
    return ok;
}

static bool call_page(script *s, pushing *p, text *page, duet_error *err)
{
    lua_State *L = script_lua(s);
    if (!load_page(s, err))
        return false;
    lua_pushcfunction(L, push_shown);
    lua_pushlightuserdata(L, p);
    if (!script_call(s, 1, 1, err) || !script_call(s, 1, 1, err))
        return false;
    size_t n = 0;
    const char *chars = lua_tolstring(L, -1, &n);
    text_add_bytes(page, chars, n);
    return text_ok(page, err);
}

// The script is ours, and bounded only by how much there is to show.
bool page_make(text *page, const cJSON *shown, duet_error *err)
{
    const script_limits limits = {.memory_bytes = (size_t)4 << 30,
                                  .instructions = (uint64_t)1 << 40,
                                  .seconds = 3600,
                                  .failure = DUET_STATUS_BAD_INPUT};
    pushing p = {.shown = shown};
    script *s = sandbox_open(&limits, err);
    bool ok = s && call_page(s, &p, page, err);
    text_free(&p.words);
    script_close(s);
    return ok;
}
