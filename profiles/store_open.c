// SPDX-License-Identifier: MIT
// Opens the store.
//
// The file is in WAL mode, so that look-ups go on while a tuner writes; on a
// network file system, where WAL would lose data, it keeps a rollback journal.
#define _GNU_SOURCE
#include "profiles/store.h"

#include "base/text_file.h"
#include "base/variable.h"
#include "profiles/key.h"
#include "profiles/sql.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/vfs.h>
#include <unistd.h>

#define BUSY_MS 5000
#define LOOK_BUSY_MS 50 // an application's start waits no longer

// ----------------------------------------------------------------------- paths

bool store_user_path(text *path, duet_error *err)
{
    if (variable_text("DUET_PROFILE"))
        text_add(path, "%s", variable_text("DUET_PROFILE"));
    else if (variable_text("XDG_DATA_HOME"))
        text_add(path, "%s/duet/profiles.db", variable_text("XDG_DATA_HOME"));
    else if (variable_text("HOME"))
        text_add(path, "%s/.local/share/duet/profiles.db", variable_text("HOME"));
    else
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "no place for the profile store: set DUET_PROFILE to a file, or HOME");
    return text_ok(path, err);
}

bool store_system_path(text *path)
{
    const char *at = variable_text("XDG_DATA_DIRS");
    for (at = at ? at : "/usr/local/share:/usr/share"; *at; at += strspn(at, ":")) {
        int length = (int)strcspn(at, ":");
        text_free(path);
        text_add(path, "%.*s/duet/profiles.db", length, at);
        if (length > 0 && text_ok(path, NULL) && access(text_chars(path), R_OK) == 0)
            return true;
        at += length;
    }
    text_free(path);
    return false;
}

// ------------------------------------------------------------------ connection

static store *make(const char *path, const char *file, duet_error *err)
{
    store *s = calloc(1, sizeof *s);
    if (s) {
        s->path = strdup(path);
        s->file = strdup(file);
    }
    if (s && s->path && s->file)
        return s;
    store_close(s);
    return null_no_memory(err, "%s", path);
}

