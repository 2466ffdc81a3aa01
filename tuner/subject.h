// SPDX-License-Identifier: MIT
// What is tuned: a kind of work that plans divide between two devices.
//
// A kind says how its work is opened on a device pair, how a plan launches it, and what is right.
// Measurements, races, verdicts and the record exist once, for all kinds. A new kind is a file, and
// a row in subject.c.
#ifndef TUNER_SUBJECT_H
#define TUNER_SUBJECT_H

#include "runtime/selection/profile_subject.h"
#include "tuner/measure.h"

// One piece of work on one device pair. The def, pair and cores must live as long.
typedef struct subject {
    const struct subject_kind *kind; // NULL: not open
    const duet_tune_def *def;
    duet_device_pair *pair;
    core_watch *cores; // NULL: nobody looks at other programs
    void *state;       // the kind's own
    duet_plan plan;    // its variants are the defaults that must work
    uint64_t units;    // that a share divides: objects, items
    bool one_device;   // the two devices have nothing to share
    double launch_ms;  // that all of the work takes, about; 0: it is not known
} subject;

// The result that every launch must find, and how right that is.
typedef struct subject_truth {
    uint64_t hash;
    uint64_t pairs; // that collide, or hits; 0: none are counted
    duet_accuracy accuracy;
} subject_truth;

// Each thing that a def may ask for: ASK(name, in words, whether the def asks for it).
#define SUBJECT_ASKS(ASK)                                                \
    ASK(TASK, "task", def->task)                                         \
    ASK(STEPS, "steps", def->steps)                                      \
    ASK(QUERY, "query", def->query)                                      \
    ASK(SCENE, "scene", def->scene)                                      \
    ASK(ITEMS, "items of a query", def->items)                           \
    ASK(SEARCH, "search", def->search)                                   \
    ASK(VARIANTS, "variants", def->n_variants)                           \
    ASK(MODES, "modes", def->n_modes)                                    \
    ASK(LEVELS, "level or accuracy", def->n_levels || def->has_accuracy) \
    ASK(ORDER, "order", def->ordered)

#define PLACE(name, words, asked) SUBJECT_PLACE_##name,
enum { SUBJECT_ASKS(PLACE) };
#undef PLACE
#define BIT(name, words, asked) SUBJECT_##name = 1 << SUBJECT_PLACE_##name,
enum { SUBJECT_ASKS(BIT) };
#undef BIT

typedef struct subject_kind {
    const char *has;   // "a task has", for what it cannot be asked for
    unsigned asked_by; // a def that asks for this is of the kind
    unsigned takes;    // the most that a def may ask for
    bool searches;     // kernels, unless the def says which
    bool has_one_way;  // each device has grids and kernels of its own: mode own, variant auto
    bool (*check)(const duet_tune_def *def, duet_error *err); // NULL: nothing is left to check
    void (*complete)(duet_tune_def *def); // fills in what else the def leaves open; or NULL
    // Fills state and units, and what differs of plan and one_device. Closed also after a failure.
    bool (*open)(subject *s, duet_error *err);
    void (*close)(subject *s);
    bool (*describe)(subject *s, profile_subject *p, duet_error *err);
    // Sets the level that is tuned and tells it; NULL: the kind has no levels.
    bool (*set_level)(subject *s, duet_level level, duet_error *err);
    duet_level (*level)(const subject *s);
    // NULL: each launch is checked by itself.
    bool (*find_truth)(subject *s, subject_truth *truth, duet_error *err);
    measure_machine machine; // its functions; the context is the subject
    bool lives_on_one;       // its state is on one device: A alone may be the better one for it
} subject_kind;

extern const subject_kind subject_still, subject_query, subject_motion, subject_task;

// Checks that the def asks for nothing that its kind has not; BAD_ARGUMENT.
bool subject_check(const duet_tune_def *def, duet_error *err);

// Fills in what the def leaves open.
void subject_complete(duet_tune_def *def);

// Closed by subject_release, also after a failure.
bool subject_prepare(subject *s, const duet_tune_def *def, duet_device_pair *pair,
                     core_watch *cores, duet_error *err);
void subject_release(subject *s); // an unopened one is passed over

duet_level subject_level(const subject *s); // certified if the kind has no levels
measure_machine subject_machine(subject *s, uint64_t hash);

// A still step's times as strategies want them: each device's from the step's begin.
search_sample measure_sample(const duet_result *result, const duet_plan *plan);

#endif
