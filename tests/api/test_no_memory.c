// SPDX-License-Identifier: MIT
// Whichever call for memory fails, the failure that is told is that one. --all: each of them; else
// a sample.
#define _POSIX_C_SOURCE 200809L
#include "support/test.h"

#include "base/text.h"
#include "gen/gen.h"
#include "profiles/exchange.h"
#include "profiles/lookup.h"
#include "support/store.h"
#include "wrong/memory.h"

// Does it once for each call for memory, which fails alone, or with all behind it.
static void assert_told(bool (*work)(duet_error *err))
{
    rng random = rng_seed(test_seed());
    memory_refuse(UINT64_MAX, 0);
    must(work(ERR));
    const uint64_t n = memory_asked(), step = test_takes_all() ? 1 : n / 100 + 1;
    uint64_t n_failed = 0;
    assert_true(n > 0);
    for (uint64_t at = rng_below(&random, (uint32_t)step); at < 2 * n; at += step) {
        duet_error err = {0};
        memory_refuse(at % n, at < n ? at : UINT64_MAX);
        const bool ok = work(&err);
        memory_refuse(UINT64_MAX, 0);
        n_failed += !ok;
        if (ok != (err.status == DUET_STATUS_OK) || (!ok && err.status != DUET_STATUS_NO_MEMORY))
            fail_msg("call %" PRIu64 " of %" PRIu64 " for memory fails: %s: %s", at % n, n,
                     duet_status_name(err.status), err.text);
    }
    assert_true(n_failed > 0);
}

// ---------------------------------------------------------------- kernels of a folder

static char folder[64];

static const char card[] = "return {\n"
                           "  about = 'adds',\n"
                           "  params = { { 'WG', values = { 64, 32 }, about = 'a group' },\n"
                           "             { 'PER_ITEM', min = 1, max = 4 } },\n"
                           "  args = { k = [[ uint n\n uint *x ]] },\n"
                           "  uses = { 'common.clh' },\n"
                           "}\n";

static void write_kernel(void)
{
    static const char *const files[][2] = {
        {"common.clh", "// shared\n"},
        {"k.lua", card},
        {"k.cl.in", "//@ for i = 1, 2 do\n// ${i}\n//@ end\nkernel void k(ARGS_OF_k) {}\n"}};
    test_make_folder(folder);
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        own(text) path = {0};
        text_add(&path, "%s/%s", folder, files[i][0]);
        test_write_file(text_chars(&path), files[i][1]);
    }
}

static bool make_kernel(duet_error *err)
{
    const gen_limits limits = {.max_group = 1024, .local_bytes = 48 << 10, .fp64 = true};
    gen_variant v = {.text = NULL};
    gen *g = gen_open(folder, err);
    const bool ok = g && gen_make(g, "k", NULL, 0, &limits, &v, err);
    gen_variant_free(&v);
    gen_close(g);
    return ok;
}

TEST(a_kernel_is_not_made_for_want_of_memory)
{
    write_kernel();
    assert_told(make_kernel);
}

// ---------------------------------------------------------------- scenes

static bool load_scene(duet_error *err)
{
    const duet_setting settings[] = {{"n", "20"}};
    duet_scene *scene = duet_scene_load("falling", settings, 1, err);
    const bool ok = scene;
    duet_scene_destroy(scene);
    return ok;
}

TEST(a_scene_is_not_read_for_want_of_memory)
{
    assert_told(load_scene);
}

// ---------------------------------------------------------------- stores

static char *lines;
static size_t n_lines;

// Into a store that has none of it.
static bool import(duet_error *err)
{
    profile_import_counts counts;
    FILE *in = fmemopen(lines, n_lines, "r");
    store *s = store_open("import.db", STORE_WRITE, err);
    const bool ok = s && profile_import(s, in, "rows.jsonl", &counts, err);
    store_close(s);
    fclose(in);
    remove("import.db");
    return ok;
}

TEST(rows_are_not_imported_for_want_of_memory)
{
    FILE *out = open_memstream(&lines, &n_lines);
    must(profile_export(test_store_tuned(), out, "an export", ERR));
    fclose(out);
    test_keep(lines, free);
    assert_told(import);
}

static bool look_up(duet_error *err)
{
    store *s = store_open("tuned.db", STORE_READ, err);
    const profile_request request = test_usual_request(1500);
    profile_found found;
    const bool ok = s && profile_lookup(s, &request, &found, NULL, err);
    store_close(s);
    return ok;
}

TEST(no_profile_is_found_for_want_of_memory)
{
    test_store_tune("tuned.db");
    assert_told(look_up);
}
