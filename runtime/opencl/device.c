// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L // nanosleep
#include "runtime/opencl/device.h"

#include "base/error.h"
#include "base/text.h"
#include "runtime/opencl/device_list.h"
#include "runtime/opencl/program_build.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static bool fail_unknown(const char *selector, const device_root *roots, uint32_t n,
                         duet_error *err)
{
    text there = {0};
    bool has_cpu = false;
    const char *absent;
    for (uint32_t i = 0; i < n; ++i) {
        has_cpu = has_cpu || roots[i].info.kind == DUET_KIND_CPU;
        text_add(&there, "%s%s", i ? ", " : "", roots[i].info.selector);
    }
    for (uint32_t i = 0; (absent = device_list_absent(i)); ++i)
        text_add(&there, "; %s", absent);
    if (!has_cpu && !device_list_has_pocl())
        text_add(&there, "; to work on the CPU too: apt install pocl-opencl-icd");
    bad_argument(err, "no device '%s'; there is %s", selector, text_chars(&there));
    text_free(&there);
    return false;
}

static bool is_word(const char *chars, size_t length, const char *word)
{
    return strlen(word) == length && memcmp(word, chars, length) == 0;
}

// "cpu" and "gpu" are the strongest of their kind.
static const device_root *find_root(const char *selector, size_t length, duet_error *err)
{
    const device_root *roots = NULL;
    uint32_t n = 0;
    if (!device_list_roots(&roots, &n, err))
        return NULL;
    const device_root *strongest =
        is_word(selector, length, "cpu")   ? device_list_strongest(DEVICE_CPU, NULL)
        : is_word(selector, length, "gpu") ? device_list_strongest(DEVICE_GPU, NULL)
                                           : NULL;
    if (strongest)
        return strongest;
    for (uint32_t i = 0; i < n; ++i)
        if (is_word(selector, length, roots[i].info.selector))
            return &roots[i];
    fail_unknown(selector, roots, n, err);
    return NULL;
}

// Reads "[first-last]", or "[k/n]" for the k-th of n equal parts; nothing may follow.
static bool read_part(const char *part, uint32_t units, uint32_t *first, uint32_t *last)
{
    uint32_t k = 0;
    uint32_t n = 0;
    int end = 0;
    if (!isdigit((unsigned char)part[1]))
        return false;
    if (sscanf(part, "[%9u-%9u]%n", first, last, &end) == 2 && part[end] == '\0')
        return *first <= *last && *last < units;
    if (sscanf(part, "[%9u/%9u]%n", &k, &n, &end) != 2 || part[end] != '\0')
        return false;
    *first = n ? (uint32_t)((uint64_t)units * (k - 1) / n) : 0;
    *last = n ? (uint32_t)((uint64_t)units * k / n) - 1 : 0;
    return k >= 1 && k <= n && n <= units;
}

static bool check_part(const device_root *root, const char *selector, uint32_t *first,
                       uint32_t *last, duet_error *err)
{
    const duet_device_info *info = &root->info;
    if (!info->can_cut)
        return bad_argument(err, "%s: %s cannot be cut into parts%s", selector, info->selector,
                            info->units == 1 ? ", it has one unit" : "");
    if (!read_part(strchr(selector, '['), info->units, first, last))
        return bad_argument(err,
                            "%s: a part of %s is [first-last] with 0 <= first <= last <= %u, or "
                            "[k/n] with 1 <= k <= n <= %u",
                            selector, info->selector, info->units - 1, info->units);
    return true;
}

// Units before, of, and after the part are cut off together, because a cut
// always begins at unit 0; only the part is kept.
static bool cut(const device_root *root, uint32_t first, uint32_t last, cl_device_id *part,
                duet_error *err)
{
    cl_device_partition_property cuts[6] = {CL_DEVICE_PARTITION_BY_COUNTS};
    cl_device_id parts[3] = {NULL};
    uint32_t counts[3] = {first, last - first + 1, root->info.units - last - 1};
    uint32_t n = 0;
    uint32_t wanted = 0;
    for (int i = 0; i < 3; ++i) {
        if (i == 1)
            wanted = n;
        if (counts[i] > 0)
            cuts[1 + n++] = counts[i];
    }
    cuts[1 + n] = CL_DEVICE_PARTITION_BY_COUNTS_LIST_END;
    cl_int code = clCreateSubDevices(root->id, cuts, n, parts, NULL);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "cutting units %u to %u off %s", first, last,
                            root->info.selector);
    for (uint32_t i = 0; i < n; ++i)
        if (i != wanted)
            clReleaseDevice(parts[i]);
    *part = parts[wanted];
    device_object_made();
    return true;
}

// Holding a root device does nothing.
static void hold_id(device *d, cl_device_id id)
{
    clRetainDevice(id);
    d->id = id;
    device_object_made();
}

static bool choose_id(device *d, const char *selector, duet_error *err)
{
    const char *part = strchr(selector, '[');
    size_t length = part ? (size_t)(part - selector) : strlen(selector);
    const device_root *root = find_root(selector, length, err);
    if (!root)
        return false;
    d->info = root->info;
    if (!part) {
        hold_id(d, root->id);
        return true;
    }
    uint32_t first = 0;
    uint32_t last = 0;
    if (!check_part(root, selector, &first, &last, err) || !cut(root, first, last, &d->id, err))
        return false;
    device_info_read(d->id, &d->info);
    d->info.can_cut = false; // parts are named by the units of the whole
    snprintf(d->info.selector, sizeof d->info.selector, "%.40s[%u-%u]", root->info.selector, first,
             last);
    return true;
}

