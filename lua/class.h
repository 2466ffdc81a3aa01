// SPDX-License-Identifier: MIT
// A kind of userdata: methods, fields that read like a table's, and how it is
// closed. A closed one answers no method but close, which may come again.
#ifndef LUA_CLASS_H
#define LUA_CLASS_H

#include "gen/field.h"

#include "duet_error.h"

#include <lauxlib.h>
#include <lua.h>
#include <stdbool.h>

// A function of the module, "duet.scene", or a method of a class, "duet.scene:poses". One whose
// name begins with __ is the metatable's; "close" is __gc and __close too.
typedef struct lua_method {
    const char *name;
    lua_CFunction call;
    lua_Integer which; // its first upvalue, for several that share a C function
} lua_method;

// Methods whose C functions have the names of class and method: METHODS(world, step) is
// "duet.world:step" by world_step.
#define METHODS(class, ...) EACH(METHOD_OF, class, , __VA_ARGS__)
#define METHOD_OF(class, none, method)                  \
    {                                                   \
        "duet." #class ":" #method, class##_##method, 0 \
    }

typedef struct lua_class {
    const char *name;                       // "duet.scene"
    const field *fields;                    // NULL: none
    const void *(*struct_of)(lua_State *L); // the struct of the userdata at 1; raises if closed
    lua_CFunction about;           // without fields: pushes what it is in words; raises if closed
    void (*destroy)(void *object); // "close", if the userdata begins with a handle
    const char *noun;              // the name of that: "tree"
} lua_class;

// Adds what one file has to the module.
typedef struct lua_noun {
    const lua_class *classes[5]; // up to NULL
    const lua_method *methods;   // of any class that is open; ends with {0}
} lua_noun;

// Defines the destroy of a class of such objects.
#define CLASS_DESTROY(type)                  \
    static void destroy_##type(void *object) \
    {                                        \
        duet_##type##_destroy(object);       \
    }

// The object of such a userdata. NULL: it is closed.
typedef struct lua_handle {
    void *object;
} lua_handle;

// Makes the metatable, once a state.
void class_open(lua_State *L, const lua_class *c);

// Adds a method to an open class; its name is without the class's.
void class_add(lua_State *L, const char *class, const lua_method *m);

// Opens a noun's classes, and adds its methods to these and others, its functions to the module at
// -1.
void class_open_noun(lua_State *L, const lua_noun *noun);

// A Lua function: of an object of ours its class's name, then the names of its fields
// in order and those of its methods, as two lists; of anything else nothing.
int class_names(lua_State *L);

// Pushes a zeroed userdata with space for one uservalue: its parent.
void *class_push(lua_State *L, const lua_class *c, size_t bytes);

// The same, and the parent is the value at that index.
void *class_push_of(lua_State *L, const lua_class *c, size_t bytes, int parent_index);

// The userdata of such a class at an index, or the object of its handle. Both raise an error if
// it is closed.
void *class_check(lua_State *L, int index, const lua_class *c);
void *class_object(lua_State *L, int index, const lua_class *c);

// The string argument at the index, which has no NUL: C would see it cut. text_option gives NULL
// for nil and none.
const char *text_check(lua_State *L, int index);
const char *text_option(lua_State *L, int index);

// nil, message, "STATUS": what a failed call gives back.
int class_push_failure(lua_State *L, const duet_error *err);
// Raises an error if the running script's time is over or it was told to
// stop: for functions that work long.
void class_check_limits(lua_State *L);

// true, or the failure.
int class_push_done(lua_State *L, bool ok, const duet_error *err);

#endif
