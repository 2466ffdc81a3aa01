// SPDX-License-Identifier: MIT
// The members of a C struct, as a table of rows: from it a Lua table is read
// into the struct, and the struct told to Lua.
#ifndef LUA_MEMBER_H
#define LUA_MEMBER_H

#include "lua/each.h"
#include "runtime/duet.h"

#include <lua.h>
#include <stddef.h>
#include <stdint.h>

typedef struct member member;

// read takes the value on top of the stack, or raises an error; push pushes
// one. Either may be missing where the other is all that is used.
typedef struct member_type {
    void (*read)(lua_State *L, const member *m, void *at);
    void (*push)(lua_State *L, const member *m, const void *at);
    const member *members; // a struct's
    const char *what;      // its name in messages: "a plan"
} member_type;

struct member {
    const char *name;
    const member_type *type;
    size_t offset;
    size_t size;                       // offset of the member
    const char *(*name_of)(int value); // names of an enum: NULL past the last
};

// Rows of a table of members, which ends with {0}: several whose types say how they are read, of a
// struct or of one that lies in it at `path`, which ends with a point; and one of another type.
#define MEMBERS(struct_, ...) EACH(MEMBER_OF, struct_, , __VA_ARGS__)
#define MEMBERS_IN(struct_, path, ...) EACH(MEMBER_OF, struct_, path, __VA_ARGS__)
#define MEMBER_OF(struct_, path, member) \
    MEMBER_AT(#member, MEMBER_TYPE(((struct_ *)0)->path member), struct_, path member, NULL)
#define MEMBER(type, struct_, member) MEMBER_AT(#member, type, struct_, member, NULL)
#define MEMBER_ENUM(struct_, member, name_of) \
    MEMBER_AT(#member, member_enum, struct_, member, name_of)
#define MEMBER_AT(name_, type_, struct_, path, name_of_)                      \
    {                                                                         \
        .name = (name_), .type = &(type_), .offset = offsetof(struct_, path), \
        .size = sizeof((struct_ *)0)->path, .name_of = (name_of_)             \
    }

// The same without a name: a whole table, for a call.
#define MEMBERS_OF(struct_, ...) ((const member[]){MEMBERS(struct_, __VA_ARGS__), {0}})

// clang-format off
#define MEMBER_TYPE(value) *_Generic((value),                                                      \
    const char *: &member_string, char *: &member_chars, bool: &member_bool,                       \
    uint32_t: &member_count, uint64_t: &member_count, int32_t: &member_int, int64_t: &member_int,  \
    float: &member_float, float *: &member_float, double: &member_double, double *: &member_double,\
    uint32_t *: &member_counts, uint64_t *: &member_sizes,                                         \
    duet_plan: &member_plan, duet_accuracy: &member_accuracy)
// clang-format on

extern const member_type member_string; // const char *; the table's, so only read by a call
extern const member_type member_chars;  // char[size]
extern const member_type member_bool;   // bool
extern const member_type member_count;  // uint32_t or uint64_t
extern const member_type member_int;    // int32_t or int64_t
extern const member_type member_float;  // float, or several: { x, y, z }
extern const member_type member_double; // double, or several
extern const member_type member_counts; // several uint32_t
extern const member_type member_sizes;  // several uint64_t
extern const member_type member_share;  // uint32_t out of DUET_SHARE_ONE, as 0 to 1
extern const member_type member_enum;   // an enum, by its name
extern const member_type member_plan;   // a duet_plan as a table
extern const member_type member_accuracy;

// read and push of a type that is a struct: a table. Members that it leaves out stay as they are.
void member_read_struct(lua_State *L, const member *m, void *at);
void member_push_struct(lua_State *L, const member *m, const void *at);

// Copies the table at index into the struct; nil or none leaves it as it is. A
// key that is no field is an error that lists the fields, so that a misspelt
// name is not passed over in silence. `what` is what messages call the table.
void member_read_table(lua_State *L, int index, const char *what, const member *members, void *to);

// Pushes a table with all fields of the struct.
void member_push_table(lua_State *L, const member *members, const void *from);

// Pushes a list of such tables, of n structs of `size` bytes.
void member_push_list(lua_State *L, const member *members, const void *from, uint64_t n,
                      size_t size);

// NULL if there is none of that name.
const member *member_find(const member *members, const char *name);
void member_push(lua_State *L, const member *m, const void *from);

// Pushes what a message calls the value at index: a number or text as it is,
// others by their type, since an address would be another one on each run.
const char *member_push_shown(lua_State *L, int index);

// Read functions refuse by it: "field 'n': a string, not a whole number".
int member_refuse(lua_State *L, const member *m, const char *wanted);

#endif
