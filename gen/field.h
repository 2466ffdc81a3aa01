// SPDX-License-Identifier: MIT
// The fields of a C struct, as a table of rows: by it a Lua table is read into the struct, and the
// struct told to Lua.
#ifndef GEN_FIELD_H
#define GEN_FIELD_H

#include "gen/each.h"
#include "gen/field_line.h"

#include <lua.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct field field;

// read takes the value on top of the stack, or raises an error; push pushes
// one. Either may be missing if the other is all that is used.
typedef struct field_type {
    void (*read)(lua_State *L, const field *f, void *at);
    void (*push)(lua_State *L, const field *f, const void *at);
    const field *fields; // a struct's
    const char *what;    // its name in messages: "a plan"
} field_type;

// A table in another, in messages: "workload 3", or "args.x" if row is negative.
typedef struct field_table {
    const char *name;
    lua_Integer row;
    const char *list; // the field whose rows such tables are, "workloads"; NULL: none
} field_table;

struct field {
    const char *name; // "[1]": the table's first element
    const field_type *type;
    size_t offset;
    size_t size;                       // offset of the member
    const char *(*name_of)(int value); // names of an enum: NULL past the last
    double least, most;                // of numbers; both 0: any
    const char *expected;              // in messages; NULL: as the type says
    const field_table *table;          // set while it is read; NULL: none
};

// A list of names in a table, kept alive by it; { "auto", "paper" }.
enum { FIELD_NAMES = 32 };
typedef struct field_name_list {
    const char *names[FIELD_NAMES];
    uint32_t n;
} field_name_list;

// Values of an enum, by a list of their names or by one name.
typedef struct field_enum_list {
    int values[FIELD_NAMES];
    uint32_t n;
} field_enum_list;

