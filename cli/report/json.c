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
        bad_input(err, "%s: not JSON", path);
    return o;
}

bool json_write(const cJSON *o, text *t, duet_error *err)
{
    char *chars = cJSON_Print(o);
    if (!chars)
        return no_memory(err, "the JSON object");
    text_add_json(t, chars);
    cJSON_free(chars);
    return text_ok(t, err);
}

static cJSON *make(const json_member *m)
{
    return m->kind == JSON_STRING ? cJSON_CreateString(m->string)
           : m->kind == JSON_FLAG ? cJSON_CreateBool(m->number != 0)
           : isnan(m->number)     ? cJSON_CreateNull()
                                  : cJSON_CreateNumber(m->number);
}

void json_add_members(cJSON *o, const json_member *members, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        if (members[i].kind != JSON_STRING || members[i].string)
            cJSON_AddItemToObject(o, members[i].name, make(&members[i]));
}

void json_add_plan(cJSON *o, double share, const char *mode, const char *variant_a,
                   const char *variant_b)
{
    json_add(o, NUMBER("share", share), STRING("mode", mode), STRING("variant_a", variant_a),
             STRING("variant_b", variant_b));
}

void json_add_rates(cJSON *o, double true_pairs, double missed, double false_rate)
{
    bool measured = true_pairs >= 1;
    json_add(o, NUMBER("missed_rate", measured ? missed : NAN),
             NUMBER("false_rate", measured ? false_rate : NAN),
             NUMBER("true_pairs", measured ? true_pairs : NAN));
}

void json_add_whole(cJSON *o, double ms, double gain, double low, double high)
{
    bool raced = ms > 0;
    json_add(o, NUMBER("whole_ms", raced ? ms : NAN),
             INTERVAL("whole_gain", raced ? gain : NAN, raced ? low : NAN, raced ? high : NAN));
}

void json_add_hash(cJSON *o, uint64_t hash)
{
    char digits[17];
    snprintf(digits, sizeof digits, "%016" PRIx64, hash);
    json_add(o, STRING("hash", digits));
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
        json_add(stage, STRING("name", stages[i].name),
                 STRING("device", stages[i].device == 0 ? "A" : "B"), NUMBER("ms", stages[i].ms),
                 FLAG("transfer", stages[i].transfer), NUMBER("begin_ms", stages[i].begin_ms),
                 NUMBER("end_ms", stages[i].end_ms));
    }
}

void json_add_devices(cJSON *o, const duet_device_pair *pair)
{
    const duet_device_info *a = duet_device_pair_get_info(pair, 0);
    const duet_device_info *b = duet_device_pair_get_info(pair, 1);
    json_add(o, STRING("a", a->selector), STRING("b", b->selector), STRING("a_name", a->name),
             STRING("b_name", b->name));
}

void json_add_cores(cJSON *o, const core_tally *cores)
{
    if (cores->of == 0)
        return;
    json_add(o, NUMBER("watched", cores->launches), NUMBER("disturbed", cores->disturbed),
             NUMBER("cpu_load", fmin(cores->others / cores->of, 1)));
}

void json_add_pair(cJSON *o, const char *name, const duet_device_pair *pair)
{
    char both[256];
    snprintf(both, sizeof both, "%s,%s", duet_device_pair_get_info(pair, 0)->selector,
             duet_device_pair_get_info(pair, 1)->selector);
    json_add(o, STRING(name, both));
}

bool json_require(const cJSON *o, const json_field *fields, const char *where, duet_error *err)
{
    for (const json_field *f = fields; f->name; ++f)
        if (!f->is(cJSON_GetObjectItemCaseSensitive(o, f->name)))
            return bad_input(err, "%s: '%s' is not %s", where, f->name, f->what);
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

const cJSON *json_list(const cJSON *o, const char *name)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(o, name);
    return cJSON_IsArray(list) ? list : NULL;
}
