// SPDX-License-Identifier: MIT
// JSON that the program printed. Whatever is not there fails the test.
#ifndef TESTS_JSON_H
#define TESTS_JSON_H

#include "support/program.h"

#include <cjson/cJSON.h>
#include <stdbool.h>

// One object and nothing else, but for the end of a line behind it. It lasts until the test ends.
cJSON *json_of(const char *chars);

// The same of a program that went well and said nothing on stderr.
cJSON *json_of_program(program p);

// The same of the program with these arguments, and with these variables.
cJSON *json_of_run(const char *arguments, ...) __attribute__((format(printf, 1, 2)));
cJSON *json_of_run_with(const char *variables, const char *arguments, ...)
    __attribute__((format(printf, 2, 3)));

// Runs a command that moves a scene to step --steps: its state hash, and the steps that it made.
void get_hash(const char *arguments, char hash[32], double *steps);

const cJSON *json_field(const cJSON *o, const char *key);
int json_size(const cJSON *o, const char *key); // of that array
double json_number(const cJSON *o, const char *key);
const char *json_string(const cJSON *o, const char *key);
bool json_true(const cJSON *o, const char *key); // and not false
const cJSON *json_array(const cJSON *o, const char *key, int n);
const cJSON *json_row(const cJSON *o, const char *key, int i); // of that array

#endif
