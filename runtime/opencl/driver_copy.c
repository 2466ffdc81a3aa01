// SPDX-License-Identifier: MIT
#include "runtime/opencl/driver_copy.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { MENDED_IN = 6, MOST_COPIES = 1024 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static bool taken[MOST_COPIES];

static bool mixes_up_programs(const duet_device_info *info)
{
    return strncmp(info->platform, "Portable Computing Language", 27) == 0 &&
           strtol(info->driver, NULL, 10) < MENDED_IN;
}

// More devices than there are copies share the last one.
uint32_t driver_copy_take(const duet_device_info *info)
{
    if (!mixes_up_programs(info))
        return 0;
    uint32_t copy = 0;
    pthread_mutex_lock(&lock);
    while (copy < MOST_COPIES - 1 && taken[copy])
        ++copy;
    taken[copy] = true;
    pthread_mutex_unlock(&lock);
    return copy;
}

void driver_copy_return(const duet_device_info *info, uint32_t copy)
{
    if (!mixes_up_programs(info))
        return;
    pthread_mutex_lock(&lock);
    taken[copy] = false;
    pthread_mutex_unlock(&lock);
}
