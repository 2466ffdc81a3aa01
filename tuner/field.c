// SPDX-License-Identifier: MIT
#include "tuner/field.h"

void field_enter(field *f, duet_plan plan)
{
    if (f->n < RACE_RIVALS)
        f->plans[f->n++] = plan;
}

uint32_t field_find(const field *f, const duet_plan *plan)
{
    uint32_t i = 0;
    while (i < f->n && !trial_log_same_plan(&f->plans[i], plan))
        ++i;
    return i;
}

void field_enter_new(field *f, const duet_plan *plan)
{
    if (field_find(f, plan) == f->n)
        field_enter(f, *plan);
}

// Drops plans that are too slow to be worth another round.
static void drop_hopeless(field *f)
{
    uint32_t leader = race_leader(&f->race);
    for (uint32_t i = 0; f->hopeless > 0 && i < f->n && leader < f->n; ++i) {
        if (f->race.rivals[i].rounds > 0 && race_compare(&f->race, leader, i).ratio > f->hopeless)
            race_drop(&f->race, i);
    }
}

void field_race(tuning *t, field *f, const race_options *options)
{
    uint32_t rival;
    f->race = race_begin(f->n, options);
    while (tuning_goes_on(t) && race_next(&f->race, &rival)) {
        trial got = tuning_run_on(t, rival == f->n - 1 ? f->whole : NULL, &f->plans[rival]);
        uint64_t ns = t->focus.stages ? got.focus_ns
                      : f->of_a       ? got.sample.a_ns
                                      : got.sample.total_ns;
        if (got.usable)
            race_add(&f->race, rival, (double)ns);
        else
            race_drop(&f->race, rival);
        drop_hopeless(f);
        f->terms[rival] = got.terms;
    }
}

race_gain field_duel(tuning *t, const duet_plan *usual, const duet_plan *plan,
                     const race_options *options)
{
    field f = {.plans = {*usual, *plan}, .n = 2};
    field_race(t, &f, options);
    return race_rounds(&f.race, 0, 1) > 0 ? race_compare(&f.race, 1, 0)
                                          : race_no_gain(RACE_AMBIGUOUS);
}
