// SPDX-License-Identifier: MIT
#include "cli/bench_set.h"

#include <stdio.h>
#include <string.h>

const bench_scene bench_scenes[] = {
    // The density is that of a million objects in the paper's world.
    {.name = "paper", "250000", "3000", "126", "29", .levels = true},
    {.name = "paper2d", "250000", "3000", "1000", "110"},
    {.name = "clustered", "100000", "3000"},
    {.name = "mixed", "100000", "3000", .mixed = true},
    {.name = "planes", "100000", "3000"},
    {.name = "falling", "20000", "200", .moves = true},
    {0},
};

static const uint32_t shares[] = {0, DUET_SHARE_ONE / 4, DUET_SHARE_ONE / 2, DUET_SHARE_ONE * 3 / 4,
                                  DUET_SHARE_ONE};
static const duet_mode modes[] = {DUET_MODE_SHARED, DUET_MODE_SLAB};
static const struct {
    const char *variant;
    bool one_size; // of cells
} variants[] = {{"auto", false}, {"simd", false}, {"auto sort=radix", false}, {"paper", true}};

typedef struct plan_list {
    duet_plan *plans;
    uint32_t n;
} plan_list;

// Adds a plan unless it is there: the pair's own kernels are among the others.
static void add(plan_list *list, const duet_plan *plan)
{
    for (uint32_t i = 0; i < list->n; ++i) {
        const duet_plan *p = &list->plans[i];
        if (p->share == plan->share && p->mode == plan->mode &&
            strcmp(p->variant_a, plan->variant_a) == 0 &&
            strcmp(p->variant_b, plan->variant_b) == 0)
            return;
    }
    list->plans[list->n++] = *plan;
}

static void use_kernels(duet_plan *plan, const char *variant)
{
    snprintf(plan->variant_a, sizeof plan->variant_a, "%s", variant);
    snprintf(plan->variant_b, sizeof plan->variant_b, "%s", variant);
}

uint32_t bench_plans(const bench_scene *scene, const duet_device_pair *pair,
                     duet_plan plans[BENCH_PLANS_MOST])
{
    plan_list list = {plans, 0};
    duet_plan plan = duet_default_plan(pair);
    plan.mode = DUET_MODE_OWN;
    for (size_t i = 0; i < sizeof shares / sizeof *shares; ++i) {
        plan.share = shares[i];
        add(&list, &plan);
    }
    plan.share = DUET_SHARE_ONE / 2;
    for (size_t i = 0; i < sizeof variants / sizeof *variants; ++i) {
        use_kernels(&plan, variants[i].variant);
        if (!(variants[i].one_size && scene->mixed))
            add(&list, &plan);
    }
    use_kernels(&plan, "auto");
    for (size_t i = 0; i < sizeof modes / sizeof *modes && !scene->mixed; ++i) {
        plan.mode = modes[i];
        add(&list, &plan);
    }
    return list.n;
}
