// SPDX-License-Identifier: MIT
// What a tuning measured, in order: all the state it has.
//
// A tuning decides from its measurements alone. One that was interrupted runs
// again from its beginning and is served from the tape until that ends; then
// it measures on. So it ends as if it had never stopped.
#ifndef TUNER_TAPE_H
#define TUNER_TAPE_H

#include "runtime/base/text.h"
#include "tuner/duet_tune.h"
#include "tuner/search.h"

typedef struct tape_entry {
    duet_plan plan;
    bool usable;           // it built, ran and found the right pairs
    search_sample sample;  // its typical launch
    duet_tune_terms terms; // of that one
    uint32_t launches;
    uint64_t spent_ns;
} tape_entry;

typedef struct tape {
    tape_entry *entries;
    uint32_t n;
    uint32_t capacity;
    uint32_t played; // entries that were served again
} tape;

void tape_free(tape *t);
bool tape_add(tape *t, const tape_entry *entry, duet_error *err);

bool tape_same_plan(const duet_plan *a, const duet_plan *b);

// The next entry to serve, if it is for this plan; NULL at the end. Where it is
// for another plan something that decides has changed: the rest is forgotten.
const tape_entry *tape_play(tape *t, const duet_plan *plan);

void tape_to_json(const tape *t, text *json);
// BAD_INPUT for text that no tape wrote.
bool tape_from_json(tape *t, const char *json, duet_error *err);

#endif
