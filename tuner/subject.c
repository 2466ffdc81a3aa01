// SPDX-License-Identifier: MIT
#include "tuner/subject.h"

#include "base/error.h"
#include "tuner/tune.h"

// The first that is asked for; a still step is what is left.
static const subject_kind *const kinds[] = {&subject_task, &subject_motion, &subject_query,
                                            &subject_still};

static const duet_mode modes[] = {DUET_MODE_OWN};
static const char *const variants[] = {"auto"};

#define WORDS(name, words, asked) words,
static const char *const names[] = {SUBJECT_ASKS(WORDS)};

#define IF_ASKED(name, words, asked) ((asked) ? SUBJECT_##name : 0) |
static unsigned asked(const duet_tune_def *def)
{
    return SUBJECT_ASKS(IF_ASKED) 0;
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
            return bad_argument(err, "%s no %s; expected none", kind->has, names[i]);
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

static core_others look_at_others(void *context)
{
    return core_watch_others(((subject *)context)->cores);
}

measure_machine subject_machine(subject *s, uint64_t hash)
{
    measure_machine machine = s->kind->machine;
    machine.context = s;
    machine.look_at_others = look_at_others;
    machine.hash = hash;
    machine.launch_ms = s->launch_ms;
    return machine;
}
