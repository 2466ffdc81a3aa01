// SPDX-License-Identifier: MIT
#include "tuner/joint_space.h"

#include "base/error.h"
#include "tuner/kernel_search.h"
#include "tuner/tune.h"

bool joint_space_add(joint_space *s, int device, const kernel_space *kernel, duet_error *err)
{
    if ((device == 0 ? s->n_a : s->kernels.n - s->n_a) == SEARCH_KERNELS)
        return true;
    s->n_a += device == 0;
    return kernel_spaces_add(&s->kernels, kernel, err);
}

void joint_space_free(joint_space *s)
{
    kernel_spaces_free(&s->kernels);
}

static int device_of(const joint_space *s, uint32_t kernel)
{
    return kernel < s->n_a ? 0 : 1;
}

static void reset_device(const joint_space *s, search_sample *p, int device)
{
    for (uint32_t i = 0; i < s->kernels.n; ++i)
        if (device_of(s, i) == device)
            p->configs[i] = (uint16_t)s->kernels.of[i].now;
}

search_sample joint_space_base(const joint_space *s, uint32_t share)
{
    search_sample p = {.share = share};
    reset_device(s, &p, 0);
    reset_device(s, &p, 1);
    return p;
}

void joint_space_normalize(const joint_space *s, search_sample *p)
{
    if (p->share == 0)
        reset_device(s, p, 0);
    if (p->share == SEARCH_ONE)
        reset_device(s, p, 1);
}

// ---------------------------------------------------------------- numbers

static uint32_t share_of(const joint_space *s, uint32_t place)
{
    return s->points ? (uint32_t)((uint64_t)SEARCH_ONE * place / s->points) : 0;
}

// At most so many sets of configs of a device count: several kernels may have more than any search
// goes through, and their product stays a number.
#define MOST_CONFIGS (UINT64_C(1) << 24)

static uint64_t count_configs(const joint_space *s, int device)
{
    uint64_t n = 1;
    for (uint32_t i = 0; i < s->kernels.n; ++i) {
        n *= device_of(s, i) == device ? s->kernels.of[i].n_configs : 1;
        n = n < MOST_CONFIGS ? n : MOST_CONFIGS;
    }
    return n;
}

uint64_t joint_space_count(const joint_space *s)
{
    uint64_t a = count_configs(s, 0), b = count_configs(s, 1);
    return s->points ? a * b * (s->points - 1) + a + b : b;
}

static void set_configs(const joint_space *s, search_sample *p, int device, uint64_t number)
{
    for (uint32_t i = 0; i < s->kernels.n; ++i)
        if (device_of(s, i) == device) {
            p->configs[i] = (uint16_t)(number % s->kernels.of[i].n_configs);
            number /= s->kernels.of[i].n_configs;
        }
}

// B alone, then A alone, then both at each share between.
search_sample joint_space_at(const joint_space *s, uint64_t number)
{
    uint64_t a = count_configs(s, 0), b = count_configs(s, 1);
    search_sample p = joint_space_base(s, 0);
    if (number < b) {
        set_configs(s, &p, 1, number);
    } else if (number < a + b) {
        p.share = SEARCH_ONE;
        set_configs(s, &p, 0, number - b);
    } else {
        uint64_t shared = number - a - b, inner = s->points - 1;
        p.share = share_of(s, 1 + (uint32_t)(shared % inner));
        set_configs(s, &p, 0, shared / inner % a);
        set_configs(s, &p, 1, shared / inner / a);
    }
    return p;
}

// ---------------------------------------------------------------- chance

search_sample joint_space_random(const joint_space *s, rng *r)
{
    search_sample p = {.share = share_of(s, rng_below(r, s->points + 1))};
    for (uint32_t i = 0; i < s->kernels.n; ++i)
        p.configs[i] = (uint16_t)rng_below(r, s->kernels.of[i].n_configs);
    joint_space_normalize(s, &p);
    return p;
}

// Another config that differs in the fewest parameters, by chance where several do.
static uint16_t step_config(const kernel_space *k, uint16_t from, rng *r)
{
    uint32_t least = UINT32_MAX, n = 0;
    uint16_t chosen = from;
    for (uint32_t i = 0; i < k->n_configs; ++i) {
        uint32_t differ = kernel_search_distance(k, from, i);
        if (differ == 0 || differ > least)
            continue;
        n = differ < least ? 1 : n + 1;
        least = differ;
        if (rng_below(r, n) == 0)
            chosen = (uint16_t)i;
    }
    return chosen;
}

static uint32_t step_share(const joint_space *s, uint32_t share, rng *r)
{
    enum { FARTHEST = 4 };
    int place = (int)(((uint64_t)share * s->points + SEARCH_ONE / 2) / SEARCH_ONE);
    int by = 1 + (int)rng_below(r, FARTHEST);
    place += rng_below(r, 2) ? by : -by;
    place = place < 0 ? 0 : place > (int)s->points ? (int)s->points : place;
    return share_of(s, (uint32_t)place);
}

// The share is what most depends on the others, and is moved in a third of the steps.
search_sample joint_space_neighbour(const joint_space *s, const search_sample *p, rng *r)
{
    search_sample to = *p;
    if (s->kernels.n == 0 || (s->points && rng_below(r, 3) == 0)) {
        to.share = step_share(s, p->share, r);
    } else {
        uint32_t i = rng_below(r, s->kernels.n);
        to.configs[i] = step_config(&s->kernels.of[i], to.configs[i], r);
    }
    joint_space_normalize(s, &to);
    return to;
}

// ---------------------------------------------------------------- plans

bool joint_space_plan(const joint_space *s, const search_sample *p, duet_plan *plan)
{
    *plan = s->base;
    plan->share = p->share;
    bool fits = true;
    for (uint32_t i = 0; fits && i < s->kernels.n; ++i)
        fits = kernel_space_write(&s->kernels.of[i], p->configs[i],
                                  plan_variant_of(plan, device_of(s, i)));
    return fits;
}
