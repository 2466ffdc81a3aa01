// SPDX-License-Identifier: MIT
// A variant's text is its config as #defines, the headers its card asks for,
// and the kernel itself. A kernel's files are read when it is first asked for,
// so that a broken one does not stop the others.
#define _POSIX_C_SOURCE 200809L
#include "gen/kernel.h"
#include "base/blob.h"
#include "base/text_file.h"

#include <limits.h>
#include <sha256.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Folder, name and ending.
enum { FILE_SIZE = sizeof((kernel *)0)->name + sizeof((kernel *)0)->folder + 8 };

// ---------------------------------------------------------------- files

static bool file_exists(const char *dir, const char *file)
{
    char path[PATH_MAX];
    const int n = snprintf(path, sizeof path, "%s/%s", dir ? dir : "kernels", file);
    return n < PATH_MAX && (dir ? access(path, F_OK) == 0 : blob_find(path) != NULL);
}

// Appends a file of the kernels' folder, and tells its path.
static bool read_file(const char *dir, const char *file, text *path, text *chars, duet_error *err)
{
    text_add(path, "%s/%s", dir ? dir : "kernels", file);
    if (!text_ok(path, err))
        return false;
    if (dir)
        return text_read_file(chars, path->chars, err);
    const blob *b = blob_find(path->chars);
    if (!b)
        return error_set(err, DUET_STATUS_NOT_FOUND, "%s: there is no such file", path->chars);
    text_add_bytes(chars, b->bytes, b->length);
    return text_ok(chars, err);
}

// The name does not depend on the folder, so that equal kernels have equal
// text wherever they were read from.
static void begin_file(const char *file, text *out)
{
    text_add(out, "#line 1 \"kernels/%s\"\n", file);
}

static bool end_file(text *out, duet_error *err)
{
    if (text_ok(out, NULL) && out->chars[out->length - 1] != '\n')
        text_add(out, "\n");
    return text_ok(out, err);
}

static bool add_file(const char *dir, const char *file, text *out, duet_error *err)
{
    text path = {0};
    begin_file(file, out);
    bool ok = read_file(dir, file, &path, out, err);
    text_free(&path);
    return ok && end_file(out, err);
}

static bool is_added(const gen *g, const char *file)
{
    char own[FILE_SIZE];
    bool is = false;
    for (uint32_t i = 0; i < g->n_kernels; ++i) {
        snprintf(own, sizeof own, "%s.cl", g->kernels[i].name);
        is = is || (g->kernels[i].given_text && strcmp(own, file) == 0);
    }
    return is;
}

const char *gen_folder(const gen *g, const char *file)
{
    return g->dir && !is_added(g, file) && file_exists(g->dir, file) ? g->dir : NULL;
}

// ---------------------------------------------------------------- parts

static void kernel_forget(kernel *k)
{
    if (k->is_read)
        card_close(&k->card);
    free(k->valid.before);
    k->valid = (valid_configs){0};
    text_free(&k->plain);
    for (int i = 0; i < KERNEL_MADE; ++i)
        text_free(&k->made[i].whole);
    template_close(k->choices);
    template_close(k->template);
    k->choices = k->template = NULL;
    k->is_read = false;
}

void kernel_close(kernel *k)
{
    kernel_forget(k);
    free(k->given_card);
    free(k->given_text);
}

static bool read_card(const char *dir, kernel *k, duet_error *err)
{
    char file[FILE_SIZE];
    snprintf(file, sizeof file, "%s%s.lua", k->folder, k->name);
    text path = {0}, chars = {0};
    if (k->given_card) {
        text_add(&path, "the card of %s", k->name);
        text_add(&chars, "%s", k->given_card);
    }
    k->is_read = (k->given_card ? text_ok(&path, err) && text_ok(&chars, err)
                                : read_file(dir, file, &path, &chars, err)) &&
                 card_open(&k->card, k->name, path.chars, &chars, err);
    text_free(&path);
    text_free(&chars);
    return k->is_read;
}

static bool read_headers(const char *dir, kernel *k, duet_error *err)
{
    static const char common[] = "common.clh"; // the carried one, unless the folder has its own
    bool ok = add_file(dir && file_exists(dir, common) ? dir : NULL, common, &k->plain, err);
    for (uint32_t i = 0; ok && i < k->card.uses.n; ++i)
        ok = add_file(dir, k->card.uses.at[i], &k->plain, err);
    return ok;
}

static bool read_template(const char *dir, kernel *k, const char *file, duet_error *err)
{
    text path = {0}, chars = {0};
    char line_name[FILE_SIZE + sizeof "kernels/"];
    snprintf(line_name, sizeof line_name, "kernels/%s", file);
    if (read_file(dir, file, &path, &chars, err))
        k->template = template_open(&chars, path.chars, line_name, &k->card.emit, err);
    text_free(&path);
    text_free(&chars);
    return k->template;
}

static bool read_body(const char *dir, kernel *k, duet_error *err)
{
    char plain[FILE_SIZE], shaped[FILE_SIZE];
    snprintf(plain, sizeof plain, "%s%s.cl", k->folder, k->name);
    snprintf(shaped, sizeof shaped, "%s%s.cl.in", k->folder, k->name);
    if (k->given_text) {
        begin_file(plain, &k->plain);
        text_add_bytes(&k->plain, k->given_text, strlen(k->given_text));
        return end_file(&k->plain, err);
    }
    if (!file_exists(dir, shaped))
        return add_file(dir, plain, &k->plain, err);
    if (file_exists(dir, plain))
        return error_set(err, DUET_STATUS_BUILD_FAILED, "%s/%s stands beside %s: keep one of them",
                         dir ? dir : "kernels", plain, shaped);
    return read_template(dir, k, shaped, err);
}

