// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "profiles/subject.h"

#include "profiles/sql.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <sha256.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// ---------------------------------------------------------------- devices

static void add_field(text *t, const char *name, const char *value)
{
    text_add(t, "%s=%s\n", name, value ? value : "");
}

static void add_number(text *t, const char *name, uint64_t value)
{
    text_add(t, "%s=%" PRIu64 "\n", name, value);
}

void profile_sha(const char *chars, size_t n, char key[PROFILE_SHA])
{
    SHA256Data((const uint8_t *)chars, n, key);
}

// Gives the text back.
static void close_key(text *t, char key[PROFILE_SHA])
{
    profile_sha(text_chars(t), t->length, key);
    text_free(t);
}

// A host's memory varies with what else is set up on it, a card's is its own.
static uint64_t own_bytes(const profile_device *device)
{
    return strcmp(device->kind, "cpu") == 0 ? 0 : device->global_bytes;
}

void profile_device_key(const profile_device *device, char key[PROFILE_SHA])
{
    text t = {0};
    add_field(&t, "kind", device->kind);
    add_field(&t, "vendor", device->vendor);
    add_field(&t, "name", device->name);
    add_field(&t, "arch", device->arch);
    add_number(&t, "units", device->units);
    add_number(&t, "max_group", device->max_group);
    add_number(&t, "local_bytes", device->local_bytes);
    add_number(&t, "global_bytes", own_bytes(device));
    close_key(&t, key);
}

void profile_env_seat(const profile_env *env, char key[PROFILE_SHA])
{
    text t = {0};
    char device[PROFILE_SHA];
    profile_device_key(&env->device, device);
    add_field(&t, "device", device);
    add_field(&t, "platform", env->platform);
    add_field(&t, "part", env->part);
    add_number(&t, "part_units", env->part_units);
    add_field(&t, "limits", env->limits);
    close_key(&t, key);
}

void profile_env_key(const profile_env *env, char key[PROFILE_SHA])
{
    text t = {0};
    char seat[PROFILE_SHA];
    profile_env_seat(env, seat);
    add_field(&t, "seat", seat);
    add_field(&t, "platform_version", env->platform_version);
    add_field(&t, "driver", env->driver);
    add_field(&t, "cl_version", env->cl_version);
    close_key(&t, key);
}

static bool put_device(store *s, const profile_device *device, int64_t *id, duet_error *err)
{
    char key[PROFILE_SHA];
    profile_device_key(device, key);
    sql q = sql_make(s,
                     "INSERT INTO device (key, kind, vendor, name, arch, units, max_group, "
                     "local_bytes, global_bytes) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) "
                     "ON CONFLICT (key) DO NOTHING",
                     err);
    sql_text(&q, key);
    sql_text(&q, device->kind);
    sql_text(&q, device->vendor);
    sql_text(&q, device->name);
    sql_text(&q, device->arch);
    sql_int(&q, device->units);
    sql_int(&q, device->max_group);
    sql_int(&q, (int64_t)device->local_bytes);
    sql_int(&q, (int64_t)own_bytes(device));
    return sql_run(&q) && sql_find(s, "SELECT id FROM device WHERE key = ?", key, id, err);
}

static bool put_env(store *s, const profile_env *env, int64_t *id, duet_error *err)
{
    int64_t device_id = 0;
    if (!put_device(s, &env->device, &device_id, err))
        return false;
    char key[PROFILE_SHA];
    char seat[PROFILE_SHA];
    profile_env_key(env, key);
    profile_env_seat(env, seat);
    sql q = sql_make(s,
                     "INSERT INTO env (key, seat, device_id, platform, platform_version, driver, "
                     "cl_version, part, part_units, limits) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
                     "ON CONFLICT (key) DO NOTHING",
                     err);
    sql_text(&q, key);
    sql_text(&q, seat);
    sql_int(&q, device_id);
    sql_text(&q, env->platform);
    sql_text(&q, env->platform_version);
    sql_text(&q, env->driver);
    sql_text(&q, env->cl_version);
    sql_text(&q, env->part);
    sql_int(&q, env->part_units);
    sql_text(&q, env->limits);
    return sql_run(&q) && sql_find(s, "SELECT id FROM env WHERE key = ?", key, id, err);
}

