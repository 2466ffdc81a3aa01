// SPDX-License-Identifier: MIT
#include "lua/array.h"

#include "base/budget.h"
#include "lua/class.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

// A row is a C struct; columns has a letter for each of its fields in order:
// f float, d double, i int32_t, I uint32_t, Q uint64_t, h int16_t, C uint8_t, B bool.
typedef struct kind_info {
    lua_class class;
    const char *columns;
    size_t bytes;
    size_t least; // columns that a row may end after; 0: it has all
} kind_info;

static const kind_info kinds[ARRAY_KINDS];

static int width_of(const array *a)
{
    return (int)strlen(kinds[a->kind].columns);
}

static void *row_at(const array *a, uint64_t i)
{
    return (char *)a->rows + i * kinds[a->kind].bytes;
}

static size_t bytes_of(char letter)
{
    return strchr("dQ", letter)   ? sizeof(double)
           : letter == 'h'        ? sizeof(int16_t)
           : strchr("CB", letter) ? sizeof(bool)
                                  : sizeof(float);
}

// A member begins at a multiple of its size.
static void *column_at(const array *a, uint64_t i, int column)
{
    const char *columns = kinds[a->kind].columns;
    size_t at = 0;
    for (int k = 0; k <= column; ++k) {
        size_t bytes = bytes_of(columns[k]);
        at = (at + bytes - 1) / bytes * bytes + bytes;
    }
    return (char *)row_at(a, i) + at - bytes_of(columns[column]);
}

// ---------------------------------------------------------------- making

array *array_push_empty(lua_State *L, array_kind kind)
{
    array *a = class_push(L, &kinds[kind].class, sizeof *a);
    a->kind = kind;
    return a;
}

array *array_push(lua_State *L, array_kind kind, uint64_t n)
{
    uint64_t most = (SIZE_MAX / 2 - sizeof(array)) / kinds[kind].bytes;
    if (n > most)
        luaL_error(L, "%s of %I rows: too many", kinds[kind].class.name, (LUAI_UACINT)n);
    array *a = class_push(L, &kinds[kind].class, sizeof *a + n * kinds[kind].bytes);
    a->kind = kind;
    a->rows = a + 1;
    a->n = n;
    return a;
}

void array_push_copy(lua_State *L, array_kind kind, const void *rows, uint64_t n)
{
    array *a = array_push(L, kind, n);
    if (n > 0)
        memcpy(a->rows, rows, n * kinds[kind].bytes);
}

void array_own(array *a, void *rows, uint64_t n)
{
    a->rows = rows;
    a->n = n;
    a->access = ARRAY_OWNED;
    budget_hold(n * kinds[a->kind].bytes);
}

void array_push_view(lua_State *L, array_kind kind, array_access access, void *rows, uint64_t n,
                     const uint64_t *epoch)
{
    array *a = class_push_of(L, &kinds[kind].class, sizeof *a, 1);
    *a = (array){kind, access, rows, n, epoch, *epoch};
}

// Raises an error about the value on top of the stack.
static void refuse_value(lua_State *L, const array *a, uint64_t i, int column, const char *wanted)
{
    luaL_error(L, "%s: row %I, column %d: %s, not %s", kinds[a->kind].class.name, (LUAI_UACINT)i,
               column + 1, field_push_shown(L, -1), wanted);
}

static lua_Integer take_whole(lua_State *L, const array *a, uint64_t i, int column,
                              lua_Integer least, lua_Integer most, const char *wanted)
{
    int is_whole = 0;
    lua_Integer value = lua_tointegerx(L, -1, &is_whole);
    if (!is_whole || value < least || value > most)
        refuse_value(L, a, i, column, wanted);
    return value;
}

static lua_Number take_number(lua_State *L, const array *a, uint64_t i, int column)
{
    int is_number = 0;
    lua_Number value = lua_tonumberx(L, -1, &is_number);
    if (!is_number)
        refuse_value(L, a, i, column, "a number");
    return value;
}

