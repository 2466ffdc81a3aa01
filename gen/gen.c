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

gen *gen_open(const char *kernel_dir, duet_error *err)
{
    gen *g = calloc(1, sizeof *g);
    bool ok = g;
    if (ok && kernel_dir)
        ok = (g->dir = strdup(kernel_dir));
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "the generator: no memory");
    ok = ok && (kernel_dir ? list_dir(g, err) : list_carried(g, err));
    if (!ok) {
        gen_close(g);
        return NULL;
    }
    if (g->n_kernels > 1)
        qsort(g->kernels, g->n_kernels, sizeof *g->kernels, compare_names);
    for (uint32_t i = 1; i < g->n_kernels; ++i) {
        const kernel *k = &g->kernels[i];
        if (strcmp(k->name, k[-1].name) != 0)
            continue;
        error_set(err, DUET_STATUS_BAD_INPUT,
                  "kernel %s: its card is in %s and in %s; expected one", k->name,
                  *k[-1].folder ? k[-1].folder : "./", *k->folder ? k->folder : "./");
        gen_close(g);
        return NULL;
    }
    return g;
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
        signature_define(&v->entries[i], out);
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

bool gen_count(gen *g, const char *name, const gen_limits *limits, uint64_t *count, duet_error *err)
{
    kernel *k = find_kernel(g, name, err);
    return k && space_count(&k->space, &k->card, limits, count, err);
}

bool gen_config(gen *g, const char *name, const gen_limits *limits, uint64_t index,
                gen_setting *config, duet_error *err)
{
    kernel *k = find_kernel(g, name, err);
    return k && space_config(&k->space, &k->card, limits, index, config, err);
}
