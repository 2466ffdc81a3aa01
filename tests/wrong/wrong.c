// SPDX-License-Identifier: MIT
// An OpenCL driver that miscompiles for some contexts, of a device of its own each, or refuses a
// buffer: LD_PRELOAD puts this before the loader. In the source of programs for the context
// WRONG_CONTEXT (from 0 on) and later ones the text WRONG_FROM becomes WRONG_TO, so a test knows
// which kernel is wrong, and for which bodies. Of the buffers that are made REFUSED_BUFFER (from 0
// on) is not.
#define _GNU_SOURCE
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { CONTEXTS = 16 };

// Contexts are numbered as their first programs come.
static bool is_wrong(cl_context context)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    static cl_context known[CONTEXTS];
    static int n;
    const char *first = getenv("WRONG_CONTEXT");
    int at = 0;
    pthread_mutex_lock(&lock);
    while (at < n && known[at] != context)
        ++at;
    if (at == n && n < CONTEXTS)
        known[n++] = context;
    pthread_mutex_unlock(&lock);
    return first && at >= atoi(first);
}

// All strings as one, with room for so much more.
static char *join(cl_uint n, const char **strings, const size_t *lengths, size_t more)
{
    size_t total = 0;
    for (cl_uint i = 0; i < n; ++i)
        total += lengths && lengths[i] ? lengths[i] : strlen(strings[i]);
    char *text = malloc(total + more + 1), *at = text;
    if (!text)
        abort();
    for (cl_uint i = 0; i < n; ++i) {
        size_t length = lengths && lengths[i] ? lengths[i] : strlen(strings[i]);
        memcpy(at, strings[i], length);
        at += length;
    }
    *at = '\0';
    return text;
}

__attribute__((visibility("default"))) cl_program
clCreateProgramWithSource(cl_context context, cl_uint n, const char **strings,
                          const size_t *lengths, cl_int *code)
{
    __typeof__(&clCreateProgramWithSource) real;
    void *const found = dlsym(RTLD_NEXT, "clCreateProgramWithSource");
    memcpy(&real, &found, sizeof real);
    const char *from = getenv("WRONG_FROM"), *to = getenv("WRONG_TO");
    if (!from || !to || !is_wrong(context))
        return real(context, n, strings, lengths, code);
    char *text = join(n, strings, lengths, strlen(to));
    char *at = strstr(text, from);
    if (at) {
        memmove(at + strlen(to), at + strlen(from), strlen(at + strlen(from)) + 1);
        memcpy(at, to, strlen(to));
    }
    const char *whole = text;
    cl_program program = real(context, 1, &whole, NULL, code);
    free(text);
    return program;
}

__attribute__((visibility("default"))) cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags,
                                                             size_t bytes, void *host, cl_int *code)
{
    static atomic_int n;
    __typeof__(&clCreateBuffer) real;
    void *const found = dlsym(RTLD_NEXT, "clCreateBuffer");
    memcpy(&real, &found, sizeof real);
    const char *refused = getenv("REFUSED_BUFFER");
    if (!refused || atomic_fetch_add(&n, 1) != atoi(refused))
        return real(context, flags, bytes, host, code);
    *code = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    return NULL;
}
