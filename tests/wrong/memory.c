// SPDX-License-Identifier: MIT
// The memory of a program that runs out of it: the linker leads calls here (--wrap).
#include "wrong/memory.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static uint64_t n_asked, first_refused = UINT64_MAX, last_refused;

void memory_refuse(uint64_t first, uint64_t last)
{
    n_asked = 0;
    first_refused = first;
    last_refused = last;
}

uint64_t memory_asked(void)
{
    return n_asked;
}

static bool refuses(void)
{
    const uint64_t place = n_asked++;
    return place >= first_refused && place <= last_refused;
}

void *__real_malloc(size_t bytes);
void *__real_calloc(size_t n, size_t bytes);
void *__real_realloc(void *at, size_t bytes);
char *__real_strdup(const char *chars);
void *__wrap_malloc(size_t bytes);
void *__wrap_calloc(size_t n, size_t bytes);
void *__wrap_realloc(void *at, size_t bytes);
char *__wrap_strdup(const char *chars);

void *__wrap_malloc(size_t bytes)
{
    return refuses() ? NULL : __real_malloc(bytes);
}

void *__wrap_calloc(size_t n, size_t bytes)
{
    return refuses() ? NULL : __real_calloc(n, bytes);
}

void *__wrap_realloc(void *at, size_t bytes)
{
    return refuses() ? NULL : __real_realloc(at, bytes);
}

char *__wrap_strdup(const char *chars)
{
    return refuses() ? NULL : __real_strdup(chars);
}