static bool make_queue(cl_command_queue *queue, const device *d, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    *queue = clCreateCommandQueue(d->context, d->id, CL_QUEUE_PROFILING_ENABLE, &code);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "making a queue on %s", d->info.selector);
    device_object_made();
    return true;
}

static void share_context(device *d, cl_context context)
{
    clRetainContext(context);
    d->context = context;
    device_object_made();
}

static bool make_context(device *d, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    d->context = clCreateContext(NULL, 1, &d->id, NULL, NULL, &code);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "making a context on %s", d->info.selector);
    device_object_made();
    return true;
}

// Whether a GPU of NVIDIA orders memory as groups that meet do it (kernels/dynamics/meet.clh):
// since Volta.
static bool orders_memory(const device *d)
{
    enum { COMPUTE_CAPABILITY_MAJOR_NV = 0x4000 };
    cl_uint major = 0;
    return clGetDeviceInfo(d->id, COMPUTE_CAPABILITY_MAJOR_NV, sizeof major, &major, NULL) ==
               CL_SUCCESS &&
           major >= 7;
}

// With the context. Closes the device where it is not ready.
static bool make_ready(device *d, bool has_context, duet_error *err)
{
    if (has_context && make_queue(&d->queue, d, err) && make_queue(&d->beside, d, err)) {
        d->built = program_pool_open();
        d->quirks = driver_quirks(&d->info);
        if ((d->quirks & DRIVER_MEETS) && !orders_memory(d))
            d->quirks &= ~(uint32_t)DRIVER_MEETS;
        return true;
    }
    device_close(d);
    return false;
}

bool device_open(device *d, const char *selector, duet_error *err)
{
    return device_open_beside(d, selector, NULL, err);
}

bool device_open_beside(device *d, const char *selector, const device *first, duet_error *err)
{
    *d = (device){0};
    bool ok = choose_id(d, selector, err);
    if (ok && first && d->id == first->id)
        share_context(d, first->context);
    else
        ok = ok && make_context(d, err);
    return make_ready(d, ok, err);
}

// ---------------------------------------------------------------- a caller's queue

// OpenCL does not tell which units of its parent a caller's sub-device has.
static void name_part(device *d)
{
    cl_device_id root = d->id, parent = d->id;
    while (parent) {
        root = parent;
        parent = NULL;
        clGetDeviceInfo(root, CL_DEVICE_PARENT_DEVICE, sizeof parent, &parent, NULL);
    }
    const device_root *whole = device_list_find(root);
    uint32_t units = d->info.units;
    snprintf(d->info.selector, sizeof d->info.selector, "%.40s[%u unit%s]",
             whole ? whole->info.selector : "device", units, units == 1 ? "" : "s");
    d->info.can_cut = false;
}

static void know_id(device *d)
{
    const device_root *root = device_list_find(d->id);
    if (root) {
        d->info = root->info;
        return;
    }
    device_info_read(d->id, &d->info);
    name_part(d);
}

static bool hold_context(device *d, cl_command_queue queue, duet_error *err)
{
    cl_context context = NULL;
    cl_device_id id = NULL;
    cl_int code = clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof context, &context, NULL);
    if (code == CL_SUCCESS)
        code = clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof id, &id, NULL);
    if (code == CL_SUCCESS)
        code = clRetainCommandQueue(queue);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "a queue of the caller's: asking for its device");
    d->callers = queue;
    device_object_made();
    share_context(d, context);
    hold_id(d, id);
    know_id(d);
    return true;
}

bool device_open_on_queue(device *d, cl_command_queue queue, duet_error *err)
{
    *d = (device){0};
    return make_ready(d, hold_context(d, queue, err), err);
}

// A driver's thread lets go of a command, and with it of the queue, a moment after the command is
// over, and PoCL reads the device then. Returns whether that is done. Bounded, for a caller's
// buffer holds the last command that used it.
static bool wait_until_alone(cl_command_queue queue)
{
    const struct timespec moment = {.tv_nsec = 50000};
    cl_uint users = 1;
    clFinish(queue);
    for (int i = 0; i < 2000; ++i) {
        if (clGetCommandQueueInfo(queue, CL_QUEUE_REFERENCE_COUNT, sizeof users, &users, NULL) !=
                CL_SUCCESS ||
            users <= 1)
            return true;
        nanosleep(&moment, NULL);
    }
    return false;
}

static void release_queue(cl_command_queue queue)
{
    if (!queue)
        return;
    clReleaseCommandQueue(queue);
    device_object_gone();
}

void device_close(device *d)
{
    program_pool_close(d->built);
    const cl_command_queue queues[] = {d->queue, d->beside};
    bool is_alone = true;
    for (int i = 0; i < 2; ++i) {
        if (queues[i] && d->info.kind == DUET_KIND_CPU) // its driver's threads are the host's
            is_alone &= wait_until_alone(queues[i]);
        release_queue(queues[i]);
    }
    release_queue(d->callers);
    if (d->context) {
        clReleaseContext(d->context);
        device_object_gone();
    }
    if (d->id) {
        if (is_alone) // a part that may still be read lasts as long as the process
            clReleaseDevice(d->id);
        device_object_gone();
    }
    *d = (device){0};
}
