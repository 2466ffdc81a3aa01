// SPDX-License-Identifier: MIT
// A stands where the paper has the CPU and B where it has the GPU.
#include "tuner/terms.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

// Which term a stage of a device counts to.
typedef struct row {
    const char *stage;
    size_t at[2]; // A's, B's
} row;

#define AT(term) offsetof(duet_tune_terms, term)

// A's own grid is work that A does before its search, so it is A's time. Only
// B's pairs cross the bus in the paper; where A's do, that ends A's work.
static const row rows[] = {
    {"send objects", {AT(bus2), AT(t1)}},  {"hash", {AT(cpu1), AT(t1)}},
    {"sort", {AT(cpu1), AT(t1)}},          {"bounds", {AT(cpu1), AT(t1)}},
    {"reorder", {AT(cpu1), AT(gpu1)}},     {"cell start", {AT(cpu1), AT(gpu1)}},
    {"clear", {AT(cpu1), AT(gpu2)}},       {"candidates", {AT(cpu1), AT(gpu2)}},
    {"narrow", {AT(cpu2), AT(gpu3)}},      {"decide", {AT(cpu2), AT(gpu3)}},
    {"send grid", {AT(bus1), AT(bus1)}},   {"receive grid", {AT(bus2), AT(bus2)}},
    {"fetch pairs", {AT(cpu2), AT(bus3)}},
};

// What equation 4 leaves over: A's side less B's, as part of the longer.
static double imbalance(const duet_tune_terms *t, bool shared)
{
    double a = t->bus1 + t->bus2 + t->cpu1 + t->cpu2;
    double b = t->gpu1 + t->gpu2 + t->gpu3 + t->bus3 + (shared ? 0 : t->t1);
    double longer = fmax(a, b);
    return longer > 0 ? (a - b) / longer : 0;
}

duet_tune_terms terms_of(const duet_result *result, const duet_plan *plan)
{
    duet_tune_terms terms = {0};
    for (uint32_t i = 0; i < result->n_stages; ++i) {
        const duet_stage *stage = &result->stages[i];
        for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
            if (strcmp(stage->name, rows[k].stage) == 0)
                *(double *)((char *)&terms + rows[k].at[stage->device]) += stage->ms;
        }
    }
    terms.imbalance = imbalance(&terms, plan->mode == DUET_MODE_SHARED);
    return terms;
}

const terms_field terms_fields[] = {
    {"T_1", AT(t1)},
    {"T_CPU1", AT(cpu1)},
    {"T_CPU2", AT(cpu2)},
    {"T_GPU1", AT(gpu1)},
    {"T_GPU2", AT(gpu2)},
    {"T_GPU3", AT(gpu3)},
    {"T_BUS1", AT(bus1)},
    {"T_BUS2", AT(bus2)},
    {"T_BUS3", AT(bus3)},
    {"imbalance", AT(imbalance)},
    {NULL, 0},
};

static double *value_of(const terms_field *f, duet_tune_terms *terms)
{
    return (double *)((char *)terms + f->at);
}

double terms_value(const terms_field *f, const duet_tune_terms *terms)
{
    return *(const double *)((const char *)terms + f->at);
}

void terms_to_json(const duet_tune_terms *terms, text *json)
{
    for (const terms_field *f = terms_fields; f->name; ++f)
        text_add(json, "%c\"%s\":%.6f", f == terms_fields ? '{' : ',', f->name,
                 terms_value(f, terms));
    text_add(json, "}");
}

void terms_from_json(const cJSON *json, duet_tune_terms *terms)
{
    *terms = (duet_tune_terms){0};
    for (const terms_field *f = terms_fields; f->name; ++f) {
        const cJSON *number = cJSON_GetObjectItemCaseSensitive(json, f->name);
        *value_of(f, terms) = cJSON_IsNumber(number) ? number->valuedouble : 0;
    }
}
