// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // memmem, which is linear
#include "gen/pattern.h"
#include "gen/script.h"

#include <lauxlib.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { MOST_CAPTURES = 32, MOST_DEPTH = 200 };

// Steps between two looks at the limits, and how many of them cost as much as
// an instruction.
enum { STEPS_AT_ONCE = 2048, STEPS_AN_INSTRUCTION = 4 };

enum { OPEN = -1, POSITION = -2 }; // a capture's length, until it has one

typedef struct matcher {
    lua_State *lua;
    const char *text, *text_end;
    const char *pattern, *pattern_end;
    uint32_t steps;
    int depth;
    int n;
    struct {
        const char *at;
        ptrdiff_t length;
    } captures[MOST_CAPTURES];
} matcher;

static const char *match(matcher *m, const char *at, const char *item);

static void step(matcher *m, size_t n)
{
    size_t left = STEPS_AT_ONCE - m->steps;
    if (n < left) {
        m->steps += (uint32_t)n;
        return;
    }
    script_spend(m->lua, (m->steps + (uint64_t)n) / STEPS_AN_INSTRUCTION);
    m->steps = 0;
}

// ---------------------------------------------------------------- one byte

static bool is_letter(unsigned char c)
{
    return (c | 32) >= 'a' && (c | 32) <= 'z';
}

static bool is_digit(unsigned char c)
{
    return c >= '0' && c <= '9';
}

static bool is_hex(unsigned char c)
{
    return is_digit(c) || ((c | 32) >= 'a' && (c | 32) <= 'f');
}

