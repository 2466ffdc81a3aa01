// SPDX-License-Identifier: MIT
#include "runtime/opencl/launcher.h"

#include "base/error.h"

#include <string.h>

// The type that the name has otherwise, for a message; NULL where there is no such name.
static const char *other_type(bindings from, const char *name)
{
    for (; from->name; ++from)
        if (strcmp(from->name, name) == 0)
            return from->type;
    return NULL;
}

static const binding *find(bindings from, const gen_arg *arg)
{
    for (; from->name; ++from)
        if (strcmp(from->name, arg->name) == 0 && strcmp(from->type, arg->type) == 0)
            return from;
    return NULL;
}

static bool fail(const char *kernel, const gen_entry *entry, const gen_arg *arg, bindings from,
                 duet_error *err)
{
    const char *type = other_type(from, arg->name);
    if (type)
        return error_set(err, DUET_STATUS_BUILD_FAILED,
                         "kernel %s: argument '%s' of %s is of type '%s'; expected '%s'", kernel,
                         arg->name, entry->name, arg->type, type);
    return error_set(err, DUET_STATUS_BUILD_FAILED,
                     "kernel %s: %s has an argument '%s' that its launcher does not know", kernel,
                     entry->name, arg->name);
}

bool launcher_bind(launcher *l, const char *kernel, const gen_entry *entry, bindings from,
                   duet_error *err)
{
    l->n = 0;
    for (uint32_t i = 0; i < entry->n_args; ++i) {
        const gen_arg *arg = &entry->args[i];
        const binding *b = find(from, arg);
        if (!b)
            return fail(kernel, entry, arg, from, err);
        l->args[l->n].at = b->at;
        l->args[l->n++].bytes = arg->bytes ? arg->bytes : (uint32_t)sizeof(cl_mem);
    }
    return true;
}

cl_int launcher_set(const launcher *l, cl_kernel k, const void *values, uint32_t *bad)
{
    cl_int code = CL_SUCCESS;
    for (uint32_t i = 0; i < l->n && code == CL_SUCCESS; ++i) {
        *bad = i;
        code = clSetKernelArg(k, i, l->args[i].bytes, (const char *)values + l->args[i].at);
    }
    return code;
}
