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

// Whether it is to be compiled, or taken from where it is built.
static bool is_wanted(const program *p)
{
    bool asked = false;
    for (int i = 0; i < p->n_entries; ++i)
        asked = asked || p->entries[i].k.state == KERNEL_ASKED;
    return asked && !p->cl;
}

// ---------------------------------------------------------------- of a binary

// A driver may refuse a binary that it made itself, after an update say; the
// source is built then.
static bool build_binary(const program_set *set, program *p)
{
    const unsigned char *bytes = (const unsigned char *)p->binary;
    cl_int status = CL_SUCCESS, code = CL_SUCCESS;
    cl_program cl = clCreateProgramWithBinary(set->device->context, 1, &set->device->id,
                                              &p->binary_bytes, &bytes, &status, &code);
    if (!cl)
        return false;
    if (status != CL_SUCCESS ||
        clBuildProgram(cl, 1, &set->device->id, PROGRAM_OPTIONS, NULL, NULL) != CL_SUCCESS) {
        clReleaseProgram(cl);
        return false;
    }
    device_object_made();
    p->cl = cl;
    return true;
}

// How many are left to compile.
static uint32_t build_binaries(program_set *set)
{
    uint32_t left = 0;
    for (program *p = set->first; p; p = p->next) {
        if (!is_wanted(p))
            continue;
        bool built = p->binary && build_binary(set, p);
        left += !built;
        if (built)
            program_pool_put(set->device->built, p);
        free(p->binary);
        p->binary = NULL;
    }
    return left;
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

// ---------------------------------------------------------------- of its text

// NVIDIA's compiler counts the lines of the whole text, "<kernel>:1014:1: error: ...", and says
// nothing of the files that #line names.
const char *program_place_message(const char *source, const char *message,
                                  char place[PROGRAM_PLACE])
{
    static const char own[] = "<kernel>:", directive[] = "#line ";
    char *rest = NULL, *name = NULL;
    unsigned long left = 0, line = 1;
    place[0] = '\0';
    if (strncmp(message, own, strlen(own)) == 0)
        left = strtoul(message + strlen(own), &rest, 10);
    const char *file = NULL;
    for (const char *at = source; at && left > 1; --left, ++line) {
        if (strncmp(at, directive, strlen(directive)) == 0) {
            line = strtoul(at + strlen(directive), &name, 10) - 1;
            file = strncmp(name, " \"", 2) == 0 ? name + 2 : file;
        }
        at = strchr(at, '\n');
        at = at ? at + 1 : NULL;
    }
    if (!file || left != 1)
        return message;
    snprintf(place, PROGRAM_PLACE, "%.*s:%lu", (int)strcspn(file, "\"\n"), file, line);
    return rest;
}

// Adds the message with the file that was read in the place of its name in the text,
// "kernels/FILE".
static void add_message(const gen *g, const char *message, text *to)
{
    static const char root[] = "kernels/";
    const char *at = strstr(message, root);
    const char *name = at ? at + strlen(root) : "";
    char file[128];
    snprintf(file, sizeof file, "%.*s", (int)strcspn(name, ":\" "), name);
    const char *folder = *file ? gen_folder(g, file) : NULL;
    if (folder)
        text_add(to, "%.*s%s/%s", (int)(at - message), message, folder, name);
    else
        text_add(to, "%s", message);
}

// NVIDIA's assembler says "ptxas fatal", behind the compiler's warnings.
const char *program_first_error(const char *log)
{
    static const char *const marks[] = {"error:", "fatal", "error"};
    const char *at = NULL;
    for (size_t i = 0; !at && i < sizeof marks / sizeof *marks; ++i)
        at = strstr(log, marks[i]);
    while (at && at > log && at[-1] != '\n')
        --at;
    return at ? at : log;
}

static bool fail_with_log(const program_set *set, const program *p, cl_program cl, duet_error *err)
{
    char log[16384] = "";
    clGetProgramBuildInfo(cl, set->device->id, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
    char place[PROGRAM_PLACE];
    const char *from = program_place_message(p->text, program_first_error(log), place);
    int length = (int)strcspn(from, "\n");
    text given = {0}, told = {0};
    text_add(&given, "%s%.*s", place, length ? length : 22,
             length ? from : "the compiler is silent");
    add_message(set->gen, text_chars(&given), &told);
    error_set(err, DUET_STATUS_BUILD_FAILED, "%s on %s: %s", p->name, set->device->info.selector,
              text_chars(&told));
    text_free(&given);
    text_free(&told);
    return false;
}

static bool build_sources(const program_set *set, program *p, cl_uint n, const char *sources[],
                          const char *options, duet_error *err)
{
    cl_int code = CL_SUCCESS;
    cl_program cl = clCreateProgramWithSource(set->device->context, n, sources, NULL, &code);
    if (!cl)
        return error_set_cl(err, code, "%s on %s", p->name, set->device->info.selector);
    if (clBuildProgram(cl, 1, &set->device->id, options, NULL, NULL) != CL_SUCCESS) {
        fail_with_log(set, p, cl, err);
        clReleaseProgram(cl);
        return false;
    }
    device_object_made();
    p->cl = cl;
    return true;
}

// With declarations of ours in the place of the driver's header, if there are some and it has one.
static bool build_declared(const program_set *set, program *p)
{
    const char *built_ins = gen_built_ins(set->gen), *sources[] = {built_ins, p->text};
    char options[96];
    if (!built_ins || !(set->device->quirks & DRIVER_READS_HEADER))
        return false;
    snprintf(options, sizeof options, "%s %s", PROGRAM_OPTIONS, driver_header_option);
    return build_sources(set, p, 2, sources, options, NULL);
}

// A program that a driver refuses with our declarations is built with its own, whose messages
// count.
bool program_compile(const program_set *set, program *p, duet_error *err)
{
    if (build_declared(set, p))
        return true;
    const char *source = p->text;
    return build_sources(set, p, 1, &source, PROGRAM_OPTIONS, err);
}

// ---------------------------------------------------------------- all of a set

// Programs that are compiled by several threads, each the next one that nobody has taken.
typedef struct compilation {
    program_set *set;
    pthread_mutex_t lock;
    program *next;
    uint32_t taken, n;
    duet_error failure; // no other is begun then
} compilation;

static program *take_next(compilation *c)
{
    const program_builder *b = &c->set->builder;
    pthread_mutex_lock(&c->lock);
    program *p = c->failure.status == DUET_STATUS_OK ? c->next : NULL;
    while (p && !is_wanted(p))
        p = p->next;
    if (p) {
        c->next = p->next;
        ++c->taken;
        if (b->on_compile)
            b->on_compile(b->context, &c->set->device->info, p->name, c->taken, c->n);
    }
    pthread_mutex_unlock(&c->lock);
    return p;
}

// Compiles as many programs as from `from` to `to`.
static void compile_some(void *arg, uint64_t from, uint64_t to)
{
    compilation *c = arg;
    duet_error why = {0};
    for (; from < to && budget_check_stop(&why); ++from) {
        program *p = take_next(c);
        duet_error complaint = {0};
        if (!p)
            break;
        if (!program_compile(c->set, p, &complaint)) {
            // Ctrl-C ends the processes of a compiler, too, which is then no fault of the text.
            if (budget_check_stop(&why))
                why = complaint;
            break;
        }
        program_pool_put(c->set->device->built, p);
        keep_binary(c->set, p);
    }
    if (why.status == DUET_STATUS_OK)
        return;
    pthread_mutex_lock(&c->lock);
    error_copy(&c->failure, &why);
    pthread_mutex_unlock(&c->lock);
}

static uint32_t helpers_for(const program_set *set, uint32_t n)
{
    enum { MOST_HELPERS = 3 };
    if (n < 2 || set->device->quirks & (DRIVER_ONE_COMPILER | DRIVER_CRASHES))
        return 0;
    return n - 1 < MOST_HELPERS ? n - 1 : MOST_HELPERS;
}

// Builds all that is not built, of its binary or else of its text, and puts it into the pool; what
// was built of its text is kept in the folder. After a failure some may be built.
static bool build_missing(program_set *set, duet_error *err)
{
    const program_builder *b = &set->builder;
    uint32_t n = build_binaries(set), n_helpers = helpers_for(set, n);
    compilation c = {.set = set, .next = set->first, .n = n};
    thread_pool *helpers = n_helpers > 0 ? thread_pool_open(n_helpers, NULL) : NULL;
    pthread_mutex_init(&c.lock, NULL);
    thread_pool_share(helpers, compile_some, &c, n, 1);
    thread_pool_close(helpers);
    pthread_mutex_destroy(&c.lock);
    if (b->on_compile && n > 0)
        b->on_compile(b->context, &set->device->info, NULL, n, n);
    return c.failure.status == DUET_STATUS_OK || error_copy(err, &c.failure);
}

// ---------------------------------------------------------------- a set, with its kernels

// Unless a folder was named, a driver that keeps its kernels itself is left to do so.
bool program_builder_keeps(const program_builder *b, const duet_device_info *info)
{
    return b->cache_dir && !(b->is_default && (driver_quirks(info) & DRIVER_KEEPS_KERNELS));
}

static void look_in_folder(const program_set *set, program *p)
{
    text binary = {0};
    cache_key(p->text, PROGRAM_OPTIONS, &set->device->info, p->key);
    if (cache_get(set->cache_dir, p->key, &binary)) {
        p->binary = binary.chars;
        p->binary_bytes = binary.length;
    }
}

// Takes what another world has on the device, or the folder.
static void look_up(program_set *set)
{
    for (program *p = set->first; p; p = p->next)
        if (is_wanted(p) && !program_pool_take(set->device->built, p) && set->cache_dir)
            look_in_folder(set, p);
}

static bool create_kernels(const program_set *set, program *p, duet_error *err)
{
    for (int i = 0; i < p->n_entries; ++i) {
        kernel *k = &p->entries[i].k;
        cl_int code = CL_SUCCESS;
        if (k->state != KERNEL_ASKED)
            continue;
        k->cl = clCreateKernel(p->cl, p->entries[i].entry, &code);
        if (!k->cl)
            return error_set(err, DUET_STATUS_BUILD_FAILED, "%s on %s: has no kernel '%s'", p->name,
                             set->device->info.selector, p->entries[i].entry);
        k->state = KERNEL_BUILT;
        device_object_made();
    }
    free(p->text);
    p->text = NULL;
    return true;
}

void program_set_spare(program_set *set)
{
    for (program *p = set->first; p; p = p->next)
        for (int i = 0; i < p->n_entries; ++i)
            kernel_spare(&p->entries[i].k);
}

bool program_set_build(program_set *set, duet_error *err)
{
    look_up(set);
    bool ok = build_missing(set, err);
    for (program *p = set->first; ok && p; p = p->next)
        ok = !p->cl || create_kernels(set, p, err);
    if (!ok)
        program_set_spare(set);
    return ok;
}
