// SPDX-License-Identifier: MIT
#include "runtime/opencl/program_build.h"

#include "base/budget.h"
#include "base/error.h"
#include "runtime/opencl/cache.h"
#include "runtime/opencl/thread_pool.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Contraction is off in the kernels' text; nothing here may loosen it.
static const char BUILD_OPTIONS[] = "-cl-std=CL1.2 -w";

static void release(cl_program *built)
{
    if (!*built)
        return;
    clReleaseProgram(*built);
    device_object_gone();
    *built = NULL;
}

static void release_kernel(cl_kernel k)
{
    if (!k)
        return;
    clReleaseKernel(k);
    device_object_gone();
}

void program_close(program *p)
{
    for (int i = 0; i < p->n_entries; ++i)
        release_kernel(p->entries[i].k.cl);
    release(&p->cl);
    free(p->text);
    free(p);
}

// ---------------------------------------------------------------- what the device has

// Three times what a world and a motion with every effect have together: a search among variants
// comes back to those it tried. PoCL holds 1.3 MB a program.
enum { PLACES = 128 };

struct program_pool {
    pthread_mutex_t lock;
    unsigned next; // whose turn it is to be replaced
    struct {
        char sha256[65];
        cl_program cl;
    } places[PLACES];
};

program_pool *program_pool_open(void)
{
    program_pool *pool = calloc(1, sizeof *pool);
    if (pool)
        pthread_mutex_init(&pool->lock, NULL);
    return pool;
}

void program_pool_close(program_pool *pool)
{
    if (!pool)
        return;
    for (int i = 0; i < PLACES; ++i)
        release(&pool->places[i].cl);
    pthread_mutex_destroy(&pool->lock);
    free(pool);
}

static cl_program retained(cl_program built)
{
    clRetainProgram(built);
    device_object_made();
    return built;
}

static bool take_from_pool(program_pool *pool, program *p)
{
    if (!pool)
        return false;
    pthread_mutex_lock(&pool->lock);
    for (int i = 0; i < PLACES && !p->cl; ++i)
        if (pool->places[i].cl && strcmp(pool->places[i].sha256, p->sha256) == 0)
            p->cl = retained(pool->places[i].cl);
    pthread_mutex_unlock(&pool->lock);
    return p->cl;
}

static void put_into_pool(program_pool *pool, const program *p)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    unsigned i = pool->next++ % PLACES;
    release(&pool->places[i].cl);
    memcpy(pool->places[i].sha256, p->sha256, sizeof p->sha256);
    pool->places[i].cl = retained(p->cl);
    pthread_mutex_unlock(&pool->lock);
}

// ---------------------------------------------------------------- what the folder has

// Unless a folder was named, a driver that keeps its kernels itself is left to do so.
bool program_builder_keeps(const program_builder *b, const duet_device_info *info)
{
    return b->cache_dir && !(b->is_default && driver_of(info).keeps_kernels);
}

// A driver may refuse a binary that it made itself, after an update say; the
// source is built then.
static bool build_binary(const program_set *set, program *p, const text *binary)
{
    const unsigned char *bytes = (const unsigned char *)binary->chars;
    cl_int status = CL_SUCCESS, code = CL_SUCCESS;
    cl_program cl = clCreateProgramWithBinary(set->device->context, 1, &set->device->id,
                                              &binary->length, &bytes, &status, &code);
    if (!cl)
        return false;
    if (status != CL_SUCCESS ||
        clBuildProgram(cl, 1, &set->device->id, BUILD_OPTIONS, NULL, NULL) != CL_SUCCESS) {
        clReleaseProgram(cl);
        return false;
    }
    device_object_made();
    p->cl = cl;
    return true;
}

static bool build_kept(const program_set *set, program *p)
{
    if (!set->cache_dir)
        return false;
    text binary = {0};
    cache_key(p->text, BUILD_OPTIONS, &set->device->info, p->key);
    bool built = cache_get(set->cache_dir, p->key, &binary) && build_binary(set, p, &binary);
    text_free(&binary);
    return built;
}

static void keep_binary(const program_set *set, const program *p)
{
    size_t n = 0;
    if (!set->cache_dir ||
        clGetProgramInfo(p->cl, CL_PROGRAM_BINARY_SIZES, sizeof n, &n, NULL) != CL_SUCCESS || !n)
        return;
    unsigned char *bytes = malloc(n);
    if (bytes && clGetProgramInfo(p->cl, CL_PROGRAM_BINARIES, sizeof bytes, &bytes, NULL) == 0)
        cache_put(set->cache_dir, p->key, (const char *)bytes, n);
    free(bytes);
}

// ---------------------------------------------------------------- what is compiled

