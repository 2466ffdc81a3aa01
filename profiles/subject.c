// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "profiles/subject.h"

#include "base/text.h"
#include "profiles/sql.h"

#include <assert.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <sha256.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Ends the insertion of a row that may be there.
#define ONCE "ON CONFLICT (key) DO NOTHING"

// ---------------------------------------------------------------- devices

static void add_field(SHA256_CTX *sum, const char *name, const char *value)
{
    const char *const parts[] = {name, "=", value ? value : "", "\n"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i)
        SHA256Update(sum, (const uint8_t *)parts[i], strlen(parts[i]));
}

static void add_number(SHA256_CTX *sum, const char *name, uint64_t value)
{
    char digits[24];
    snprintf(digits, sizeof digits, "%" PRIu64, value);
    add_field(sum, name, digits);
}

// A host's memory varies with what else is set up on it, a card's is its own.
static uint64_t own_bytes(const profile_device *device)
{
    return strcmp(device->kind, "cpu") == 0 ? 0 : device->global_bytes;
}

void profile_device_key(const profile_device *device, char key[PROFILE_SHA])
{
    SHA256_CTX sum;
    SHA256Init(&sum);
    add_field(&sum, "kind", device->kind);
    add_field(&sum, "vendor", device->vendor);
    add_field(&sum, "name", device->name);
    add_field(&sum, "arch", device->arch);
    add_number(&sum, "units", device->units);
    add_number(&sum, "max_group", device->max_group);
    add_number(&sum, "local_bytes", device->local_bytes);
    add_number(&sum, "global_bytes", own_bytes(device));
    SHA256End(&sum, key);
}

static void seat_of(const profile_env *env, char key[PROFILE_SHA])
{
    SHA256_CTX sum;
    char device[PROFILE_SHA];
    profile_device_key(&env->device, device);
    SHA256Init(&sum);
    add_field(&sum, "device", device);
    add_field(&sum, "platform", env->platform);
    add_field(&sum, "part", env->part);
    add_number(&sum, "part_units", env->part_units);
    add_field(&sum, "limits", env->limits);
    SHA256End(&sum, key);
}

void profile_env_keys(const profile_env *env, char key[PROFILE_SHA], char seat[PROFILE_SHA])
{
    SHA256_CTX sum;
    seat_of(env, seat);
    SHA256Init(&sum);
    add_field(&sum, "seat", seat);
    add_field(&sum, "platform_version", env->platform_version);
    add_field(&sum, "driver", env->driver);
    add_field(&sum, "cl_version", env->cl_version);
    SHA256End(&sum, key);
}

void profile_env_key(const profile_env *env, char key[PROFILE_SHA])
{
    char seat[PROFILE_SHA];
    profile_env_keys(env, key, seat);
}

static const sql_column device_columns[] = {
    SQL_COLUMN("kind", profile_device, kind),
    SQL_COLUMN("vendor", profile_device, vendor),
    SQL_COLUMN("name", profile_device, name),
    SQL_COLUMN("arch", profile_device, arch),
    SQL_COLUMN("units", profile_device, units),
    SQL_COLUMN("max_group", profile_device, max_group),
    SQL_COLUMN("local_bytes", profile_device, local_bytes),
    SQL_COLUMN("global_bytes", profile_device, global_bytes),
    {0},
};

static bool put_device(store *s, const profile_device *device, int64_t *id, duet_error *err)
{
    char key[PROFILE_SHA];
    profile_device row = *device;
    row.global_bytes = own_bytes(device);
    profile_device_key(device, key);
    sql q = sql_insert(s, "device", device_columns, "key", ONCE, err);
    sql_bind(&q, device_columns, &row);
    sql_text(&q, key);
    return sql_run(&q) && sql_find(s, "SELECT id FROM device WHERE key = ?", key, id, err);
}

// But those of the device.
static const sql_column env_columns[] = {
    SQL_COLUMN("platform", profile_env, platform),
    SQL_COLUMN("platform_version", profile_env, platform_version),
    SQL_COLUMN("driver", profile_env, driver),
    SQL_COLUMN("cl_version", profile_env, cl_version),
    SQL_COLUMN("part", profile_env, part),
    SQL_COLUMN("part_units", profile_env, part_units),
    SQL_COLUMN("limits", profile_env, limits),
    {0},
};

