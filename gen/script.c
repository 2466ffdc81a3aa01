// SPDX-License-Identifier: MIT
// The limits and the errors of a private Lua state.
//
// The limits are looked at in four places, so that nothing a script can do
// lasts long between two of them: between instructions, the more often the
// larger what one of them may touch; where memory is asked for; where the
// parser asks for more text; and in library functions that work long on what is
// there already (script_spend). The state, once a limit is passed, gets no more
// memory until the call has ended, so that nothing can catch the error and go
// on.
#define _GNU_SOURCE // memmem
#include "gen/script.h"
#include "base/budget.h"
#include "base/clock.h"
#include "base/text.h"

#include <inttypes.h>
#include <lauxlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// How often the limits are looked at, in instructions.
#define HOOK_INSTRUCTIONS 256

// One instruction can compare or copy a whole string; strings of up to this
// size cost about as much as the instructions between two looks.
#define SMALL_BYTES ((size_t)1 << 16)

// How much is asked for between two looks at the clock.
#define CLOCK_BYTES ((size_t)1 << 16)

// How much text the parser gets at a time: with deep functions inside others
// each of its names costs microseconds.
#define PIECE_BYTES 512

enum { MOST_JUMPS = 10000 }; // goto and break in a text

typedef enum passed { NOTHING, INSTRUCTIONS, TIME, STOP } passed;

struct script {
    lua_State *lua;
    script_limits limits;
    size_t used_bytes;
    size_t largest_bytes;       // the largest string or block of userdata that there was
    size_t asked_bytes;         // since the last look at the clock
    uint64_t instructions_left; // instructions that the running call may still take
    uint64_t spent;             // since the last look at the clock
    budget budget;
    uint64_t left_ns; // the rest of the last call's time, for closing
    passed passed;    // the limit that the running call has passed
    lua_Integer n_shown;
    int depth;        // calls inside calls; the outermost one sets the limits
    uintptr_t stack;  // the block that holds Lua's stack
    bool stack_moves; // Lua asks for another one; what looks at the stack would crash
    bool stack_grew;  // since the last look at the limits
    char place[400];  // "name:line", where that was or memory ran out last
    text name;        // name of the chunk loaded last, or else the sandbox
    text source;      // its text
};

script_limits script_default_limits(void)
{
    return (script_limits){
        .memory_bytes = (size_t)64 << 20, .instructions = 100000000, .seconds = 10};
}

// ---------------------------------------------------------------- limits

static script *script_of(lua_State *L)
{
    return *(script **)lua_getextraspace(L);
}

// Whether a frame is a script's: what the state was given to serve scripts has a name
// with "=".
static bool is_scripts(const lua_Debug *ar)
{
    return ar->currentline > 0 && *ar->source != '=';
}

// The innermost line of the chunk loaded last, or else of any. Lua tells none
// where memory ran out; neither call here allocates. While the stack moves, what
// was noted after it grew last holds on.
static void note_place(script *s)
{
    lua_Debug ar;
    bool found = false, any = false;
    if (s->stack_moves)
        return;
    for (int level = 0; !found && s->lua && lua_getstack(s->lua, level, &ar); ++level) {
        if (!lua_getinfo(s->lua, "Sl", &ar) || !is_scripts(&ar))
            continue;
        const char *name = ar.source + (*ar.source == '@');
        found = strcmp(name, s->name.chars) == 0;
        if (found || !any)
            snprintf(s->place, sizeof s->place, "%s:%d", name, ar.currentline);
        any = true;
    }
}

static bool pass(script *s, passed limit)
{
    if (!s->passed) {
        s->passed = limit;
        note_place(s);
    }
    return false;
}

static bool check_clock(script *s)
{
    duet_error why = {0};
    s->spent = s->asked_bytes = 0;
    if (s->passed)
        return false;
    if (budget_check(&why))
        return true;
    return pass(s, why.status == DUET_STATUS_INTERRUPTED ? STOP : TIME);
}

static bool spend(script *s, uint64_t instructions)
{
    if (instructions >= s->instructions_left)
        return pass(s, INSTRUCTIONS);
    s->instructions_left -= instructions;
    s->spent += instructions;
    return s->passed == NOTHING && (s->spent < HOOK_INSTRUCTIONS || check_clock(s));
}

// The error says what and where the limit was when it becomes a duet_error.
static void raise_limit(lua_State *L)
{
    lua_pushliteral(L, "a limit was passed");
    lua_error(L);
}

