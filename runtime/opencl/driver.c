// SPDX-License-Identifier: MIT
#include "runtime/opencl/driver.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { MENDED_IN = 6, MOST_COPIES = 1024 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static bool taken[MOST_COPIES];

static bool is_pocl(const duet_device_info *info)
{
    return strncmp(info->platform, "Portable Computing Language", 27) == 0;
}

static bool is_oclgrind(const duet_device_info *info)
{
    return strcmp(info->platform, "Oclgrind") == 0;
}

static bool mixes_up_programs(const duet_device_info *info)
{
    return is_pocl(info) && strtol(info->driver, NULL, 10) < MENDED_IN;
}

bool driver_keeps_kernels(const duet_device_info *info)
{
    return is_pocl(info);
}

bool driver_compiles_one_by_one(const duet_device_info *info)
{
    return is_pocl(info) || is_oclgrind(info);
}

const char *driver_header_option(const duet_device_info *info)
{
    return is_pocl(info) ? "-D _OPENCL_H_" : NULL; // what guards Clang's opencl-c.h
}

static bool reads_header(const duet_device_info *info)
{
    return driver_header_option(info);
}

const char *duet_device_info_get_quirk(const duet_device_info *info, uint32_t i)
{
    static const struct {
        bool (*has)(const duet_device_info *info);
        const char *quirk;
    } known[] = {
        {mixes_up_programs, "mixes up equal programs of two devices: each open device has its own"},
        {driver_keeps_kernels,
         "compiles twice when asked for binaries: what it built is left to its own cache"},
        {is_oclgrind, "breaks when two threads compile at once: programs are compiled one by one"},
        {reads_header,
         "reads 17,000 lines of declarations for each program: Duet's kernels have their own"},
    };
    for (size_t k = 0; info && k < sizeof known / sizeof *known; ++k)
        if (known[k].has(info) && i-- == 0)
            return known[k].quirk;
    return NULL;
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
