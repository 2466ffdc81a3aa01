// SPDX-License-Identifier: MIT
#include "runtime/scene/scene_materials.h"

#include "gen/field.h"
#include "runtime/bodies/material.h"
#include "runtime/scene/scene_lua.h"

#include <string.h>

// Each reads one value of a row from the top of the stack, or returns what it expects.
static const char *take_number(lua_State *L, float *to)
{
    if (lua_type(L, -1) != LUA_TNUMBER)
        return "friction and restitution as numbers";
    *to = (float)lua_tonumber(L, -1);
    return NULL;
}

static const char *take_rule(lua_State *L, duet_combine *to)
{
    const char *name = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "?";
    for (int i = 0; material_rule_name(i); ++i)
        if (strcmp(material_rule_name(i), name) == 0) {
            *to = (duet_combine)i;
            return NULL;
        }
    return "a rule: average, geometric_mean, min, product or max";
}

static const char *take_material_field(lua_State *L, const char *name, duet_material *m)
{
    if (strcmp(name, "friction") == 0)
        return take_number(L, &m->friction);
    if (strcmp(name, "restitution") == 0)
        return take_number(L, &m->restitution);
    if (strcmp(name, "friction_rule") == 0)
        return take_rule(L, &m->friction_rule);
    if (strcmp(name, "restitution_rule") == 0)
        return take_rule(L, &m->restitution_rule);
    return "no fields but friction, restitution, friction_rule and restitution_rule";
}

static const char *take_pair_field(lua_State *L, const char *name, duet_material_pair *p)
{
    if (strcmp(name, "friction") == 0)
        return take_number(L, &p->friction);
    if (strcmp(name, "restitution") == 0)
        return take_number(L, &p->restitution);
    return "no fields but two materials, friction and restitution";
}

static const char *take_pair_end(lua_State *L, lua_Integer index, duet_material_pair *p)
{
    lua_Integer id = lua_isinteger(L, -1) ? lua_tointeger(L, -1) : 0;
    if (index < 1 || index > 2 || id < 1 || id >= DUET_MATERIALS)
        return "two materials by their numbers";
    *(index == 1 ? &p->a : &p->b) = (uint32_t)id;
    return NULL;
}

// The rows are on top of the stack; `row` is what they are counted by.
static const char *take_material(lua_State *L, duet_material *m)
{
    const char *fault = NULL;
    *m = material_of_rules();
    for (lua_pushnil(L); !fault && lua_next(L, -2); lua_pop(L, 1))
        fault =
            take_material_field(L, lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "?", m);
    return fault;
}

static const char *take_pair(lua_State *L, duet_material_pair *p)
{
    const char *fault = NULL;
    *p = (duet_material_pair){0};
    for (lua_pushnil(L); !fault && lua_next(L, -2); lua_pop(L, 1))
        fault =
            lua_isinteger(L, -2)
                ? take_pair_end(L, lua_tointeger(L, -2), p)
                : take_pair_field(L, lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "?", p);
    return fault || (p->a && p->b) ? fault : "two materials by their numbers";
}

// How many rows the list on top of the stack has; more than `most`: it is none, or too long.
static lua_Integer count_rows(lua_State *L, lua_Integer most)
{
    lua_Unsigned n = lua_istable(L, -1) ? lua_rawlen(L, -1) : (lua_Unsigned)most + 1;
    return n > (lua_Unsigned)most ? most + 1 : (lua_Integer)n;
}

const char *scene_take_materials(lua_State *L, duet_motion_def *def, lua_Integer *row)
{
    const char *fault = NULL;
    lua_Integer n = count_rows(L, DUET_MATERIALS - 1);
    *row = 0;
    if (n >= DUET_MATERIALS)
        return "a list of at most 15 materials";
    for (lua_Integer i = 1; !fault && i <= n; ++i) {
        *row = i;
        fault = lua_rawgeti(L, -1, i) == LUA_TTABLE ? take_material(L, &def->materials[i])
                                                    : "a table of friction and restitution";
        lua_pop(L, 1);
    }
    def->n_materials = (uint32_t)n;
    return fault;
}

const char *scene_take_material_pairs(lua_State *L, duet_motion_def *def, lua_Integer *row)
{
    const char *fault = NULL;
    lua_Integer n = count_rows(L, DUET_MATERIAL_PAIRS);
    *row = 0;
    if (n > DUET_MATERIAL_PAIRS)
        return "a list of at most 120 pairs of materials";
    for (lua_Integer i = 1; !fault && i <= n; ++i) {
        *row = i;
        fault = lua_rawgeti(L, -1, i) == LUA_TTABLE ? take_pair(L, &def->material_pairs[i - 1])
                                                    : "a table of two materials";
        lua_pop(L, 1);
    }
    def->n_material_pairs = (uint32_t)n;
    return fault;
}

// ---------------------------------------------------------------- of a scene

static void read_list(lua_State *L, const char *name, duet_motion_def *def,
                      const char *(*take)(lua_State *, duet_motion_def *, lua_Integer *))
{
    lua_Integer row = 0;
    if (lua_getfield(L, 1, name) != LUA_TNIL) {
        const char *fault = take(L, def, &row);
        if (fault)
            field_raise(L, name, "%s, row %lld: expected %s", name, (long long)row, fault);
    }
    lua_pop(L, 1);
}

void scene_read_materials(lua_State *L, scene_reading *reading)
{
    read_list(L, "materials", &reading->scene->motion, scene_take_materials);
    read_list(L, "material_pairs", &reading->scene->motion, scene_take_material_pairs);
}
