// SPDX-License-Identifier: MIT
#include "support/json.h"

#include "support/test.h"

static void free_json(void *o)
{
    cJSON_Delete(o);
}

cJSON *json_of(const char *chars)
{
    const char *end = NULL;
    cJSON *o = cJSON_ParseWithOpts(chars, &end, false);
    if (!cJSON_IsObject(o) || (strcmp(end, "") != 0 && strcmp(end, "\n") != 0))
        fail_msg("no JSON object: '%s'", chars);
    return test_keep(o, free_json);
}

cJSON *json_of_program(program p)
{
    if (p.exit_code != 0)
        fail_msg("exit %d: %s", p.exit_code, p.err);
    assert_string_equal(p.err, "");
    assert_true(*p.out && p.out[strlen(p.out) - 1] == '\n');
    return json_of(p.out);
}

cJSON *json_of_run(const char *arguments, ...)
{
    va_list args;
    va_start(args, arguments);
    program p = program_run_list("", arguments, args);
    va_end(args);
    return json_of_program(p);
}

cJSON *json_of_run_with(const char *variables, const char *arguments, ...)
{
    va_list args;
    va_start(args, arguments);
    program p = program_run_list(variables, arguments, args);
    va_end(args);
    return json_of_program(p);
}

const cJSON *json_field(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);
    if (!item)
        fail_msg("no '%s'", key);
    return item;
}

int json_size(const cJSON *o, const char *key)
{
    return cJSON_GetArraySize(json_field(o, key));
}

double json_number(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);
    if (!cJSON_IsNumber(item))
        fail_msg("no number '%s'", key);
    return item->valuedouble;
}

const char *json_string(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);
    if (!cJSON_IsString(item))
        fail_msg("no string '%s'", key);
    return item->valuestring;
}

bool json_true(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);
    if (!cJSON_IsBool(item))
        fail_msg("no truth '%s'", key);
    return cJSON_IsTrue(item);
}

const cJSON *json_array(const cJSON *o, const char *key, int n)
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(o, key);
    assert_true(cJSON_IsArray(array));
    assert_int_equal(cJSON_GetArraySize(array), n);
    return array;
}

const cJSON *json_row(const cJSON *o, const char *key, int i)
{
    const cJSON *row = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(o, key), i);
    if (!row)
        fail_msg("no row %d of '%s'", i, key);
    return row;
}

void get_hash(const char *arguments, char hash[32], double *steps)
{
    const cJSON *o = json_of_run("%s", arguments);
    snprintf(hash, 32, "%s", json_string(o, "hash"));
    *steps = json_number(o, "steps");
    assert_true(json_number(o, "step") == atof(strstr(arguments, "--steps ") + strlen("--steps ")));
}
