// SPDX-License-Identifier: MIT
#include "runtime/opencl/kernel.h"

#include <stdlib.h>
#include <string.h>

int64_t kernel_param(const kernel *k, const char *param)
{
    const char *at = k->name;
    size_t length = strlen(param);
    while ((at = strchr(at, '.')))
        if (strncmp(++at, param, length) == 0)
            return strtoll(at + length, NULL, 10);
    return 0;
}

bool kernel_is(const kernel *k, const char *name)
{
    size_t length = strlen(name);
    return k && strncmp(k->name, name, length) == 0 && (k->name[length] == '.' || !k->name[length]);
}

void kernel_ask(kernel *k)
{
    k->state = k->state == KERNEL_SPARED ? KERNEL_ASKED : k->state;
}

void kernel_spare(kernel *k)
{
    k->state = k->state == KERNEL_ASKED ? KERNEL_SPARED : k->state;
}
