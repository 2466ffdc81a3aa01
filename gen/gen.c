// SPDX-License-Identifier: MIT
// A variant's text is its config as #defines, the headers its card asks for,
// and the kernel itself. A kernel's files are read when it is first asked for,
// so that a broken one does not stop the others.
#define _POSIX_C_SOURCE 200809L
#include "gen/gen.h"
#include "base/blob.h"
#include "gen/kernel.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <sha256.h>
#include <stdlib.h>
#include <string.h>

struct gen {
    char *dir; // NULL: what is carried
    kernel *kernels;
    uint32_t n_kernels;
};

// ---------------------------------------------------------------- the list

// The length of NAME in "NAME.lua"; 0 where it is no card.
static size_t card_length(const char *file)
{
    size_t length = strlen(file);
    bool is_card = length > 4 && file[0] != '.' && strcmp(file + length - 4, ".lua") == 0;
    return is_card ? length - 4 : 0;
}

// Takes up the kernel of a card, FOLDER/NAME.lua or NAME.lua; no other file.
static bool add_kernel(gen *g, const char *path, duet_error *err)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    size_t folder = (size_t)(name - path), length = card_length(name);
    if (length == 0)
        return true;
    kernel *grown = realloc(g->kernels, (g->n_kernels + 1) * sizeof *grown);
    if (!grown)
        return error_set(err, DUET_STATUS_NO_MEMORY, "the list of kernels: no memory");
    g->kernels = grown;
    kernel *k = &grown[g->n_kernels];
    if (length >= sizeof k->name || folder >= sizeof k->folder)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: a kernel's name has at most %zu letters, its folder's %zu", path,
                         sizeof k->name - 1, sizeof k->folder - 2);
    *k = (kernel){0};
    memcpy(k->name, name, length);
    memcpy(k->folder, path, folder);
    ++g->n_kernels;
    return true;
}

static bool list_carried(gen *g, duet_error *err)
{
    bool ok = true;
    for (const blob *b = blobs; ok && b->path; ++b)
        if (strncmp(b->path, "kernels/", 8) == 0)
            ok = add_kernel(g, b->path + 8, err);
    return ok;
}

// Cards in the folder, and in those within it; `inner` is "", or one of these.
static bool list_folder(gen *g, const char *inner, duet_error *err)
{
    text path = {0};
    text_add(&path, "%s/%s", g->dir, inner);
    DIR *dir = opendir(text_chars(&path));
    text_free(&path);
    bool ok = true;
    for (struct dirent *entry; dir && ok && (entry = readdir(dir));) {
        text file = {0};
        text_add(&file, "%s%s", inner, entry->d_name);
        ok = text_ok(&file, err) && add_kernel(g, file.chars, err);
        if (ok && !*inner && *entry->d_name != '.') {
            text_add(&file, "/");
            ok = text_ok(&file, err) && list_folder(g, file.chars, err);
        }
        text_free(&file);
    }
    if (dir)
        closedir(dir);
    return ok &&
           (dir || *inner ||
            error_set(err, DUET_STATUS_NOT_FOUND, "kernel folder %s: %s", g->dir, strerror(errno)));
}

static bool list_dir(gen *g, duet_error *err)
{
    return list_folder(g, "", err) &&
           (g->n_kernels > 0 || error_set(err, DUET_STATUS_NOT_FOUND,
                                          "kernel folder %s: no card (*.lua) in it", g->dir));
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const kernel *)a)->name, ((const kernel *)b)->name);
}

// By their names, of which there is one each.
static bool order_kernels(gen *g, duet_error *err)
{
    bool ok = true;
    if (g->n_kernels > 1)
        qsort(g->kernels, g->n_kernels, sizeof *g->kernels, compare_names);
    for (uint32_t i = 1; ok && i < g->n_kernels; ++i) {
        const kernel *k = &g->kernels[i];
        if (strcmp(k->name, k[-1].name) == 0)
            ok = error_set(err, DUET_STATUS_BAD_INPUT,
                           "kernel %s: its card is in %s and in %s; expected one", k->name,
                           *k[-1].folder ? k[-1].folder : "./", *k->folder ? k->folder : "./");
    }
    return ok;
}

gen *gen_open(const char *kernel_dir, duet_error *err)
{
    gen *g = calloc(1, sizeof *g);
    bool ok = g;
    if (ok && kernel_dir)
        ok = (g->dir = strdup(kernel_dir));
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "the generator: no memory");
    ok = ok && (kernel_dir ? list_dir(g, err) : list_carried(g, err)) && order_kernels(g, err);
    if (ok)
        return g;
    gen_close(g);
    return NULL;
}

void gen_close(gen *g)
{
    if (!g)
        return;
    for (uint32_t i = 0; i < g->n_kernels; ++i)
        kernel_forget(&g->kernels[i]);
    free(g->kernels);
    free(g->dir);
    free(g);
}

