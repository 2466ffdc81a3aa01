// SPDX-License-Identifier: MIT
// Opens and closes the store, and its transactions.
//
// The file is in WAL mode, so that look-ups go on while a tuner writes; on a
// network file system, where WAL would lose data, it keeps a rollback journal.
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "profiles/store.h"

#include "profiles/sql.h"
#include "runtime/base/clock.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/vfs.h>
#include <unistd.h>

#define BUSY_MS 5000
#define LOOK_BUSY_MS 50 // an application's start waits no longer

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
    return admit_store(s, err) && (!s->writable || choose_journal(s, err));
}

static bool open_resting(store *s, int busy_ms, duet_error *err)
{
    text name = {0};
    quiet_name(s->path, &name);
    bool ok = text_ok(&name, err) &&
              open_connection(s, name.chars, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, busy_ms, err);
    text_free(&name);
    return ok;
}

static bool can_make_files_beside(const char *path)
{
    char *folder = strdup(path);
    char *slash = folder ? strrchr(folder, '/') : NULL;
    if (slash)
        slash[slash == folder] = '\0';
    bool can = folder && access(slash ? folder : ".", W_OK) == 0;
    free(folder);
    return can;
}

// Where it may, SQLite is let clear its side files away at the end, which it
// does only for a connection that could write.
static bool open_for_reading(store *s, duet_error *err)
{
    if (!can_make_files_beside(s->path) && quiet_look(s->path).holds)
        return open_resting(s, BUSY_MS, err) && admit_store(s, err);
    return open_connection(s, s->path, SQLITE_OPEN_READWRITE, BUSY_MS, err) &&
           admit_store(s, err) && sql_script(s, "PRAGMA query_only = ON", err);
}

static bool open_for_look(store *s, duet_error *err)
{
    s->quiet = quiet_look(s->path);
    return (s->quiet.holds
                ? open_resting(s, LOOK_BUSY_MS, err)
                : open_connection(s, s->path, SQLITE_OPEN_READONLY, LOOK_BUSY_MS, err)) &&
           admit_store(s, err);
}

static store *open_store(const char *path, store_access access,
                         bool (*open)(store *s, duet_error *err), duet_error *err)
{
    store *s = admit_path(path, access, err) ? make(path, err) : NULL;
    if (s && open(s, err) && text_ok(&s->note, err))
        return s;
    store_close(s);
    return NULL;
}

// Makes a store beside its place and puts it there whole, so that nobody meets
// a file in the making. Where that fails, or another process was quicker, there
// is nothing to say: the store is opened next, and made in place if need be.
static void make_whole(const char *path)
{
    text beside = {0};
    text_add(&beside, "%s.%ld.new", path, (long)getpid());
    store *s = text_ok(&beside, NULL)
                   ? open_store(beside.chars, STORE_WRITE, open_for_writing, NULL)
                   : NULL;
    if (s) {
        store_close(s);
        link(beside.chars, path);
        unlink(beside.chars);
    }
    text_free(&beside);
}

store *store_open(const char *path, store_access access, duet_error *err)
{
    if (access == STORE_READ)
        return open_store(path, access, open_for_reading, err);
    struct stat info;
    if (admit_path(path, access, err) && stat(path, &info) != 0)
        make_whole(path);
    return open_store(path, access, open_for_writing, err);
}

store *store_open_look(const char *path, duet_error *err)
{
    return open_store(path, STORE_READ, open_for_look, err);
}

bool store_undisturbed(const store *s)
{
    return !s->quiet.holds || quiet_still(s->path, &s->quiet);
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