static bool connect(store *s, const char *name, int flags, int busy_ms, duet_error *err)
{
    int code = sqlite3_open_v2(name, &s->db, flags | SQLITE_OPEN_NOMUTEX, NULL);
    if (!s->db)
        return no_memory(err, "%s", s->path);
    sqlite3_extended_result_codes(s->db, 1);
    sqlite3_busy_timeout(s->db, busy_ms);
    sqlite3_limit(s->db, SQLITE_LIMIT_LENGTH, TEXT_LINE_MOST); // the length of a line of an import
    if (code != SQLITE_OK)
        return sql_fail(s, code, err);
    sqlite3_db_config(s->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_db_config(s->db, SQLITE_DBCONFIG_ENABLE_FKEY, 1, NULL);
    sqlite3_db_config(s->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    return true;
}

static bool open_connection(store *s, int flags, int busy_ms, duet_error *err)
{
    text name = {0};
    store_file_name(s->file, &name);
    bool ok = text_ok(&name, err) && connect(s, name.chars, flags, busy_ms, err);
    text_free(&name);
    return ok;
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
        statfs(s->file, &info) == 0 ? store_journal((unsigned long)info.f_type) : "wal";
    if (strcmp(mode, "wal") != 0 && s->note.length == 0)
        text_add(&s->note,
                 "%s: is on a network file system: processes wait for each other there; a local "
                 "file is faster",
                 s->path);
    return change_journal(s, mode, err) && sql_script(s, "PRAGMA synchronous = NORMAL", err);
}

static bool open_for_writing(store *s, duet_error *err)
{
    if (!open_connection(s, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, BUSY_MS, err))
        return false;
    s->writable = true;
    if (sqlite3_db_readonly(s->db, "main") == 1)
        return sql_fail(s, SQLITE_READONLY, err);
    return store_validate(s, err) && (!s->writable || choose_journal(s, err));
}

static bool open_resting(store *s, int busy_ms, duet_error *err)
{
    text name = {0};
    unlocked_read_uri(s->file, &name);
    bool ok = text_ok(&name, err) &&
              connect(s, name.chars, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, busy_ms, err);
    text_free(&name);
    return ok;
}

// A file that rests needs no lock, no side file, no space and no rights to be
// read. If a writer is at work, or was killed, its side file must be read too;
// SQLite clears that away at the end if this user may write.
static bool open_for_reading(store *s, duet_error *err)
{
    s->reading = unlocked_read_begin(s->file);
    if (s->reading.holds)
        return open_resting(s, BUSY_MS, err) && store_validate(s, err);
    return open_connection(s, SQLITE_OPEN_READWRITE, BUSY_MS, err) && store_validate(s, err) &&
           sql_script(s, "PRAGMA query_only = ON", err);
}

static bool open_for_look(store *s, duet_error *err)
{
    s->reading = unlocked_read_begin(s->file);
    return (s->reading.holds ? open_resting(s, LOOK_BUSY_MS, err)
                             : open_connection(s, SQLITE_OPEN_READONLY, LOOK_BUSY_MS, err)) &&
           store_validate(s, err);
}

typedef bool opening(store *s, duet_error *err);

static store *open_file(const char *path, const char *file, opening *open, duet_error *err)
{
    store *s = make(path, file, err);
    if (s && open(s, err) && text_ok(&s->note, err))
        return s;
    store_close(s);
    return NULL;
}

static store *open_store(const char *path, store_access access, opening *open, duet_error *err)
{
    return store_validate_path(path, access, err) ? open_file(path, path, open, err) : NULL;
}

// ---------------------------------------------------------------------- making

static bool not_made(const char *path, duet_error *err)
{
    return error_set(err, DUET_STATUS_STORE_FAILED, "%s: cannot be made: %s", path,
                     strerror(errno));
}

// A name that nobody can guess, and an empty file there that is nobody else's.
static bool begin_beside(const char *path, text *beside, duet_error *err)
{
    char id[PROFILE_ID];
    if (!profile_new_id(id, err))
        return false;
    text_add(beside, "%s.%.16s.new", path, id);
    if (!text_ok(beside, err))
        return false;
    int file = open(beside->chars, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
    return file >= 0 ? close(file) == 0 : not_made(path, err);
}

// A file system without hard links may still rename; one that does neither
// without taking another's place gets its file made where it lies.
static bool put_in_place(const char *beside, const char *path, duet_error *err)
{
    if (link(beside, path) == 0 || errno == EEXIST)
        return true;
    if (renameat2(AT_FDCWD, beside, AT_FDCWD, path, RENAME_NOREPLACE) == 0 || errno == EEXIST ||
        errno == EINVAL || errno == ENOSYS)
        return true;
    return not_made(path, err);
}

static void remove_all(const char *beside)
{
    static const char *const endings[] = {"", "-wal", "-shm", "-journal"};
    for (size_t i = 0; i < sizeof endings / sizeof endings[0]; ++i) {
        text name = {0};
        text_add(&name, "%s%s", beside, endings[i]);
        if (text_ok(&name, NULL))
            unlink(name.chars);
        text_free(&name);
    }
}

// Makes a store beside its place and puts it there whole, so that nobody meets
// a file in the making and a failure leaves none.
static bool make_whole(const char *path, duet_error *err)
{
    text beside = {0};
    bool ok = begin_beside(path, &beside, err);
    if (ok) {
        store *s = open_file(path, beside.chars, open_for_writing, err);
        ok = s != NULL;
        store_close(s);
        ok = ok && put_in_place(beside.chars, path, err);
        remove_all(beside.chars);
    }
    text_free(&beside);
    return ok;
}

static store *open_at(const char *path, store_access access, duet_error *err)
{
    if (access == STORE_READ)
        return open_store(path, access, open_for_reading, err);
    struct stat info;
    if (!store_validate_path(path, access, err) ||
        (stat(path, &info) != 0 && !make_whole(path, err)))
        return NULL;
    return open_store(path, access, open_for_writing, err);
}

store *store_open(const char *path, store_access access, duet_error *err)
{
    text user = {0};
    bool ok = path || store_user_path(&user, err);
    store *s = ok ? open_at(path ? path : text_chars(&user), access, err) : NULL;
    text_free(&user);
    return s;
}

store *store_open_look(const char *path, duet_error *err)
{
    return open_store(path, STORE_READ, open_for_look, err);
}
