// SPDX-License-Identifier: MIT
#include "profiles/keys.h"

#include "profiles/sql.h"
#include "profiles/workload.h"

#include <assert.h>
#include <string.h>

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
