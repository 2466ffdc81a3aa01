// SPDX-License-Identifier: MIT
#include "tuner/trial_log.h"

#include "base/list.h"
#include "tuner/terms.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

void trial_log_free(trial_log *t)
{
    free(t->entries);
    *t = (trial_log){0};
}

bool trial_log_add(trial_log *t, const trial *entry, duet_error *err)
{
    trial *entries = list_room(t->entries, t->n, sizeof *entries, err);
    if (!entries)
        return false;
    t->entries = entries;
    t->entries[t->n++] = *entry;
    return true;
}

bool trial_log_same_plan(const duet_plan *a, const duet_plan *b)
{
    return a->share == b->share && a->mode == b->mode && strcmp(a->variant_a, b->variant_a) == 0 &&
           strcmp(a->variant_b, b->variant_b) == 0;
}

const trial *trial_log_next(trial_log *t, const duet_plan *plan)
{
    if (t->played == t->n)
        return NULL;
    const trial *entry = &t->entries[t->played];
    if (!trial_log_same_plan(&entry->plan, plan)) {
        t->n = t->played;
        return NULL;
    }
    ++t->played;
    return entry;
}

const trial *trial_log_of(const trial_log *t, const duet_plan *plan, const trial *after)
{
    const trial *end = t->entries + t->played, *at = after ? after + 1 : t->entries;
    while (at < end && !(at->usable && trial_log_same_plan(&at->plan, plan)))
        ++at;
    return at < end ? at : NULL;
}

// ---------------------------------------------------------------- JSON

// Variants are words, names and numbers: nothing that JSON would escape.
void trial_log_to_json(const trial_log *t, text *json)
{
    text_add(json, "{\"trials\":[");
    for (uint32_t i = 0; i < t->n; ++i) {
        const trial *e = &t->entries[i];
        text_add(json, "%s[%" PRIu32 ",%d,\"%s\",\"%s\",", i ? "," : "", e->plan.share,
                 (int)e->plan.mode, e->plan.variant_a, e->plan.variant_b);
        text_add(json, "%d,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",", e->usable, e->sample.total_ns,
                 e->sample.a_ns, e->sample.b_ns);
        text_add(json, "%" PRIu32 ",%" PRIu64 ",", e->launches, e->spent_ns);
        terms_to_json(&e->terms, json);
        text_add(json, ",%" PRIu64 ",%" PRIu32 ",%" PRIu32 "]", e->focus_ns, e->watched,
                 e->disturbed);
    }
    text_add(json, "]}");
}

// Reads the row's next item and steps on; at is NULL past the end.
static bool next_number(const cJSON **at, double most, uint64_t *number)
{
    bool ok = cJSON_IsNumber(*at) && (*at)->valuedouble >= 0 && (*at)->valuedouble <= most;
    *number = ok ? (uint64_t)(*at)->valuedouble : 0;
    *at = *at ? (*at)->next : NULL;
    return ok;
}

static bool next_variant(const cJSON **at, char variant[DUET_VARIANT])
{
    bool ok = cJSON_IsString(*at) && strlen((*at)->valuestring) < DUET_VARIANT;
    if (ok)
        strcpy(variant, (*at)->valuestring);
    *at = *at ? (*at)->next : NULL;
    return ok;
}

static bool read_entry(const cJSON *row, trial *e)
{
    uint64_t share = 0, mode = 0, usable = 0, launches = 0, watched = 0, disturbed = 0;
    const cJSON *at = row->child;
    bool ok = next_number(&at, DUET_SHARE_ONE, &share) && next_number(&at, 255, &mode) &&
              next_variant(&at, e->plan.variant_a) && next_variant(&at, e->plan.variant_b) &&
              next_number(&at, 1, &usable) && next_number(&at, 0x1p53, &e->sample.total_ns) &&
              next_number(&at, 0x1p53, &e->sample.a_ns) &&
              next_number(&at, 0x1p53, &e->sample.b_ns) &&
              next_number(&at, UINT32_MAX, &launches) && next_number(&at, 0x1p53, &e->spent_ns);
    e->plan.share = e->sample.share = (uint32_t)share;
    e->plan.mode = (duet_mode)mode;
    e->usable = usable;
    e->launches = (uint32_t)launches;
    terms_from_json(at, &e->terms); // a log of the store's first version has none
    at = at ? at->next : NULL;
    // Logs of older versions of the store end before one of these.
    ok = ok && (!at || next_number(&at, 0x1p53, &e->focus_ns));
    ok = ok && (!at || (next_number(&at, UINT32_MAX, &watched) &&
                        next_number(&at, (double)watched, &disturbed)));
    e->watched = (uint32_t)watched;
    e->disturbed = (uint32_t)disturbed;
    return ok && !at;
}

static bool read_log(const cJSON *rows, trial_log *t, duet_error *err)
{
    const cJSON *row;
    if (!cJSON_IsArray(rows))
        return error_set(err, DUET_STATUS_BAD_INPUT, "search state: not one that a tuning wrote");
    cJSON_ArrayForEach(row, rows)
    {
        trial entry = {0};
        if (!read_entry(row, &entry))
            return error_set(err, DUET_STATUS_BAD_INPUT,
                             "search state: trial %" PRIu32 " is malformed", t->n);
        if (!trial_log_add(t, &entry, err))
            return false;
    }
    return true;
}

bool trial_log_from_json(trial_log *t, const char *json, duet_error *err)
{
    *t = (trial_log){0};
    cJSON *root = cJSON_ParseWithOpts(json, NULL, true);
    bool ok = read_log(cJSON_GetObjectItemCaseSensitive(root, "trials"), t, err);
    cJSON_Delete(root);
    if (!ok)
        trial_log_free(t);
    return ok;
}
