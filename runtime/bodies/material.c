// SPDX-License-Identifier: MIT
#include "runtime/bodies/material.h"

#include "base/error.h"
#include "kernels/dynamics/materials.h"

#include <assert.h>
#include <string.h>

static_assert(DUET_MATERIALS == MATERIALS_MOST, "kernels and host have one table");

duet_material material_of_rules(void)
{
    return (duet_material){.friction_rule = DUET_COMBINE_GEOMETRIC_MEAN,
                           .restitution_rule = DUET_COMBINE_MAX};
}

const char *material_rule_name(int rule)
{
    static const char *const names[] = {
        [DUET_COMBINE_AVERAGE] = "average", [DUET_COMBINE_GEOMETRIC_MEAN] = "geometric_mean",
        [DUET_COMBINE_MIN] = "min",         [DUET_COMBINE_PRODUCT] = "product",
        [DUET_COMBINE_MAX] = "max",
    };
    return rule >= 0 && rule <= DUET_COMBINE_MAX ? names[rule] : NULL;
}

// ---------------------------------------------------------------- checks

static const char *surface_fault(float friction, float restitution)
{
    if (!(friction >= 0.0f && friction <= 1e6f))
        return "friction from 0 to 1e6";
    return restitution >= 0.0f && restitution <= 1.0f ? NULL : "restitution from 0 to 1";
}

static const char *material_fault(const duet_material *m)
{
    if (!material_rule_name((int)m->friction_rule) || !material_rule_name((int)m->restitution_rule))
        return "rules of duet_combine";
    return surface_fault(m->friction, m->restitution);
}

static const char *pair_fault(const duet_motion_def *def, const duet_material_pair *p)
{
    if (p->a < 1 || p->a > def->n_materials || p->b < 1 || p->b > def->n_materials)
        return "two of the materials";
    return surface_fault(p->friction, p->restitution);
}

bool materials_check(const duet_motion_def *def, duet_error *err)
{
    if (def->n_materials >= DUET_MATERIALS)
        return bad_argument(err, "n_materials is %u; expected at most %d", def->n_materials,
                            DUET_MATERIALS - 1);
    if (def->n_material_pairs > DUET_MATERIAL_PAIRS)
        return bad_argument(err, "n_material_pairs is %u; expected at most %d",
                            def->n_material_pairs, DUET_MATERIAL_PAIRS);
    const char *fault = NULL;
    for (uint32_t i = 1; i <= def->n_materials; ++i)
        if ((fault = material_fault(&def->materials[i])))
            return bad_argument(err, "material %u: expected %s", i, fault);
    for (uint32_t i = 0; i < def->n_material_pairs; ++i)
        if ((fault = pair_fault(def, &def->material_pairs[i])))
            return bad_argument(err, "pair %u of materials: expected %s", i + 1, fault);
    return true;
}

bool materials_are_same(const duet_motion_def *a, const duet_motion_def *b)
{
    return a->n_materials == b->n_materials && a->n_material_pairs == b->n_material_pairs &&
           memcmp(&a->materials[1], &b->materials[1], a->n_materials * sizeof *a->materials) == 0 &&
           memcmp(a->material_pairs, b->material_pairs,
                  a->n_material_pairs * sizeof *a->material_pairs) == 0;
}

// ---------------------------------------------------------------- a body's

float material_friction(const duet_motion_def *def, const duet_body *b)
{
    return b->material ? def->materials[b->material].friction : b->friction;
}

float material_restitution(const duet_motion_def *def, const duet_body *b)
{
    return b->material ? def->materials[b->material].restitution : b->restitution;
}

static bool is_of(const duet_material_pair *p, uint32_t material)
{
    return p->a == material || p->b == material;
}

bool material_is_rough(const duet_motion_def *def, const duet_body *b)
{
    bool rough = material_friction(def, b) > 0.0f;
    for (uint32_t i = 0; b->material && i < def->n_material_pairs; ++i)
        rough |=
            is_of(&def->material_pairs[i], b->material) && def->material_pairs[i].friction > 0.0f;
    return rough;
}

bool material_is_elastic(const duet_motion_def *def, const duet_body *b)
{
    bool elastic = material_restitution(def, b) > 0.0f;
    for (uint32_t i = 0; b->material && i < def->n_material_pairs; ++i)
        elastic |= is_of(&def->material_pairs[i], b->material) &&
                   def->material_pairs[i].restitution > 0.0f;
    return elastic;
}

// ---------------------------------------------------------------- the table

// A body without a material leaves the rule to the other.
static duet_combine rule_of(duet_combine a, duet_combine b, uint32_t i, uint32_t j)
{
    if (i == 0 || j == 0)
        return i == 0 ? b : a;
    return a > b ? a : b;
}

static void set_rules(const duet_motion_def *def, uint32_t i, uint32_t j, float *row)
{
    const duet_material own = material_of_rules();
    const duet_material *a = i ? &def->materials[i] : &own, *b = j ? &def->materials[j] : &own;
    row[RULE_FRICTION] = (float)rule_of(a->friction_rule, b->friction_rule, i, j);
    row[RULE_RESTITUTION] = (float)rule_of(a->restitution_rule, b->restitution_rule, i, j);
    row[GIVEN_FRICTION] = row[GIVEN_RESTITUTION] = 0.0f;
}

static void give(float *row, const duet_material_pair *p)
{
    row[RULE_FRICTION] = row[RULE_RESTITUTION] = RULE_GIVEN;
    row[GIVEN_FRICTION] = p->friction;
    row[GIVEN_RESTITUTION] = p->restitution;
}

void material_fill_rules(const duet_motion_def *def, float *rules)
{
    for (uint32_t i = 0; i < DUET_MATERIALS; ++i)
        for (uint32_t j = 0; j < DUET_MATERIALS; ++j)
            set_rules(def, i, j, rules + (i * DUET_MATERIALS + j) * MATERIAL_ROW);
    for (uint32_t i = 0; i < def->n_material_pairs; ++i) {
        const duet_material_pair *p = &def->material_pairs[i];
        give(rules + (p->a * DUET_MATERIALS + p->b) * MATERIAL_ROW, p);
        give(rules + (p->b * DUET_MATERIALS + p->a) * MATERIAL_ROW, p);
    }
}
