// SPDX-License-Identifier: MIT
#include "runtime/opencl/program.h"

#include "base/budget.h"
#include "base/error.h"
#include "runtime/opencl/cache.h"
#include "runtime/opencl/driver.h"
#include "runtime/opencl/thread_pool.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_ENTRIES = 5, MOST_HELPERS = 3 };

// Contraction is off in the kernels' text; nothing here may loosen it.
static const char BUILD_OPTIONS[] = "-cl-std=CL1.2 -w";

typedef struct program {
    struct program *next;
    char sha256[65];
    cl_program cl; // NULL: asked for, and not yet built from its text
    char name[160];
    char *text;
    struct {
        char entry[48];
        kernel k;
    } entries[MAX_ENTRIES];
    int n_entries;
} program;

struct program_set {
    const device *device;
    gen *gen;
    program_builder builder;
    gen_limits limits;
    program *first;
};

// Unless a folder was named, a driver that keeps its kernels itself is left to do so.
bool program_builder_keeps(const program_builder *b, const duet_device_info *info)
{
    return b->cache_dir && !(b->is_default && driver_of(info).keeps_kernels);
}

gen_limits program_limits(const duet_device_info *info)
{
    return (gen_limits){
        .max_group = info->max_group,
        .local_bytes = info->local_bytes,
        .fp64 = info->fp64,
        .cpu = info->kind == DUET_KIND_CPU,
    };
}

program_set *program_set_open(const device *d, gen *g, const program_builder *builder,
                              duet_error *err)
{
    program_set *set = calloc(1, sizeof *set);
    if (!set) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for the kernels of %s", d->info.selector);
        return NULL;
    }
    set->device = d;
    set->gen = g;
    if (builder)
        set->builder = *builder;
    set->limits = program_limits(&d->info);
    return set;
}

gen_limits program_set_limits(const program_set *set)
{
    return set->limits;
}

int64_t kernel_param(const kernel *k, const char *param)
{
    const char *at = k->name;
    size_t length = strlen(param);
    while ((at = strchr(at, '.')))
        if (strncmp(++at, param, length) == 0)
            return strtoll(at + length, NULL, 10);
    return 0;
}

bool kernel_is(const kernel *k, const char *name)
{
    size_t length = strlen(name);
    return k && strncmp(k->name, name, length) == 0 && (k->name[length] == '.' || !k->name[length]);
}

static void release_built(program *p)
{
    if (!p->cl)
        return;
    clReleaseProgram(p->cl);
    device_object_gone();
    p->cl = NULL;
}

static void free_program(program *p)
{
    for (int i = 0; i < p->n_entries; ++i) {
        if (!p->entries[i].k.cl)
            continue;
        clReleaseKernel(p->entries[i].k.cl);
        device_object_gone();
    }
    release_built(p);
    free(p->text);
    free(p);
}

void program_set_close(program_set *set)
{
    if (!set)
        return;
    while (set->first) {
        program *p = set->first;
        set->first = p->next;
        free_program(p);
    }
    free(set);
}

