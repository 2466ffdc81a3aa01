// SPDX-License-Identifier: MIT
// An OpenCL driver whose platform has no device, as a GPU's has on a machine without one. The
// loader finds it by a .icd file.
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl_icd.h>
#include <string.h>

struct _cl_platform_id {
    const cl_icd_dispatch *dispatch;
};

static cl_int CL_API_CALL get_platform_info(cl_platform_id platform, cl_platform_info what,
                                            size_t size, void *value, size_t *needs)
{
    (void)platform;
    const char *says = what == CL_PLATFORM_NAME             ? "Abacus"
                       : what == CL_PLATFORM_EXTENSIONS     ? "cl_khr_icd"
                       : what == CL_PLATFORM_ICD_SUFFIX_KHR ? "ABACUS"
                                                            : "OpenCL 1.2 Abacus";
    size_t n = strlen(says) + 1;
    if (needs)
        *needs = n;
    if (value && size < n)
        return CL_INVALID_VALUE;
    if (value)
        memcpy(value, says, n);
    return CL_SUCCESS;
}

static cl_int CL_API_CALL get_device_ids(cl_platform_id platform, cl_device_type type, cl_uint n,
                                         cl_device_id *ids, cl_uint *found)
{
    (void)platform, (void)type, (void)n, (void)ids;
    if (found)
        *found = 0;
    return CL_DEVICE_NOT_FOUND;
}

static const cl_icd_dispatch dispatch = {.clGetPlatformInfo = get_platform_info,
                                         .clGetDeviceIDs = get_device_ids};
static struct _cl_platform_id abacus = {&dispatch};

static cl_int CL_API_CALL get_platform_ids(cl_uint n, cl_platform_id *platforms, cl_uint *found)
{
    if (found)
        *found = 1;
    if (platforms && n > 0)
        platforms[0] = &abacus;
    return CL_SUCCESS;
}

__attribute__((visibility("default"))) void *CL_API_CALL
clGetExtensionFunctionAddress(const char *name)
{
    if (strcmp(name, "clIcdGetPlatformIDsKHR") == 0)
        return (void *)get_platform_ids;
    return strcmp(name, "clGetPlatformInfo") == 0 ? (void *)get_platform_info : NULL;
}
