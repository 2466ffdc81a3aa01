// SPDX-License-Identifier: MIT
#include "tuner/terms.h"

#include <cjson/cJSON.h>
#include <stddef.h>

#define AT(term) offsetof(duet_tune_terms, term)

const terms_field terms_fields[] = {
    {"T_1", AT(t1)},        {"T_CPU1", AT(cpu1)},
    {"T_CPU2", AT(cpu2)},   {"T_GPU1", AT(gpu1)},
    {"T_GPU2", AT(gpu2)},   {"T_GPU3", AT(gpu3)},
    {"T_BUS1", AT(bus1)},   {"T_BUS2", AT(bus2)},
    {"T_BUS3", AT(bus3)},   {"imbalance", AT(imbalance)},
    {"joules", AT(joules)}, {NULL, 0},
};

double terms_value(const terms_field *f, const duet_tune_terms *terms)
{
    return *(const double *)((const char *)terms + f->at);
}

void terms_to_json(const duet_tune_terms *terms, text *json)
{
    for (const terms_field *f = terms_fields; f->name; ++f)
        text_add(json, "%c\"%s\":%.9g", f == terms_fields ? '{' : ',', f->name,
                 terms_value(f, terms));
    text_add(json, "}");
}

void terms_from_json(const char *json, duet_tune_terms *terms)
{
    cJSON *row = cJSON_Parse(json);
    *terms = (duet_tune_terms){0};
    for (const terms_field *f = terms_fields; f->name; ++f) {
        const cJSON *number = cJSON_GetObjectItemCaseSensitive(row, f->name);
        *(double *)((char *)terms + f->at) = cJSON_IsNumber(number) ? number->valuedouble : 0;
    }
    cJSON_Delete(row);
}
