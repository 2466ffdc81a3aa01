// SPDX-License-Identifier: MIT
// Which kernels there are, what varies in them, and which configs are valid.
#define _POSIX_C_SOURCE 200809L
#include "gen/gen.h"
#include "base/blob.h"
#include "base/list.h"
#include "gen/kernel.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- the list

// The length of NAME in "NAME.lua"; 0 if it is no card, as "NAME.task.lua".
static size_t card_length(const char *file)
{
    size_t length = strlen(file);
    bool is_card =
        length > 4 && strcspn(file, ".") == length - 4 && strcmp(file + length - 4, ".lua") == 0;
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
    kernel *grown = list_room(g->kernels, g->n_kernels, sizeof *grown, err);
    if (!grown)
        return false;
    g->kernels = grown;
    kernel *k = &grown[g->n_kernels];
    if (length >= sizeof k->name || folder >= sizeof k->folder)
        return bad_argument(err, "%s: a kernel's name has at most %zu letters, its folder's %zu",
                            path, sizeof k->name - 1, sizeof k->folder - 2);
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
    bool ok = text_ok(&path, err);
    DIR *dir = ok ? opendir(path.chars) : NULL;
    text_free(&path);
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
           (g->n_kernels > 0 ||
            error_set(err, DUET_STATUS_NOT_FOUND, "kernel folder %s: no card (*.lua) in it%s",
                      g->dir, gen_without(g)));
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
            ok = bad_input(err, "kernel %s: its card is in %s and in %s; expected one", k->name,
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
        no_memory(err, "the generator");
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
        kernel_close(&g->kernels[i]);
    free(g->kernels);
    free(g->dir);
    free(g);
}

// The kernel of that name without what it had; one that is new, if there is none.
static kernel *make_place(gen *g, const char *name, duet_error *err)
{
    text file = {0};
    text_add(&file, "%s.lua", name);
    kernel *k = g->kernels;
    while (k < g->kernels + g->n_kernels && strcmp(k->name, name) != 0)
        ++k;
    bool is_new = k == g->kernels + g->n_kernels;
    bool ok = text_ok(&file, err) && (!is_new || add_kernel(g, file.chars, err));
    text_free(&file);
    if (!ok)
        return NULL;
    if (is_new)
        return &g->kernels[g->n_kernels - 1];
    kernel_close(k);
    k->given_card = k->given_text = NULL;
    return k;
}

bool gen_add(gen *g, const char *name, const char *card_text, const char *body, duet_error *err)
{
    if (!*name || strpbrk(name, "./"))
        return bad_argument(err, "a kernel's name is '%.48s'; expected letters and digits", name);
    kernel *k = make_place(g, name, err);
    if (!k)
        return false;
    *k->folder = '\0';
    k->given_card = strdup(card_text);
    k->given_text = strdup(body);
    return (k->given_card && k->given_text) || no_memory(err, "%s", name);
}

const char *gen_kernel(const gen *g, uint32_t i)
{
    return i < g->n_kernels ? g->kernels[i].name : NULL;
}

const char *gen_built_ins(const gen *g)
{
    bool carried = !g->dir;
    for (uint32_t i = 0; i < g->n_kernels; ++i)
        carried &= !g->kernels[i].given_text;
    return carried ? blob_find("kernels/built_ins.clh")->bytes : NULL;
}

// ---------------------------------------------------------------- what varies

bool gen_about(gen *g, const char *name, const char **about, duet_error *err)
{
    const kernel *k = kernel_find(g, name, err);
    if (k)
        *about = k->card.about;
    return k;
}

bool gen_params(gen *g, const char *name, const gen_limits *limits, const gen_param **params,
                uint32_t *n_params, duet_error *err)
{
    kernel *k = kernel_find(g, name, err);
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
           a->cpu == b->cpu && a->units == b->units;
}

// Walks through the block from its first config on and ends after the valid
// one that makes n `enough`, which is then in config.
static bool walk_block(card *c, const gen_limits *limits, uint64_t block, uint64_t enough,
                       gen_setting *config, uint64_t *n, duet_error *err)
{
    uint64_t size = card_size(c), end = (block + 1) * BLOCK;
    *n = 0;
    for (uint64_t i = block * BLOCK; i < size && i < end && *n < enough; ++i) {
        bool is_valid;
        card_config(c, i, config);
        if (!card_judge(c, limits, config, &is_valid, err))
            return false;
        *n += is_valid;
    }
    return true;
}

static bool count_blocks(kernel *k, const gen_limits *limits, duet_error *err)
{
    gen_setting config[CARD_MAX_PARAMS];
    uint64_t n_blocks = (card_size(&k->card) + BLOCK - 1) / BLOCK;
    uint64_t *before = calloc(n_blocks + 1, sizeof *before);
    bool ok = before || no_memory(err, "the configs of %s", k->card.kernel);
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
    kernel *k = kernel_find(g, name, err);
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
    kernel *k = kernel_find(g, name, err);
    if (!k || !count_valid(k, limits, err))
        return false;
    const valid_configs *valid = &k->valid;
    uint64_t count = valid->before[valid->n_blocks];
    if (index >= count)
        return bad_argument(err, "%s: config %" PRIu64 " of %" PRIu64, k->card.kernel, index,
                            count);
    uint64_t block = block_of(valid, index), n = 0;
    return walk_block(&k->card, limits, block, index - valid->before[block] + 1, config, &n, err);
}