static bool is_space(unsigned char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static bool is_visible(unsigned char c)
{
    return c > ' ' && c < 127;
}

// %a, %d ...: in capitals what is none of them; other bytes are themselves.
static bool in_class(unsigned char c, unsigned char class)
{
    bool is = false;
    switch (class | 32) {
    case 'a':
        is = is_letter(c);
        break;
    case 'c':
        is = c < ' ' || c == 127;
        break;
    case 'd':
        is = is_digit(c);
        break;
    case 'g':
        is = is_visible(c);
        break;
    case 'l':
        is = c >= 'a' && c <= 'z';
        break;
    case 'p':
        is = is_visible(c) && !is_letter(c) && !is_digit(c);
        break;
    case 's':
        is = is_space(c);
        break;
    case 'u':
        is = c >= 'A' && c <= 'Z';
        break;
    case 'w':
        is = is_letter(c) || is_digit(c);
        break;
    case 'x':
        is = is_hex(c);
        break;
    case 'z':
        is = c == '\0';
        break;
    default:
        return c == class;
    }
    return is == (class >= 'a');
}

// Behind the item's single byte, class or set.
static const char *skip_single(matcher *m, const char *item)
{
    const char *end = m->pattern_end;
    if (*item == '%' && item + 1 == end)
        luaL_error(m->lua, "malformed pattern (ends with '%%')");
    if (*item != '[')
        return item + (*item == '%' ? 2 : 1);
    const char *at = item + 1 + (item + 1 < end && item[1] == '^');
    bool first = true;
    for (; at < end && (first || *at != ']'); first = false)
        at += *at == '%' ? 2 : 1;
    if (at >= end)
        luaL_error(m->lua, "malformed pattern (missing ']')");
    step(m, (size_t)(at - item));
    return at + 1;
}

// A set from its '[' to the ']' at last. Both ends of a range are in it.
static bool in_set(matcher *m, unsigned char c, const char *item, const char *last)
{
    bool negated = item[1] == '^';
    const char *at = item + 1 + negated;
    bool found = false;
    while (at < last && !found) {
        if (*at == '%') {
            found = in_class(c, (unsigned char)at[1]);
            at += 2;
        } else if (at + 2 < last && at[1] == '-') {
            found = c >= (unsigned char)at[0] && c <= (unsigned char)at[2];
            at += 3;
        } else {
            found = c == (unsigned char)*at++;
        }
    }
    step(m, (size_t)(at - item));
    return found != negated;
}

// Whether the byte at is the item's, which ends before after.
static bool is_single(matcher *m, const char *at, const char *item, const char *after)
{
    if (at >= m->text_end)
        return false;
    unsigned char c = (unsigned char)*at;
    step(m, 1);
    switch (*item) {
    case '.':
        return true;
    case '%':
        return in_class(c, (unsigned char)item[1]);
    case '[':
        return in_set(m, c, item, after - 1);
    default:
        return c == (unsigned char)*item;
    }
}

// ---------------------------------------------------------------- captures

static const char *open_capture(matcher *m, const char *at, const char *item, ptrdiff_t length)
{
    if (m->n == MOST_CAPTURES)
        luaL_error(m->lua, "too many captures");
    m->captures[m->n].at = at;
    m->captures[m->n].length = length;
    ++m->n;
    const char *end = match(m, at, item + (length == POSITION ? 2 : 1));
    if (!end)
        --m->n;
    return end;
}

static const char *close_capture(matcher *m, const char *at, const char *item)
{
    int i = m->n - 1;
    while (i >= 0 && m->captures[i].length != OPEN)
        --i;
    if (i < 0)
        luaL_error(m->lua, "invalid pattern capture");
    m->captures[i].length = at - m->captures[i].at;
    const char *end = match(m, at, item + 1);
    if (!end)
        m->captures[i].length = OPEN;
    return end;
}

// What %1 to %9 stand for. NULL where the text is not the same here.
static const char *match_again(matcher *m, const char *at, unsigned char digit)
{
    int i = digit - '1';
    if (i < 0 || i >= m->n || m->captures[i].length == OPEN)
        luaL_error(m->lua, "invalid capture index %%%d", i + 1);
    if (m->captures[i].length == POSITION)
        return NULL; // a place is no text
    size_t length = (size_t)m->captures[i].length;
    step(m, length / 8 + 1);
    bool same = (size_t)(m->text_end - at) >= length && memcmp(m->captures[i].at, at, length) == 0;
    return same ? at + length : NULL;
}

static void push_capture(matcher *m, int i, const char *from, const char *to)
{
    if (i >= m->n && i > 0)
        luaL_error(m->lua, "invalid capture index %%%d", i + 1);
    if (i >= m->n)
        lua_pushlstring(m->lua, from, (size_t)(to - from));
    else if (m->captures[i].length == POSITION)
        lua_pushinteger(m->lua, m->captures[i].at - m->text + 1);
    else if (m->captures[i].length == OPEN)
        luaL_error(m->lua, "unfinished capture");
    else
        lua_pushlstring(m->lua, m->captures[i].at, (size_t)m->captures[i].length);
}

// All captures; without any the whole match, where from is not NULL.
static int push_captures(matcher *m, const char *from, const char *to)
{
    int n = m->n == 0 && from ? 1 : m->n;
    luaL_checkstack(m->lua, n, "too many captures");
    for (int i = 0; i < n; ++i)
        push_capture(m, i, from, to);
    return n;
}

// ---------------------------------------------------------------- items

// %bxy
static const char *match_balance(matcher *m, const char *at, const char *item)
{
    if (item + 1 >= m->pattern_end)
        luaL_error(m->lua, "malformed pattern (missing arguments to '%%b')");
    if (at >= m->text_end || *at != item[0])
        return NULL;
    size_t open = 0;
    for (const char *to = at; to < m->text_end; ++to) {
        step(m, 1);
        if (*to == item[1] && to > at && --open == 0)
            return to + 1;
        if (*to == item[0] && (item[0] != item[1] || to == at))
            ++open;
    }
    return NULL;
}

// %f[set]: between a byte that is not in the set and one that is.
static bool is_frontier(matcher *m, const char *at, const char *item, const char *after)
{
    unsigned char before = at == m->text ? '\0' : (unsigned char)at[-1];
    unsigned char here = at < m->text_end ? (unsigned char)*at : '\0';
    return !in_set(m, before, item, after - 1) && in_set(m, here, item, after - 1);
}

// x* and x+: as many as there are, then fewer.
static const char *match_most(matcher *m, const char *at, const char *item, const char *after,
                              size_t least)
{
    size_t n = 0;
    while (is_single(m, at + n, item, after))
        ++n;
    for (; n + 1 > least; --n) {
        const char *end = match(m, at + n, after + 1);
        if (end || n == 0)
            return end;
    }
    return NULL;
}

// x-: as few as will do.
static const char *match_least(matcher *m, const char *at, const char *item, const char *after)
{
    for (;; ++at) {
        const char *end = match(m, at, after + 1);
        if (end)
            return end;
        if (!is_single(m, at, item, after))
            return NULL;
    }
}

// %b, %f and %1: sets *at and *item behind what matched; false where nothing did.
static bool match_special(matcher *m, const char **at, const char **item)
{
    const char *after = *item + 2;
    if ((*item)[1] == 'b') {
        *at = match_balance(m, *at, after);
        *item = after + 2;
    } else if ((*item)[1] == 'f') {
        if (after >= m->pattern_end || *after != '[')
            luaL_error(m->lua, "missing '[' after '%%f' in pattern");
        *item = skip_single(m, after);
        if (!is_frontier(m, *at, after, *item))
            *at = NULL;
    } else {
        *at = match_again(m, *at, (unsigned char)(*item)[1]);
        *item = after;
    }
    return *at != NULL;
}

static bool is_special(const matcher *m, const char *item)
{
    return *item == '%' && item + 1 < m->pattern_end &&
           (item[1] == 'b' || item[1] == 'f' || is_digit((unsigned char)item[1]));
}

// One item with what may stand behind it: *, +, - or ?. *more where the pattern
// goes on at *item from *at; else the value is how the whole ended.
static const char *match_item(matcher *m, const char **at, const char **item, bool *more)
{
    const char *from = *at;
    const char *after = skip_single(m, *item);
    char repeat = after < m->pattern_end ? *after : '\0';
    *more = false;
    if (repeat == '*' || repeat == '+')
        return match_most(m, from, *item, after, repeat == '+');
    if (repeat == '-')
        return match_least(m, from, *item, after);
    bool is = is_single(m, from, *item, after);
    if (repeat == '?' && is) {
        const char *end = match(m, from + 1, after + 1);
        if (end)
            return end;
    }
    *more = is || repeat == '?';
    *at = from + (is && repeat != '?');
    *item = after + (repeat == '?');
    return NULL;
}

static const char *match_here(matcher *m, const char *at, const char *item)
{
    while (item < m->pattern_end) {
        step(m, 1);
        if (*item == '(')
            return open_capture(m, at, item,
                                item + 1 < m->pattern_end && item[1] == ')' ? POSITION : OPEN);
        if (*item == ')')
            return close_capture(m, at, item);
        if (*item == '$' && item + 1 == m->pattern_end)
            return at == m->text_end ? at : NULL;
        if (is_special(m, item)) {
            if (!match_special(m, &at, &item))
                return NULL;
            continue;
        }
        bool more = false;
        const char *end = match_item(m, &at, &item, &more);
        if (!more)
            return end;
    }
    return at;
}

// Where a match that begins at this place ends, or NULL.
static const char *match(matcher *m, const char *at, const char *item)
{
    if (++m->depth > MOST_DEPTH)
        luaL_error(m->lua, "pattern too complex");
    const char *end = match_here(m, at, item);
    --m->depth;
    return end;
}

// ---------------------------------------------------------------- searching

// The text at index 1 and the pattern at 2, without the ^ that it may begin with.
static matcher begin(lua_State *L, bool *anchored)
{
    size_t n = 0;
    size_t length = 0;
    matcher m = {.lua = L};
    m.text = luaL_checklstring(L, 1, &n);
    m.pattern = luaL_checklstring(L, 2, &length);
    m.text_end = m.text + n;
    m.pattern_end = m.pattern + length;
    *anchored = length > 0 && *m.pattern == '^';
    m.pattern += *anchored;
    return m;
}

static const char *try_at(matcher *m, const char *at)
{
    m->n = m->depth = 0;
    step(m, 1);
    return match(m, at, m->pattern);
}

// The place of index's number in a text of n bytes, from 0; n + 1 behind it.
static size_t place_of(lua_State *L, int index, size_t n)
{
    lua_Integer place = luaL_optinteger(L, index, 1);
    if (place > 0)
        return (lua_Unsigned)place - 1 > n ? n + 1 : (size_t)place - 1;
    if (place == 0 || place < -(lua_Integer)n)
        return 0;
    return n - (size_t)-place;
}

static bool is_plain(const char *pattern, size_t n)
{
    static const bool magic[UINT8_MAX + 1] = {
        ['^'] = true, ['$'] = true, ['*'] = true, ['+'] = true, ['?'] = true,
        ['.'] = true, ['('] = true, ['['] = true, ['%'] = true, ['-'] = true};
    for (size_t i = 0; i < n; ++i)
        if (magic[(unsigned char)pattern[i]])
            return false;
    return true;
}

static int find_plain(matcher *m, const char *from)
{
    size_t n = (size_t)(m->pattern_end - m->pattern);
    const char *found = n == 0 ? from : memmem(from, (size_t)(m->text_end - from), m->pattern, n);
    step(m, ((size_t)((found ? found : m->text_end) - from) + n) / 8);
    if (!found) {
        lua_pushnil(m->lua);
        return 1;
    }
    lua_pushinteger(m->lua, found - m->text + 1);
    lua_pushinteger(m->lua, found - m->text + (lua_Integer)n);
    return 2;
}

static int search(lua_State *L, bool find)
{
    bool anchored = false;
    matcher m = begin(L, &anchored);
    size_t length = 0;
    const char *pattern = lua_tolstring(L, 2, &length);
    size_t from = place_of(L, 3, (size_t)(m.text_end - m.text));
    if (from > (size_t)(m.text_end - m.text)) {
        lua_pushnil(L);
        return 1;
    }
    if (find && (lua_toboolean(L, 4) || is_plain(pattern, length))) {
        m.pattern = pattern; // a plain ^ is one of its bytes
        return find_plain(&m, m.text + from);
    }
    for (const char *at = m.text + from; at <= m.text_end; ++at) {
        const char *end = try_at(&m, at);
        if (end && find) {
            lua_pushinteger(L, at - m.text + 1);
            lua_pushinteger(L, end - m.text);
            return 2 + push_captures(&m, NULL, NULL);
        }
        if (end)
            return push_captures(&m, at, end);
        if (anchored)
            break;
    }
    lua_pushnil(L);
    return 1;
}

static int find(lua_State *L)
{
    return search(L, true);
}

static int match_once(lua_State *L)
{
    return search(L, false);
}

// ---------------------------------------------------------------- one after the other

typedef struct place {
    size_t next;
    size_t last_end; // an empty match right there is none
} place;

// Upvalues: the text, the pattern, the place.
static int next_match(lua_State *L)
{
    bool anchored = false;
    lua_settop(L, 0);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_pushvalue(L, lua_upvalueindex(2));
    place *p = lua_touserdata(L, lua_upvalueindex(3));
    matcher m = begin(L, &anchored);
    m.pattern -= anchored; // here a ^ is a byte like others
    for (; p->next <= (size_t)(m.text_end - m.text); ++p->next) {
        const char *at = m.text + p->next;
        const char *end = try_at(&m, at);
        if (!end || (size_t)(end - m.text) == p->last_end)
            continue;
        p->next = p->last_end = (size_t)(end - m.text);
        return push_captures(&m, at, end);
    }
    return 0;
}

static int gmatch(lua_State *L)
{
    size_t n = 0;
    luaL_checklstring(L, 1, &n);
    luaL_checkstring(L, 2);
    size_t from = place_of(L, 3, n);
    lua_settop(L, 2);
    place *p = lua_newuserdatauv(L, sizeof *p, 0);
    *p = (place){from, SIZE_MAX};
    lua_pushcclosure(L, next_match, 3);
    return 1;
}

// ---------------------------------------------------------------- replacing

// Adds the replacement's text, with captures for %0 to %9.
static void add_text(matcher *m, luaL_Buffer *out, const char *from, const char *to)
{
    size_t n = 0;
    const char *with = lua_tolstring(m->lua, 3, &n);
    for (size_t i = 0; i < n; ++i) {
        const char *percent = memchr(with + i, '%', n - i);
        size_t plain = percent ? (size_t)(percent - with) - i : n - i;
        luaL_addlstring(out, with + i, plain);
        i += plain;
        if (!percent)
            return;
        char what = ++i < n ? with[i] : '\0';
        if (what == '%') {
            luaL_addchar(out, '%');
        } else if (what == '0') {
            luaL_addlstring(out, from, (size_t)(to - from));
        } else if (is_digit((unsigned char)what)) {
            push_capture(m, what - '1', from, to);
            luaL_tolstring(m->lua, -1, NULL);
            lua_remove(m->lua, -2);
            luaL_addvalue(out);
        } else {
            luaL_error(m->lua, "invalid use of '%%' in replacement string");
        }
    }
}

// Whether the match was replaced; a value of nil or false leaves it.
static bool add_replacement(matcher *m, luaL_Buffer *out, const char *from, const char *to)
{
    lua_State *L = m->lua;
    int type = lua_type(L, 3);
    if (type == LUA_TSTRING || type == LUA_TNUMBER) {
        add_text(m, out, from, to);
        return true;
    }
    if (type == LUA_TFUNCTION) {
        lua_pushvalue(L, 3);
        lua_call(L, push_captures(m, from, to), 1);
    } else {
        push_capture(m, 0, from, to);
        lua_gettable(L, 3);
    }
    if (!lua_toboolean(L, -1)) {
        lua_pop(L, 1);
        luaL_addlstring(out, from, (size_t)(to - from));
        return false;
    }
    if (!lua_isstring(L, -1))
        luaL_error(L, "invalid replacement value (a %s)", luaL_typename(L, -1));
    luaL_addvalue(out);
    return true;
}

static int gsub(lua_State *L)
{
    bool anchored = false;
    bool changed = false;
    matcher m = begin(L, &anchored);
    int type = lua_type(L, 3);
    luaL_argexpected(L,
                     type == LUA_TNUMBER || type == LUA_TSTRING || type == LUA_TFUNCTION ||
                         type == LUA_TTABLE,
                     3, "string/function/table");
    if (type == LUA_TNUMBER)
        lua_tostring(L, 3);
    lua_Integer most = luaL_optinteger(L, 4, m.text_end - m.text + 1);
    lua_Integer n = 0;
    const char *at = m.text;
    const char *last_end = NULL;
    luaL_Buffer out;
    luaL_buffinit(L, &out);
    while (n < most) {
        const char *end = try_at(&m, at);
        if (end && end != last_end) {
            ++n;
            changed |= add_replacement(&m, &out, at, end);
            at = last_end = end;
        } else if (at < m.text_end) {
            luaL_addchar(&out, *at++);
        } else {
            break;
        }
        if (anchored)
            break;
    }
    if (changed) {
        luaL_addlstring(&out, at, (size_t)(m.text_end - at));
        luaL_pushresult(&out);
    } else {
        lua_pushvalue(L, 1);
    }
    lua_pushinteger(L, n);
    return 2;
}

void pattern_open(lua_State *L)
{
    static const luaL_Reg functions[] = {
        {"find", find}, {"match", match_once}, {"gmatch", gmatch}, {"gsub", gsub}, {NULL, NULL}};
    luaL_setfuncs(L, functions, 0);
}
