// SPDX-License-Identifier: MIT
#include "tuner/search.h"

#include "base/budget.h"
#include "tuner/strategy.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

search_options search_default_options(void)
{
    return (search_options){.quantum = 8, .points = 32, .rounds = 3, .probe_cost = 3.0};
}

static bool fail_unknown(const char *name, duet_error *err)
{
    text known = {0};
    for (uint32_t i = 0; strategies[i]; ++i)
        text_add(&known, "%s%s", i ? ", " : "", strategies[i]->name);
    error_set(err, DUET_STATUS_NOT_FOUND, "strategy '%s': there is none; there are %s", name,
              text_chars(&known));
    text_free(&known);
    return false;
}

bool search_begin(search *s, const char *name, const search_options *options, duet_error *err)
{
    *s = (search){.strategy = strategy_find(name)};
    if (!s->strategy)
        return fail_unknown(name, err);
    s->options = options ? *options : search_default_options();
    if (s->options.quantum == 0)
        s->options.quantum = 1;
    return true;
}

void search_end(search *s)
{
    free(s->samples);
    *s = (search){0};
}

static uint32_t most_launches(const search *s)
{
    return s->options.launches ? s->options.launches : s->strategy->launches;
}

bool search_ask(const search *s, search_next *next, duet_error *err)
{
    *next = (search_next){.done = true};
    uint32_t most = most_launches(s);
    if (most && s->n >= most)
        return true;
    return s->strategy->ask(s, next, err);
}

bool search_tell(search *s, const search_sample *sample, duet_error *err)
{
    if (s->n == s->capacity) {
        uint32_t capacity = s->capacity ? 2 * s->capacity : 32;
        if (!budget_space(capacity * sizeof *s->samples, err))
            return false;
        search_sample *grown = realloc(s->samples, capacity * sizeof *grown);
        if (!grown)
            return error_set(err, DUET_STATUS_NO_MEMORY,
                             "a search of %" PRIu32 " launches: no memory", s->n + 1);
        s->samples = grown;
        s->capacity = capacity;
    }
    s->samples[s->n++] = *sample;
    return true;
}

uint32_t search_pick(const search *s)
{
    return s->n ? s->strategy->pick(s) : 0;
}

void search_bracket(const search *s, uint32_t *low, uint32_t *high)
{
    *low = 0;
    *high = SEARCH_ONE;
    if (s->strategy->bracket)
        s->strategy->bracket(s, low, high);
}

const search_sample *search_fastest(const search *s)
{
    const search_sample *fastest = NULL;
    for (uint32_t i = 0; i < s->n; ++i) {
        if (!fastest || s->samples[i].total_ns < fastest->total_ns)
            fastest = &s->samples[i];
    }
    return fastest;
}

const search_sample *search_at(const search *s, uint32_t share)
{
    for (uint32_t i = 0; i < s->n; ++i) {
        if (s->samples[i].share == share)
            return &s->samples[i];
    }
    return NULL;
}

uint32_t search_first_share(const search *s)
{
    bool near = s->options.has_start && s->options.start > 0 && s->options.start < SEARCH_ONE;
    return near ? s->options.start : SEARCH_ONE / 16;
}

void search_to_json(const search *s, text *json)
{
    const search_options *o = &s->options;
    text_add(json, "{\"strategy\":\"%s\",\"launches\":%" PRIu32 ",\"quantum\":%" PRIu32,
             s->strategy->name, o->launches, o->quantum);
    text_add(json, ",\"points\":%" PRIu32 ",\"rounds\":%" PRIu32 ",\"probe_cost\":%.17g", o->points,
             o->rounds, o->probe_cost);
    if (o->has_start)
        text_add(json, ",\"start\":%" PRIu32, o->start);
    text_add(json, ",\"samples\":[");
    for (uint32_t i = 0; i < s->n; ++i) {
        const search_sample *at = &s->samples[i];
        text_add(json, "%s[%" PRIu32 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 "]", i ? "," : "",
                 at->share, at->total_ns, at->a_ns, at->b_ns);
    }
    text_add(json, "]}");
}

// Doubles hold every count below 2^53 exactly: 104 days of nanoseconds.
static bool read_count(const cJSON *item, double most, uint64_t *count)
{
    if (!cJSON_IsNumber(item) || !(item->valuedouble >= 0 && item->valuedouble <= most))
        return false;
    *count = (uint64_t)item->valuedouble;
    return true;
}

static bool read_option(const cJSON *root, const char *name, uint32_t *option)
{
    uint64_t count;
    if (!read_count(cJSON_GetObjectItemCaseSensitive(root, name), UINT32_MAX, &count))
        return false;
    *option = (uint32_t)count;
    return true;
}

static bool read_options(const cJSON *root, search_options *o)
{
    const cJSON *cost = cJSON_GetObjectItemCaseSensitive(root, "probe_cost");
    o->probe_cost = cJSON_IsNumber(cost) ? cost->valuedouble : 0;
    o->has_start = cJSON_HasObjectItem(root, "start");
    return cJSON_IsNumber(cost) && read_option(root, "launches", &o->launches) &&
           read_option(root, "quantum", &o->quantum) && read_option(root, "points", &o->points) &&
           read_option(root, "rounds", &o->rounds) &&
           (!o->has_start || read_option(root, "start", &o->start));
}

static bool read_sample(const cJSON *row, search_sample *sample)
{
    uint64_t share;
    if (cJSON_GetArraySize(row) != 4 || !read_count(row->child, SEARCH_ONE, &share))
        return false;
    sample->share = (uint32_t)share;
    const cJSON *times = row->child->next;
    return read_count(times, 0x1p53, &sample->total_ns) &&
           read_count(times->next, 0x1p53, &sample->a_ns) &&
           read_count(times->next->next, 0x1p53, &sample->b_ns);
}

static bool read_search(const cJSON *root, search *s, duet_error *err)
{
    search_options options;
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(root, "strategy");
    const cJSON *samples = cJSON_GetObjectItemCaseSensitive(root, "samples");
    if (!cJSON_IsString(name) || !cJSON_IsArray(samples) || !read_options(root, &options))
        return error_set(err, DUET_STATUS_BAD_INPUT, "search state: not one that a search wrote");
    if (!search_begin(s, name->valuestring, &options, err))
        return false;
    const cJSON *row;
    cJSON_ArrayForEach(row, samples)
    {
        search_sample sample;
        if (!read_sample(row, &sample))
            return error_set(err, DUET_STATUS_BAD_INPUT,
                             "search state: sample %" PRIu32 " is malformed", s->n);
        if (!search_tell(s, &sample, err))
            return false;
    }
    return true;
}

bool search_from_json(search *s, const char *json, duet_error *err)
{
    *s = (search){0};
    cJSON *root = cJSON_ParseWithOpts(json, NULL, true);
    bool ok = read_search(root, s, err);
    cJSON_Delete(root);
    if (!ok)
        search_end(s);
    return ok;
}
