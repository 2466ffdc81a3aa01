// SPDX-License-Identifier: MIT
#include "tuner/subject.h"

#include "base/error.h"
#include "tuner/tune.h"

// The first that is asked for; a still step is what is left.
static const subject_kind *const kinds[] = {&subject_task, &subject_motion, &subject_query,
                                            &subject_still};

static const duet_mode modes[] = {DUET_MODE_OWN};
static const char *const variants[] = {"auto"};

// In the order of their numbers.
static const char *const names[] = {"task",
                                    "steps",
                                    "query",
                                    "scene",
                                    "items of a query",
                                    "search",
                                    "variants",
                                    "modes",
                                    "level or accuracy",
                                    "order"};

static unsigned asked(const duet_tune_def *def)
{
    return (def->task ? SUBJECT_TASK : 0) | (def->steps ? SUBJECT_STEPS : 0) |
           (def->query ? SUBJECT_QUERY : 0) | (def->scene ? SUBJECT_SCENE : 0) |
           (def->items ? SUBJECT_ITEMS : 0) | (def->search ? SUBJECT_SEARCH : 0) |
           (def->n_variants ? SUBJECT_VARIANTS : 0) | (def->n_modes ? SUBJECT_MODES : 0) |
           (def->n_levels || def->has_accuracy ? SUBJECT_LEVELS : 0) |
           (def->ordered ? SUBJECT_ORDER : 0);
}

static const subject_kind *kind_of(const duet_tune_def *def)
{
    const subject_kind *const *kind = kinds;
    while ((*kind)->asked_by && !((*kind)->asked_by & asked(def)))
        ++kind;
    return *kind;
}

bool subject_check(const duet_tune_def *def, duet_error *err)
{
    const subject_kind *kind = kind_of(def);
    unsigned foreign = asked(def) & ~kind->takes;
    for (uint32_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (foreign & 1u << i)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s no %s; expected none", kind->has,
                             names[i]);
    return !kind->check || kind->check(def, err);
}

void subject_complete(duet_tune_def *def)
{
    const subject_kind *kind = kind_of(def);
    if (kind->searches && !def->search)
        def->search = "kernels";
    if (kind->has_one_way) {
        def->modes = modes;
        def->n_modes = 1;
    }
    if (kind->has_one_way && def->n_variants == 0) {
        def->variants = variants;
        def->n_variants = 1;
    }
    if (kind->complete)
        kind->complete(def);
}

bool subject_prepare(subject *s, const duet_tune_def *def, duet_device_pair *pair,
                     core_watch *cores, duet_error *err)
{
    *s = (subject){.kind = kind_of(def),
                   .def = def,
                   .pair = pair,
                   .cores = cores,
                   .plan = duet_default_plan(pair),
                   .one_device = duet_device_pair_is_one(pair)};
    if (s->kind->has_one_way) {
        s->plan.mode = modes[0];
        plan_set_variants(&s->plan, variants[0]);
    }
    return s->kind->open(s, err);
}

void subject_release(subject *s)
{
    if (s->kind)
        s->kind->close(s);
    *s = (subject){0};
}

duet_level subject_level(const subject *s)
{
    return s->kind->level ? s->kind->level(s) : DUET_LEVEL_CERTIFIED;
}

measure_machine subject_machine(subject *s, uint64_t hash)
{
    measure_machine machine = s->kind->machine;
    machine.context = s;
    machine.hash = hash;
    return machine;
}
