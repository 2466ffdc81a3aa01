// SPDX-License-Identifier: MIT
#include "gen/signature.h"
#include "base/error.h"
#include "base/list.h"
#include "gen/field_line.h"
#include "gen/script.h"

#include <lauxlib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- types

static const struct {
    const char *name;
    uint32_t bytes; // in float, for a real
} value_types[] = {
    {"uint", 4},   {"int", 4},    {"float", 4},   {"float2", 8}, {"uint2", 8},
    {"int4", 16},  {"uint4", 16}, {"float4", 16}, {"real", 4},   {"real2", 8},
    {"real4", 16}, {"long", 8},   {"ulong", 8},   {"double", 8},
};

static bool is_real(const char *type)
{
    return strncmp(type, "real", 4) == 0;
}

// The bytes of a value of the type; 0 if none is passed as a value.
static uint32_t value_bytes(const char *type, bool doubles)
{
    for (size_t i = 0; i < sizeof value_types / sizeof value_types[0]; ++i)
        if (strcmp(value_types[i].name, type) == 0)
            return value_types[i].bytes * (doubles && is_real(type) ? 2 : 1);
    return 0;
}

// ---------------------------------------------------------------- reading

static bool is_name(const char *word)
{
    size_t length = strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
    return length > 0 && length < GEN_NAME && !word[length] && !(*word >= '0' && *word <= '9');
}

static void refuse(lua_State *L, const signature *s, const char *line)
{
    field_raise(L, s->entry,
                "%s: '%s' is no argument; expected [volatile] [const | constant] "
                "TYPE [*]NAME [[only] if CONDITION]",
                s->entry, line);
}

// Leaves "return CONDITION" as a function in the registry.
static int read_condition(lua_State *L, const signature *s, const char *condition)
{
    const char *chunk = lua_pushfstring(L, "return %s", condition);
    if (luaL_loadbufferx(L, chunk, strlen(chunk), s->entry, "t") != LUA_OK)
        field_raise(L, s->entry, "%s: 'if %s' is no condition", s->entry, condition);
    int ref = luaL_ref(L, LUA_REGISTRYINDEX);
    lua_pop(L, 1);
    return ref;
}

// Whether the word is the qualifier; then the line goes on behind it.
static bool take_word(char **line, const char *word)
{
    size_t length = strlen(word);
    if (strncmp(*line, word, length) != 0 || (*line)[length] != ' ')
        return false;
    *line += length + strspn(*line + length, " ");
    return true;
}

static void cut_blanks(char *line)
{
    for (char *end = line + strlen(line); end > line && end[-1] == ' '; --end)
        end[-1] = '\0';
}

// Whether the word ends the line; then the line ends before it.
static bool take_last_word(char *line, const char *word)
{
    size_t length = strlen(line), taken = strlen(word);
    if (length <= taken || line[length - taken - 1] != ' ' ||
        strcmp(line + length - taken, word) != 0)
        return false;
    line[length - taken] = '\0';
    cut_blanks(line);
    return true;
}

// "real4 *rotations" in `line`, which is cut up.
static bool read_declaration(char *line, signature_arg *a)
{
    a->arg.is_volatile = take_word(&line, "volatile");
    bool is_constant = take_word(&line, "constant"), is_const = take_word(&line, "const");
    a->arg.memory = is_constant ? GEN_CONSTANT : is_const ? GEN_READ : GEN_WRITTEN;
    char *name = strchr(line, ' ');
    if (!name)
        return false;
    *name++ = '\0';
    bool is_buffer = *name == '*';
    name += is_buffer;
    if (!is_name(line) || !is_name(name) || strlen(line) + 3 > sizeof a->arg.type ||
        (!is_buffer && (a->arg.memory || a->arg.is_volatile || value_bytes(line, false) == 0)))
        return false;
    snprintf(a->arg.name, sizeof a->arg.name, "%s", name);
    snprintf(a->arg.type, sizeof a->arg.type, "%.20s%s", line, is_buffer ? " *" : "");
    return true;
}