static bool put_pair(store *s, int64_t env_a, int64_t env_b, int64_t *pair_id, duet_error *err)
{
    sql q = sql_make(
        s, "INSERT INTO pair (env_a, env_b) VALUES (?, ?) ON CONFLICT (env_a, env_b) DO NOTHING",
        err);
    sql_int(&q, env_a);
    sql_int(&q, env_b);
    if (!sql_run(&q))
        return false;
    q = sql_make(s, "SELECT id FROM pair WHERE env_a = ? AND env_b = ?", err);
    sql_int(&q, env_a);
    sql_int(&q, env_b);
    *pair_id = sql_row(&q) ? sql_get_int(&q, 0) : 0;
    return sql_close(&q);
}

bool profile_pair_put(store *s, const profile_pair *pair, int64_t *pair_id, duet_error *err)
{
    if (!store_begin(s, err))
        return false;
    int64_t env_a = 0;
    int64_t env_b = 0;
    bool ok = put_env(s, &pair->a, &env_a, err);
    ok = ok && put_env(s, &pair->b, &env_b, err);
    ok = ok && put_pair(s, env_a, env_b, pair_id, err);
    return store_end(s, ok, err);
}

void profile_host(char host[PROFILE_SHA])
{
    text t = {0};
    char name[256] = {0};
    gethostname(name, sizeof name - 1);
    add_field(&t, "host", name);
    text id = {0}; // two machines may have one name
    if (text_read_file(&id, "/etc/machine-id", NULL))
        add_field(&t, "id", text_chars(&id));
    text_free(&id);
    close_key(&t, host);
}

// ---------------------------------------------------------------- workloads

static int compare_words(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

// The words sorted, each once, a space between.
static void add_words(text *t, const char *words)
{
    enum { MAX_WORDS = 32 };
    text copy = {0};
    text_add(&copy, "%s", words ? words : "");
    const char *list[MAX_WORDS];
    size_t n = 0;
    char *rest = NULL;
    char *word = copy.chars ? strtok_r(copy.chars, " ", &rest) : NULL;
    for (; word && n < MAX_WORDS; word = strtok_r(NULL, " ", &rest))
        list[n++] = word;
    qsort(list, n, sizeof list[0], compare_words);
    for (size_t i = 0; i < n; ++i)
        if (i == 0 || strcmp(list[i], list[i - 1]) != 0)
            text_add(t, i == 0 ? "%s" : " %s", list[i]);
    text_free(&copy);
}

static void add_kind(text *t, const profile_workload *w)
{
    text_add(t, "%uD %s%s, level %s, effects: ", w->dims, w->shape, w->rotated ? " rotated" : "",
             w->level);
    add_words(t, w->effects && *w->effects ? w->effects : "none");
}

// To the nearest of `steps` in an octave, so that two draws seldom differ.
static double rounded(double x, int steps)
{
    return x > 0 ? exp2(round(steps * log2(x)) / steps) : 0;
}

void profile_workload_text(const profile_workload *w, text *t)
{
    enum { FINE = 4, COARSE = 1 };
    add_kind(t, w);
    text_add(t, "; n %" PRIu64 "; cells", w->n);
    for (uint32_t k = 0; k < w->dims; ++k)
        text_add(t, " %.3g", rounded(w->cells[k], FINE));
    text_add(t, " of %.3g; occupancy %.3g to %.3g; sizes 1:%.3g", rounded(w->cell, FINE),
             rounded(w->occ_mean, FINE), rounded(w->occ_p99, COARSE),
             rounded(w->size_ratio, COARSE));
}

void profile_workload_family(const profile_workload *w, text *t)
{
    add_kind(t, w);
    text_add(t, "; sizes 1:%.3g", rounded(w->size_ratio, 1));
}

static bool check_fields(const profile_workload *w, duet_error *err)
{
    if (w->dims != 2 && w->dims != 3)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "a workload's dims are 2 or 3, not %u",
                         w->dims);
    if (w->n == 0 || w->n > INT64_MAX)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "a workload has at least one object");
    if (!w->shape || !w->level)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "a workload needs a shape and a level");
    if (!(isfinite(w->cell) && isfinite(w->occ_mean) && isfinite(w->occ_p99)))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a workload's cell and occupancy are numbers");
    if (!(isfinite(w->size_ratio) && w->size_ratio >= 1))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a workload's size ratio is 1 or more, not %g", w->size_ratio);
    return true;
}

