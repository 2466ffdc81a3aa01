// SPDX-License-Identifier: MIT
// Decides whether what lies at a path is a store of ours, and refuses with one
// line what is not: a folder, another program's file, a newer version.
#define _POSIX_C_SOURCE 200809L
#include "profiles/sql.h"

#include "base/blob.h"

#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

// --------------------------------------------------------- before it is opened

static bool make_folders(const char *path, duet_error *err)
{
    text folder = {0};
    text_add(&folder, "%s", path);
    bool ok = text_ok(&folder, err);
    for (char *at = ok ? strchr(folder.chars + 1, '/') : NULL; ok && at; at = strchr(at + 1, '/')) {
        *at = '\0';
        if (mkdir(folder.chars, 0755) != 0 && errno != EEXIST)
            ok = error_set(err, DUET_STATUS_STORE_FAILED, "%s: its folder %s cannot be made: %s",
                           path, folder.chars, strerror(errno));
        *at = '/';
    }
    text_free(&folder);
    return ok;
}

// A file that does not begin like SQLite's must never reach it: SQLite takes a
// short one for an empty database.
static bool check_head(const char *path, duet_error *err)
{
    static const char magic[16] = "SQLite format 3";
    char head[sizeof magic] = {0};
    FILE *file = fopen(path, "rb");
    if (!file)
        return error_set(err, DUET_STATUS_STORE_FAILED, "%s: cannot be read: %s", path,
                         strerror(errno));
    size_t n = fread(head, 1, sizeof head, file);
    fclose(file);
    if (n == 0 || memcmp(head, magic, sizeof magic) == 0)
        return true;
    return error_set(err, DUET_STATUS_STORE_FAILED,
                     "%s: is not a profile store and was left as it is; move it away or name "
                     "another file with DUET_PROFILE",
                     path);
}

bool store_validate_path(const char *path, store_access access, duet_error *err)
{
    struct stat info;
    if (!*path)
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "the profile store's path is empty; name a file");
    if (stat(path, &info) == 0)
        return S_ISREG(info.st_mode)
                   ? check_head(path, err)
                   : error_set(err, DUET_STATUS_STORE_FAILED,
                               "%s: is %s; a profile store is a file", path,
                               S_ISDIR(info.st_mode) ? "a folder" : "a device or a pipe");
    if (errno != ENOENT)
        return error_set(err, DUET_STATUS_STORE_FAILED, "%s: %s", path, strerror(errno));
    if (access == STORE_WRITE)
        return make_folders(path, err);
    return error_set(err, DUET_STATUS_NOT_FOUND,
                     "%s: there is no profile store; duet tune makes one", path);
}

// --------------------------------------------------------- after it is opened

typedef enum identity { IS_EMPTY, IS_FOREIGN, IS_OLDER, IS_OURS, IS_NEWER } identity;

// In one transaction, since another process may be making the file.
static bool identify(store *s, identity *is, int64_t *version, duet_error *err)
{
    int64_t application = 0;
    int64_t objects = 0;
    if (!sql_script(s, "BEGIN", err) ||
        !sql_number(s, "PRAGMA application_id", &application, err) ||
        !sql_number(s, "PRAGMA user_version", version, err) ||
        !sql_number(s, "SELECT count(*) FROM sqlite_schema", &objects, err) ||
        !sql_script(s, "COMMIT", err))
        return false;
    if (application == STORE_APPLICATION && *version > 0)
        *is = *version > STORE_VERSION ? IS_NEWER : *version < STORE_VERSION ? IS_OLDER : IS_OURS;
    else
        *is = application == 0 && *version == 0 && objects == 0 ? IS_EMPTY : IS_FOREIGN;
    return true;
}

// Views, triggers and virtual tables have no pages. They run what their text says,
// for ever if it says so, so that only those which Duet's own schema makes are let
// in.
static bool check_code(store *s, duet_error *err)
{
    const blob *schema = blob_find("profiles/schema.sql");
    assert(schema);
    text unknown = {0};
    sql q = sql_make(s,
                     "SELECT type, name, coalesce(sql, '') FROM sqlite_schema "
                     "WHERE coalesce(rootpage, 0) = 0",
                     err);
    while (!unknown.chars && sql_row(&q))
        if (!strstr(schema->bytes, sql_get_text(&q, 2)))
            text_add(&unknown, "%s '%s'", sql_get_text(&q, 0), sql_get_text(&q, 1));
    bool ok = sql_close(&q) && text_ok(&unknown, err) &&
              (!unknown.chars ||
               error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: holds a %s that Duet does not make, and was left as it is; name "
                         "another file with DUET_PROFILE",
                         s->path, unknown.chars));
    text_free(&unknown);
    return ok;
}

static bool open_newer(store *s, int64_t version, duet_error *err)
{
    s->writable = false;
    text_add(&s->note,
             "%s: was written by a newer Duet (version %" PRId64 ", this one knows %d); it is "
             "only read",
             s->path, version, STORE_VERSION);
    return sql_script(s, "PRAGMA query_only = ON", err);
}

bool store_validate(store *s, duet_error *err)
{
    identity is = IS_FOREIGN;
    int64_t version = 0;
    if (!identify(s, &is, &version, err))
        return false;
    if (is != IS_EMPTY && is != IS_FOREIGN && !check_code(s, err))
        return false;
    switch (is) {
    case IS_OURS:
        return true;
    case IS_NEWER:
        return open_newer(s, version, err);
    case IS_EMPTY:
        return s->writable
                   ? migrate_create(s, err)
                   : error_set(err, DUET_STATUS_NOT_FOUND,
                               "%s: there is nothing in it yet; duet tune fills it", s->path);
    case IS_OLDER:
        return s->writable ? migrate_upgrade(s, migrate_upgrades, err)
                           : error_set(err, DUET_STATUS_STORE_FAILED,
                                       "%s: is of the older version %" PRId64
                                       "; duet tune upgrades it and keeps a copy",
                                       s->path, version);
    case IS_FOREIGN:
        break;
    }
    return error_set(err, DUET_STATUS_STORE_FAILED,
                     "%s: is another program's SQLite file and was left as it is; name another "
                     "file with DUET_PROFILE",
                     s->path);
}
