// SPDX-License-Identifier: MIT
// The limits of a private Lua state.
//
// The limits are looked at in four places, so that nothing a script can do
// lasts long between two of them: between instructions, the more often the
// larger what one of them may touch; where memory is asked for; where the
// parser asks for more text; and in library functions that work long on what is
// there already (script_spend). The state, once a limit is passed, gets no more
// memory until the call has ended, so that nothing can catch the error and go
// on.
#include "gen/script_state.h"

#include "base/clock.h"

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

script *script_of(lua_State *L)
{
    void *s = NULL;
    return lua_getallocf(L, &s) == script_allocate ? s : NULL;
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

void script_look(lua_State *L)
{
    if (!check_clock(script_of(L)))
        raise_limit(L);
}

void script_spend(lua_State *L, uint64_t instructions)
{
    if (!spend(script_of(L), instructions))
        raise_limit(L);
}

void script_lacks_memory(lua_State *L)
{
    pass(script_of(L), HOST_MEMORY);
    raise_limit(L);
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
    else
        pass(s, HOST_MEMORY);
    return moved;
}

void *script_allocate(void *data, void *at, size_t old_bytes, size_t bytes)
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

void script_begin(script *s)
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

void script_end(script *s)
{
    if (--s->depth > 0)
        return;
    uint64_t now = clock_steady_ns();
    s->left_ns = s->budget.deadline_ns > now ? s->budget.deadline_ns - now : 0;
    lua_sethook(s->lua, NULL, 0, 0);
    budget_leave(&s->budget);
}
