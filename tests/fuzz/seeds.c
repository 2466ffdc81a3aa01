// SPDX-License-Identifier: MIT
// Writes the inputs to begin with that need no place in the sources:
//
//   fuzz_seeds FOLDER DATA
//
// A folder for each target is made in FOLDER. DATA is tests/data.
#define _POSIX_C_SOURCE 200809L
#include "support/motions.h"

#include "support/store.h"
#include "support/test.h"

#include "base/text_file.h"
#include "profiles/exchange.h"
#include "profiles/level_cost.h"
#include "profiles/sql.h"
#include "runtime/opencl/cache.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

static const char *folder;

typedef struct place {
    char chars[512];
} place;

// FOLDER/TARGET/NAME, with its folder made.
static place place_of(const char *target, const char *name)
{
    place p;
    snprintf(p.chars, sizeof p.chars, "%s/%s", folder, target);
    mkdir(p.chars, 0777);
    snprintf(p.chars, sizeof p.chars, "%s/%s/%s", folder, target, name);
    return p;
}

static void require(bool ok, const duet_error *err)
{
    if (ok)
        return;
    fprintf(stderr, "fuzz_seeds: %s\n", err->text);
    exit(1);
}

static void put(const char *target, const char *name, const text *bytes)
{
    duet_error err = {0};
    place p = place_of(target, name);
    require(text_ok(bytes, &err) && text_write_file(p.chars, bytes->chars, bytes->length, &err),
            &err);
}

// ---------------------------------------------------------------- arrays

static void add_header(text *file, int version, const char *type, bool fortran, uint32_t rows,
                       uint32_t columns)
{
    text header = {0};
    text_add(&header, "{'descr': '%s', 'fortran_order': %s, 'shape': (%u, %u), }\n", type,
             fortran ? "True" : "False", rows, columns);
    const char length[] = {(char)header.length, 0, 0, 0};
    text_add(file, "\x93NUMPY%c", version);
    text_add_bytes(file, "\0", 1);
    text_add_bytes(file, length, version == 1 ? 2 : 4);
    text_add_bytes(file, header.chars, header.length);
    text_free(&header);
}

// A valid row whatever its kind: lower corners 0 and all else 1.
static void add_rows(text *file, bool doubles, uint32_t rows, uint32_t columns)
{
    for (uint32_t i = 0; i < rows * columns; ++i) {
        double value = i % columns < columns / 2 ? 0.0 : 1.0;
        float less = (float)value;
        text_add_bytes(file, doubles ? (const char *)&value : (const char *)&less,
                       doubles ? sizeof value : sizeof less);
    }
}

static void put_array(const char *target, int version, bool doubles, bool fortran, uint32_t columns)
{
    char name[64];
    text file = {0};
    snprintf(name, sizeof name, "v%d.%s.%s.%u.npy", version, doubles ? "f8" : "f4",
             fortran ? "columns" : "rows", columns);
    add_header(&file, version, doubles ? "<f8" : "<f4", fortran, 2, columns);
    add_rows(&file, doubles, 2, columns);
    put(target, name, &file);
    text_free(&file);
}

static void put_arrays(void)
{
    static const uint32_t columns[] = {4, 5, 6, 10};
    for (uint32_t i = 0; i < 8; ++i)
        put_array("npy", i % 3 + 1, i % 2, i / 4, columns[i % 4]);
    for (uint32_t i = 0; i < 4; ++i)
        put_array("pairs", i % 3 + 1, i % 2, i / 2, 10 + 10 * (i % 2));
}

// ---------------------------------------------------------------- stores

// Small pages make a small file, of which a change hits more.
static void put_store(const char *name, bool filled)
{
    duet_error err = {0};
    place p = place_of("store", name);
    remove(p.chars);
    store *s = store_open(p.chars, STORE_WRITE, &err);
    require(s, &err);
    if (filled) {
        test_tune_usual(s);
        test_fill_out(s);
    }
    place lines = place_of("import", filled ? "rows.jsonl" : "none.jsonl");
    require(profile_export_file(s, profile_export, lines.chars, &err), &err);
    store_close(s);
    test_store_run(p.chars, "PRAGMA journal_mode = DELETE; PRAGMA page_size = 512; VACUUM");
}

// ---------------------------------------------------------------- caches

static void put_entry(void)
{
    static const char key[65] = "00000000000000000000000000000000000000000000000000000000000000fe";
    place p = place_of("cache", "");
    if (!cache_put(p.chars, key,
                   "\x7f"
                   "ELF and so on",
                   15))
        exit(1);
}

// ---------------------------------------------------------------- motions

// The same recording with a hash behind its second step, which a fuzzer reaches: the form of
// docs/formats.md.
static void put_hash_kept(const char *path)
{
    enum { HEAD = 40, RECORD = 16 };
    const uint32_t two[4] = {0, 2}, hash[4] = {254, 1}, rest[4] = {0, 18};
    const uint64_t value = 1;
    duet_error err = {0};
    text file = {0}, kept = {0};
    require(text_read_file(&file, path, &err), &err);
    text_add_bytes(&kept, file.chars, HEAD);
    text_add_bytes(&kept, (const char *)two, RECORD);
    text_add_bytes(&kept, (const char *)hash, RECORD);
    text_add_bytes(&kept, (const char *)&value, sizeof value);
    text_add_bytes(&kept, (const char *)rest, RECORD);
    text_add_bytes(&kept, file.chars + HEAD + RECORD, file.length - HEAD - RECORD - 8);
    uint64_t sum = text_checksum(kept.chars, kept.length);
    text_add_bytes(&kept, (const char *)&sum, sizeof sum);
    put("replay", "hash.replay", &kept);
    text_free(&file);
    text_free(&kept);
}

// At the start, where the boxes touch, and after a command.
static void put_states(void)
{
    duet_error err = {0};
    const duet_body_list first = {.n = 1};
    duet_device_pair *pair = motions_open_pair(&err);
    require(pair, &err);
    for (int which = 0; which < MOTIONS; ++which) {
        duet_motion *m = motions_make(which, pair, &err);
        require(m, &err);
        for (int step = 0; step <= 30; ++step) {
            char name[32];
            duet_motion_result result;
            snprintf(name, sizeof name, "%d.%d.motion", which, step);
            place p = place_of("motion", name);
            if (step == 0 && which == 0)
                require(duet_motion_record(m, &err), &err);
            require(step % 15 > 0 || duet_motion_save(m, p.chars, &err), &err);
            require(step != 20 || duet_motion_remove_bodies(m, first, &err), &err);
            require(duet_motion_advance(m, &result, &err), &err);
        }
        if (which == 0) {
            place p = place_of("replay", "0.replay");
            require(duet_motion_save_recording(m, p.chars, &err), &err);
            put_hash_kept(p.chars);
        }
        duet_motion_destroy(m);
    }
    duet_device_pair_destroy(pair);
}

int main(int argc, char **argv)
{
    if (argc != 2)
        return 2;
    folder = argv[1];
    mkdir(folder, 0777);
    put_arrays();
    put_store("filled.db", true);
    put_store("empty.db", false);
    put_entry();
    put_states();
    return 0;
}