bool profile_workload_key(const profile_workload *w, char key[PROFILE_SHA], duet_error *err)
{
    if (!check_fields(w, err))
        return false;
    text t = {0};
    profile_workload_text(w, &t);
    bool ok = text_ok(&t, err);
    profile_sha(text_chars(&t), t.length, key);
    text_free(&t);
    return ok;
}

static bool insert_workload(store *s, const profile_workload *w, const char *key,
                            const char *family, const char *effects, duet_error *err)
{
    sql q = sql_make(s,
                     "INSERT INTO workload (key, family, name, dims, n, cells_x, cells_y, cells_z, "
                     "cell, occ_mean, occ_p99, size_ratio, shape, rotated, effects, level) "
                     "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
                     "ON CONFLICT (key) DO NOTHING",
                     err);
    sql_text(&q, key);
    sql_text(&q, family);
    sql_text(&q, w->name);
    sql_int(&q, w->dims);
    sql_int(&q, (int64_t)w->n);
    sql_int(&q, w->cells[0]);
    sql_int(&q, w->cells[1]);
    sql_int(&q, w->dims == 3 ? w->cells[2] : 1);
    sql_real(&q, w->cell);
    sql_real(&q, w->occ_mean);
    sql_real(&q, w->occ_p99);
    sql_real(&q, w->size_ratio);
    sql_text(&q, w->shape);
    sql_int(&q, w->rotated);
    sql_text(&q, effects);
    sql_text(&q, w->level);
    return sql_run(&q);
}

bool profile_workload_put(store *s, const profile_workload *w, int64_t *workload_id,
                          duet_error *err)
{
    char key[PROFILE_SHA];
    if (!profile_workload_key(w, key, err))
        return false;
    text family = {0};
    text effects = {0};
    profile_workload_family(w, &family);
    add_words(&effects, w->effects);
    bool ok = text_ok(&family, err) && text_ok(&effects, err);
    if (ok && store_begin(s, err)) {
        ok = insert_workload(s, w, key, text_chars(&family), text_chars(&effects), err);
        ok = ok && sql_find(s, "SELECT id FROM workload WHERE key = ?", key, workload_id, err);
        ok = store_end(s, ok, err);
    } else
        ok = false;
    text_free(&family);
    text_free(&effects);
    return ok;
}

// ---------------------------------------------------------------- keys

// Columns of device from `at` on: kind, vendor, name, arch, units, max_group,
// local_bytes, global_bytes.
static profile_device read_device(const sql *q, int at)
{
    return (profile_device){
        .kind = sql_get_text(q, at),
        .vendor = sql_get_text(q, at + 1),
        .name = sql_get_text(q, at + 2),
        .arch = sql_get_text(q, at + 3),
        .units = (uint32_t)sql_get_int(q, at + 4),
        .max_group = (uint32_t)sql_get_int(q, at + 5),
        .local_bytes = (uint64_t)sql_get_int(q, at + 6),
        .global_bytes = (uint64_t)sql_get_int(q, at + 7),
    };
}

static bool device_is_right(const sql *q, duet_error *err)
{
    (void)err;
    char key[PROFILE_SHA];
    profile_device device = read_device(q, 1);
    profile_device_key(&device, key);
    return strcmp(key, sql_get_text(q, 0)) == 0;
}