void script_spend(lua_State *L, uint64_t instructions)
{
    if (!spend(script_of(L), instructions))
        raise_limit(L);
}

duet_status script_set_failure(lua_State *L, duet_status status)
{
    script *s = script_of(L);
    duet_status before = s->limits.failure;
    s->limits.failure = status;
    return before;
}

static int hook_interval(const script *s)
{
    int interval = HOOK_INSTRUCTIONS;
    for (size_t bytes = s->largest_bytes; bytes > SMALL_BYTES && interval > 1; bytes /= 2)
        interval /= 2;
    return interval;
}

static void on_count(lua_State *L, lua_Debug *ar)
{
    (void)ar;
    script *s = script_of(L);
    if (s->stack_grew)
        note_place(s);
    s->stack_grew = false;
    bool enough = spend(s, (uint64_t)hook_interval(s));
    if (!enough || (hook_interval(s) < HOOK_INSTRUCTIONS && !check_clock(s)))
        raise_limit(L);
}

static void set_hook(script *s)
{
    lua_sethook(s->lua, on_count, LUA_MASKCOUNT, hook_interval(s));
}

// ---------------------------------------------------------------- memory

// Lua says what kind of object a new block is for. Tables do not count here: no
// instruction looks at the whole of one.
static void note_size(script *s, size_t kind, size_t bytes)
{
    if ((kind != LUA_TSTRING && kind != LUA_TUSERDATA) || bytes <= s->largest_bytes)
        return;
    int before = hook_interval(s);
    s->largest_bytes = bytes;
    if (s->depth > 0 && hook_interval(s) != before)
        set_hook(s);
}

static bool may_grow(script *s, size_t bytes)
{
    if (s->depth == 0)
        return true;
    s->asked_bytes += bytes;
    return s->passed == NOTHING && (s->asked_bytes < CLOCK_BYTES || check_clock(s));
}

// Lua collects its garbage and asks once more, which takes long if there is
// much: the clock is looked at before.
static void *refuse_memory(script *s)
{
    s->asked_bytes = CLOCK_BYTES;
    note_place(s);
    return NULL;
}

// The first block without a kind that a new state asks for is its stack; there are no
// coroutines, which would have stacks of their own.
static void note_stack(script *s, bool is_new, size_t kind, const void *moved)
{
    if (s->stack_moves || (!s->stack && is_new && kind == 0))
        s->stack = (uintptr_t)moved;
    s->stack_grew = s->stack_grew || s->stack_moves;
}

static void *take_block(script *s, void *at, size_t old_bytes, size_t bytes)
{
    if (bytes > old_bytes && !may_grow(s, bytes - old_bytes))
        return NULL;
    if (bytes > old_bytes && bytes - old_bytes > s->limits.memory_bytes - s->used_bytes)
        return refuse_memory(s);
    void *moved = realloc(at, bytes);
    if (moved)
        s->used_bytes = s->used_bytes - old_bytes + bytes;
    return moved;
}

static void *allocate(void *data, void *at, size_t old_bytes, size_t bytes)
{
    script *s = data;
    bool is_new = !at;
    size_t kind = is_new ? old_bytes : 0;
    if (is_new)
        old_bytes = 0;
    if (bytes == 0) {
        free(at);
        s->used_bytes -= old_bytes;
        return NULL;
    }
    s->stack_moves = !is_new && (uintptr_t)at == s->stack;
    void *moved = take_block(s, at, old_bytes, bytes);
    if (moved) {
        note_stack(s, is_new, kind, moved);
        note_size(s, kind, bytes);
    }
    s->stack_moves = false;
    return moved;
}

// ---------------------------------------------------------------- begin and end

static void collect(void *owner)
{
    lua_gc(((script *)owner)->lua, LUA_GCCOLLECT, 0);
}

static void begin_limits(script *s)
{
    if (s->depth++ > 0)
        return;
    s->instructions_left = s->limits.instructions;
    s->spent = s->asked_bytes = 0;
    s->place[0] = '\0';
    s->passed = NOTHING;
    s->budget.deadline_ns = clock_steady_ns() + (uint64_t)(s->limits.seconds * 1e9);
    s->budget.seconds = s->limits.seconds;
    s->budget.reclaim = collect;
    s->budget.owner = s;
    s->budget.host_bytes = s->limits.host_bytes ? s->limits.host_bytes : SIZE_MAX;
    budget_enter(&s->budget);
    set_hook(s);
}

