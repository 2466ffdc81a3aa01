// SPDX-License-Identifier: MIT
#include "runtime/opencl/driver.h"

#include <string.h>

static bool is_pocl(const duet_device_info *info)
{
    return strncmp(info->platform, "Portable Computing Language", 27) == 0;
}

static bool is_oclgrind(const duet_device_info *info)
{
    return strcmp(info->platform, "Oclgrind") == 0;
}

// What the kernel's text says within its own expansion is OpenCL's own function.
const char *driver_third_axis(const duet_device_info *info)
{
    return is_pocl(info) && info->kind == DUET_KIND_CPU
               ? "#define get_group_id(axis) get_group_id(2)\n"
                 "#define get_num_groups(axis) get_num_groups(2)\n"
                 "#define get_global_id(axis) (get_group_id(2) * get_local_size(0) + "
                 "get_local_id(0))\n"
                 "#define get_global_size(axis) (get_num_groups(2) * get_local_size(0))\n"
                 "#line 1\n"
               : NULL;
}

static bool has_third_axis(const duet_device_info *info)
{
    return driver_third_axis(info);
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
        {has_third_axis,
         "compiles a kernel for each range, and mixes them up before 6.0: all launches look alike"},
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
