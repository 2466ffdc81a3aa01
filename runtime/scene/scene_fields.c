// SPDX-License-Identifier: MIT
#include "runtime/scene/scene_fields.h"

#include "runtime/bodies/material.h"
#include "runtime/duet.h"

#include <lauxlib.h>
#include <string.h>

const char *scene_boundary_name(int boundary)
{
    static const char *const names[] = {[DUET_BOUNDARY_NONE] = "none",
                                        [DUET_BOUNDARY_WALLS] = "walls",
                                        [DUET_BOUNDARY_PERIODIC] = "periodic"};
    return boundary <= DUET_BOUNDARY_PERIODIC ? names[boundary] : NULL;
}

const char *scene_integrator_name(int integrator)
{
    static const char *const names[] = {[DUET_INTEGRATOR_EULER] = "euler",
                                        [DUET_INTEGRATOR_VERLET] = "verlet",
                                        [DUET_INTEGRATOR_YOSHIDA] = "yoshida"};
    return integrator <= DUET_INTEGRATOR_YOSHIDA ? names[integrator] : NULL;
}

// ---------------------------------------------------------------- effects

uint32_t scene_effect_named(const char *name)
{
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (strcmp(duet_effect_name(bit), name) == 0)
            return bit;
    return 0;
}

static void read_effects(lua_State *L, const field *f, void *at)
{
    if (!lua_istable(L, -1))
        field_refuse(L, f, "a list of effects' names");
    for (lua_Unsigned n = lua_rawlen(L, -1), k = 1; k <= n; ++k) {
        lua_rawgeti(L, -1, (lua_Integer)k);
        const char *name = field_text(L, -1);
        uint32_t effect = name ? scene_effect_named(name) : 0;
        if (!effect)
            field_raise(
                L, f->name,
                "%s has '%s', which is no effect; docs/effects.md and duet.effects() list them",
                f->name, field_push_shown(L, -1));
        *(uint32_t *)at |= effect;
        lua_pop(L, 1);
    }
}

void scene_push_effects(lua_State *L, uint32_t effects)
{
    lua_newtable(L);
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1) {
        if (!(effects & bit))
            continue;
        lua_pushstring(L, duet_effect_name(bit));
        lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    }
}

static void push_effects(lua_State *L, const field *f, const void *at)
{
    (void)f;
    scene_push_effects(L, *(const uint32_t *)at);
}

const field_type field_effects = {.read = read_effects, .push = push_effects};

// ---------------------------------------------------------------- materials

#define SURFACE(struct_)                                                 \
    FIELD_WITHIN(struct_, , friction, 0, 1e6, "a number from 0 to 1e6"), \
        FIELD_WITHIN(struct_, , restitution, 0, 1, "a number from 0 to 1")

static const field material_fields[] = {
    SURFACE(duet_material),
    FIELD_ENUM(duet_material, friction_rule, material_rule_name),
    FIELD_ENUM(duet_material, restitution_rule, material_rule_name),
    {0},
};

#define ONE_OF_PAIR(name, member)                                                          \
    {                                                                                      \
        FIELD_ROW(name, field_count, duet_material_pair, member),                          \
            .least = 1, .most = DUET_MATERIALS - 1, .expected = "the number of a material" \
    }

static const field pair_fields[] = {
    ONE_OF_PAIR("[1]", a),
    ONE_OF_PAIR("[2]", b),
    SURFACE(duet_material_pair),
    {0},
};

// How many rows the list on top of the stack has.
static uint32_t count_rows(lua_State *L, const field *f, uint32_t most, const char *expected)
{
    lua_Unsigned n = lua_istable(L, -1) ? lua_rawlen(L, -1) : (lua_Unsigned)most + 1;
    if (n > most)
        field_refuse(L, f, expected);
    return (uint32_t)n;
}

static void read_materials(lua_State *L, const field *f, void *at)
{
    duet_motion_def *def = at;
    uint32_t n = count_rows(L, f, DUET_MATERIALS - 1, "a list of at most 15 materials");
    for (uint32_t i = 1; i <= n; ++i) {
        def->materials[i] = material_of_rules();
        lua_rawgeti(L, -1, i);
        field_read_row(L, -1, (field_table){"materials, row", i, f->name}, material_fields,
                       &def->materials[i]);
        lua_pop(L, 1);
    }
    def->n_materials = n;
}

static void read_pairs(lua_State *L, const field *f, void *at)
{
    duet_motion_def *def = at;
    uint32_t n = count_rows(L, f, DUET_MATERIAL_PAIRS, "a list of at most 120 pairs of materials");
    for (uint32_t i = 1; i <= n; ++i) {
        const field_table row = {"material_pairs, row", i, f->name};
        duet_material_pair *pair = &def->material_pairs[i - 1];
        *pair = (duet_material_pair){0};
        lua_rawgeti(L, -1, i);
        field_read_row(L, -1, row, pair_fields, pair);
        if (!pair->a || !pair->b || pair->a > def->n_materials || pair->b > def->n_materials)
            field_raise_in(L, &row, NULL, "expected two of the %u materials by their numbers",
                           def->n_materials);
        lua_pop(L, 1);
    }
    def->n_material_pairs = n;
}

const field_type field_materials = {.read = read_materials};
const field_type field_material_pairs = {.read = read_pairs};
