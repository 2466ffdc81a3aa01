// SPDX-License-Identifier: MIT
// Devices, and the device pair that shares the work.
#ifndef DUET_DEVICE_H
#define DUET_DEVICE_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

typedef enum duet_device_kind {
    DUET_KIND_CPU,
    DUET_KIND_GPU,
    DUET_KIND_ACCELERATOR
} duet_device_kind;

typedef struct duet_device_info {
    char selector[64]; // "pocl:0", "nvidia:1"; a part of a CPU is "pocl:0[0-1]"
    char platform[128];
    char platform_version[128];
    char name[256];
    char vendor[128];
    char driver[128];
    char cl_version[128];
    duet_device_kind kind;
    uint32_t units; // compute units
    uint32_t clock_mhz;
    uint32_t max_group; // work-items in a work-group
    uint64_t global_bytes;
    uint64_t local_bytes;
    uint64_t max_buffer_bytes;
    bool host_memory; // works on host memory without copies
    bool fp64;        // has double
    bool can_cut;     // can be cut into parts with [first-last]
} duet_device_info;

typedef struct duet_device_list duet_device_list;

// Lists all root devices of all platforms. The list may be empty; NULL: memory ran out.
DUET_API duet_device_list *duet_device_list_create(duet_error *err);
DUET_API void duet_device_list_destroy(duet_device_list *list);
DUET_API uint32_t duet_device_list_get_count(const duet_device_list *list);
DUET_API const duet_device_info *duet_device_list_get_info(const duet_device_list *list,
                                                           uint32_t i);

// Returns line i, from 0, on why an installed OpenCL platform has no device in the list; NULL
// past the last. The text lasts as long as the process.
DUET_API const char *duet_device_list_get_absent(const duet_device_list *list, uint32_t i);

// Returns flaw i, from 0, of the device's driver that Duet works round; NULL past the last. The
// line says what the driver does, a colon, and what Duet does about it.
DUET_API const char *duet_device_info_get_quirk(const duet_device_info *info, uint32_t i);

// An ordered device pair: A takes the share, B the rest. If both are one device, B does
// all of the work, unless a share is asked for.
typedef struct duet_device_pair duet_device_pair;

// Called before a kernel is compiled, which can take seconds: it is the k-th of n kernels, from
// 1, that the device needs and that neither the cache nor the pair has. After the last one it is
// called once more, with kernel NULL. Calls never overlap, and may come from any thread.
typedef void duet_compile_callback(void *context, const duet_device_info *device,
                                   const char *kernel, uint32_t k, uint32_t n);

// A selector is "pocl:0"; "cpu" or "gpu", the strongest of each; or a part of a CPU, by its
// units "pocl:0[0-3]" or as the k-th of n equal parts "cpu[1/2]". If b is NULL, a is one
// selector for both, "A,B" for the two, or "halves" for the two halves of the CPU. If
// both are NULL, A is the CPU and B the strongest GPU; without a GPU both are the CPU.
typedef struct duet_device_pair_def {
    const char *a;          // selector of A
    const char *b;          // selector of B
    const char *kernel_dir; // reads kernels from this folder instead of the carried ones
    const char *cache_dir;  // keeps built programs here. NULL: in $XDG_CACHE_HOME/duet or
                            // ~/.cache/duet, except PoCL's, which it keeps itself; "": nowhere
    duet_compile_callback *on_compile; // may be NULL
    void *context;                     // passed to on_compile
    int cookie;
} duet_device_pair_def;

// Fills a, kernel_dir and cache_dir from DUET_PAIR, DUET_KERNEL_DIR and DUET_CACHE ("off":
// nowhere).
DUET_API duet_device_pair_def duet_default_device_pair_def(void);

// Opens a device pair. NO_DEVICE if there is none, BAD_ARGUMENT for an unknown selector: the
// line lists the devices. A pair may be destroyed before the worlds made on it: its devices
// are released with the last of them.
DUET_API duet_device_pair *duet_device_pair_create(const duet_device_pair_def *def,
                                                   duet_error *err);
// Opens the pair of the default def with selectors as its a: one device with "gpu", two with
// "cpu,gpu". NULL: the default pair.
DUET_API duet_device_pair *duet_device_pair_open(const char *selectors, duet_error *err);
DUET_API void duet_device_pair_destroy(duet_device_pair *pair);
// Says whether A and B are the same device, so that B does all of the work by default; false
// for NULL.
DUET_API bool duet_device_pair_is_one(const duet_device_pair *pair);
// Returns false, with a line that says why, if built programs cannot be kept: all works, but
// kernels are compiled again each time.
DUET_API bool duet_device_pair_check_cache(const duet_device_pair *pair, duet_error *err);
DUET_API const duet_device_info *duet_device_pair_get_info(const duet_device_pair *pair,
                                                           int device); // 0: A, 1: B, else NULL

DUET_C_END

#endif
