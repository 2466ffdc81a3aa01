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

void terms_to_json(const duet_tune_terms *t, text *json)
{
    text_add(json, "{\"T_1\":%.6f,\"T_CPU1\":%.6f,\"T_CPU2\":%.6f,", t->t1, t->cpu1, t->cpu2);
    text_add(json, "\"T_GPU1\":%.6f,\"T_GPU2\":%.6f,\"T_GPU3\":%.6f,", t->gpu1, t->gpu2, t->gpu3);
    text_add(json, "\"T_BUS1\":%.6f,\"T_BUS2\":%.6f,\"T_BUS3\":%.6f,", t->bus1, t->bus2, t->bus3);
    text_add(json, "\"imbalance\":%.6f}", t->imbalance);
}