// Columns of whole numbers: the letter, its type, and what a value must be.
#define WHOLE_COLUMNS(X)                                                         \
    X('i', int32_t, INT32_MIN, INT32_MAX, "a whole number of 32 bits")           \
    X('I', uint32_t, 0, UINT32_MAX, "a whole number from 0 to 2^32 - 1")         \
    X('h', int16_t, INT16_MIN, INT16_MAX, "a whole number from -32768 to 32767") \
    X('Q', uint64_t, LUA_MININTEGER, LUA_MAXINTEGER, "a whole number")           \
    X('C', uint8_t, 0, UINT8_MAX, "a whole number from 0 to 255")

// Writes the value on top of the stack into a row's column, and pops it.
static void take_column(lua_State *L, const array *a, uint64_t i, int column)
{
    void *to = column_at(a, i, column);
    switch (kinds[a->kind].columns[column]) {
#define TAKE(letter, type, least, most, wanted)                               \
    case letter:                                                              \
        *(type *)to = (type)take_whole(L, a, i, column, least, most, wanted); \
        break;
        WHOLE_COLUMNS(TAKE)
    case 'B':
        if (!lua_isboolean(L, -1))
            refuse_value(L, a, i, column, "true or false");
        *(bool *)to = lua_toboolean(L, -1);
        break;
    case 'd':
        *(double *)to = take_number(L, a, i, column);
        break;
    default:
        *(float *)to = (float)take_number(L, a, i, column);
    }
    lua_pop(L, 1);
}

// Refuses a row of another width. Columns that it may leave out are 0.
static void begin_row(lua_State *L, const array *a, uint64_t i, lua_Unsigned given)
{
    int width = width_of(a);
    size_t least = kinds[a->kind].least ? kinds[a->kind].least : (size_t)width;
    if (given < least || given > (lua_Unsigned)width)
        luaL_error(L, "%s: row %I: %I numbers, and a row has %d", kinds[a->kind].class.name,
                   (LUAI_UACINT)i, (LUAI_UACINT)given, width);
    if (given < (lua_Unsigned)width)
        memset(row_at(a, i), 0, kinds[a->kind].bytes);
}

static void read_row(lua_State *L, int index, const array *a, uint64_t i)
{
    lua_Unsigned given = lua_istable(L, index) ? lua_rawlen(L, index) : 0;
    begin_row(L, a, i, given);
    for (int column = 0; column < (int)given; ++column) {
        lua_rawgeti(L, index, column + 1);
        take_column(L, a, i, column);
    }
}

static void push_from_rows(lua_State *L, int index, array_kind kind)
{
    lua_Unsigned n = lua_rawlen(L, index);
    array *a = array_push(L, kind, n);
    for (lua_Unsigned i = 0; i < n; ++i) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        read_row(L, lua_gettop(L), a, i);
        lua_pop(L, 1);
    }
}

static void push_from_numbers(lua_State *L, int index, array_kind kind)
{
    lua_Unsigned numbers = lua_rawlen(L, index);
    lua_Unsigned width = strlen(kinds[kind].columns);
    if (numbers % width != 0)
        luaL_error(L, "%s from %I numbers: a row has %d", kinds[kind].class.name,
                   (LUAI_UACINT)numbers, (int)width);
    array *a = array_push(L, kind, numbers / width);
    for (lua_Unsigned i = 0; i < numbers; ++i) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        take_column(L, a, i / width, (int)(i % width));
    }
}

static void push_from_bytes(lua_State *L, int index, array_kind kind)
{
    size_t length = 0;
    const char *bytes = lua_tolstring(L, index, &length);
    size_t width = kinds[kind].bytes;
    if (length % width != 0)
        luaL_error(L, "%s from %I bytes: a row has %d", kinds[kind].class.name, (LUAI_UACINT)length,
                   (int)width);
    array *a = array_push(L, kind, length / width);
    memcpy(a->rows, bytes, length);
    for (uint64_t i = 0; kind == ARRAY_BODIES && i < a->n; ++i)
        for (int column = 12; column < 14; ++column) { // any other byte is no bool
            unsigned char *flag = column_at(a, i, column);
            *flag = *flag != 0;
        }
}