static void end_limits(script *s)
{
    if (--s->depth > 0)
        return;
    uint64_t now = clock_steady_ns();
    s->left_ns = s->budget.deadline_ns > now ? s->budget.deadline_ns - now : 0;
    lua_sethook(s->lua, NULL, 0, 0);
    budget_leave(&s->budget);
}

// ---------------------------------------------------------------- errors

// "name: ..." or "...:12:..."
static bool has_place(const char *message, const text *name)
{
    if (strncmp(message, name->chars, name->length) == 0 && message[name->length] == ':')
        return true;
    for (const char *at = strchr(message, ':'); at; at = strchr(at + 1, ':')) {
        size_t digits = strspn(at + 1, "0123456789");
        if (digits > 0 && at[1 + digits] == ':')
            return true;
    }
    return false;
}

// Lua keeps only the end of a long chunk name: "...end/of/path.lua:12: ...".
// The rest of the message after that end, or NULL if it does not begin so.
static const char *after_cut_name(const char *message, const text *name)
{
    size_t kept = LUA_IDSIZE - 1 - 3;
    if (strncmp(message, "...", 3) != 0 || name->length < LUA_IDSIZE - 1)
        return NULL;
    bool same = strncmp(message + 3, name->chars + name->length - kept, kept) == 0;
    return same ? message + 3 + kept : NULL;
}

// The limit that the running call has passed, as a line.
static bool report_limit(script *s, duet_status status, duet_error *err)
{
    const char *place = *s->place ? s->place : s->name.chars;
    if (s->passed == STOP)
        return error_set(err, DUET_STATUS_INTERRUPTED, "%s: stopped", place);
    if (s->passed == INSTRUCTIONS)
        return error_set(err, status,
                         "%s: runs for more than the %" PRIu64 " instructions it may take", place,
                         s->limits.instructions);
    if (s->passed == TIME)
        return error_set(err, status, "%s: runs for more than the %g s it may take", place,
                         s->budget.seconds);
    return error_set(err, status, "%s: needs more than the %s of memory it may take", place,
                     budget_memory(s->limits.memory_bytes).chars);
}

// Takes the error value off the stack and makes a line of it.
static bool fail(script *s, int lua_status, duet_error *err)
{
    const char *name = s->name.chars;
    bool is_text = lua_type(s->lua, -1) == LUA_TSTRING;
    const char *message = is_text ? lua_tostring(s->lua, -1) : "";
    duet_status status = s->limits.failure;
    const char *rest = after_cut_name(message, &s->name);
    if (lua_status == LUA_ERRMEM || s->passed)
        report_limit(s, status, err);
    else if (!is_text)
        error_set(err, status, "%s: raises a %s as its error, not a line of text", name,
                  luaL_typename(s->lua, -1));
    else if (rest)
        error_set(err, status, "%s%s", name, rest);
    else if (has_place(message, &s->name))
        error_set(err, status, "%s", message);
    else
        error_set(err, status, "%s: %s", name, message);
    lua_pop(s->lua, 1);
    return false;
}

// ---------------------------------------------------------------- calls

script *script_open(const script_limits *limits, duet_error *err)
{
    script *s = calloc(1, sizeof *s);
    if (!s)
        return error_null(err, DUET_STATUS_NO_MEMORY, "a Lua state: no memory");
    s->limits = limits ? *limits : script_default_limits();
    if (!s->limits.failure)
        s->limits.failure = DUET_STATUS_BAD_INPUT;
    text_add(&s->name, "the sandbox");
    s->lua = text_ok(&s->name, err) ? lua_newstate(allocate, s) : NULL;
    if (s->lua) {
        *(script **)lua_getextraspace(s->lua) = s;
        return s;
    }
    error_set(err, DUET_STATUS_NO_MEMORY, "a Lua state in %zu bytes: no memory",
              s->limits.memory_bytes);
    script_close(s);
    return NULL;
}

void script_close(script *s)
{
    if (!s)
        return;
    if (s->lua) {
        s->budget.deadline_ns = clock_steady_ns() + s->left_ns;
        budget_enter(&s->budget);
        lua_close(s->lua);
        budget_leave(&s->budget);
    }
    text_free(&s->name);
    text_free(&s->source);
    free(s);
}

lua_State *script_lua(script *s)
{
    return s->lua;
}

