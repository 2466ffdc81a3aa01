// SPDX-License-Identifier: MIT
#include "tuner/level_choice.h"

#include "base/error.h"

#include <math.h>

// What a level that promises more may cost before one that promises less is
// worth it: less than that is noise.
static const double WORTH = 1.02;

// A row of the table of level costs, with what it gets wrong by pairs that collide.
typedef struct offer {
    duet_level level;
    double step_ns;
    duet_accuracy wrong;
} offer;

static duet_accuracy wrong_of(const profile_level_cost *cost)
{
    double pairs = fmax((double)cost->true_pairs, 1);
    return (duet_accuracy){(double)cost->missed / pairs, (double)cost->invented / pairs};
}

static bool is_among(duet_level level, const duet_level *levels, uint32_t n)
{
    uint32_t i = 0;
    while (i < n && levels[i] != level)
        ++i;
    return i < n;
}

static uint32_t list_offers(const profile_level_cost *costs, uint32_t n_costs,
                            const duet_level *levels, uint32_t n_levels, offer *offers)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < n_costs; ++i) {
        duet_level level;
        if (duet_level_from_name(costs[i].level, &level) && is_among(level, levels, n_levels))
            offers[n++] = (offer){level, costs[i].step_ns, wrong_of(&costs[i])};
    }
    return n;
}

// How far above what is allowed; 0 where it is within.
static double excess(const offer *o, const duet_accuracy *accuracy)
{
    return fmax(o->wrong.missed - accuracy->missed, 0) +
           fmax(o->wrong.false_rate - accuracy->false_rate, 0);
}

static const offer *quickest_within(const offer *offers, uint32_t n, const duet_accuracy *accuracy)
{
    const offer *best = NULL;
    for (uint32_t i = 0; i < n; ++i)
        if (excess(&offers[i], accuracy) <= 0 && (!best || offers[i].step_ns < best->step_ns))
            best = &offers[i];
    return best;
}

// The quickest of those that promise all that `than` does, and more.
static const offer *safer_for_nothing(const offer *offers, uint32_t n, const offer *than,
                                      const duet_accuracy *accuracy)
{
    const offer *best = than;
    for (uint32_t i = 0; i < n; ++i) {
        const offer *o = &offers[i];
        bool promises_more =
            duet_level_covers(o->level, best->level) && !duet_level_covers(best->level, o->level);
        if (promises_more && excess(o, accuracy) <= 0 && o->step_ns <= WORTH * than->step_ns)
            best = o;
    }
    return best;
}

static bool tell_nearest(const offer *offers, uint32_t n, const duet_accuracy *accuracy,
                         duet_error *err)
{
    if (n == 0)
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "none of the levels to choose from runs on both devices");
    const offer *nearest = &offers[0];
    for (uint32_t i = 1; i < n; ++i)
        if (excess(&offers[i], accuracy) < excess(nearest, accuracy))
            nearest = &offers[i];
    return error_set(err, DUET_STATUS_NOT_FOUND,
                     "no level to choose from is within missed %.6g and false rate %.6g: '%s' "
                     "comes nearest, with %.6g and %.6g",
                     accuracy->missed, accuracy->false_rate,
                     duet_level_get_info(nearest->level)->name, nearest->wrong.missed,
                     nearest->wrong.false_rate);
}

bool level_choose(const profile_level_cost *costs, uint32_t n_costs, const duet_level *levels,
                  uint32_t n_levels, const duet_accuracy *accuracy, duet_level *level,
                  duet_error *err)
{
    offer offers[PROFILE_LEVEL_COSTS];
    uint32_t n = list_offers(costs, n_costs, levels, n_levels, offers);
    const offer *quickest = quickest_within(offers, n, accuracy);
    if (!quickest)
        return tell_nearest(offers, n, accuracy, err);
    *level = safer_for_nothing(offers, n, quickest, accuracy)->level;
    return true;
}
