// SPDX-License-Identifier: MIT
// The terms of the paper's equations 4 to 6 by their names, and as JSON.
#ifndef TUNER_TERMS_H
#define TUNER_TERMS_H

#include "base/text.h"
#include "tuner/duet_tune.h"

// The terms by the names that the paper has for them; the last is {NULL}.
typedef struct terms_field {
    const char *name;
    size_t at; // in duet_tune_terms
} terms_field;

extern const terms_field terms_fields[];
double terms_value(const terms_field *field, const duet_tune_terms *terms);

// {"T_1":..,"T_CPU1":..,...,"imbalance":..,"joules":..}, milliseconds. Missing terms come back as
// 0, and what is no object as all 0.
void terms_to_json(const duet_tune_terms *terms, text *json);
void terms_from_json(const char *json, duet_tune_terms *terms);

#endif
