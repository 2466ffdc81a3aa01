// SPDX-License-Identifier: MIT
// Whether what lies at a path is a store of ours, and which version: made fresh,
// brought up from an older one that has upgrades, or refused with one line.
//
// All upgrades of a file are one transaction, and before it the whole file is
// copied beside itself, so that one can go back to the older Duet.
#define _POSIX_C_SOURCE 200809L
#include "profiles/sql.h"

#include "base/blob.h"
#include "base/output.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

// --------------------------------------------------------- before it is opened

static bool make_folders(const char *path, duet_error *err)
{
    text failed = {0};
    bool ok = output_make_folders(path, 0755, &failed);
    if (!ok && errno == ENOMEM)
        error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory to make its folder", path);
    else if (!ok)
        error_set(err, DUET_STATUS_STORE_FAILED, "%s: its folder %s cannot be made: %s", path,
                  text_chars(&failed), strerror(errno));
    text_free(&failed);
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

// -------------------------------------------------------------------- versions

static const char *const known_upgrades[] = {NULL};

static bool set_version(store *s, int64_t version, duet_error *err)
{
    char pragma[64];
    snprintf(pragma, sizeof pragma, "PRAGMA user_version = %" PRId64, version);
    return sql_script(s, pragma, err);
}

static bool create(store *s, duet_error *err)
{
    const blob *schema = blob_find("profiles/schema.sql");
    assert(schema);
    if (!store_begin(s, err))
        return false;
    int64_t version = 0; // another process may have made it while this one waited
    bool ok = sql_number(s, "PRAGMA user_version", &version, err);
    if (ok && version == 0) {
        char pragma[64];
        snprintf(pragma, sizeof pragma, "PRAGMA application_id = %d", STORE_APPLICATION);
        ok = sql_script(s, schema->bytes, err) && sql_script(s, pragma, err) &&
             set_version(s, STORE_VERSION, err);
    }
    return store_end(s, ok, err);
}

static bool take_name(const char *name)
{
    int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
    return file >= 0 && close(file) == 0;
}

// The first name of PATH.v7, PATH.v7.1, PATH.v7.2 ... that is free, which is
// then an empty file.
static bool free_name(const store *s, int64_t version, text *name, duet_error *err)
{
    text_add(name, "%s.v%" PRId64, s->path, version);
    for (int i = 1; text_ok(name, err) && !take_name(name->chars); ++i) {
        if (errno != EEXIST)
            return error_set(err, DUET_STATUS_STORE_FAILED, "%s: cannot be made: %s", name->chars,
                             strerror(errno));
        text_free(name);
        text_add(name, "%s.v%" PRId64 ".%d", s->path, version, i);
    }
    return text_ok(name, err);
}

static bool copy_pages(store *from, store *to, duet_error *err)
{
    sqlite3_backup *backup = sqlite3_backup_init(to->db, "main", from->db, "main");
    if (backup) {
        sqlite3_backup_step(backup, -1);
        sqlite3_backup_finish(backup);
    }
    int code = sqlite3_errcode(to->db);
    return code == SQLITE_OK || sql_fail(to, code, err);
}

static bool open_plainly(store *s, int flags, duet_error *err)
{
    text name = {0};
    store_file_name(s->path, &name);
    bool ok = text_ok(&name, err);
    if (ok) {
        int code = sqlite3_open_v2(name.chars, &s->db, flags, NULL);
        ok = code == SQLITE_OK || sql_fail(s, code, err);
    }
    text_free(&name);
    return ok;
}

// Reads through a connection of its own: SQLite refuses to copy from one that
// holds the write lock, which is what keeps others out meanwhile.
static bool copy_file(const store *s, const char *name, duet_error *err)
{
    store from = {.path = s->path, .file = s->file};
    store to = {.path = (char *)name, .file = (char *)name};
    bool ok = open_plainly(&from, SQLITE_OPEN_READONLY, err) &&
              open_plainly(&to, SQLITE_OPEN_READWRITE, err) && copy_pages(&from, &to, err);
    sqlite3_close(to.db);
    sqlite3_close(from.db);
    if (!ok)
        unlink(name);
    return ok;
}

static bool run_upgrades(store *s, const char *const *upgrades, int64_t from, int64_t to,
                         duet_error *err)
{
    char detail[64];
    snprintf(detail, sizeof detail, "from version %" PRId64 " to %" PRId64, from, to);
    bool ok = true;
    for (int64_t version = from; ok && version < to; ++version)
        ok = sql_script(s, upgrades[version - STORE_FIRST_VERSION], err);
    return ok && set_version(s, to, err) && store_audit(s, "upgrade", detail, err);
}

bool migrate_upgrade(store *s, const char *const *upgrades, duet_error *err)
{
    int64_t newest = STORE_FIRST_VERSION;
    while (upgrades[newest - STORE_FIRST_VERSION])
        ++newest;
    if (!store_begin(s, err))
        return false;
    text copy = {0};
    int64_t version = 0; // another process may have upgraded it while this one waited
    bool ok = sql_number(s, "PRAGMA user_version", &version, err);
    if (ok && version < newest) {
        ok = free_name(s, version, &copy, err) && copy_file(s, text_chars(&copy), err) &&
             run_upgrades(s, upgrades, version, newest, err);
        if (ok)
            text_add(&s->note, "%s: upgraded from version %" PRId64 "; the file as it was is %s",
                     s->path, version, text_chars(&copy));
    }
    text_free(&copy);
    return store_end(s, ok, err);
}

// --------------------------------------------------------- after it is opened

typedef enum identity { IS_EMPTY, IS_FOREIGN, IS_OLDER, IS_OURS, IS_UNKNOWN } identity;

// In one transaction, since another process may be making the file.
static bool identify(store *s, identity *is, int64_t *version, duet_error *err)
{
    int64_t application = 0;
    int64_t objects = 0;
    if (!sql_script(s, "BEGIN", err) ||
        !sql_number(s, "PRAGMA application_id", &application, err) ||
        !sql_number(s, "PRAGMA user_version", version, err) ||
        (application == 0 && !sql_number(s, "SELECT count(*) FROM sqlite_schema", &objects, err)) ||
        !sql_script(s, "COMMIT", err))
        return false;
    if (application == STORE_APPLICATION && *version > 0)
        *is = *version == STORE_VERSION                                    ? IS_OURS
              : *version < STORE_FIRST_VERSION || *version > STORE_VERSION ? IS_UNKNOWN
                                                                           : IS_OLDER;
    else
        *is = application == 0 && *version == 0 && objects == 0 ? IS_EMPTY : IS_FOREIGN;
    return true;
}

// Views, triggers and virtual tables have no pages. They run what their text says,
// for ever if it says so, so that only those which Duet's own schema makes are let
// in.
//
// An older version's view is another; its upgrade drops it, and nothing reads it before.
static bool check_code(store *s, bool is_older, duet_error *err)
{
    const blob *schema = blob_find("profiles/schema.sql");
    assert(schema);
    text unknown = {0};
    sql q = sql_make(s,
                     "SELECT type, name, coalesce(sql, '') FROM sqlite_schema "
                     "WHERE coalesce(rootpage, 0) = 0 "
                     "AND NOT (?1 AND type = 'view' AND name = 'part')",
                     err);
    sql_int(&q, is_older);
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

bool store_validate(store *s, duet_error *err)
{
    identity is = IS_FOREIGN;
    int64_t version = 0;
    if (!identify(s, &is, &version, err))
        return false;
    if ((is == IS_OURS || is == IS_OLDER) && !check_code(s, is == IS_OLDER, err))
        return false;
    switch (is) {
    case IS_OURS:
        return true;
    case IS_UNKNOWN:
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: is of version %" PRId64 ", and this Duet knows version %d; name "
                         "another file with DUET_PROFILE",
                         s->path, version, STORE_VERSION);
    case IS_EMPTY:
        return s->writable
                   ? create(s, err)
                   : error_set(err, DUET_STATUS_NOT_FOUND,
                               "%s: there is nothing in it yet; duet tune fills it", s->path);
    case IS_OLDER:
        return s->writable ? migrate_upgrade(s, known_upgrades, err)
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
