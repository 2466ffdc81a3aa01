// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/task/task.h"

#include "base/budget.h"
#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    size_t bytes;
    bool is_whole;
} scalars[TASK_SCALARS] = {
    [TASK_CHAR] = {"char", 1, true},    [TASK_UCHAR] = {"uchar", 1, true},
    [TASK_SHORT] = {"short", 2, true},  [TASK_USHORT] = {"ushort", 2, true},
    [TASK_INT] = {"int", 4, true},      [TASK_UINT] = {"uint", 4, true},
    [TASK_LONG] = {"long", 8, true},    [TASK_ULONG] = {"ulong", 8, true},
    [TASK_FLOAT] = {"float", 4, false}, [TASK_DOUBLE] = {"double", 8, false},
};

bool task_type_read(const char *name, task_scalar *scalar, uint32_t *lanes)
{
    static const struct {
        const char *end;
        uint32_t lanes;
    } ends[] = {{"", 1}, {"2", 2}, {"4", 4}, {"8", 8}, {"16", 16}};
    for (int i = 0; i < TASK_SCALARS; ++i) {
        size_t n = strlen(scalars[i].name);
        for (size_t k = 0; strncmp(name, scalars[i].name, n) == 0 && k < 5; ++k)
            if (strcmp(name + n, ends[k].end) == 0) {
                *scalar = (task_scalar)i;
                *lanes = ends[k].lanes;
                return true;
            }
    }
    return false;
}

size_t task_scalar_bytes(task_scalar scalar)
{
    return scalars[scalar].bytes;
}

bool task_scalar_is_whole(task_scalar scalar)
{
    return scalars[scalar].is_whole;
}

// Begins at a page, so that devices that work on host memory can have it as it is.
bool task_values_make(task_values *v, task_scalar scalar, uint64_t n, duet_error *err)
{
    enum { PAGE = 4096 };
    size_t bytes = scalars[scalar].bytes;
    *v = (task_values){.scalar = scalar, .n = n, .size = (size_t)n * bytes};
    if (n > SIZE_MAX / 2 / bytes)
        return no_memory(err, "%" PRIu64 " numbers", n);
    if (!budget_space(v->size, err))
        return false;
    if (posix_memalign(&v->bytes, PAGE, v->size) != 0) {
        v->bytes = NULL;
        return no_memory(err, "%" PRIu64 " numbers", n);
    }
    memset(v->bytes, 0, v->size);
    return true;
}

void task_values_free(task_values *v)
{
    free(v->bytes);
    *v = (task_values){0};
}

double task_values_get(const task_values *v, uint64_t i)
{
    switch (v->scalar) {
    case TASK_FLOAT:
        return ((const float *)v->bytes)[i];
    case TASK_DOUBLE:
        return ((const double *)v->bytes)[i];
    case TASK_ULONG:
        return (double)((const uint64_t *)v->bytes)[i];
    default:
        return (double)task_values_get_whole(v, i);
    }
}

int64_t task_values_get_whole(const task_values *v, uint64_t i)
{
    switch (v->scalar) {
    case TASK_CHAR:
        return ((const int8_t *)v->bytes)[i];
    case TASK_UCHAR:
        return ((const uint8_t *)v->bytes)[i];
    case TASK_SHORT:
        return ((const int16_t *)v->bytes)[i];
    case TASK_USHORT:
        return ((const uint16_t *)v->bytes)[i];
    case TASK_INT:
        return ((const int32_t *)v->bytes)[i];
    case TASK_UINT:
        return ((const uint32_t *)v->bytes)[i];
    default:
        return ((const int64_t *)v->bytes)[i];
    }
}

void task_values_set(task_values *v, uint64_t i, double value)
{
    if (v->scalar == TASK_FLOAT)
        ((float *)v->bytes)[i] = (float)value;
    else
        ((double *)v->bytes)[i] = value;
}

void task_values_set_whole(task_values *v, uint64_t i, int64_t value)
{
    switch (v->scalar) {
    case TASK_CHAR:
    case TASK_UCHAR:
        ((uint8_t *)v->bytes)[i] = (uint8_t)value;
        break;
    case TASK_SHORT:
    case TASK_USHORT:
        ((uint16_t *)v->bytes)[i] = (uint16_t)value;
        break;
    case TASK_INT:
    case TASK_UINT:
        ((uint32_t *)v->bytes)[i] = (uint32_t)value;
        break;
    default:
        ((int64_t *)v->bytes)[i] = value;
    }
}
