// SPDX-License-Identifier: MIT
// Opens the store, and refuses with one line what is not ours to open.
//
// The file is in WAL mode, so that look-ups go on while a tuner writes; on a
// network file system, where WAL would lose data, it keeps a rollback journal.
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "profiles/store.h"

#include "profiles/sql.h"
#include "runtime/base/clock.h"

#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/vfs.h>
#include <unistd.h>

#define BUSY_MS 5000
#define LOOK_BUSY_MS 50     // an application's start waits no longer
#define SETTLED_NS 50000000 // file times tick more coarsely than files are written

// ------------------------------------------------------------ what lies there

static bool make_folders(const char *path, duet_error *err)
{
    text folder = {0};
    text_add(&folder, "%s", path);
    bool ok = text_ok(&folder, err);
    for (char *at = ok ? strchr(folder.chars + 1, '/') : NULL; ok && at; at = strchr(at + 1, '/')) {
        *at = '\0';
        if (mkdir(folder.chars, 0755) != 0 && errno != EEXIST)
            ok = error_set(err, DUET_STORE_FAILED, "%s: its folder %s cannot be made: %s", path,
                           folder.chars, strerror(errno));
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
        return error_set(err, DUET_STORE_FAILED, "%s: cannot be read: %s", path, strerror(errno));
    size_t n = fread(head, 1, sizeof head, file);
    fclose(file);
    if (n == 0 || memcmp(head, magic, sizeof magic) == 0)
        return true;
    return error_set(err, DUET_STORE_FAILED,
                     "%s: is not a profile store and was left as it is; move it away or name "
                     "another file with DUET_PROFILE",
                     path);
}

static bool check_path(const char *path, store_access access, duet_error *err)
{
    struct stat info;
    if (stat(path, &info) == 0)
        return S_ISDIR(info.st_mode)
                   ? error_set(err, DUET_STORE_FAILED,
                               "%s: is a folder; a profile store is a file in it", path)
                   : check_head(path, err);
    if (errno != ENOENT)
        return error_set(err, DUET_STORE_FAILED, "%s: %s", path, strerror(errno));
    if (access == STORE_WRITE)
        return make_folders(path, err);
    return error_set(err, DUET_NOT_FOUND, "%s: there is no profile store; duet tune makes one",
                     path);
}

// ------------------------------------------------------------------ connection

static store *make(const char *path, duet_error *err)
{
    store *s = calloc(1, sizeof *s);
    if (s)
        s->path = strdup(path);
    if (s && s->path)
        return s;
    store_close(s);
    error_set(err, DUET_NO_MEMORY, "%s: no memory to open it", path);
    return NULL;
}

static bool open_connection(store *s, const char *name, int flags, int busy_ms, duet_error *err)
{
    int code = sqlite3_open_v2(name, &s->db, flags | SQLITE_OPEN_NOMUTEX, NULL);
    if (!s->db)
        return error_set(err, DUET_NO_MEMORY, "%s: no memory to open it", s->path);
    sqlite3_extended_result_codes(s->db, 1);
    sqlite3_busy_timeout(s->db, busy_ms);
    if (code != SQLITE_OK)
        return sql_fail(s, code, err);
    sqlite3_db_config(s->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_db_config(s->db, SQLITE_DBCONFIG_ENABLE_FKEY, 1, NULL);
    sqlite3_db_config(s->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    return true;
}

typedef enum identity { IS_EMPTY, IS_FOREIGN, IS_OLDER, IS_OURS, IS_NEWER } identity;

static bool identify(store *s, identity *is, int64_t *version, duet_error *err)
{
    int64_t application = 0;
    int64_t objects = 0;
    if (!sql_number(s, "PRAGMA application_id", &application, err) ||
        !sql_number(s, "PRAGMA user_version", version, err) ||
        !sql_number(s, "SELECT count(*) FROM sqlite_schema", &objects, err))
        return false;
    if (application == STORE_APPLICATION && *version > 0)
        *is = *version > STORE_VERSION ? IS_NEWER : *version < STORE_VERSION ? IS_OLDER : IS_OURS;
    else
        *is = application == 0 && *version == 0 && objects == 0 ? IS_EMPTY : IS_FOREIGN;
    return true;
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

// Makes or upgrades the file where that is asked for; refuses it where it is
// none of ours.
static bool admit(store *s, duet_error *err)
{
    identity is = IS_FOREIGN;
    int64_t version = 0;
    if (!identify(s, &is, &version, err))
        return false;
    switch (is) {
    case IS_OURS:
        return true;
    case IS_NEWER:
        return open_newer(s, version, err);
    case IS_EMPTY:
        return s->writable
                   ? migrate_create(s, err)
                   : error_set(err, DUET_NOT_FOUND,
                               "%s: there is nothing in it yet; duet tune fills it", s->path);
    case IS_OLDER:
        return s->writable ? migrate_upgrade(s, migrate_upgrades, err)
                           : error_set(err, DUET_STORE_FAILED,
                                       "%s: is of the older version %" PRId64
                                       "; duet tune upgrades it and keeps a copy",
                                       s->path, version);
    case IS_FOREIGN:
        break;
    }
    return error_set(err, DUET_STORE_FAILED,
                     "%s: is another program's SQLite file and was left as it is; name another "
                     "file with DUET_PROFILE",
                     s->path);
}

const char *store_journal(unsigned long file_system)
{
    static const unsigned long network[] = {
        0x6969,     // NFS
        0x517b,     // SMB
        0xff534d42, // CIFS
        0xfe534d42, // SMB 2
        0x5346414f, // AFS
        0x01021997, // 9P
        0x65735546, // FUSE, sshfs among others
        0x00c36400, // Ceph
        0x0bd00bd0, // Lustre
        0x47504653, // GPFS
        0x19830326, // BeeGFS
    };
    for (size_t i = 0; i < sizeof network / sizeof network[0]; ++i)
        if (network[i] == (file_system & 0xffffffff))
            return "delete";
    return "wal";
}

// Changing the journal needs the file alone, and SQLite does not wait for that
// by itself.
static bool change_journal(store *s, const char *mode, duet_error *err)
{
    char pragma[64];
    snprintf(pragma, sizeof pragma, "PRAGMA journal_mode = %s", mode);
    int code = SQLITE_BUSY;
    for (int waited_ms = 0; code == SQLITE_BUSY && waited_ms < BUSY_MS; waited_ms += 10) {
        if (waited_ms > 0)
            sqlite3_sleep(10);
        code = sqlite3_exec(s->db, pragma, NULL, NULL, NULL) & 0xff;
    }
    return code == SQLITE_OK || sql_fail(s, code, err);
}

static bool choose_journal(store *s, duet_error *err)
{
    struct statfs info;
    const char *mode =
        statfs(s->path, &info) == 0 ? store_journal((unsigned long)info.f_type) : "wal";
    if (strcmp(mode, "wal") != 0 && s->note.length == 0)
        text_add(&s->note,
                 "%s: is on a network file system: processes wait for each other there; a local "
                 "file is faster",
                 s->path);
    return change_journal(s, mode, err) && sql_script(s, "PRAGMA synchronous = NORMAL", err);
}

static bool open_for_writing(store *s, duet_error *err)
{
    if (!open_connection(s, s->path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, BUSY_MS, err))
        return false;
    s->writable = true;
    if (sqlite3_db_readonly(s->db, "main") == 1)
        return sql_fail(s, SQLITE_READONLY, err);
    return admit(s, err) && (!s->writable || choose_journal(s, err));
}

static bool open_for_reading(store *s, duet_error *err)
{
    return open_connection(s, s->path, SQLITE_OPEN_READONLY, BUSY_MS, err) && admit(s, err);
}

store *store_open(const char *path, store_access access, duet_error *err)
{
    if (!check_path(path, access, err))
        return NULL;
    store *s = make(path, err);
    if (!s)
        return NULL;
    bool ok = access == STORE_WRITE ? open_for_writing(s, err) : open_for_reading(s, err);
    if (ok && text_ok(&s->note, err))
        return s;
    store_close(s);
    return NULL;
}

void store_close(store *s)
{
    if (!s)
        return;
    assert(s->depth == 0);
    sqlite3_close(s->db);
    text_free(&s->note);
    free(s->path);
    free(s);
}

const char *store_path(const store *s)
{
    return s->path;
}

bool store_writable(const store *s)
{
    return s->writable;
}

const char *store_note(const store *s)
{
    return s->note.length > 0 ? text_chars(&s->note) : NULL;
}

// ------------------------------------------------------------------- a look-up

// Bytes in a side file; 0 where there is none.
static int64_t side_bytes(const char *path, const char *ending)
{
    text name = {0};
    struct stat info;
    text_add(&name, "%s%s", path, ending);
    bool there = stat(text_chars(&name), &info) == 0;
    text_free(&name);
    return there ? (int64_t)info.st_size : 0;
}

static int64_t changed_ns(const struct stat *info)
{
    return (int64_t)info->st_mtim.tv_sec * 1000000000 + info->st_mtim.tv_nsec;
}

static bool nobody_writes(const char *path, struct stat *seen)
{
    return stat(path, seen) == 0 && side_bytes(path, "-wal") == 0 &&
           side_bytes(path, "-journal") == 0 && changed_ns(seen) + SETTLED_NS < clock_calendar_ns();
}

bool store_undisturbed(const store *s)
{
    struct stat info;
    return !s->quiet ||
           (nobody_writes(s->path, &info) && info.st_ino == s->seen.st_ino &&
            info.st_size == s->seen.st_size && changed_ns(&info) == changed_ns(&s->seen));
}

// An immutable file is read without locks and side files.
static void immutable_name(const char *path, text *name)
{
    text_add(name, "file:");
    for (const char *c = path; *c; ++c)
        text_add(name, strchr("%?#", *c) ? "%%%02X" : "%c", (unsigned char)*c);
    text_add(name, "?immutable=1");
}

store *store_open_look(const char *path, duet_error *err)
{
    if (!check_path(path, STORE_READ, err))
        return NULL;
    store *s = make(path, err);
    if (!s)
        return NULL;
    text name = {0};
    s->quiet = nobody_writes(path, &s->seen);
    if (s->quiet)
        immutable_name(path, &name);
    else
        text_add(&name, "%s", path);
    bool ok = text_ok(&name, err) &&
              open_connection(s, text_chars(&name),
                              SQLITE_OPEN_READONLY | (s->quiet ? SQLITE_OPEN_URI : 0), LOOK_BUSY_MS,
                              err) &&
              admit(s, err);
    text_free(&name);
    if (ok)
        return s;
    store_close(s);
    return NULL;
}

// ---------------------------------------------------------------- transactions

bool store_begin(store *s, duet_error *err)
{
    if (s->depth == 0) {
        if (!s->writable)
            return error_set(err, DUET_STORE_FAILED, "%s: is open for reading only", s->path);
        s->broken = false;
        if (!sql_script(s, "BEGIN IMMEDIATE", err))
            return false;
    }
    ++s->depth;
    return true;
}

bool store_end(store *s, bool ok, duet_error *err)
{
    assert(s->depth > 0);
    s->broken = s->broken || !ok;
    if (--s->depth > 0)
        return ok;
    ok = !s->broken && sql_script(s, "COMMIT", err);
    // A full disk makes SQLite roll back by itself.
    if (!ok && !sqlite3_get_autocommit(s->db))
        sqlite3_exec(s->db, "ROLLBACK", NULL, NULL, NULL);
    return ok;
}

bool store_audit(store *s, const char *what, const char *detail, duet_error *err)
{
    sql q = sql_make(s, "INSERT INTO audit (at_ns, what, detail) VALUES (?, ?, ?)", err);
    sql_int(&q, clock_calendar_ns());
    sql_text(&q, what);
    sql_text(&q, detail);
    return sql_run(&q);
}