static bool env_is_right(const sql *q, duet_error *err)
{
    (void)err;
    char key[PROFILE_SHA];
    char seat[PROFILE_SHA];
    profile_env env = {
        .device = read_device(q, 9),
        .platform = sql_get_text(q, 2),
        .platform_version = sql_get_text(q, 3),
        .driver = sql_get_text(q, 4),
        .cl_version = sql_get_text(q, 5),
        .part = sql_get_text(q, 6),
        .part_units = (uint32_t)sql_get_int(q, 7),
        .limits = sql_get_text(q, 8),
    };
    profile_env_key(&env, key);
    profile_env_seat(&env, seat);
    return strcmp(key, sql_get_text(q, 0)) == 0 && strcmp(seat, sql_get_text(q, 1)) == 0;
}

static bool workload_is_right(const sql *q, duet_error *err)
{
    char key[PROFILE_SHA];
    text family = {0};
    profile_workload w = {
        .dims = (uint32_t)sql_get_int(q, 2),
        .n = (uint64_t)sql_get_int(q, 3),
        .cells = {(uint32_t)sql_get_int(q, 4), (uint32_t)sql_get_int(q, 5),
                  (uint32_t)sql_get_int(q, 6)},
        .cell = sql_get_real(q, 7),
        .occ_mean = sql_get_real(q, 8),
        .occ_p99 = sql_get_real(q, 9),
        .size_ratio = sql_get_real(q, 10),
        .shape = sql_get_text(q, 11),
        .rotated = sql_get_int(q, 12) != 0,
        .effects = sql_get_text(q, 13),
        .level = sql_get_text(q, 14),
    };
    bool right = profile_workload_key(&w, key, err);
    if (right) {
        profile_workload_family(&w, &family);
        right = strcmp(key, sql_get_text(q, 0)) == 0 &&
                strcmp(text_chars(&family), sql_get_text(q, 1)) == 0;
    }
    text_free(&family);
    return right;
}

static bool script_is_right(const sql *q, duet_error *err)
{
    (void)err;
    char key[PROFILE_SHA];
    const char *body = sql_get_text(q, 1);
    profile_sha(body, strlen(body), key);
    return strcmp(key, sql_get_text(q, 0)) == 0;
}

#define DEVICE_FIELDS \
    "d.kind, d.vendor, d.name, d.arch, d.units, d.max_group, d.local_bytes, d.global_bytes"

static const struct {
    const char *table;
    const char *query;
    bool (*is_right)(const sql *q, duet_error *err);
} kinds[] = {
    {"device", "SELECT d.key, " DEVICE_FIELDS " FROM device d WHERE d.id = ?", device_is_right},
    {"env",
     "SELECT e.key, e.seat, e.platform, e.platform_version, e.driver, e.cl_version, e.part, "
     "e.part_units, e.limits, " DEVICE_FIELDS
     " FROM env e JOIN device d ON d.id = e.device_id WHERE e.id = ?",
     env_is_right},
    {"workload",
     "SELECT key, family, dims, n, cells_x, cells_y, cells_z, cell, occ_mean, occ_p99, "
     "size_ratio, shape, rotated, effects, level FROM workload WHERE id = ?",
     workload_is_right},
    {"script", "SELECT key, body FROM script WHERE id = ?", script_is_right},
};

bool key_check(store *s, const char *table, int64_t id, bool *right, duet_error *err)
{
    size_t k = 0;
    while (k < sizeof kinds / sizeof kinds[0] && strcmp(kinds[k].table, table) != 0)
        ++k;
    assert(k < sizeof kinds / sizeof kinds[0]);
    sql q = sql_make(s, kinds[k].query, err);
    sql_int(&q, id);
    duet_error wrong = {0}; // a field that cannot be is a wrong row and no failure
    *right = sql_row(&q) && kinds[k].is_right(&q, &wrong);
    return sql_close(&q);
}