static void read_line(lua_State *L, signature *s, const char *from, size_t length)
{
    char line[160], declaration[160];
    while (length > 0 && from[length - 1] == ' ')
        --length;
    if (length == 0)
        return;
    snprintf(line, sizeof line, "%.*s", (int)length, from);
    memcpy(declaration, line, sizeof line);
    char *condition = strstr(declaration, " if ");
    if (condition) {
        *condition = '\0';
        condition += 4;
    }
    if (length >= sizeof line || s->n == GEN_MAX_ARGS)
        field_raise(L, s->entry, "%s: more than %d arguments, or a line of %d letters", s->entry,
                    GEN_MAX_ARGS, (int)length);
    signature_arg *a = &s->args[s->n];
    a->condition = LUA_NOREF;
    cut_blanks(declaration);
    a->arg.is_only = condition && take_last_word(declaration, "only");
    if (!read_declaration(declaration, a))
        refuse(L, s, line);
    if (condition)
        a->condition = read_condition(L, s, condition);
    ++s->n;
}

// The entry's name and its list lie on top.
static void read_entry(lua_State *L, signature *s)
{
    const char *name = lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "";
    if (!is_name(name) || lua_type(L, -1) != LUA_TSTRING)
        field_raise(L, "args", "args: expected an entry's NAME = [[ its arguments ]]");
    snprintf(s->entry, sizeof s->entry, "%s", name);
    const char *at = lua_tostring(L, -1);
    while (*at) {
        at += strspn(at, " \n");
        size_t length = strcspn(at, "\n");
        read_line(L, s, at, length);
        at += length;
    }
}

static int by_entry(const void *a, const void *b)
{
    return strcmp(((const signature *)a)->entry, ((const signature *)b)->entry);
}

void signature_read(lua_State *L, signature **list, uint32_t *n)
{
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        duet_error why = {0};
        signature *grown = list_room(*list, *n, sizeof **list, &why);
        if (!grown) { // a script further out may have kept all that it may take
            script_set_failure(L, why.status);
            luaL_error(L, "%s", why.text);
        }
        *list = grown;
        grown[*n] = (signature){0};
        read_entry(L, &grown[(*n)++]);
    }
    if (*n > 1)
        qsort(*list, *n, sizeof **list, by_entry);
}

// ---------------------------------------------------------------- a config

static int refuse_name(lua_State *L)
{
    return luaL_error(L, "no parameter '%s'", lua_tostring(L, 2));
}

void signature_push_config(lua_State *L, const gen_setting *config, uint32_t n)
{
    lua_createtable(L, 0, (int)n);
    for (uint32_t i = 0; i < n; ++i) {
        lua_pushinteger(L, config[i].value);
        lua_setfield(L, -2, config[i].name);
    }
}

// The globals of a condition: each parameter, and no other name.
static void push_scope(lua_State *L, const gen_setting *config, uint32_t n)
{
    signature_push_config(L, config, n);
    lua_createtable(L, 0, 1);
    lua_pushcfunction(L, refuse_name);
    lua_setfield(L, -2, "__index");
    lua_setmetatable(L, -2);
}

// The scope is on top. A number would always hold in Lua, so it is refused.
static bool holds(lua_State *L, const signature *s, const signature_arg *a)
{
    if (a->condition == LUA_NOREF)
        return true;
    lua_rawgeti(L, LUA_REGISTRYINDEX, a->condition);
    lua_pushvalue(L, -2);
    lua_setupvalue(L, -2, 1);
    lua_call(L, 0, 1);
    if (lua_type(L, -1) != LUA_TBOOLEAN)
        luaL_error(L, "%s: the condition of '%s' gives a %s; expected a comparison", s->entry,
                   a->arg.name, luaL_typename(L, -1));
    bool yes = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return yes;
}

static bool has_doubles(const gen_setting *config, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(config[i].name, "DOUBLE") == 0)
            return config[i].value != 0;
    return false;
}

void signature_resolve(lua_State *L, const signature *s, const gen_setting *config, uint32_t n,
                       gen_entry *entry)
{
    bool doubles = has_doubles(config, n);
    gen_arg left_out[GEN_MAX_ARGS];
    *entry = (gen_entry){.n_fields = s->n};
    memcpy(entry->name, s->entry, sizeof entry->name);
    push_scope(L, config, n);
    for (uint32_t i = 0, n_left_out = 0; i < s->n; ++i) {
        gen_arg arg = s->args[i].arg;
        arg.bytes = value_bytes(arg.type, doubles);
        arg.is_double = doubles && is_real(arg.type);
        if (holds(L, s, &s->args[i]))
            entry->args[entry->n_args++] = arg;
        else
            left_out[n_left_out++] = arg;
    }
    memcpy(entry->args + entry->n_args, left_out, (s->n - entry->n_args) * sizeof *left_out);
    lua_pop(L, 1);
}