static bool read_choices(kernel *k, duet_error *err)
{
    char name[FILE_SIZE + sizeof " and its headers"];
    snprintf(name, sizeof name, "%s and its headers", k->name);
    k->choices = template_open(&k->plain, name, NULL, NULL, err);
    return k->choices;
}

static bool read_kernel(kernel *k, const char *dir, duet_error *err)
{
    bool ok = read_card(dir, k, err);
    ok = ok && read_headers(dir, k, err);
    ok = ok && read_body(dir, k, err);
    k->card.has_struct = ok && strstr(k->plain.chars, "ARG_FIELDS");
    ok = ok && (!template_has_lua(&k->plain) || read_choices(k, err));
    if (!ok)
        kernel_forget(k);
    return ok;
}

const char *gen_without(const gen *g)
{
    const char *given = getenv("DUET_KERNEL_DIR");
    return g->dir && given && strcmp(given, g->dir) == 0
               ? "; without DUET_KERNEL_DIR the built-in kernels are read"
               : "";
}

kernel *kernel_find(gen *g, const char *name, duet_error *err)
{
    for (uint32_t i = 0; i < g->n_kernels; ++i) {
        kernel *k = &g->kernels[i];
        if (strcmp(k->name, name) == 0)
            return k->is_read || read_kernel(k, g->dir, err) ? k : NULL;
    }
    text all = {0};
    for (uint32_t i = 0; i < g->n_kernels; ++i)
        text_add(&all, "%s%s", i > 0 ? ", " : "", g->kernels[i].name);
    if (g->dir)
        bad_argument(err, "no kernel '%s' in %s: there are %s%s", name, g->dir, text_chars(&all),
                     gen_without(g));
    else
        bad_argument(err, "no kernel '%s': there are %s", name, text_chars(&all));
    text_free(&all);
    return NULL;
}

// ---------------------------------------------------------------- variants

bool gen_make(gen *g, const char *name, const gen_setting *settings, uint32_t n_settings,
              const gen_limits *limits, gen_variant *variant, duet_error *err)
{
    gen_offer *offers = calloc(n_settings + 1, sizeof *offers);
    *variant = (gen_variant){0};
    if (!offers)
        return no_memory(err, "%s", name);
    for (uint32_t i = 0; i < n_settings; ++i)
        offers[i] = (gen_offer){NULL, settings[i].name, settings[i].value, GEN_REQUIRED, NULL};
    bool ok = gen_make_offered(g, name, offers, n_settings, limits, variant, err);
    free(offers);
    return ok;
}

static bool add_text(const kernel *k, const gen_setting *config, text *out, duet_error *err)
{
    if (!k->choices)
        text_add_bytes(out, k->plain.chars, k->plain.length);
    else if (!template_expand(k->choices, config, k->card.n_params, out, err))
        return false;
    return k->template ? template_expand(k->template, config, k->card.n_params, out, err)
                       : text_ok(out, err);
}

// The text that begins with the prelude, which is freed or becomes its beginning. NULL: it failed.
static const made_text *make_text(kernel *k, const gen_setting *config, text *prelude,
                                  duet_error *err)
{
    for (int i = 0; i < KERNEL_MADE; ++i) {
        const made_text *m = &k->made[i];
        if (m->prelude != prelude->length || !m->whole.chars ||
            memcmp(m->whole.chars, prelude->chars, m->prelude) != 0)
            continue;
        text_free(prelude);
        return m;
    }
    made_text *m = &k->made[k->n_made++ % KERNEL_MADE];
    text_free(&m->whole);
    *m = (made_text){.prelude = prelude->length};
    if (!add_text(k, config, prelude, err)) {
        text_free(prelude);
        return NULL;
    }
    m->whole = *prelude;
    *prelude = (text){0};
    SHA256Data((const uint8_t *)m->whole.chars, m->whole.length, m->sha256);
    return m;
}

bool gen_make_offered(gen *g, const char *name, const gen_offer *offers, uint32_t n_offers,
                      const gen_limits *limits, gen_variant *variant, duet_error *err)
{
    gen_setting config[CARD_MAX_PARAMS] = {{NULL, 0}};
    text out = {0};
    *variant = (gen_variant){0};
    kernel *k = kernel_find(g, name, err);
    bool ok = k && card_fill(&k->card, offers, n_offers, limits, config, err) &&
              card_resolve(&k->card, limits, config, variant, &out, err);
    const made_text *made = ok ? make_text(k, config, &out, err) : NULL;
    variant->text = made ? strdup(made->whole.chars) : NULL;
    if (made && !variant->text)
        no_memory(err, "%s", name);
    if (!variant->text) {
        text_free(&out);
        gen_variant_free(variant);
        return false;
    }
    memcpy(variant->sha256, made->sha256, sizeof made->sha256);
    return true;
}

void gen_variant_free(gen_variant *variant)
{
    free(variant->text);
    free(variant->entries);
    *variant = (gen_variant){0};
}