static bool put_env(store *s, const profile_env *env, int64_t *id, duet_error *err)
{
    int64_t device_id = 0;
    if (!put_device(s, &env->device, &device_id, err))
        return false;
    char key[PROFILE_SHA];
    char seat[PROFILE_SHA];
    profile_env_keys(env, key, seat);
    sql q = sql_insert(s, "env", env_columns, "key, seat, device_id", ONCE, err);
    sql_bind(&q, env_columns, env);
    sql_text(&q, key);
    sql_text(&q, seat);
    sql_int(&q, device_id);
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

// Two machines may have one name.
static ssize_t read_machine_id(char *id, size_t size)
{
    const int file = open("/etc/machine-id", O_RDONLY | O_CLOEXEC);
    const ssize_t n = file < 0 ? 0 : read(file, id, size);
    if (file >= 0)
        close(file);
    return n;
}

void profile_host(char host[PROFILE_SHA])
{
    SHA256_CTX sum;
    char name[256] = {0}, id[256] = {0};
    gethostname(name, sizeof name - 1);
    SHA256Init(&sum);
    add_field(&sum, "host", name);
    if (read_machine_id(id, sizeof id - 1) > 0)
        add_field(&sum, "id", id);
    SHA256End(&sum, host);
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
    t->failed = t->failed || copy.failed;
    text_free(&copy);
}

enum { FINE = 4, COARSE = 1 }; // steps in an octave

// To the nearest step, so that two draws seldom differ.
static double rounded(double x, int steps)
{
    return x > 0 ? exp2(round(steps * log2(x)) / steps) : 0;
}

static void add_kind(text *t, const profile_workload *w)
{
    text_add(t, "%uD %s%s, level %s, effects: ", w->dims, w->shape, w->rotated ? " rotated" : "",
             w->level);
    add_words(t, w->effects && *w->effects ? w->effects : "none");
    if (w->query)
        text_add(t, ", query: %s", w->query);
    if (w->boxes)
        text_add(t, " of %.3g boxes", rounded((double)w->boxes, COARSE));
}

void profile_workload_text(const profile_workload *w, text *t)
{
    add_kind(t, w);
    text_add(t, "; n %" PRIu64, w->n);
    if (w->query)
        return;
    text_add(t, "; cells");
    for (uint32_t k = 0; k < w->dims; ++k)
        text_add(t, " %.3g", rounded(w->cells[k], FINE));
    text_add(t, " of %.3g; occupancy %.3g to %.3g; sizes 1:%.3g", rounded(w->cell, FINE),
             rounded(w->occ_mean, FINE), rounded(w->occ_p99, COARSE),
             rounded(w->size_ratio, COARSE));
}

bool profile_workload_moves(const profile_workload *w)
{
    const size_t n = strlen(PROFILE_MOVING);
    bool moves = false;
    for (const char *at = w->effects; at && !moves; at = strchr(at, ' ')) {
        at += strspn(at, " ");
        moves = strcspn(at, " ") == n && strncmp(at, PROFILE_MOVING, n) == 0;
    }
    return moves;
}

// Ground under more bodies is larger.
void profile_workload_family(const profile_workload *w, text *t)
{
    add_kind(t, w);
    if (!w->query && !profile_workload_moves(w))
        text_add(t, "; sizes 1:%.3g", rounded(w->size_ratio, COARSE));
}

static bool check_fields(const profile_workload *w, duet_error *err)
{
    if (w->dims != 2 && w->dims != 3)
        return bad_argument(err, "a workload's dims are 2 or 3, not %u", w->dims);
    if (w->n == 0 || w->n > INT64_MAX)
        return bad_argument(err, "a workload has at least one %s", w->query ? "item" : "object");
    if (!w->shape || !w->level)
        return bad_argument(err, "a workload needs a shape and a level");
    if (!(isfinite(w->cell) && isfinite(w->occ_mean) && isfinite(w->occ_p99)))
        return bad_argument(err, "a workload's cell and occupancy are numbers");
    if (!(isfinite(w->size_ratio) && w->size_ratio >= 1))
        return bad_argument(err, "a workload's size ratio is 1 or more, not %g", w->size_ratio);
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

static const sql_column workload_columns[] = {
    SQL_COLUMN("dims", profile_workload, dims),
    SQL_COLUMN("n", profile_workload, n),
    SQL_COLUMN("cells_x", profile_workload, cells[0]),
    SQL_COLUMN("cells_y", profile_workload, cells[1]),
    SQL_COLUMN("cells_z", profile_workload, cells[2]),
    SQL_COLUMN("cell", profile_workload, cell),
    SQL_COLUMN("occ_mean", profile_workload, occ_mean),
    SQL_COLUMN("occ_p99", profile_workload, occ_p99),
    SQL_COLUMN("size_ratio", profile_workload, size_ratio),
    SQL_COLUMN("shape", profile_workload, shape),
    SQL_COLUMN("rotated", profile_workload, rotated),
    SQL_COLUMN("effects", profile_workload, effects),
    SQL_COLUMN("level", profile_workload, level),
    SQL_COLUMN("query", profile_workload, query),
    SQL_COLUMN("boxes", profile_workload, boxes),
    {0},
};

static bool insert_workload(store *s, const profile_workload *w, const char *key,
                            const char *family, const char *effects, duet_error *err)
{
    profile_workload row = *w;
    row.cells[2] = w->dims == 3 ? w->cells[2] : 1;
    row.effects = effects;
    sql q = sql_insert(s, "workload", workload_columns, "key, family, name", ONCE, err);
    sql_bind(&q, workload_columns, &row);
    sql_text(&q, key);
    sql_text(&q, family);
    sql_text(&q, w->name);
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

// Each is given the row's own columns, then those of the device and the rest.
static bool device_is_right(const sql *q, duet_error *err)
{
    (void)err;
    char key[PROFILE_SHA];
    profile_device device = {0};
    int rest = sql_read(q, 0, device_columns, &device);
    profile_device_key(&device, key);
    return strcmp(key, sql_get_text(q, rest)) == 0;
}

static bool env_is_right(const sql *q, duet_error *err)
{
    (void)err;
    char key[PROFILE_SHA];
    char seat[PROFILE_SHA];
    profile_env env = {0};
    int rest = sql_read(q, sql_read(q, 0, env_columns, &env), device_columns, &env.device);
    profile_env_keys(&env, key, seat);
    return strcmp(key, sql_get_text(q, rest)) == 0 && strcmp(seat, sql_get_text(q, rest + 1)) == 0;
}

static bool workload_is_right(const sql *q, duet_error *err)
{
    char key[PROFILE_SHA];
    text family = {0};
    profile_workload w = {0};
    int rest = sql_read(q, 0, workload_columns, &w);
    bool right = profile_workload_key(&w, key, err);
    if (right) {
        profile_workload_family(&w, &family);
        right = text_ok(&family, err) && strcmp(key, sql_get_text(q, rest)) == 0 &&
                strcmp(text_chars(&family), sql_get_text(q, rest + 1)) == 0;
    }
    text_free(&family);
    return right;
}

static bool script_is_right(const sql *q, duet_error *err)
{
    (void)err;
    char key[PROFILE_SHA];
    const char *body = sql_get_text(q, 0);
    profile_sha(body, strlen(body), key);
    return strcmp(key, sql_get_text(q, 1)) == 0;
}

static const sql_column script_columns[] = {{.name = "body"}, {0}};

static const struct {
    const char *table;
    const sql_column *own;
    const sql_column *of_device; // NULL: none
    const char *rest;
    bool (*is_right)(const sql *q, duet_error *err);
} kinds[] = {
    {"device", device_columns, NULL, ", t.key FROM device t", device_is_right},
    {"env", env_columns, device_columns,
     ", t.key, t.seat FROM env t JOIN device d ON d.id = t.device_id", env_is_right},
    {"workload", workload_columns, NULL, ", t.key, t.family FROM workload t", workload_is_right},
    {"script", script_columns, NULL, ", t.key FROM script t", script_is_right},
};

bool key_check(store *s, const char *table, int64_t id, bool *right, duet_error *err)
{
    size_t k = 0;
    while (k < sizeof kinds / sizeof kinds[0] && strcmp(kinds[k].table, table) != 0)
        ++k;
    assert(k < sizeof kinds / sizeof kinds[0]);
    text query = {0};
    text_add(&query, "SELECT ");
    sql_add_names(&query, "t.", kinds[k].own);
    if (kinds[k].of_device) {
        text_add(&query, ", ");
        sql_add_names(&query, "d.", kinds[k].of_device);
    }
    text_add(&query, "%s WHERE t.id = ?", kinds[k].rest);
    sql q = sql_make_text(s, &query, err);
    sql_int(&q, id);
    duet_error wrong = {0}; // a field that cannot be is a wrong row and no failure
    *right = sql_row(&q) && kinds[k].is_right(&q, &wrong);
    bool ok = wrong.status != DUET_STATUS_NO_MEMORY || error_copy(err, &wrong);
    return sql_close(&q) && ok;
}
