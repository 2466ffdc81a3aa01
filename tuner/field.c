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
static void drop_hopeless(race *r, double hopeless)
{
    uint32_t leader = race_leader(r);
    for (uint32_t i = 0; i < r->n && leader < r->n; ++i) {
        if (r->rivals[i].rounds > 0 && race_compare(r, leader, i).ratio > hopeless)
            race_drop(r, i);
    }
}

// Returns the time to compare: of the stages in focus, or of A's part, or of the step.
static double time_of(const tuning *t, const trial *got, bool of_a)
{
    uint64_t step = of_a ? got->sample.a_ns : got->sample.total_ns;
    return (double)(t->focus.stages ? got->focus_ns : step);
}

bool field_race(tuning *t, field *f, const race_options *options, bool of_a, double hopeless,
                duet_error *err)
{
    uint32_t rival;
    f->race = race_begin(f->n, options);
    while (tuning_within_budget(t) && race_next(&f->race, &rival)) {
        trial got;
        if (!tuning_run_trial(t, &f->plans[rival], &got, err))
            return false;
        if (got.usable)
            race_add(&f->race, rival, time_of(t, &got, of_a));
        else
            race_drop(&f->race, rival);
        drop_hopeless(&f->race, hopeless);
        f->terms[rival] = got.terms;
    }
    return true;
}