static void push_from_value(lua_State *L, int index, array_kind kind)
{
    if (lua_type(L, index) == LUA_TSTRING) {
        push_from_bytes(L, index, kind);
        return;
    }
    luaL_checktype(L, index, LUA_TTABLE);
    bool by_row = lua_rawgeti(L, index, 1) == LUA_TTABLE;
    lua_pop(L, 1);
    if (by_row)
        push_from_rows(L, index, kind);
    else
        push_from_numbers(L, index, kind);
}

// n rows: boxes without size and transforms at the origin, not turned; bodies at
// rest.
static void push_blank(lua_State *L, array_kind kind, lua_Integer n)
{
    luaL_argcheck(L, n >= 0, 1, "a count from 0");
    array *a = array_push(L, kind, (uint64_t)n);
    for (uint64_t i = 0; kind == ARRAY_POSES && i < a->n; ++i)
        ((duet_pose *)a->rows)[i].rotation[3] = 1;
    for (uint64_t i = 0; kind == ARRAY_LARGE_POSES && i < a->n; ++i)
        ((duet_large_pose *)a->rows)[i].pose.rotation[3] = 1;
    for (uint64_t i = 0; kind == ARRAY_TRANSFORMS && i < a->n; ++i)
        ((duet_transform *)a->rows)[i].rotation[3] = 1;
    for (uint64_t i = 0; kind == ARRAY_COMPACT_TRANSFORMS && i < a->n; ++i)
        ((duet_compact_transform *)a->rows)[i].rotation[3] = 1;
    for (uint64_t i = 0; kind == ARRAY_BODIES && i < a->n; ++i)
        ((duet_body *)a->rows)[i] = duet_default_body();
}

// duet.poses(n), (rows), (numbers), (bytes); the upvalue is the kind.
static int make(lua_State *L)
{
    array_kind kind = (array_kind)lua_tointeger(L, lua_upvalueindex(1));
    class_check_limits(L);
    if (lua_type(L, 1) == LUA_TNUMBER)
        push_blank(L, kind, luaL_checkinteger(L, 1));
    else
        push_from_value(L, 1, kind);
    return 1;
}

// ---------------------------------------------------------------- reading

array *array_test(lua_State *L)
{
    for (int kind = 0; kind < ARRAY_KINDS; ++kind) {
        array *a = luaL_testudata(L, 1, kinds[kind].class.name);
        if (a)
            return a;
    }
    return NULL;
}

static void check_alive(lua_State *L, int index, const array *a)
{
    luaL_argcheck(L, a->rows || a->n == 0, index, "the array is closed");
    luaL_argcheck(L, !a->epoch || *a->epoch == a->epoch_made, index,
                  "the view is of memory that its owner has given back");
}

static array *check_self(lua_State *L)
{
    array *a = array_test(L);
    if (!a)
        luaL_typeerror(L, 1, "duet.poses or another array");
    check_alive(L, 1, a);
    return a;
}

const array *array_check(lua_State *L, int index, array_kind kind)
{
    index = lua_absindex(L, index);
    if (!lua_isuserdata(L, index)) {
        push_from_value(L, index, kind);
        lua_replace(L, index);
    }
    const array *a = luaL_checkudata(L, index, kinds[kind].class.name);
    check_alive(L, index, a);
    return a;
}

static uint64_t check_place(lua_State *L, int index, const array *a)
{
    lua_Integer i = luaL_checkinteger(L, index);
    if (i < 0 || (uint64_t)i >= a->n)
        luaL_argerror(L, index,
                      lua_pushfstring(L, "place %I of %I rows, counted from 0", (LUAI_UACINT)i,
                                      (LUAI_UACINT)a->n));
    return (uint64_t)i;
}

