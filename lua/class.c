// SPDX-License-Identifier: MIT
#include "lua/class.h"

#include "base/budget.h"

#include <stdio.h>
#include <string.h>

// object.name: a field's value, else the method; a misspelt name is an error.
static int find_member(lua_State *L)
{
    const lua_class *c = lua_touserdata(L, lua_upvalueindex(1));
    const char *name = lua_type(L, 2) == LUA_TSTRING ? lua_tostring(L, 2) : "";
    luaL_checkudata(L, 1, c->name);
    lua_pushvalue(L, 2);
    if (lua_rawget(L, lua_upvalueindex(2)) != LUA_TNIL)
        return 1;
    const field *m = c->fields ? field_named(c->fields, name) : NULL;
    if (!m)
        return luaL_error(L, "%s has no '%s'", c->name, field_push_shown(L, 2));
    field_push(L, m, c->struct_of(L));
    return 1;
}

// Puts a text in the place of the value on top; { 1, 2, 3 } for a vector, { ... } for a record.
static void push_text(lua_State *L)
{
    if (!lua_istable(L, -1)) {
        luaL_tolstring(L, -1, NULL);
        lua_remove(L, -2);
        return;
    }
    lua_pushliteral(L, "{ ");
    for (lua_Unsigned i = 1; i <= lua_rawlen(L, -2); ++i) {
        lua_pushstring(L, i > 1 ? ", " : "");
        lua_rawgeti(L, -3, (lua_Integer)i);
        lua_concat(L, 3);
    }
    if (lua_rawlen(L, -2) == 0) {
        lua_pushliteral(L, "...");
        lua_concat(L, 2);
    }
    lua_pushliteral(L, " }");
    lua_concat(L, 2);
    lua_remove(L, -2);
}

// name = value, ... of the object at 1; raises if it is closed.
static int describe(lua_State *L)
{
    const lua_class *c = lua_touserdata(L, lua_upvalueindex(1));
    const void *from = c->struct_of(L);
    luaL_Buffer line;
    luaL_buffinit(L, &line);
    for (const field *m = c->fields; m->name; ++m) {
        luaL_addstring(&line, m == c->fields ? "" : ", ");
        luaL_addstring(&line, m->name);
        luaL_addstring(&line, " = ");
        field_push(L, m, from);
        push_text(L);
        luaL_addvalue(&line);
    }
    luaL_pushresult(&line);
    return 1;
}

// "duet.scene { name = paper, n = 1000 }"
static int class_tostring(lua_State *L)
{
    const lua_class *c = lua_touserdata(L, lua_upvalueindex(1));
    luaL_checkudata(L, 1, c->name);
    if (!c->fields && !c->about) {
        lua_pushstring(L, c->name);
        return 1;
    }
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_pushcclosure(L, c->about ? c->about : describe, 1);
    lua_pushvalue(L, 1);
    if (lua_pcall(L, 1, 1, 0) == LUA_OK)
        lua_pushfstring(L, "%s { %s }", c->name, lua_tostring(L, -1));
    else
        lua_pushfstring(L, "%s (closed)", c->name);
    return 1;
}

// The class of the value at 1, and its methods on top; else NULL, and nothing pushed.
static const lua_class *find_class(lua_State *L)
{
    const lua_class *c = NULL;
    if (!lua_isuserdata(L, 1) || !luaL_getmetafield(L, 1, "__index"))
        return NULL;
    if (lua_tocfunction(L, -1) == find_member) {
        lua_getupvalue(L, -1, 1);
        c = lua_touserdata(L, -1);
        lua_getupvalue(L, -2, 2);
        lua_replace(L, -3);
    }
    lua_pop(L, 1);
    return c;
}

int class_names(lua_State *L)
{
    lua_settop(L, 1);
    const lua_class *c = find_class(L);
    if (!c)
        return 0;
    lua_pushstring(L, c->name);
    lua_newtable(L);
    for (int i = 0; c->fields && c->fields[i].name; ++i) {
        lua_pushstring(L, c->fields[i].name);
        lua_rawseti(L, -2, i + 1);
    }
    lua_newtable(L);
    for (lua_pushnil(L); lua_next(L, 2); lua_pop(L, 1)) {
        lua_pushvalue(L, -2);
        lua_rawseti(L, 5, (lua_Integer)lua_rawlen(L, 5) + 1);
    }
    return 3;
}

// The close of a userdata that begins with a handle; upvalue 1 is its class.
static int close_handle(lua_State *L)
{
    const lua_class *c = lua_touserdata(L, lua_upvalueindex(1));
    lua_handle *handle = luaL_checkudata(L, 1, c->name);
    if (handle->object)
        c->destroy(handle->object);
    handle->object = NULL;
    return 0;
}