// ---------------------------------------------------------------- as text

// "__global const double4 *restrict rotations" of "real4 *"; a field is not restrict.
static void add_argument(const gen_arg *a, bool is_field, text *out)
{
    bool is_buffer = a->bytes == 0, is_real = strncmp(a->type, "real", 4) == 0;
    static const char *const memories[] = {"__global ", "__global const ", "__constant const "};
    const char *alone = a->memory == GEN_CONSTANT || is_field ? "" : "restrict ";
    const char *real = a->is_double ? "double" : "float";
    text_add(out, " \\\n    %s%s", a->is_volatile ? "volatile " : "",
             is_buffer ? memories[a->memory] : "");
    text_add(out, "%s%s%s%s", is_real ? real : "", a->type + (is_real ? 4 : 0),
             is_buffer ? alone : " ", a->name);
}

static void add_macro(const gen_entry *entry, const char *kind, text *out)
{
    text_add(out, "#define ");
    for (const char *c = entry->name; *c; ++c)
        text_add(out, "%c", *c >= 'a' && *c <= 'z' ? *c - 'a' + 'A' : *c);
    text_add(out, "_%s", kind);
}

static void write_arguments(const gen_entry *entry, text *out)
{
    add_macro(entry, "ARGS", out);
    for (uint32_t i = 0; i < entry->n_args; ++i) {
        add_argument(&entry->args[i], false, out);
        text_add(out, i + 1 < entry->n_args ? "," : "");
    }
    text_add(out, "\n");
}

static void write_values(const gen_entry *entry, text *out)
{
    add_macro(entry, "VALUES", out);
    for (uint32_t i = 0; i < entry->n_args; ++i)
        text_add(out, " \\\n    .%s = %s,", entry->args[i].name, entry->args[i].name);
    text_add(out, "\n");
}

static bool is_field(const gen_entry *entry, uint32_t i)
{
    return i < entry->n_args || !entry->args[i].is_only;
}

// Finds field `name` in the entries before entries[n], and in that one up to its argument `last`.
static bool is_there(const gen_entry *entries, uint32_t n, uint32_t last, const char *name)
{
    for (uint32_t e = 0; e <= n; ++e)
        for (uint32_t i = 0; i < (e < n ? entries[e].n_fields : last); ++i)
            if (is_field(&entries[e], i) && strcmp(entries[e].args[i].name, name) == 0)
                return true;
    return false;
}

// The argument as a field of all entries: constant, const and volatile if it is so in any, so that
// each entry's argument fits.
static gen_arg merged(const gen_entry *entries, uint32_t n, gen_arg arg)
{
    for (uint32_t e = 0; e < n; ++e)
        for (uint32_t i = 0; i < entries[e].n_fields; ++i)
            if (strcmp(entries[e].args[i].name, arg.name) == 0) {
                if (arg.memory < entries[e].args[i].memory)
                    arg.memory = entries[e].args[i].memory;
                arg.is_volatile = arg.is_volatile || entries[e].args[i].is_volatile;
            }
    return arg;
}

void signature_write(const gen_entry *entries, uint32_t n, text *out)
{
    for (uint32_t e = 0; e < n; ++e)
        write_arguments(&entries[e], out);
}

void signature_write_fields(const gen_entry *entries, uint32_t n, text *out)
{
    for (uint32_t e = 0; e < n; ++e)
        write_values(&entries[e], out);
    text_add(out, "#define ARG_FIELDS");
    for (uint32_t e = 0; e < n; ++e)
        for (uint32_t i = 0; i < entries[e].n_fields; ++i) {
            gen_arg arg = merged(entries, n, entries[e].args[i]);
            if (!is_field(&entries[e], i) || is_there(entries, e, i, arg.name))
                continue;
            add_argument(&arg, true, out);
            text_add(out, ";");
        }
    text_add(out, "\n");
}