// The compiler's first error, or else its first line.
static bool fail_with_log(const program_set *set, const program *p, duet_error *err)
{
    char log[16384] = "";
    clGetProgramBuildInfo(p->cl, set->device->id, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
    const char *from = strstr(log, "error:");
    while (from && from > log && from[-1] != '\n')
        --from;
    if (!from)
        from = log;
    int length = (int)strcspn(from, "\n");
    return error_set(err, DUET_STATUS_BUILD_FAILED, "%s on %s: %.*s", p->name,
                     set->device->info.selector, length ? length : 22,
                     length ? from : "the compiler is silent");
}

static bool build_sources(const program_set *set, program *p, cl_uint n, const char *sources[],
                          const char *options, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    p->cl = clCreateProgramWithSource(set->device->context, n, sources, NULL, &code);
    if (!p->cl)
        return error_set_cl(err, code, "%s on %s", p->name, set->device->info.selector);
    device_object_made();
    return clBuildProgram(p->cl, 1, &set->device->id, options, NULL, NULL) == CL_SUCCESS ||
           fail_with_log(set, p, err);
}

// With declarations of ours in the place of the driver's header.
static bool build_declared(const program_set *set, program *p)
{
    const char *sources[] = {set->built_ins, p->text};
    char options[96];
    snprintf(options, sizeof options, "%s %s", BUILD_OPTIONS, set->device->driver.header_option);
    return build_sources(set, p, 2, sources, options, NULL);
}

// What a driver refuses with our declarations is built with its own, and its messages count.
bool program_compile(const program_set *set, program *p, duet_error *err)
{
    if (set->built_ins && build_declared(set, p))
        return true;
    release(&p->cl);
    const char *source = p->text;
    return build_sources(set, p, 1, &source, BUILD_OPTIONS, err);
}

// ---------------------------------------------------------------- all of a set

// What another world has on the device, or the folder; how many are left to compile.
static uint32_t take_what_is_built(program_set *set)
{
    uint32_t left = 0;
    for (program *p = set->first; p; p = p->next) {
        if (p->cl || take_from_pool(set->device->built, p))
            continue;
        if (build_kept(set, p))
            put_into_pool(set->device->built, p);
        left += !p->cl;
    }
    return left;
}

static void tell(const program_set *set, const char *kernel_name, uint32_t k, uint32_t n)
{
    if (set->builder.on_compile && n > 0)
        set->builder.on_compile(set->builder.context, &set->device->info, kernel_name, k, n);
}

// Programs that are compiled by several threads, each the next one that nobody has taken.
typedef struct compilation {
    program_set *set;
    pthread_mutex_t lock;
    program *next;
    uint32_t taken, n;
    duet_error why; // of the first that failed: no other is begun
} compilation;

static program *take_next(compilation *c)
{
    pthread_mutex_lock(&c->lock);
    program *p = c->why.status == DUET_STATUS_OK ? c->next : NULL;
    while (p && p->cl)
        p = p->next;
    if (p) {
        c->next = p->next;
        tell(c->set, p->name, ++c->taken, c->n);
    }
    pthread_mutex_unlock(&c->lock);
    return p;
}

// As many as from `from` to `to`.
static void compile_some(void *arg, uint64_t from, uint64_t to)
{
    compilation *c = arg;
    duet_error why = {0};
    for (; from < to && budget_check_stop(&why); ++from) {
        program *p = take_next(c);
        if (!p || !program_compile(c->set, p, &why))
            break;
        put_into_pool(c->set->device->built, p);
        keep_binary(c->set, p);
    }
    pthread_mutex_lock(&c->lock);
    error_copy(&c->why, &why);
    pthread_mutex_unlock(&c->lock);
}

static uint32_t helpers_for(const program_set *set, uint32_t n)
{
    enum { MOST_HELPERS = 3 };
    if (n < 2 || set->device->driver.compiles_one_by_one)
        return 0;
    return n - 1 < MOST_HELPERS ? n - 1 : MOST_HELPERS;
}

static bool compile_the_others(program_set *set, uint32_t n, duet_error *err)
{
    uint32_t n_helpers = helpers_for(set, n);
    compilation c = {.set = set, .next = set->first, .n = n};
    thread_pool *helpers = n_helpers > 0 ? thread_pool_open(n_helpers, NULL) : NULL;
    pthread_mutex_init(&c.lock, NULL);
    thread_pool_share(helpers, compile_some, &c, n, 1);
    thread_pool_close(helpers);
    pthread_mutex_destroy(&c.lock);
    if (c.why.status == DUET_STATUS_OK)
        return true;
    // Ctrl-C ends the processes of a compiler, too, which then has its own complaint.
    return budget_check_stop(err) && error_copy(err, &c.why);
}

static bool create_kernels(const program_set *set, program *p, duet_error *err)
{
    for (int i = 0; i < p->n_entries; ++i) {
        if (p->entries[i].k.cl)
            continue;
        cl_int code = CL_SUCCESS;
        p->entries[i].k.cl = clCreateKernel(p->cl, p->entries[i].entry, &code);
        if (!p->entries[i].k.cl)
            return error_set(err, DUET_STATUS_BUILD_FAILED, "%s on %s: has no kernel '%s'", p->name,
                             set->device->info.selector, p->entries[i].entry);
        device_object_made();
    }
    free(p->text);
    p->text = NULL;
    return true;
}

// A failure must not come back when other kernels are asked for.
static void forget_unbuilt(program_set *set)
{
    for (program **at = &set->first; *at;) {
        program *p = *at;
        bool built = p->cl && !p->text;
        while (built && p->n_entries > 0 && !p->entries[p->n_entries - 1].k.cl)
            --p->n_entries;
        if (built) {
            at = &p->next;
            continue;
        }
        *at = p->next;
        program_close(p);
    }
}

bool program_set_build(program_set *set, duet_error *err)
{
    uint32_t n = take_what_is_built(set);
    bool ok = compile_the_others(set, n, err);
    tell(set, NULL, n, n);
    for (program *p = set->first; ok && p; p = p->next)
        ok = create_kernels(set, p, err);
    if (!ok)
        forget_unbuilt(set);
    return ok;
}