static void push_column(lua_State *L, const array *a, uint64_t i, int column)
{
    const void *at = column_at(a, i, column);
    switch (kinds[a->kind].columns[column]) {
#define PUSH(letter, type, least, most, wanted)               \
    case letter:                                              \
        lua_pushinteger(L, (lua_Integer) * (const type *)at); \
        break;
        WHOLE_COLUMNS(PUSH)
    case 'B':
        lua_pushboolean(L, *(const bool *)at);
        break;
    case 'd':
        lua_pushnumber(L, *(const double *)at);
        break;
    default:
        lua_pushnumber(L, *(const float *)at);
    }
}

static int push_row(lua_State *L, const array *a, uint64_t i)
{
    int width = width_of(a);
    luaL_checkstack(L, width, "no space for a row");
    for (int column = 0; column < width; ++column)
        push_column(L, a, i, column);
    return width;
}

static int array_get(lua_State *L)
{
    const array *a = check_self(L);
    return push_row(L, a, check_place(L, 2, a));
}

static int array_set(lua_State *L)
{
    const array *a = check_self(L);
    uint64_t i = check_place(L, 2, a);
    int given = lua_gettop(L) - 2;
    luaL_argcheck(L, a->access != ARRAY_FIXED, 1, "these rows cannot be changed");
    begin_row(L, a, i, given > 0 ? (lua_Unsigned)given : 0);
    for (int column = 0; column < given; ++column) {
        lua_pushvalue(L, 3 + column);
        take_column(L, a, i, column);
    }
    return 0;
}

// The next place and its row; upvalues: the array, the place.
static int next_row(lua_State *L)
{
    const array *a = lua_touserdata(L, lua_upvalueindex(1));
    lua_Integer i = lua_tointeger(L, lua_upvalueindex(2));
    check_alive(L, 1, a);
    if ((uint64_t)i >= a->n)
        return 0;
    lua_pushinteger(L, i + 1);
    lua_replace(L, lua_upvalueindex(2));
    lua_pushinteger(L, i);
    return 1 + push_row(L, a, (uint64_t)i);
}

static int array_each(lua_State *L)
{
    check_self(L);
    lua_pushvalue(L, 1);
    lua_pushinteger(L, 0);
    lua_pushcclosure(L, next_row, 2);
    return 1;
}

static int array_bytes(lua_State *L)
{
    const array *a = check_self(L);
    class_check_limits(L);
    lua_pushlstring(L, a->rows ? a->rows : "", a->n * kinds[a->kind].bytes);
    return 1;
}

static int array_length(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)check_self(L)->n);
    return 1;
}

duet_object_kind array_object_kind(array_kind kind)
{
    static const duet_object_kind objects[] = {
        [ARRAY_POSES] = DUET_OBJECT_POSES,
        [ARRAY_BOUNDS] = DUET_OBJECT_BOUNDS,
        [ARRAY_TRANSFORMS] = DUET_OBJECT_TRANSFORMS,
        [ARRAY_COMPACT_TRANSFORMS] = DUET_OBJECT_COMPACT_TRANSFORMS,
        [ARRAY_SIZES] = DUET_OBJECT_SIZES,
        [ARRAY_ROUNDED_BOXES] = DUET_OBJECT_ROUNDED_BOXES,
        [ARRAY_SPHERES] = DUET_OBJECT_SPHERES,
        [ARRAY_LARGE_POSES] = DUET_OBJECT_LARGE_POSES,
    };
    return objects[kind];
}

void array_push_hash(lua_State *L, uint64_t hash)
{
    char digits[24];
    snprintf(digits, sizeof digits, "%016" PRIx64, hash);
    lua_pushstring(L, digits);
}

