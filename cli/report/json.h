// SPDX-License-Identifier: MIT
// JSON that the program wrote once and reads again: results of bench, accuracy
// and explain. And the one way in which it writes JSON.
#ifndef CLI_JSON_H
#define CLI_JSON_H

#include "base/core_watch.h"
#include "base/text.h"
#include "runtime/duet.h"

#include <cjson/cJSON.h>
#include <stdbool.h>

// A whole file; BAD_INPUT if it is no JSON.
cJSON *json_read(const char *path, duet_error *err);

// Adds the object's text, in UTF-8 and without control characters, whatever its
// strings hold.
bool json_write(const cJSON *o, text *t, duet_error *err);

// A member of an object: a string (NULL: none), a flag, or a number (NaN: null).
typedef struct json_member {
    const char *name;
    enum { JSON_NUMBER, JSON_STRING, JSON_FLAG } kind;
    double number;
    const char *string;
} json_member;

#define NUMBER(name, value) ((json_member){(name), JSON_NUMBER, (double)(value), NULL})
#define STRING(name, value) ((json_member){(name), JSON_STRING, 0, (value)})
#define FLAG(name, value) ((json_member){(name), JSON_FLAG, (value), NULL})
// NAME, NAME_low and NAME_high.
#define INTERVAL(name, value, low, high) \
    NUMBER(name, value), NUMBER(name "_low", low), NUMBER(name "_high", high)

// Adds members in turn: json_add(o, STRING("mode", mode), NUMBER("ms", ms)).
#define json_add(o, ...)                                    \
    json_add_members(o, (const json_member[]){__VA_ARGS__}, \
                     sizeof((const json_member[]){__VA_ARGS__}) / sizeof(json_member))
void json_add_members(cJSON *o, const json_member *members, size_t n);

// Adds the fields that every plan has: share (0 to 1), mode, variant_a, variant_b.
void json_add_plan(cJSON *o, double share, const char *mode, const char *variant_a,
                   const char *variant_b);

// Adds what a level got wrong of the true pairs. Below 1: it was not measured.
void json_add_rates(cJSON *o, double true_pairs, double missed, double false_rate);

// Adds how the undivided device compares, if its step took more than 0 ms; else null.
void json_add_whole(cJSON *o, double ms, double gain, double low, double high);

// Adds "hash" as 16 hexadecimal digits, for no number of JSON holds 64 bits.
void json_add_hash(cJSON *o, uint64_t hash);

// Adds an array of the lines of a text.
void json_add_lines(cJSON *o, const char *name, const char *lines);

// Adds a new object at a list's end.
cJSON *json_add_row(cJSON *list);

// Adds what other programs did meanwhile: "watched" and "disturbed", which count steps, and
// "cpu_load", the part of the cores that others had. Nothing if it is not known.
void json_add_cores(cJSON *o, const core_tally *cores);

// Adds a field "A,B" from the devices' selectors.
void json_add_pair(cJSON *o, const char *name, const duet_device_pair *pair);

// Adds "stages", a row each.
void json_add_stages(cJSON *o, const duet_stage *stages, uint32_t n);

// Adds the devices' selectors, "a" and "b", and their names, "a_name" and "b_name".
void json_add_devices(cJSON *o, const duet_device_pair *pair);

// A field that must be there; a table of them ends with {0}.
typedef struct json_field {
    const char *name;
    cJSON_bool (*is)(const cJSON *item);
    const char *what; // "a number"
} json_field;

// BAD_INPUT with "WHERE: 'name' is not a number".
bool json_require(const cJSON *o, const json_field *fields, const char *where, duet_error *err);

// The same of each object of a list, where WHERE is "PATH: WHAT NUMBER".
bool json_require_each(const cJSON *list, const json_field *fields, const char *path,
                       const char *what, duet_error *err);

// Kinds for such tables: a whole number, or any, from 0 to 2^53, beyond which no
// result goes; whole numbers are exact up to there.
#define JSON_COUNT json_is_count, "a whole number from 0 to 2^53"
#define JSON_AMOUNT json_is_amount, "a number from 0 to 2^53"
cJSON_bool json_is_count(const cJSON *item);
cJSON_bool json_is_amount(const cJSON *item);

// 0, "" and false if the field is missing or of another kind; 0 for a number
// beyond 2^53 too.
double json_number(const cJSON *o, const char *name);
const char *json_string(const cJSON *o, const char *name);

// The list under that name, for cJSON_ArrayForEach.
const cJSON *json_list(const cJSON *o, const char *name);

#endif
