// SPDX-License-Identifier: MIT
#include "runtime/opencl/device_list.h"

#include "base/error.h"
#include "runtime/opencl/device.h"
#include "runtime/opencl/driver.h"

#include <ctype.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    pthread_once_t once;
    device_root *roots;
    uint32_t n;
    bool failed;        // memory ran out
    duet_error *absent; // [n_absent] of each platform that lists no usable device, why
    uint32_t n_absent;
    bool has_pocl; // it is installed
} found = {.once = PTHREAD_ONCE_INIT};

// "pocl" for "Portable Computing Language"; a platform that is not in the list
// is called by its first word.
static void short_name(const char *platform, char name[32])
{
    static const struct {
        const char *begins;
        const char *name;
    } known[] = {
        {"Portable Computing Language", "pocl"},
        {"NVIDIA", "nvidia"},
        {"Intel", "intel"},
        {"AMD", "amd"},
        {"Oclgrind", "oclgrind"},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        if (strncmp(platform, known[i].begins, strlen(known[i].begins)) == 0) {
            snprintf(name, 32, "%s", known[i].name);
            return;
        }
    }
    size_t length = 0;
    while (length < 31 && isalnum((unsigned char)platform[length])) {
        name[length] = (char)tolower((unsigned char)platform[length]);
        ++length;
    }
    name[length] = '\0';
    if (length == 0)
        snprintf(name, 32, "platform");
}

static bool is_usable(cl_device_id id)
{
    cl_bool available = CL_FALSE;
    cl_bool compiler = CL_FALSE;
    clGetDeviceInfo(id, CL_DEVICE_AVAILABLE, sizeof available, &available, NULL);
    clGetDeviceInfo(id, CL_DEVICE_COMPILER_AVAILABLE, sizeof compiler, &compiler, NULL);
    return available && compiler;
}

// How many of the platforms before this one have the same short name.
static uint32_t namesakes(char (*names)[32], uint32_t p)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < p; ++i)
        n += strcmp(names[i], names[p]) == 0;
    return n;
}

static bool add_devices(cl_platform_id platform, const char *name, uint32_t namesake)
{
    cl_uint n = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, NULL, &n) != CL_SUCCESS || n == 0)
        return true;
    cl_device_id *ids = calloc(n, sizeof(cl_device_id));
    device_root *roots = realloc(found.roots, (found.n + n) * sizeof *roots);
    if (roots)
        found.roots = roots;
    bool ok = ids && roots;
    if (ok && clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, n, ids, NULL) == CL_SUCCESS) {
        for (cl_uint i = 0; i < n; ++i) {
            if (!is_usable(ids[i]))
                continue;
            device_root *root = &found.roots[found.n++];
            root->id = ids[i];
            device_info_read(ids[i], &root->info);
            char suffix[12] = "";
            if (namesake > 0)
                snprintf(suffix, sizeof suffix, "%u", namesake + 1);
            snprintf(root->info.selector, sizeof root->info.selector, "%s%s:%u", name, suffix, i);
        }
    }
    free(ids);
    return ok;
}

// PoCL tells nobody why it lists none.
static bool add_absent(const char *platform, const char *name)
{
    duet_error *absent = realloc(found.absent, (found.n_absent + 1) * sizeof *absent);
    if (!absent)
        return false;
    found.absent = absent;
    duet_error *why = &absent[found.n_absent++];
    *why = (duet_error){0};
    if (strcmp(name, "pocl") != 0 || driver_check_pocl_folder(why))
        error_set(why, DUET_STATUS_NO_DEVICE, "the OpenCL platform '%s' lists no device", platform);
    return true;
}

static void find_roots(void)
{
    cl_uint n = 0;
    if (clGetPlatformIDs(0, NULL, &n) != CL_SUCCESS || n == 0)
        return;
    cl_platform_id *platforms = calloc(n, sizeof(cl_platform_id));
    char(*names)[32] = calloc(n, sizeof *names);
    bool ok = platforms && names;
    if (ok && clGetPlatformIDs(n, platforms, NULL) == CL_SUCCESS) {
        for (cl_uint p = 0; ok && p < n; ++p) {
            char whole[128] = "";
            clGetPlatformInfo(platforms[p], CL_PLATFORM_NAME, sizeof whole - 1, whole, NULL);
            short_name(whole, names[p]);
            found.has_pocl = found.has_pocl || strcmp(names[p], "pocl") == 0;
            uint32_t before = found.n;
            ok = add_devices(platforms[p], names[p], namesakes(names, p));
            if (ok && found.n == before)
                ok = add_absent(whole, names[p]);
        }
    }
    found.failed = !ok;
    free(names);
    free(platforms);
}

static bool look(duet_error *err)
{
    pthread_once(&found.once, find_roots);
    return !found.failed || no_memory(err, "the list of devices");
}

static bool refuse_none(duet_error *err)
{
    return error_set(err, DUET_STATUS_NO_DEVICE, "%s",
                     found.n_absent ? found.absent[0].text
                                    : "no OpenCL device is installed; to work on the CPU: apt "
                                      "install pocl-opencl-icd");
}

bool device_list_roots(const device_root **roots, uint32_t *n, duet_error *err)
{
    if (!look(err))
        return false;
    *roots = found.roots;
    *n = found.n;
    return found.n > 0 || refuse_none(err);
}

const device_root *device_list_find(cl_device_id id)
{
    for (uint32_t i = 0; look(NULL) && i < found.n; ++i)
        if (found.roots[i].id == id)
            return &found.roots[i];
    return NULL;
}

static bool is_of(device_group group, const duet_device_info *info)
{
    return group == DEVICE_CPU   ? info->kind == DUET_KIND_CPU
           : group == DEVICE_GPU ? info->kind == DUET_KIND_GPU
                                 : info->kind != DUET_KIND_CPU;
}

static uint64_t strength(const duet_device_info *info)
{
    return (uint64_t)info->units * (info->clock_mhz ? info->clock_mhz : 1);
}

const device_root *device_list_strongest(device_group group, const device_root *passed_over)
{
    const device_root *best = NULL;
    for (uint32_t i = 0; i < found.n; ++i) {
        const device_root *root = &found.roots[i];
        if (root != passed_over && is_of(group, &root->info) &&
            (!best || strength(&root->info) > strength(&best->info)))
            best = root;
    }
    return best;
}

const char *device_list_absent(uint32_t i)
{
    return i < found.n_absent ? found.absent[i].text : NULL;
}

bool device_list_has_pocl(void)
{
    return found.has_pocl;
}

struct duet_device_list {
    const device_root *roots;
    uint32_t n;
};

duet_device_list *duet_device_list_create(duet_error *err)
{
    PUBLIC_CALL(err);
    if (!look(err))
        return NULL;
    duet_device_list *list = calloc(1, sizeof *list);
    if (!list)
        return null_no_memory(err, "the list of devices");
    *list = (duet_device_list){found.roots, found.n};
    return list;
}

void duet_device_list_destroy(duet_device_list *list)
{
    free(list);
}

uint32_t duet_device_list_get_count(const duet_device_list *list)
{
    return list ? list->n : 0;
}

const duet_device_info *duet_device_list_get_info(const duet_device_list *list, uint32_t i)
{
    return list && i < list->n ? &list->roots[i].info : NULL;
}

const char *duet_device_list_get_absent(const duet_device_list *list, uint32_t i)
{
    return list ? device_list_absent(i) : NULL;
}