static int array_tostring(lua_State *L)
{
    const array *a = check_self(L);
    lua_pushfstring(L, "%s of %I rows", kinds[a->kind].class.name, (LUAI_UACINT)a->n);
    return 1;
}

static int pairs_hash(lua_State *L)
{
    const array *a = array_check(L, 1, ARRAY_PAIRS);
    class_check_limits(L);
    array_push_hash(L, duet_pairs_hash(a->rows, a->n));
    return 1;
}

// (rows, a, b, dims) of the calling method -> two rows and the dimensions
static uint32_t check_two(lua_State *L, array_kind kind, const void *rows[2])
{
    const array *a = array_check(L, 1, kind);
    rows[0] = row_at(a, check_place(L, 2, a));
    rows[1] = row_at(a, check_place(L, 3, a));
    lua_Integer dims = luaL_optinteger(L, 4, 3);
    luaL_argcheck(L, dims == 2 || dims == 3, 4, "2 or 3 dimensions");
    return (uint32_t)dims;
}

// poses:collide(a, b, dims), and of rounded boxes; the upvalue is the kind of rows.
static int collide(lua_State *L)
{
    const void *rows[2];
    array_kind kind = (array_kind)lua_tointeger(L, lua_upvalueindex(1));
    uint32_t dims = check_two(L, kind, rows);
    lua_pushboolean(L, kind == ARRAY_POSES ? duet_poses_collide(rows[0], rows[1], dims)
                                           : duet_rounded_boxes_collide(rows[0], rows[1], dims));
    return 1;
}

static int separation(lua_State *L)
{
    const void *rows[2];
    array_kind kind = (array_kind)lua_tointeger(L, lua_upvalueindex(1));
    uint32_t dims = check_two(L, kind, rows);
    lua_pushnumber(L, kind == ARRAY_POSES ? duet_poses_separation(rows[0], rows[1], dims)
                                          : duet_rounded_boxes_separation(rows[0], rows[1], dims));
    return 1;
}

static int array_close(lua_State *L)
{
    array *a = array_test(L);
    if (!a)
        return luaL_typeerror(L, 1, "duet.poses or another array");
    if (a->access == ARRAY_OWNED) {
        budget_release(a->n * kinds[a->kind].bytes);
        duet_free(a->rows);
    }
    a->access = ARRAY_FIXED;
    if (a->n > 0)
        a->rows = NULL;
    return 0;
}

// Methods of all arrays.
static const lua_method methods[] = {{"get", array_get, 0},
                                     {"set", array_set, 0},
                                     {"each", array_each, 0},
                                     {"bytes", array_bytes, 0},
                                     {"close", array_close, 0},
                                     {"__len", array_length, 0},
                                     {"__tostring", array_tostring, 0},
                                     {0}};

static const lua_noun array_noun = {
    {NULL},
    (const lua_method[]){{"duet.poses:collide", collide, ARRAY_POSES},
                         {"duet.poses:separation", separation, ARRAY_POSES},
                         {"duet.rounded_boxes:collide", collide, ARRAY_ROUNDED_BOXES},
                         {"duet.rounded_boxes:separation", separation, ARRAY_ROUNDED_BOXES},
                         {"duet.pairs:hash", pairs_hash, 0},
                         {0}}};

#define KIND_INFO(kind, name_, columns, bytes, least) \
    {{.name = "duet." #name_}, columns, bytes, least},
static const kind_info kinds[] = {ARRAY_LIST(KIND_INFO)};

void array_open(lua_State *L)
{
    for (int kind = 0; kind < ARRAY_KINDS; ++kind) {
        const char *name = kinds[kind].class.name;
        class_open(L, &kinds[kind].class);
        for (const lua_method *m = methods; m->name; ++m)
            class_add(L, name, m);
        lua_pushinteger(L, kind);
        lua_pushcclosure(L, make, 1);
        lua_setfield(L, -2, name + sizeof "duet." - 1);
    }
    class_open_noun(L, &array_noun);
}
