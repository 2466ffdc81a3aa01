// SPDX-License-Identifier: MIT
// The choices of a tuning.
#include "tuner/tune.h"

#include <stdio.h>
#include <string.h>

static const char *const default_variants[] = {"auto", "simd", "auto sort=radix", "paper"};

const char *tune_variant(const duet_tune_def *def, uint32_t i)
{
    enum { N_DEFAULT = sizeof default_variants / sizeof *default_variants };
    if (def->n_variants > 0)
        return i < def->n_variants ? def->variants[i] : NULL;
    return i < N_DEFAULT ? default_variants[i] : NULL;
}

uint32_t tune_count_variants(const duet_tune_def *def)
{
    uint32_t n = 0;
    while (tune_variant(def, n))
        ++n;
    return n;
}

bool tune_has_variant(const duet_tune_def *def, const char *variant)
{
    const char *other;
    for (uint32_t i = 0; (other = tune_variant(def, i)); ++i)
        if (strcmp(other, variant) == 0)
            return true;
    return false;
}

uint32_t tune_count_modes(const duet_tune_def *def)
{
    enum { EACH = DUET_MODE_DEFAULT };
    return def->n_modes > 0 && def->n_modes < EACH ? def->n_modes : EACH;
}

uint32_t tune_least_share(uint64_t n)
{
    enum { GROUP = 128 };
    uint64_t share = n ? (uint64_t)GROUP * DUET_SHARE_ONE / n : 1;
    return share < 1 ? 1 : share > DUET_SHARE_ONE / 32 ? DUET_SHARE_ONE / 32 : (uint32_t)share;
}

const char *plan_variant(const duet_plan *plan, int device)
{
    return device == 0 ? plan->variant_a : plan->variant_b;
}

char *plan_variant_of(duet_plan *plan, int device)
{
    return device == 0 ? plan->variant_a : plan->variant_b;
}

void plan_set_variant(duet_plan *plan, int device, const char *variant)
{
    snprintf(plan_variant_of(plan, device), sizeof plan->variant_a, "%s", variant);
}

void plan_set_variants(duet_plan *plan, const char *variant)
{
    plan_set_variant(plan, 0, variant);
    plan_set_variant(plan, 1, variant);
}
