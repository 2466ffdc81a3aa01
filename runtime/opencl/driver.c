// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/opencl/driver.h"

#include "base/error.h"
#include "base/output.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// A macro's name within its own expansion is OpenCL's own function.
const char *driver_third_axis(uint32_t n_axes)
{
    static const char *const texts[] = {
        "#define get_group_id(axis) get_group_id(2)\n"
        "#define get_num_groups(axis) get_num_groups(2)\n"
        "#define get_global_id(axis) (get_group_id(2) * get_local_size(0) + get_local_id(0))\n"
        "#define get_global_size(axis) (get_num_groups(2) * get_local_size(0))\n"
        "#line 1\n",
        // the second and the third change places
        "#define get_group_id(axis) get_group_id((axis) ? 3 - (axis) : 0)\n"
        "#define get_num_groups(axis) get_num_groups((axis) ? 3 - (axis) : 0)\n"
        "#define get_global_id(axis) (get_group_id(axis) * get_local_size(axis) + "
        "get_local_id(axis))\n"
        "#define get_global_size(axis) (get_num_groups(axis) * get_local_size(axis))\n"
        "#line 1\n",
        ""};
    return texts[n_axes - 1];
}

const char driver_header_option[] = "-D _OPENCL_H_"; // the guard of Clang's opencl-c.h

// Not one that PoCL reaches through another driver or on another machine. PoCL's version ends with
// what it builds a device's kernels with: "OpenCL 3.0 PoCL HSTR: pthread-x86_64-...".
static bool is_pocls_own_cpu(const duet_device_info *info)
{
    static const char *const own[] = {"pthread-", "cpu-", "basic-"};
    const char *with = "", *next = info->cl_version;
    while ((next = strstr(next, "HSTR: ")))
        with = next += strlen("HSTR: ");
    for (size_t i = 0; i < sizeof own / sizeof *own; ++i)
        if (strncmp(with, own[i], strlen(own[i])) == 0)
            return info->kind == DUET_KIND_CPU;
    return false;
}

uint32_t driver_quirks(const duet_device_info *info)
{
    if (strcmp(info->platform, "Oclgrind") == 0)
        return DRIVER_CRASHES;
    if (strcmp(info->platform, "NVIDIA CUDA") == 0)
        return DRIVER_MEETS;
    if (strncmp(info->platform, "Portable Computing Language", 27) != 0)
        return 0;
    return DRIVER_READS_HEADER | DRIVER_KEEPS_KERNELS | DRIVER_ONE_COMPILER |
           (info->kind == DUET_KIND_CPU ? DRIVER_TWO_WIDTHS : 0) |
           (is_pocls_own_cpu(info) ? DRIVER_IN_PLACE : 0);
}

const char *duet_device_info_get_quirk(const duet_device_info *info, uint32_t i)
{
    static const struct {
        driver_quirk quirk;
        const char *text;
    } told[] = {
        {DRIVER_TWO_WIDTHS, "compiles a kernel again for large launches and, before 6.0, mixes the "
                            "two up: Duet makes all launches alike"},
        {DRIVER_KEEPS_KERNELS, "compiles a program again where its binary is asked for: Duet "
                               "leaves caching to the driver"},
        {DRIVER_IN_PLACE, "wakes all its threads for each map of shared memory: Duet maps none"},
        {DRIVER_CRASHES,
         "crashes where two threads compile at once: Duet compiles one program at a time"},
        {DRIVER_READS_HEADER, "reads 17 000 lines of built-in declarations for each program: "
                              "Duet's kernels declare what they call"},
    };
    const uint32_t quirks = info ? driver_quirks(info) : 0;
    for (size_t k = 0; k < sizeof told / sizeof *told; ++k)
        if ((quirks & told[k].quirk) && i-- == 0)
            return told[k].text;
    return NULL;
}

// ---------------------------------------------------------------- PoCL's folder

static void add_pocl_folder(text *path)
{
    static const struct {
        const char *variable;
        const char *below;
    } places[] = {{"POCL_CACHE_DIR", ""},
                  {"XDG_CACHE_HOME", "/pocl/kcache"},
                  {"HOME", "/.cache/pocl/kcache"}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        const char *value = getenv(places[i].variable);
        if (value && *value) {
            text_add(path, "%s%s", value, places[i].below);
            return;
        }
    }
    text_add(path, "/tmp/pocl/kcache");
}

static bool make_folder(const char *path)
{
    return output_make_folders(path, 0700, NULL) && (mkdir(path, 0700) == 0 || errno == EEXIST);
}

bool driver_check_pocl_folder(duet_error *err)
{
    text path = {0};
    add_pocl_folder(&path);
    bool ok = text_ok(&path, err);
    if (ok && (!make_folder(path.chars) || access(path.chars, W_OK | X_OK) != 0))
        ok = error_set(err, DUET_STATUS_NO_DEVICE,
                       "PoCL lists no device, since its cache folder %s cannot be written: %s; set "
                       "POCL_CACHE_DIR to a folder that can be written",
                       path.chars, strerror(errno));
    text_free(&path);
    return ok;
}
