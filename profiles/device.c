// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE
#include "profiles/device.h"

#include "profiles/sql.h"

#include <inttypes.h>
#include <sha256.h>
#include <string.h>
#include <unistd.h>

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