// Rows of a table of fields, which ends with {0}: several whose types say how they are read, of a
// struct or of one that lies in it at `path`, which ends with a point; and one of another type.
#define FIELDS(struct_, ...) EACH(FIELD_OF, struct_, , __VA_ARGS__)
#define FIELDS_IN(struct_, path, ...) EACH(FIELD_OF, struct_, path, __VA_ARGS__)
#define FIELD_OF(struct_, path, member) \
    FIELD_AT(#member, FIELD_TYPE(((struct_ *)0)->path member), struct_, path member)
#define FIELD(type, struct_, member) FIELD_AT(#member, type, struct_, member)
#define FIELD_IN(type, struct_, path, member) FIELD_AT(#member, type, struct_, path member)
#define FIELD_ENUM(struct_, member, name_of) FIELD_ENUM_AT(#member, struct_, member, name_of)
#define FIELD_ENUMS(struct_, path, name_of) FIELD_ENUMS_AT(#path, struct_, path, name_of)
#define FIELD_AT(name, type, struct_, path)  \
    {                                        \
        FIELD_ROW(name, type, struct_, path) \
    }
#define FIELD_ENUM_AT(name, struct_, path, name_of_)                      \
    {                                                                     \
        FIELD_ROW(name, field_enum, struct_, path), .name_of = (name_of_) \
    }
#define FIELD_ENUMS_AT(name, struct_, path, name_of_)                      \
    {                                                                      \
        FIELD_ROW(name, field_enums, struct_, path), .name_of = (name_of_) \
    }

// Rows with a range: finite numbers from 0 on, and any from least to most.
#define FIELDS_FROM_0(struct_, path, ...) EACH(FIELD_FROM_0, struct_, path, __VA_ARGS__)
#define FIELD_FROM_0(struct_, path, member) \
    FIELD_WITHIN(struct_, path, member, 0, FLT_MAX, "a finite number from 0")
#define FIELDS_FINITE(struct_, path, ...) EACH(FIELD_FINITE, struct_, path, __VA_ARGS__)
#define FIELD_FINITE(struct_, path, member) \
    FIELD_WITHIN(struct_, path, member, -FLT_MAX, FLT_MAX, NULL)
#define FIELD_WITHIN(struct_, path, member, least_, most_, expected_)                      \
    {                                                                                      \
        FIELD_ROW(#member, FIELD_TYPE(((struct_ *)0)->path member), struct_, path member), \
            .least = (least_), .most = (most_), .expected = (expected_)                    \
    }
#define FIELD_ROW(name_, type_, struct_, path)                            \
    .name = (name_), .type = &(type_), .offset = offsetof(struct_, path), \
    .size = sizeof((struct_ *)0)->path

// The same without a name: a whole table, for a call.
#define FIELD_LIST(struct_, ...) ((const field[]){FIELDS(struct_, __VA_ARGS__), {0}})

// clang-format off
#define FIELD_TYPE(value) *_Generic((value),                                                  \
    const char *: &field_string, char *: &field_chars, bool: &field_bool,                      \
    uint32_t: &field_count, uint64_t: &field_count, int32_t: &field_int, int64_t: &field_int,  \
    float: &field_float, float *: &field_float, double: &field_double, double *: &field_double,\
    uint32_t *: &field_counts, uint64_t *: &field_sizes, field_name_list: &field_names)
// clang-format on

extern const field_type field_string;   // const char *; the table's, so only read by a call
extern const field_type field_chars;    // char[size]
extern const field_type field_bool;     // bool
extern const field_type field_count;    // uint32_t or uint64_t
extern const field_type field_int;      // int32_t or int64_t
extern const field_type field_float;    // float, or several: { x, y, z }
extern const field_type field_double;   // double, or several
extern const field_type field_counts;   // several uint32_t
extern const field_type field_sizes;    // several uint64_t
extern const field_type field_enum;     // an enum, by its name
extern const field_type field_enums;    // a field_enum_list
extern const field_type field_names;    // a field_name_list
extern const field_type field_function; // bool: that there is one
extern const field_type field_unread;   // anything: the caller reads it

// read and push of a type that is a struct: a table. Fields that it leaves out stay as they are.
void field_read_struct(lua_State *L, const field *f, void *at);
void field_push_struct(lua_State *L, const field *f, const void *at);

// Copies the table at index into the struct, in the order of the rows; nil or none leaves it as it
// is, and so does a field that is left out. A key that is no field is an error that lists the
// fields, so that a misspelt name is not passed over in silence. `what` is what messages call the
// table. Metatables are not asked. Returns which rows, 64 at most, the table has: bit i for row i.
uint64_t field_read(lua_State *L, int index, const char *what, const field *fields, void *to);

// The same of a table that is a value or a row in another; each of its messages names which, and
// what is no table is an error, too.
uint64_t field_read_row(lua_State *L, int index, field_table table, const field *fields, void *to);

// Reads the one field from the table at index, if it has it; returns whether.
bool field_read_one(lua_State *L, int index, const field *f, void *to);

// Pushes a table with all fields of the struct.
void field_push_table(lua_State *L, const field *fields, const void *from);

// Pushes a list of such tables, of n structs of `size` bytes.
void field_push_list(lua_State *L, const field *fields, const void *from, uint64_t n, size_t size);

// NULL if there is none of that name.
const field *field_named(const field *fields, const char *name);

// Whether the rows that field_read returned have that of the name.
bool field_is_given(const field *fields, uint64_t given, const char *name);
void field_push(lua_State *L, const field *f, const void *from);

// Returns the string at index; NULL if there is none, or one with a NUL, behind which C sees
// nothing.
const char *field_text(lua_State *L, int index);

// Pushes nil, a boolean, a number or a string as text. luaL_tolstring would ask metatables, which
// could change the table that is read.
void field_push_raw(lua_State *L, int index);

// Pushes what a message calls the value at index: a number as it is, a text up to its hundredth
// byte, others by their type, since an address would be another one on each run.
const char *field_push_shown(lua_State *L, int index);

// Pushes "a, b, c", the names of an enum.
const char *field_push_names(lua_State *L, const char *(*name_of)(int value));

// Read functions refuse the value on top by it: "n is 'x'; expected a whole number".
int field_refuse(lua_State *L, const field *f, const char *expected);

// Raises "file:line: workload 3: message" about a field of the table; NULL: of the table that the
// script returned. The line is that of the name in the table, or else that of the table.
int field_raise_in(lua_State *L, const field_table *table, const char *name, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

#endif
