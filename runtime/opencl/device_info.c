// SPDX-License-Identifier: MIT
// What a driver says of a device.
#include "runtime/opencl/device.h"

#include "base/text.h"
#include "runtime/opencl/driver.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void keep_visible(char *to, size_t capacity, const char *from)
{
    text shown = {0};
    text_add_visible(&shown, from, strlen(from), "");
    snprintf(to, capacity, "%s", text_chars(&shown));
    text_free(&shown);
}

// Cut to what fits, so that a long name is a short name and not a failure.
static void read_text(cl_device_id id, cl_device_info what, char *to, size_t capacity)
{
    size_t size = 0;
    to[0] = '\0';
    if (clGetDeviceInfo(id, what, 0, NULL, &size) != CL_SUCCESS || size == 0)
        return;
    char *whole = calloc(1, size + 1);
    if (whole && clGetDeviceInfo(id, what, size, whole, NULL) == CL_SUCCESS) {
        keep_visible(to, capacity, whole);
    }
    free(whole);
}

static void read_platform(cl_device_id id, duet_device_info *info)
{
    cl_platform_id platform = NULL;
    if (clGetDeviceInfo(id, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL) != CL_SUCCESS)
        return;
    char *name = info->platform;
    char *version = info->platform_version;
    if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof info->platform - 1, name, NULL))
        name[0] = '\0';
    if (clGetPlatformInfo(platform, CL_PLATFORM_VERSION, sizeof info->platform_version - 1, version,
                          NULL))
        version[0] = '\0';
    keep_visible(name, sizeof info->platform, name);
    keep_visible(version, sizeof info->platform_version, version);
}

static uint32_t read_uint(cl_device_id id, cl_device_info what)
{
    cl_uint value = 0;
    return clGetDeviceInfo(id, what, sizeof value, &value, NULL) == CL_SUCCESS ? value : 0;
}

static uint64_t read_ulong(cl_device_id id, cl_device_info what)
{
    cl_ulong value = 0;
    return clGetDeviceInfo(id, what, sizeof value, &value, NULL) == CL_SUCCESS ? value : 0;
}

static uint32_t read_group(cl_device_id id)
{
    size_t value = 0;
    return clGetDeviceInfo(id, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof value, &value, NULL) ==
                   CL_SUCCESS
               ? (uint32_t)value
               : 1;
}

// A simulator may claim every kind at once: a CPU before all.
static duet_device_kind read_kind(cl_device_id id)
{
    uint64_t type = read_ulong(id, CL_DEVICE_TYPE);
    if (type & CL_DEVICE_TYPE_CPU)
        return DUET_KIND_CPU;
    return type & CL_DEVICE_TYPE_GPU ? DUET_KIND_GPU : DUET_KIND_ACCELERATOR;
}

static bool cuts_by_counts(cl_device_id id)
{
    cl_device_partition_property ways[16] = {0};
    size_t size = 0;
    if (clGetDeviceInfo(id, CL_DEVICE_PARTITION_PROPERTIES, sizeof ways, ways, &size) != CL_SUCCESS)
        return false;
    for (size_t i = 0; i < size / sizeof ways[0]; ++i)
        if (ways[i] == CL_DEVICE_PARTITION_BY_COUNTS)
            return true;
    return false;
}

void device_info_read(cl_device_id id, duet_device_info *info)
{
    *info = (duet_device_info){0};
    read_platform(id, info);
    read_text(id, CL_DEVICE_NAME, info->name, sizeof info->name);
    read_text(id, CL_DEVICE_VENDOR, info->vendor, sizeof info->vendor);
    read_text(id, CL_DRIVER_VERSION, info->driver, sizeof info->driver);
    read_text(id, CL_DEVICE_VERSION, info->cl_version, sizeof info->cl_version);
    info->kind = read_kind(id);
    info->units = read_uint(id, CL_DEVICE_MAX_COMPUTE_UNITS);
    info->clock_mhz = read_uint(id, CL_DEVICE_MAX_CLOCK_FREQUENCY);
    info->max_group = read_group(id);
    info->global_bytes = read_ulong(id, CL_DEVICE_GLOBAL_MEM_SIZE);
    info->local_bytes = read_ulong(id, CL_DEVICE_LOCAL_MEM_SIZE);
    info->max_buffer_bytes = read_ulong(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
    bool is_cpu = info->kind == DUET_KIND_CPU;
    info->host_memory = is_cpu && read_uint(id, CL_DEVICE_HOST_UNIFIED_MEMORY);
    info->fp64 = read_ulong(id, CL_DEVICE_DOUBLE_FP_CONFIG) != 0;
    info->can_cut = is_cpu && info->units > 1 && cuts_by_counts(id);
}
