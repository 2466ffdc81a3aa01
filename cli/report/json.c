// SPDX-License-Identifier: MIT
#include "cli/report/json.h"

#include "base/error.h"
#include "base/text_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MOST 0x1p53

cJSON *json_read(const char *path, duet_error *err)
{
    text chars = {0};
    if (!text_read_lines(&chars, path, err))
        return NULL;
    const char *end = NULL;
    cJSON *o = cJSON_ParseWithOpts(text_chars(&chars), &end, true);
    if (o && end != chars.chars + chars.length) { // a NUL, and what follows it
        cJSON_Delete(o);
        o = NULL;
    }
    text_free(&chars);
    if (!o)
        error_set(err, DUET_STATUS_BAD_INPUT, "%s: not JSON", path);
    return o;
}

bool json_write(const cJSON *o, text *t, duet_error *err)
{
    char *chars = cJSON_Print(o);
    if (!chars)
        return error_set(err, DUET_STATUS_NO_MEMORY, "the JSON object: no memory");
    text_add_json(t, chars);
    cJSON_free(chars);
    return text_ok(t, err);
}

void json_add_object(cJSON *o, const char *name, const char *chars)
{
    cJSON *object = chars ? cJSON_ParseWithOpts(chars, NULL, true) : NULL;
    if (cJSON_IsObject(object))
        cJSON_AddItemToObject(o, name, object);
    else
        cJSON_Delete(object);
}

void json_add_plan(cJSON *o, double share, const char *mode, const char *variant_a,
                   const char *variant_b)
{
    cJSON_AddNumberToObject(o, "share", share);
    cJSON_AddStringToObject(o, "mode", mode);
    cJSON_AddStringToObject(o, "variant_a", variant_a);
    cJSON_AddStringToObject(o, "variant_b", variant_b);
}

void json_add_figure(cJSON *o, const char *name, double value)
{
    cJSON_AddItemToObject(o, name, isnan(value) ? cJSON_CreateNull() : cJSON_CreateNumber(value));
}

void json_add_interval(cJSON *o, const char *name, double value, double low, double high)
{
    char bound[64];
    json_add_figure(o, name, value);
    snprintf(bound, sizeof bound, "%s_low", name);
    json_add_figure(o, bound, low);
    snprintf(bound, sizeof bound, "%s_high", name);
    json_add_figure(o, bound, high);
}

void json_add_rates(cJSON *o, double true_pairs, double missed, double false_rate)
{
    bool measured = true_pairs >= 1;
    json_add_figure(o, "missed_rate", measured ? missed : NAN);
    json_add_figure(o, "false_rate", measured ? false_rate : NAN);
    json_add_figure(o, "true_pairs", measured ? true_pairs : NAN);
}

void json_add_whole(cJSON *o, double ms, double gain, double low, double high)
{
    bool raced = ms > 0;
    json_add_figure(o, "whole_ms", raced ? ms : NAN);
    json_add_interval(o, "whole_gain", raced ? gain : NAN, raced ? low : NAN, raced ? high : NAN);
}

void json_add_hash(cJSON *o, uint64_t hash)
{
    char digits[17];
    snprintf(digits, sizeof digits, "%016" PRIx64, hash);
    cJSON_AddStringToObject(o, "hash", digits);
}

void json_add_lines(cJSON *o, const char *name, const char *lines)
{
    cJSON *list = cJSON_AddArrayToObject(o, name);
    while (*lines) {
        char line[512];
        int length = (int)strcspn(lines, "\n");
        snprintf(line, sizeof line, "%.*s", length, lines);
        cJSON_AddItemToArray(list, cJSON_CreateString(line));
        lines += length + (lines[length] == '\n');
    }
}

cJSON *json_add_row(cJSON *list)
{
    cJSON *row = cJSON_CreateObject();
    cJSON_AddItemToArray(list, row);
    return row;
}

void json_add_stages(cJSON *o, const duet_stage *stages, uint32_t n)
{
    cJSON *list = cJSON_AddArrayToObject(o, "stages");
    for (uint32_t i = 0; i < n; ++i) {
        cJSON *stage = json_add_row(list);
        cJSON_AddStringToObject(stage, "name", stages[i].name);
        cJSON_AddStringToObject(stage, "device", stages[i].device == 0 ? "A" : "B");
        cJSON_AddNumberToObject(stage, "ms", stages[i].ms);
        cJSON_AddBoolToObject(stage, "transfer", stages[i].transfer);
        cJSON_AddNumberToObject(stage, "begin_ms", stages[i].begin_ms);
        cJSON_AddNumberToObject(stage, "end_ms", stages[i].end_ms);
    }
}

void json_add_devices(cJSON *o, const duet_device_pair *pair)
{
    cJSON_AddStringToObject(o, "a", duet_device_pair_get_info(pair, 0)->selector);
    cJSON_AddStringToObject(o, "b", duet_device_pair_get_info(pair, 1)->selector);
}

void json_add_cores(cJSON *o, const core_tally *cores)
{
    if (cores->of == 0)
        return;
    cJSON_AddNumberToObject(o, "watched", (double)cores->launches);
    cJSON_AddNumberToObject(o, "disturbed", (double)cores->disturbed);
    cJSON_AddNumberToObject(o, "cpu_load", fmin(cores->others / cores->of, 1));
}

void json_add_pair(cJSON *o, const char *name, const duet_device_pair *pair)
{
    char both[256];
    snprintf(both, sizeof both, "%s,%s", duet_device_pair_get_info(pair, 0)->selector,
             duet_device_pair_get_info(pair, 1)->selector);
    cJSON_AddStringToObject(o, name, both);
}

bool json_require(const cJSON *o, const json_field *fields, const char *where, duet_error *err)
{
    for (const json_field *f = fields; f->name; ++f)
        if (!f->is(cJSON_GetObjectItemCaseSensitive(o, f->name)))
            return error_set(err, DUET_STATUS_BAD_INPUT, "%s: '%s' is not %s", where, f->name,
                             f->what);
    return true;
}

bool json_require_each(const cJSON *list, const json_field *fields, const char *path,
                       const char *what, duet_error *err)
{
    int number = 0;
    const cJSON *one;
    cJSON_ArrayForEach(one, list)
    {
        char where[512];
        snprintf(where, sizeof where, "%.400s: %s %d", path, what, number++);
        if (!json_require(one, fields, where, err))
            return false;
    }
    return true;
}

cJSON_bool json_is_amount(const cJSON *item)
{
    return cJSON_IsNumber(item) && item->valuedouble >= 0 && item->valuedouble <= MOST;
}

cJSON_bool json_is_count(const cJSON *item)
{
    return json_is_amount(item) && item->valuedouble == floor(item->valuedouble);
}

double json_number(const cJSON *o, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, name);
    return cJSON_IsNumber(item) && fabs(item->valuedouble) <= MOST ? item->valuedouble : 0;
}

const char *json_string(const cJSON *o, const char *name)
{
    const char *string = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(o, name));
    return string ? string : "";
}

bool json_true(const cJSON *o, const char *name)
{
    return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(o, name));
}

const cJSON *json_list(const cJSON *o, const char *name)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(o, name);
    return cJSON_IsArray(list) ? list : NULL;
}
