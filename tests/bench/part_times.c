// SPDX-License-Identifier: MIT
#include "part_times.h"

#include "tuner/tune.h"

#include <stdio.h>
#include <string.h>

// Returns the place of the plan's part, or of a new one; PART_TIMES if there is no space.
static uint32_t find(const part_times *p, const duet_plan *plan, int device)
{
    uint32_t i = 0;
    while (i < p->n[device] && (p->of[device][i].share != plan->share ||
                                strcmp(p->of[device][i].variant, plan_variant(plan, device)) != 0))
        ++i;
    return i;
}

bool part_times_allow(part_times *p, const duet_plan *plan)
{
    bool shares = plan->share > 0 && plan->share < DUET_SHARE_ONE, slow = false;
    for (int device = 0; device < 2 && shares; ++device) {
        uint32_t i = find(p, plan, device);
        slow |= i < p->n[device] && p->of[device][i].ns * 10 > p->least_ns * 13;
    }
    p->passed_over += slow;
    return !slow;
}

void part_times_add(part_times *p, const duet_plan *plan, const measure_launch *launch)
{
    const int64_t lost = (int64_t)launch->use.lost_ns;
    const int64_t ns[2] = {launch->a_ns - lost, launch->b_ns - lost};
    if (p->least_ns == 0 || launch->total_ns < p->least_ns)
        p->least_ns = launch->total_ns;
    for (int device = 0; device < 2; ++device) {
        uint32_t i = find(p, plan, device);
        if (i == PART_TIMES)
            continue;
        part_time *at = &p->of[device][i];
        if (i == p->n[device]) {
            *at = (part_time){.share = plan->share, .ns = ns[device]};
            snprintf(at->variant, sizeof at->variant, "%s", plan_variant(plan, device));
            ++p->n[device];
        }
        at->ns = ns[device] < at->ns ? ns[device] : at->ns;
    }
}
