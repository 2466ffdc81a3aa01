// SPDX-License-Identifier: MIT
// Lends template.lua a state; the work is done there.
#include "gen/template.h"
#include "base/blob.h"
#include "gen/sandbox.h"

#include <stdlib.h>
#include <string.h>

// Places at the bottom of the state's stack, which hold for good:
enum { LIBRARY = 1, RUN = 2 };

struct template
{
    script *script;
};

// The work of a C function in the state. Its own stack has what lies at the
// bottom, and above that a pointer to this.
typedef struct job {
    const text *chars;
    const char *path;
    const char *line_name;
    const char *module;
    const gen_setting *config;
    uint32_t n;
    text *out;
} job;

// The mark is at a line's begin or behind blanks.
bool template_has_lua(const text *chars)
{
    for (const char *at = strstr(text_chars(chars), "//@"); at; at = strstr(at + 1, "//@")) {
        const char *line = at;
        while (line > chars->chars && (line[-1] == ' ' || line[-1] == '\t'))
            --line;
        if (line == chars->chars || line[-1] == '\n')
            return true;
    }
    return false;
}

// Calls a C function with all that is on the stack and the job.
static bool call(template *t, lua_CFunction function, job *j, int n_results, duet_error *err)
{
    lua_State *L = script_lua(t->script);
    int n = lua_gettop(L);
    lua_pushcfunction(L, function);
    for (int i = 1; i <= n; ++i)
        lua_pushvalue(L, i);
    lua_pushlightuserdata(L, j);
    return script_call(t->script, n + 1, n_results, err);
}

static bool run_carried(template *t, const char *path, duet_error *err)
{
    const blob *b = blob_find(path);
    if (!b)
        return error_set(err, DUET_STATUS_BUILD_FAILED, "%s: there is no such file", path);
    return script_run(t->script, path, b->bytes, b->length, 1, err);
}

// [1] library [2] the module [3] job
static int keep_module(lua_State *L)
{
    const job *j = lua_touserdata(L, 3);
    lua_getfield(L, LIBRARY, "modules");
    lua_pushvalue(L, 2);
    lua_setfield(L, -2, j->module);
    return 0;
}

static bool open_modules(template *t, const card_names *emit, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && emit && i < emit->n; ++i) {
        text path = {0};
        text_add(&path, "gen/emit/%s.lua", emit->at[i]);
        job j = {.module = emit->at[i]};
        ok = text_ok(&path, err) && run_carried(t, path.chars, err) &&
             call(t, keep_module, &j, 0, err);
        lua_settop(script_lua(t->script), LIBRARY);
        text_free(&path);
    }
    return ok;
}

// [1] library [2] job; gives the chunk
static int translate(lua_State *L)
{
    const job *j = lua_touserdata(L, 2);
    lua_getfield(L, LIBRARY, j->line_name ? "translate" : "translate_choices");
    lua_pushlstring(L, j->chars->chars, j->chars->length);
    lua_pushstring(L, j->path);
    lua_pushstring(L, j->line_name);
    lua_call(L, 3, 1);
    return 1;
}

// Leaves the translated template at RUN.
static bool open_run(template *t, job *j, duet_error *err)
{
    if (!call(t, translate, j, 1, err))
        return false;
    lua_State *L = script_lua(t->script);
    size_t n = 0;
    const char *chunk = lua_tolstring(L, -1, &n);
    bool ok = script_load(t->script, j->path, chunk, n, err);
    lua_remove(L, RUN); // the chunk's text
    return ok;
}

template *template_open(const text *chars, const char *path, const char *line_name,
                        const card_names *emit, duet_error *err)
{
    template *t = calloc(1, sizeof *t);
    if (!t)
        return null_no_memory(err, "%s", path);
    script_limits limits = script_default_limits();
    limits.failure = DUET_STATUS_BUILD_FAILED;
    t->script = sandbox_open(&limits, err);
    job j = {.chars = chars, .path = path, .line_name = line_name};
    bool ok = t->script && run_carried(t, "gen/template.lua", err);
    ok = ok && open_modules(t, emit, err);
    ok = ok && open_run(t, &j, err);
    if (ok)
        return t;
    template_close(t);
    return NULL;
}

void template_close(template *t)
{
    if (!t)
        return;
    script_close(t->script);
    free(t);
}

// [1] library [2] the translated template [3] job
static int expand(lua_State *L)
{
    const job *j = lua_touserdata(L, 3);
    lua_getfield(L, LIBRARY, "expand");
    lua_pushvalue(L, RUN);
    signature_push_config(L, j->config, j->n);
    lua_call(L, 2, 1);
    size_t n = 0;
    const char *chars = lua_tolstring(L, -1, &n);
    text_add_bytes(j->out, chars, n);
    return 0;
}

bool template_expand(template *t, const gen_setting *config, uint32_t n, text *out, duet_error *err)
{
    job j = {.config = config, .n = n, .out = out};
    return call(t, expand, &j, 0, err) && text_ok(out, err);
}