// Takes a function off the stack, into a class under this name.
static void set_method(lua_State *L, const char *class, const char *name)
{
    luaL_getmetatable(L, class);
    lua_insert(L, -2);
    if (strncmp(name, "__", 2) == 0) {
        lua_setfield(L, -2, name);
        lua_pop(L, 1);
        return;
    }
    for (int i = 0; i < 2 && strcmp(name, "close") == 0; ++i) {
        lua_pushvalue(L, -1);
        lua_setfield(L, -3, i == 0 ? "__gc" : "__close");
    }
    lua_getfield(L, -2, "__index");
    lua_getupvalue(L, -1, 2); // find_member's
    lua_pushvalue(L, -3);
    lua_setfield(L, -2, name);
    lua_pop(L, 4);
}

void class_open(lua_State *L, const lua_class *c)
{
    if (!luaL_newmetatable(L, c->name)) {
        lua_pop(L, 1);
        return;
    }
    lua_pushlightuserdata(L, (void *)c);
    lua_pushcclosure(L, class_tostring, 1);
    lua_setfield(L, -2, "__tostring");
    lua_pushlightuserdata(L, (void *)c);
    lua_newtable(L);
    lua_pushcclosure(L, find_member, 2);
    lua_setfield(L, -2, "__index");
    lua_pushstring(L, c->name); // getmetatable gives this: scripts see no more of the metatable
    lua_setfield(L, -2, "__metatable");
    lua_pop(L, 1);
    if (!c->destroy)
        return;
    lua_pushlightuserdata(L, (void *)c);
    lua_pushcclosure(L, close_handle, 1);
    set_method(L, c->name, "close");
}

static void push_call(lua_State *L, const lua_method *m)
{
    lua_pushinteger(L, m->which);
    lua_pushcclosure(L, m->call, 1);
}

void class_add(lua_State *L, const char *class, const lua_method *m)
{
    push_call(L, m);
    set_method(L, class, m->name);
}

void class_open_noun(lua_State *L, const lua_noun *noun)
{
    for (const lua_class *const *c = noun->classes; *c; ++c)
        class_open(L, *c);
    for (const lua_method *m = noun->methods; m->name; ++m) {
        char class[32];
        size_t length = strcspn(m->name, ":");
        push_call(L, m);
        if (m->name[length] == '\0') {
            lua_setfield(L, -2, m->name + sizeof "duet." - 1);
            continue;
        }
        snprintf(class, sizeof class, "%.*s", (int)length, m->name);
        set_method(L, class, m->name + length + 1);
    }
}

// An object may hold memory that Lua knows nothing of.
void *class_push(lua_State *L, const lua_class *c, size_t bytes)
{
    duet_error why = {0};
    if (!budget_space(0, &why))
        luaL_error(L, "%s", why.text);
    void *object = lua_newuserdatauv(L, bytes, 1);
    memset(object, 0, bytes);
    luaL_setmetatable(L, c->name);
    return object;
}

void *class_push_of(lua_State *L, const lua_class *c, size_t bytes, int parent_index)
{
    parent_index = lua_absindex(L, parent_index);
    void *object = class_push(L, c, bytes);
    lua_pushvalue(L, parent_index);
    lua_setiuservalue(L, -2, 1);
    return object;
}

void *class_check(lua_State *L, int index, const lua_class *c)
{
    lua_handle *handle = luaL_checkudata(L, index, c->name);
    if (!handle->object)
        luaL_argerror(L, index, lua_pushfstring(L, "the %s is closed", c->noun));
    return handle;
}

void *class_object(lua_State *L, int index, const lua_class *c)
{
    return ((lua_handle *)class_check(L, index, c))->object;
}

const char *text_check(lua_State *L, int index)
{
    size_t n = 0;
    const char *chars = luaL_checklstring(L, index, &n);
    luaL_argcheck(L, strlen(chars) == n, index, "a string without NUL");
    return chars;
}

const char *text_option(lua_State *L, int index)
{
    return lua_isnoneornil(L, index) ? NULL : text_check(L, index);
}

void class_check_limits(lua_State *L)
{
    duet_error why = {0};
    if (!budget_check(&why))
        luaL_error(L, "%s", why.text);
}

// If a call was refused because the script's time is over, the script ends.
int class_push_failure(lua_State *L, const duet_error *err)
{
    class_check_limits(L);
    lua_pushnil(L);
    lua_pushstring(L, err->text);
    lua_pushstring(L, duet_status_name(err->status));
    return 3;
}

int class_push_done(lua_State *L, bool ok, const duet_error *err)
{
    if (!ok)
        return class_push_failure(L, err);
    lua_pushboolean(L, true);
    return 1;
}