// The compiler's first error, or else its first line.
static bool fail_with_log(const program_set *set, cl_program cl, const char *name, duet_error *err)
{
    char log[16384] = "";
    clGetProgramBuildInfo(cl, set->device->id, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
    const char *from = strstr(log, "error:");
    while (from && from > log && from[-1] != '\n')
        --from;
    if (!from)
        from = log;
    int length = (int)strcspn(from, "\n");
    return error_set(err, DUET_STATUS_BUILD_FAILED, "%s on %s: %.*s", name,
                     set->device->info.selector, length ? length : 22,
                     length ? from : "the compiler is silent");
}

static cl_int build_sources(const program_set *set, program *p, cl_uint n, const char *sources[],
                            const char *options)
{
    cl_int code = CL_SUCCESS;
    p->cl = clCreateProgramWithSource(set->device->context, n, sources, NULL, &code);
    if (!p->cl)
        return code;
    device_object_made();
    return clBuildProgram(p->cl, 1, &set->device->id, options, NULL, NULL);
}

// With declarations of ours in the place of the driver's header.
static bool build_declared(const program_set *set, program *p)
{
    const char *leave_out = driver_of(&set->device->info).header_option;
    const char *sources[] = {gen_built_ins(set->gen), p->text};
    char options[96];
    snprintf(options, sizeof options, "%s %s", BUILD_OPTIONS, leave_out ? leave_out : "");
    return leave_out && sources[0] && build_sources(set, p, 2, sources, options) == CL_SUCCESS;
}

// What a driver refuses with our declarations is built with its own, and its messages count.
static bool build_source(const program_set *set, program *p, duet_error *err)
{
    if (build_declared(set, p))
        return true;
    release_built(p);
    const char *source = p->text;
    cl_int code = build_sources(set, p, 1, &source, BUILD_OPTIONS);
    if (!p->cl)
        return error_set_cl(err, code, "%s on %s", p->name, set->device->info.selector);
    return code == CL_SUCCESS || fail_with_log(set, p->cl, p->name, err);
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

static bool has_cache(const program_set *set)
{
    return program_builder_keeps(&set->builder, &set->device->info);
}

static void find_key(const program_set *set, const program *p, char key[65])
{
    cache_key(p->text, BUILD_OPTIONS, &set->device->info, key);
}

static bool build_kept(const program_set *set, program *p)
{
    if (!has_cache(set))
        return false;
    char key[65];
    text binary = {0};
    find_key(set, p, key);
    bool built = cache_get(set->builder.cache_dir, key, &binary) && build_binary(set, p, &binary);
    text_free(&binary);
    return built;
}

static void keep_binary(const program_set *set, const program *p)
{
    size_t n = 0;
    if (!has_cache(set) ||
        clGetProgramInfo(p->cl, CL_PROGRAM_BINARY_SIZES, sizeof n, &n, NULL) != CL_SUCCESS || !n)
        return;
    char key[65];
    find_key(set, p, key);
    unsigned char *bytes = malloc(n);
    if (bytes && clGetProgramInfo(p->cl, CL_PROGRAM_BINARIES, sizeof bytes, &bytes, NULL) == 0)
        cache_put(set->builder.cache_dir, key, (const char *)bytes, n);
    free(bytes);
}

static void tell(const program_set *set, const char *kernel_name, uint32_t k, uint32_t n)
{
    if (set->builder.on_compile && n > 0)
        set->builder.on_compile(set->builder.context, &set->device->info, kernel_name, k, n);
}

// What another world has on the device, or the cache; how many are left to compile.
static uint32_t take_what_is_built(program_set *set)
{
    uint32_t left = 0;
    for (program *p = set->first; p; p = p->next) {
        if (p->cl)
            continue;
        p->cl = program_pool_take(set->device->built, p->sha256);
        if (!p->cl && build_kept(set, p))
            program_pool_put(set->device->built, p->sha256, p->cl);
        left += !p->cl;
    }
    return left;
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

static void fail_with(compilation *c, const duet_error *why)
{
    pthread_mutex_lock(&c->lock);
    if (c->why.status == DUET_STATUS_OK)
        c->why = *why;
    pthread_mutex_unlock(&c->lock);
}

static void compile_some(void *arg)
{
    compilation *c = arg;
    duet_error why = {0};
    program *p;
    while (budget_check_stop(&why) && (p = take_next(c)) && build_source(c->set, p, &why)) {
        keep_binary(c->set, p);
        program_pool_put(c->set->device->built, p->sha256, p->cl);
    }
    if (why.status != DUET_STATUS_OK)
        fail_with(c, &why);
}

static uint32_t helpers_for(const program_set *set, uint32_t n)
{
    if (n < 2 || driver_of(&set->device->info).compiles_one_by_one)
        return 0;
    return n - 1 < MOST_HELPERS ? n - 1 : MOST_HELPERS;
}

static bool compile_the_others(program_set *set, uint32_t n, duet_error *err)
{
    uint32_t n_helpers = helpers_for(set, n);
    compilation c = {.set = set, .next = set->first, .n = n};
    thread_pool *helpers = n_helpers > 0 ? thread_pool_open(n_helpers, NULL) : NULL;
    pthread_mutex_init(&c.lock, NULL);
    if (helpers)
        thread_pool_start(helpers, compile_some, &c);
    compile_some(&c);
    if (helpers)
        thread_pool_wait(helpers);
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
        free_program(p);
    }
}

bool program_set_build(program_set *set, duet_error *err)
{
    uint32_t n = take_what_is_built(set);
    bool ok = compile_the_others(set, n, err);
    tell(set, NULL, n, n);
    for (program *p = set->first; ok && p; p = p->next) {
        ok = create_kernels(set, p, err);
        if (ok) {
            free(p->text);
            p->text = NULL;
        }
    }
    if (!ok)
        forget_unbuilt(set);
    return ok;
}

static program *new_program(const program_set *set, const gen_variant *variant, duet_error *err)
{
    const char *third_axis = set->device->third_axis;
    text all = {0};
    text_add(&all, "%s%s", third_axis ? third_axis : "", variant->text);
    program *p = text_ok(&all, NULL) ? calloc(1, sizeof *p) : NULL;
    if (!p) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for the program %s", variant->name);
        text_free(&all);
        return NULL;
    }
    memcpy(p->sha256, variant->sha256, sizeof p->sha256);
    memcpy(p->name, variant->name, sizeof p->name);
    p->text = all.chars;
    return p;
}

static program *find_or_add(program_set *set, const gen_variant *variant, duet_error *err)
{
    for (program *p = set->first; p; p = p->next)
        if (strcmp(p->sha256, variant->sha256) == 0)
            return p;
    program *p = new_program(set, variant, err);
    if (p) {
        p->next = set->first;
        set->first = p;
    }
    return p;
}

// ---------------------------------------------------------------- kernels

// The type that the name has otherwise, for a message; NULL where there is no such name.
static const char *other_type(bindings from, const char *name)
{
    for (; from->name; ++from)
        if (strcmp(from->name, name) == 0)
            return from->type;
    return NULL;
}

static const binding *find_binding(bindings from, const gen_arg *arg)
{
    for (; from->name; ++from)
        if (strcmp(from->name, arg->name) == 0 && strcmp(from->type, arg->type) == 0)
            return from;
    return NULL;
}

static bool fail_to_bind(const char *name, const gen_entry *entry, const gen_arg *arg,
                         bindings from, duet_error *err)
{
    const char *type = other_type(from, arg->name);
    if (type)
        return error_set(err, DUET_STATUS_BUILD_FAILED,
                         "kernel %s: argument '%s' of %s is of type '%s'; expected '%s'", name,
                         arg->name, entry->name, arg->type, type);
    return error_set(err, DUET_STATUS_BUILD_FAILED,
                     "kernel %s: %s has an argument '%s' that its launcher does not know", name,
                     entry->name, arg->name);
}

static bool bind_entry(launcher *l, const char *name, const gen_entry *entry, bindings from,
                       duet_error *err)
{
    l->n = 0;
    for (uint32_t i = 0; i < entry->n_args; ++i) {
        const gen_arg *arg = &entry->args[i];
        const binding *b = find_binding(from, arg);
        if (!b)
            return fail_to_bind(name, entry, arg, from, err);
        l->args[l->n].at = b->at;
        l->args[l->n++].bytes = arg->bytes ? arg->bytes : (uint32_t)sizeof(cl_mem);
    }
    return true;
}

// All entries of the program are checked before it is compiled: a compiler says less of
// what is wrong with a card.
static bool bind(const program_set *set, const gen_variant *variant, const char *entry,
                 bindings from, launcher *l, duet_error *err)
{
    bool found = false;
    for (uint32_t i = 0; i < variant->n_entries; ++i) {
        launcher other;
        bool is_meant = strcmp(variant->entries[i].name, entry) == 0;
        if (!bind_entry(is_meant ? l : &other, variant->name, &variant->entries[i], from, err))
            return false;
        found = found || is_meant;
    }
    return found || error_set(err, DUET_STATUS_BUILD_FAILED,
                              "%s on %s: has no kernel '%s' in its card's args", variant->name,
                              set->device->info.selector, entry);
}

static kernel *find_or_add_entry(const program_set *set, program *p, const char *entry,
                                 const gen_variant *variant, const launcher *l, duet_error *err)
{
    for (int i = 0; i < p->n_entries; ++i)
        if (strcmp(p->entries[i].entry, entry) == 0)
            return &p->entries[i].k;
    if (p->n_entries == MAX_ENTRIES) {
        error_set(err, DUET_STATUS_BUILD_FAILED, "%s on %s: has more than %d kernels",
                  variant->name, set->device->info.selector, MAX_ENTRIES);
        return NULL;
    }
    kernel *k = &p->entries[p->n_entries].k;
    k->launcher = *l;
    k->group = variant->group;
    k->per_item = variant->per_item;
    snprintf(k->name, sizeof k->name, "%s", variant->name);
    snprintf(p->entries[p->n_entries].entry, sizeof p->entries[0].entry, "%s", entry);
    ++p->n_entries;
    return k;
}

kernel *program_set_kernel(program_set *set, const char *kernel_name, const char *entry,
                           const gen_setting *settings, uint32_t n_settings, bindings from,
                           duet_error *err)
{
    gen_variant variant = {0};
    launcher l;
    if (!gen_make(set->gen, kernel_name, settings, n_settings, &set->limits, &variant, err))
        return NULL;
    bool bound = bind(set, &variant, entry, from, &l, err);
    program *p = bound ? find_or_add(set, &variant, err) : NULL;
    kernel *k = p ? find_or_add_entry(set, p, entry, &variant, &l, err) : NULL;
    gen_variant_free(&variant);
    return k;
}

bool program_set_check(program_set *set, const char *kernel_name, const gen_setting *settings,
                       uint32_t n_settings, duet_error *err)
{
    gen_variant variant = {0};
    if (!gen_make(set->gen, kernel_name, settings, n_settings, &set->limits, &variant, err))
        return false;
    program *p = new_program(set, &variant, err);
    bool ok = p && build_source(set, p, err);
    if (p)
        free_program(p);
    gen_variant_free(&variant);
    return ok;
}