static bool remember_chunk(script *s, const char *name, const char *chars, size_t n,
                           duet_error *err)
{
    s->name.length = s->source.length = 0;
    text_add(&s->name, "%s", name);
    text_add_bytes(&s->source, chars, n);
    return text_ok(&s->name, err) && text_ok(&s->source, err);
}

static size_t count_words(const char *chars, size_t n, const char *word)
{
    size_t count = 0;
    size_t length = strlen(word);
    const char *end = chars + n;
    for (; (chars = memmem(chars, (size_t)(end - chars), word, length)); chars += length)
        ++count;
    return count;
}

// The parser joins n jumps to one label in n^2 steps, at a single word of the
// text: 10000 of them take 0.2 s.
static bool check_jumps(const script *s, const char *chars, size_t n, duet_error *err)
{
    size_t jumps = count_words(chars, n, "goto") + count_words(chars, n, "break");
    return jumps <= MOST_JUMPS || error_set(err, s->limits.failure,
                                            "%s: has goto or break %zu times, where %d are allowed",
                                            s->name.chars, jumps, MOST_JUMPS);
}

typedef struct pieces {
    const char *chars;
    size_t left;
} pieces;

// A lua_Reader.
static const char *read_piece(lua_State *L, void *data, size_t *n)
{
    pieces *p = data;
    const char *chars = p->chars;
    if (!check_clock(script_of(L)))
        raise_limit(L);
    *n = p->left < PIECE_BYTES ? p->left : PIECE_BYTES;
    p->chars += *n;
    p->left -= *n;
    return chars;
}

bool script_load(script *s, const char *name, const char *chars, size_t n, duet_error *err)
{
    text at_name = {0}; // "@path" is how Lua knows a file from a text
    text_add(&at_name, "@%s", name);
    bool ok = text_ok(&at_name, err) && remember_chunk(s, name, chars, n, err) &&
              check_jumps(s, chars, n, err);
    if (ok) {
        pieces p = {chars, n};
        begin_limits(s);
        int status = lua_load(s->lua, read_piece, &p, at_name.chars, "t");
        end_limits(s);
        ok = status == LUA_OK || fail(s, status, err);
    }
    text_free(&at_name);
    return ok;
}

bool script_call(script *s, int n_args, int n_results, duet_error *err)
{
    begin_limits(s);
    int status = lua_pcall(s->lua, n_args, n_results, 0);
    end_limits(s);
    return status == LUA_OK || fail(s, status, err);
}

bool script_run(script *s, const char *name, const char *chars, size_t n, int n_results,
                duet_error *err)
{
    begin_limits(s);
    bool ok = script_load(s, name, chars, n, err) && script_call(s, 0, n_results, err);
    end_limits(s);
    return ok;
}

// ---------------------------------------------------------------- names

// The registry's table of the objects that were shown, with their numbers.
static const char shown_key = 0;

// Its keys are weak, so that it keeps nothing alive.
static void push_shown(lua_State *L)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &shown_key) == LUA_TTABLE)
        return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_createtable(L, 0, 1);
    lua_pushliteral(L, "k");
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_pushvalue(L, -1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &shown_key);
}

static lua_Integer number_of(lua_State *L, int index)
{
    script *s = script_of(L);
    push_shown(L);
    lua_pushvalue(L, index);
    if (lua_rawget(L, -2) == LUA_TNIL) {
        lua_pushvalue(L, index);
        lua_pushinteger(L, ++s->n_shown);
        lua_rawset(L, -4);
        lua_pop(L, 1);
        lua_pushinteger(L, s->n_shown);
    }
    lua_Integer number = lua_tointeger(L, -1);
    lua_pop(L, 2);
    return number;
}

const char *script_tostring(lua_State *L, int index, size_t *length)
{
    index = lua_absindex(L, index);
    bool is_plain = lua_type(L, index) <= LUA_TSTRING && lua_type(L, index) != LUA_TLIGHTUSERDATA;
    if (is_plain || luaL_getmetafield(L, index, "__tostring") != LUA_TNIL) {
        lua_settop(L, lua_gettop(L) - !is_plain);
        return luaL_tolstring(L, index, length);
    }
    lua_pushfstring(L, "%s: %I", luaL_typename(L, index), (LUAI_UACINT)number_of(L, index));
    return lua_tolstring(L, -1, length);
}

const char *script_chunk(lua_State *L, const char **name)
{
    const script *s = script_of(L);
    *name = s->name.chars;
    return text_chars(&s->source);
}