const char *gen_kernel(const gen *g, uint32_t i)
{
    return i < g->n_kernels ? g->kernels[i].name : NULL;
}

const char *gen_built_ins(const gen *g)
{
    return g->dir ? NULL : blob_find("kernels/built_ins.clh")->bytes;
}

static kernel *find_kernel(gen *g, const char *name, duet_error *err)
{
    for (uint32_t i = 0; i < g->n_kernels; ++i) {
        kernel *k = &g->kernels[i];
        if (strcmp(k->name, name) == 0)
            return k->is_read || kernel_read(k, g->dir, err) ? k : NULL;
    }
    text all = {0};
    for (uint32_t i = 0; i < g->n_kernels; ++i)
        text_add(&all, "%s%s", i > 0 ? ", " : "", g->kernels[i].name);
    error_set(err, DUET_STATUS_NOT_FOUND, "no kernel '%s': there are %s", name, text_chars(&all));
    text_free(&all);
    return NULL;
}

// ---------------------------------------------------------------- variants

static bool is_said(const gen_param *param, const gen_setting *setting)
{
    return !param->silent || setting->value != 0;
}

// What varies, in the card's order; a range is the scene's and not named.
static bool name_variant(const card *c, const gen_setting *config, gen_variant *v, duet_error *err)
{
    text name = {0};
    text_add(&name, "%s", c->kernel);
    for (uint32_t i = 0; i < c->n_params; ++i)
        if (c->params[i].n_values > 1 && is_said(&c->params[i], &config[i]))
            text_add(&name, ".%s%" PRId64, config[i].name, config[i].value);
    bool ok = text_ok(&name, err);
    if (ok && name.length >= sizeof v->name)
        ok =
            error_set(err, DUET_STATUS_BUILD_FAILED, "%s: a variant's name has at most %zu letters",
                      name.chars, sizeof v->name - 1);
    if (ok)
        memcpy(v->name, name.chars, name.length + 1);
    text_free(&name);
    return ok;
}

// "__global const double4 *restrict rotations" of "real4 *".
static void add_argument(const gen_arg *a, text *out)
{
    bool is_buffer = a->bytes == 0, is_real = strncmp(a->type, "real", 4) == 0;
    const char *memory = a->is_constant ? "__constant " : "__global ";
    const char *alone = a->is_constant ? "" : "restrict ";
    const char *real = a->is_double ? "double" : "float";
    text_add(out, " \\\n    %s%s%s", a->is_volatile ? "volatile " : "", is_buffer ? memory : "",
             a->is_const ? "const " : "");
    text_add(out, "%s%s%s%s", is_real ? real : "", a->type + (is_real ? 4 : 0),
             is_buffer ? alone : " ", a->name);
}

// "#define ENTRY_ARGS ...", the parameters as the kernel's text names them.
static void add_entry(const gen_entry *entry, text *out)
{
    text_add(out, "#define ");
    for (const char *c = entry->name; *c; ++c)
        text_add(out, "%c", *c >= 'a' && *c <= 'z' ? *c - 'a' + 'A' : *c);
    text_add(out, "_ARGS");
    for (uint32_t i = 0; i < entry->n_args; ++i) {
        add_argument(&entry->args[i], out);
        text_add(out, i + 1 < entry->n_args ? "," : "");
    }
    text_add(out, "\n");
}

static void add_prelude(const card *c, const gen_setting *config, const gen_variant *v, text *out)
{
    text_add(out, "// %s\n", v->name);
    for (uint32_t i = 0; i < c->n_params; ++i) {
        bool negative = config[i].value < 0;
        if (!is_said(&c->params[i], &config[i]))
            continue;
        text_add(out, negative ? "#define %s (%" PRId64 ")\n" : "#define %s %" PRId64 "\n",
                 config[i].name, config[i].value);
    }
    for (uint32_t i = 0; i < v->n_entries; ++i)
        add_entry(&v->entries[i], out);
}

static bool add_kernel_text(const kernel *k, const gen_setting *config, text *out, duet_error *err)
{
    if (!k->choices)
        text_add_bytes(out, k->plain.chars, k->plain.length);
    else if (!template_expand(k->choices, config, k->card.n_params, out, err))
        return false;
    return k->template ? template_expand(k->template, config, k->card.n_params, out, err)
                       : text_ok(out, err);
}

