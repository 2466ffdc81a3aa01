// SPDX-License-Identifier: MIT
#include "tuner/subject.h"

// The first that is asked for; a still step is what is left.
static const subject_kind *const kinds[] = {&subject_task, &subject_query, &subject_motion,
                                            &subject_still};

const subject_kind *subject_kind_of(const duet_tune_def *def)
{
    const subject_kind *const *kind = kinds;
    while (!(*kind)->is_asked(def))
        ++kind;
    return *kind;
}

bool subject_prepare(subject *s, const duet_tune_def *def, duet_device_pair *pair,
                     core_watch *cores, duet_error *err)
{
    *s = (subject){.kind = subject_kind_of(def),
                   .def = def,
                   .pair = pair,
                   .cores = cores,
                   .plan = duet_default_plan(pair),
                   .one_device = duet_device_pair_is_one(pair)};
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
    return (measure_machine){
        .context = s, .launch = s->kind->launch, .hash = hash, .train = s->kind->train};
}