bool gen_make(gen *g, const char *name, const gen_setting *settings, uint32_t n_settings,
              const gen_limits *limits, gen_variant *variant, duet_error *err)
{
    *variant = (gen_variant){0};
    kernel *k = find_kernel(g, name, err);
    if (!k)
        return false;
    gen_setting config[CARD_MAX_PARAMS] = {{NULL, 0}};
    card_launch launch = {0};
    text out = {0};
    bool ok = card_fill(&k->card, settings, n_settings, limits, config, err);
    ok = ok && card_check(&k->card, limits, config, &launch, err);
    ok = ok && card_entries(&k->card, config, &variant->entries, err);
    ok = ok && name_variant(&k->card, config, variant, err);
    if (ok) {
        variant->n_entries = k->card.n_signatures;
        add_prelude(&k->card, config, variant, &out);
        ok = add_kernel_text(k, config, &out, err);
    }
    if (!ok) {
        text_free(&out);
        gen_variant_free(variant);
        return false;
    }
    SHA256Data((const uint8_t *)out.chars, out.length, variant->sha256);
    variant->text = out.chars;
    variant->group = launch.group;
    variant->per_item = launch.per_item;
    return true;
}

void gen_variant_free(gen_variant *variant)
{
    free(variant->text);
    free(variant->entries);
    *variant = (gen_variant){0};
}

// ---------------------------------------------------------------- what varies

bool gen_about(gen *g, const char *name, const char **about, duet_error *err)
{
    const kernel *k = find_kernel(g, name, err);
    if (k)
        *about = k->card.about;
    return k;
}

bool gen_params(gen *g, const char *name, const gen_limits *limits, const gen_param **params,
                uint32_t *n_params, duet_error *err)
{
    kernel *k = find_kernel(g, name, err);
    if (!k || !card_set_fallbacks(&k->card, limits, err))
        return false;
    *params = k->card.params;
    *n_params = k->card.n_params;
    return true;
}

// ---------------------------------------------------------------- valid configs

// Only how many there are in each block of the numbering is kept, no list of them.
enum { BLOCK = 256 };

static bool same_limits(const gen_limits *a, const gen_limits *b)
{
    return a->max_group == b->max_group && a->local_bytes == b->local_bytes && a->fp64 == b->fp64 &&
           a->cpu == b->cpu;
}

// Walks through the block from its first config on and ends after the valid
// one that makes n `enough`, which is then in config.
static bool walk_block(card *c, const gen_limits *limits, uint64_t block, uint64_t enough,
                       gen_setting *config, uint64_t *n, duet_error *err)
{
    uint64_t size = card_size(c), end = (block + 1) * BLOCK;
    *n = 0;
    for (uint64_t i = block * BLOCK; i < size && i < end && *n < enough; ++i) {
        card_launch launch;
        duet_error why = {0};
        card_config(c, i, config);
        bool valid = card_check(c, limits, config, &launch, &why);
        if (!valid && why.status != DUET_STATUS_BAD_ARGUMENT)
            return error_copy(err, &why);
        *n += valid;
    }
    return true;
}

static bool count_blocks(kernel *k, const gen_limits *limits, duet_error *err)
{
    gen_setting config[CARD_MAX_PARAMS];
    uint64_t n_blocks = (card_size(&k->card) + BLOCK - 1) / BLOCK;
    uint64_t *before = calloc(n_blocks + 1, sizeof *before);
    bool ok = before || error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory to count configs",
                                  k->card.kernel);
    for (uint64_t i = 0, n = 0; ok && i < n_blocks; ++i) {
        ok = walk_block(&k->card, limits, i, BLOCK, config, &n, err);
        before[i + 1] = before[i] + n;
    }
    if (ok)
        k->valid = (valid_configs){*limits, before, n_blocks};
    else
        free(before);
    return ok;
}

static bool count_valid(kernel *k, const gen_limits *limits, duet_error *err)
{
    if (!card_set_fallbacks(&k->card, limits, err))
        return false;
    if (k->valid.before && same_limits(&k->valid.limits, limits))
        return true;
    free(k->valid.before);
    k->valid.before = NULL;
    return count_blocks(k, limits, err);
}

bool gen_count(gen *g, const char *name, const gen_limits *limits, uint64_t *count, duet_error *err)
{
    kernel *k = find_kernel(g, name, err);
    if (!k || !count_valid(k, limits, err))
        return false;
    *count = k->valid.before[k->valid.n_blocks];
    return true;
}

// The block that holds valid config number index.
static uint64_t block_of(const valid_configs *valid, uint64_t index)
{
    uint64_t low = 0, high = valid->n_blocks;
    while (high - low > 1) {
        uint64_t middle = low + (high - low) / 2;
        if (valid->before[middle] <= index)
            low = middle;
        else
            high = middle;
    }
    return low;
}

bool gen_config(gen *g, const char *name, const gen_limits *limits, uint64_t index,
                gen_setting *config, duet_error *err)
{
    kernel *k = find_kernel(g, name, err);
    if (!k || !count_valid(k, limits, err))
        return false;
    const valid_configs *valid = &k->valid;
    uint64_t count = valid->before[valid->n_blocks];
    if (index >= count)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s: config %" PRIu64 " of %" PRIu64,
                         k->card.kernel, index, count);
    uint64_t block = block_of(valid, index), n = 0;
    return walk_block(&k->card, limits, block, index - valid->before[block] + 1, config, &n, err);
}
