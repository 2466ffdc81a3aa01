// SPDX-License-Identifier: MIT
// Whether what lies at a path is a store of ours, and which version: made fresh,
// brought up from an older one, or refused with one line.
//
// All upgrades of a file are one transaction, and before it the whole file is
// copied beside itself, so that one can go back to the older Duet.
#define _POSIX_C_SOURCE 200809L
#include "profiles/sql.h"

#include "base/blob.h"
#include "base/output.h"
#include "profiles/profile.h"

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
    bool ok = output_make_folders(path, 0755, &failed) ||
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

// The first word of a variant, by its new name.
#define RENAME_VARIANT(column)                                                 \
    column " = CASE substr(" column ", 1, instr(" column " || ' ', ' ') - 1) " \
           "WHEN 'rows' THEN 'auto' || substr(" column ", 5) "                 \
           "WHEN 'lanes' THEN 'simd' || substr(" column ", 6) "                \
           "WHEN 'items' THEN 'gpu' || substr(" column ", 6) ELSE " column " END"
#define RENAME_VARIANTS(table) \
    "UPDATE " table " SET " RENAME_VARIANT("variant_a") ", " RENAME_VARIANT("variant_b") ";"

const char *const migrate_upgrades[] = {
    // 2: what levels of accuracy find and cost; what a profile's gain is of.
    "CREATE TABLE price ("
    "  pair_id INTEGER NOT NULL REFERENCES pair (id),"
    "  workload_id INTEGER NOT NULL REFERENCES workload (id),"
    "  kernels TEXT NOT NULL,"
    "  level TEXT NOT NULL,"
    "  step_ns REAL NOT NULL CHECK (step_ns > 0),"
    "  true_pairs INTEGER NOT NULL CHECK (true_pairs >= 0),"
    "  missed INTEGER NOT NULL CHECK (missed BETWEEN 0 AND true_pairs),"
    "  invented INTEGER NOT NULL CHECK (invented >= 0),"
    "  created_ns INTEGER NOT NULL,"
    "  PRIMARY KEY (pair_id, workload_id, kernels, level)"
    ") STRICT, WITHOUT ROWID;"
    "ALTER TABLE profile ADD COLUMN true_pairs INTEGER;"
    "ALTER TABLE profile ADD COLUMN single_ns REAL;"
    "ALTER TABLE profile ADD COLUMN best_share INTEGER CHECK (best_share BETWEEN 0 AND 65536);"
    "ALTER TABLE profile ADD COLUMN best_mode TEXT CHECK (best_mode IN ('shared', 'own', 'slab'));"
    "ALTER TABLE profile ADD COLUMN terms TEXT CHECK (terms GLOB '{*}');",
    // 3: the field's words; drift, which nothing filled, is gone.
    "ALTER TABLE price RENAME TO level_cost;"
    "DROP TABLE drift;"
    "UPDATE session SET search_state = json_set(json_remove(search_state, '$.tape'), '$.trials', "
    "json_extract(search_state, '$.tape')) "
    "WHERE json_valid(search_state) AND json_type(search_state, '$.tape') = "
    "'array';" RENAME_VARIANTS("trial")
        RENAME_VARIANTS("profile") "UPDATE fit SET " RENAME_VARIANT("variant"),
    // 4: how well a verdict is founded, and the race against the undivided device.
    "ALTER TABLE profile ADD COLUMN rounds INTEGER;"
    "ALTER TABLE profile ADD COLUMN whole_ns REAL;"
    "ALTER TABLE profile ADD COLUMN whole_gain REAL;"
    "ALTER TABLE profile ADD COLUMN whole_gain_low REAL;"
    "ALTER TABLE profile ADD COLUMN whole_gain_high REAL;"
    "UPDATE profile SET live = 0, dead_reason = '" PROFILE_UNFOUNDED "' "
    "WHERE live = 1 AND verdict = 'ambiguous';",
    // 5: queries are workloads, too.
    "ALTER TABLE workload ADD COLUMN query TEXT;"
    "ALTER TABLE workload ADD COLUMN boxes INTEGER NOT NULL DEFAULT 0;",
    // 6: clusters.
    "CREATE TABLE fabric ("
    "  id INTEGER PRIMARY KEY,"
    "  key TEXT NOT NULL UNIQUE,"
    "  mpi TEXT NOT NULL,"
    "  place TEXT NOT NULL,"
    "  hosts INTEGER NOT NULL CHECK (hosts BETWEEN 1 AND ranks),"
    "  ranks INTEGER NOT NULL CHECK (ranks > 0),"
    "  latency_ns REAL CHECK (latency_ns > 0),"
    "  byte_ns REAL CHECK (byte_ns > 0),"
    "  times TEXT CHECK (times GLOB '{*}'),"
    "  measured_ns INTEGER NOT NULL"
    ") STRICT;"
    "CREATE TABLE cluster_run ("
    "  id INTEGER PRIMARY KEY,"
    "  uid TEXT NOT NULL UNIQUE,"
    "  fabric_id INTEGER NOT NULL REFERENCES fabric (id),"
    "  scene TEXT NOT NULL,"
    "  dims INTEGER NOT NULL CHECK (dims IN (2, 3)),"
    "  n INTEGER NOT NULL CHECK (n >= 0),"
    "  level TEXT NOT NULL,"
    "  parts INTEGER NOT NULL CHECK (parts > 0),"
    "  resident INTEGER NOT NULL CHECK (resident IN (0, 1)),"
    "  steps INTEGER NOT NULL CHECK (steps > 0),"
    "  median_ns REAL NOT NULL CHECK (low_ns <= median_ns AND median_ns <= high_ns),"
    "  low_ns REAL NOT NULL,"
    "  high_ns REAL NOT NULL,"
    "  created_ns INTEGER NOT NULL"
    ") STRICT;"
    "CREATE TABLE cluster_rank ("
    "  run_id INTEGER NOT NULL REFERENCES cluster_run (id) ON DELETE CASCADE,"
    "  number INTEGER NOT NULL,"
    "  devices TEXT NOT NULL,"
    "  n INTEGER NOT NULL CHECK (n >= 0),"
    "  ghosts INTEGER NOT NULL CHECK (ghosts >= 0),"
    "  pairs INTEGER NOT NULL CHECK (pairs >= 0),"
    "  sent_bytes INTEGER NOT NULL CHECK (sent_bytes >= 0),"
    "  busy_ns REAL NOT NULL CHECK (busy_ns >= 0),"
    "  wait_ns REAL NOT NULL CHECK (wait_ns >= 0),"
    "  PRIMARY KEY (run_id, number)"
    ") STRICT, WITHOUT ROWID;",
    // 7: what other programs did meanwhile; runs of clusters are kept no more.
    "DROP TABLE cluster_rank;"
    "DROP TABLE cluster_run;"
    "DROP TABLE fabric;"
    "DROP VIEW part;"
    "ALTER TABLE sample ADD COLUMN cpu_ns INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE sample ADD COLUMN wait_ns INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE trial ADD COLUMN disturbed INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE profile ADD COLUMN watched INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE profile ADD COLUMN disturbed INTEGER NOT NULL DEFAULT 0 CHECK (disturbed <= "
    "watched);"
    "CREATE VIEW part AS\n"
    "  SELECT pair.env_a AS env_id, w.family, s.kernels, s.host,\n"
    "         CASE t.mode WHEN 'shared' THEN 'a' ELSE 'part' END AS role,\n"
    "         t.mode, t.level, t.variant_a AS variant,\n"
    "         w.n, w.n * (t.share / 65536.0) AS own, w.occ_mean AS occupancy, t.a_ns AS time_ns\n"
    "    FROM workload w JOIN session s ON s.workload_id = w.id\n"
    "    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id\n"
    "   WHERE t.outcome = 'ok' AND t.disturbed = 0 AND t.share BETWEEN 1 AND 65535 AND t.a_ns > 0\n"
    "  UNION ALL\n"
    "  SELECT pair.env_b, w.family, s.kernels, s.host,\n"
    "         CASE t.mode WHEN 'shared' THEN 'b' ELSE 'part' END,\n"
    "         t.mode, t.level, t.variant_b,\n"
    "         w.n, w.n * (1 - t.share / 65536.0), w.occ_mean, t.b_ns\n"
    "    FROM workload w JOIN session s ON s.workload_id = w.id\n"
    "    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id\n"
    "   WHERE t.outcome = 'ok' AND t.disturbed = 0 AND t.share BETWEEN 1 AND 65535 AND t.b_ns > 0\n"
    "  UNION ALL\n"
    "  SELECT iif(t.share = 0, pair.env_b, pair.env_a), w.family, s.kernels, s.host, 'alone',\n"
    "         '', t.level, iif(t.share = 0, t.variant_b, t.variant_a),\n"
    "         w.n, w.n, w.occ_mean, t.median_ns\n"
    "    FROM workload w JOIN session s ON s.workload_id = w.id\n"
    "    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id\n"
    "   WHERE t.outcome = 'ok' AND t.disturbed = 0 AND t.share IN (0, 65536);",
    NULL,
};

static bool set_version(store *s, int64_t version, duet_error *err)
{
    char pragma[64];
    snprintf(pragma, sizeof pragma, "PRAGMA user_version = %" PRId64, version);
    return sql_script(s, pragma, err);
}

bool migrate_create(store *s, duet_error *err)
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

// The first name of PATH.v1, PATH.v1.1, PATH.v1.2 ... that is free, which is
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
        ok = sql_script(s, upgrades[version - 1], err);
    return ok && set_version(s, to, err) && store_audit(s, "upgrade", detail, err);
}

bool migrate_upgrade(store *s, const char *const *upgrades, duet_error *err)
{
    int64_t newest = 1;
    while (upgrades[newest - 1])
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

typedef enum identity { IS_EMPTY, IS_FOREIGN, IS_OLDER, IS_OURS, IS_NEWER } identity;

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
        *is = *version > STORE_VERSION ? IS_NEWER : *version < STORE_VERSION ? IS_OLDER : IS_OURS;
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
    if (is != IS_EMPTY && is != IS_FOREIGN && !check_code(s, is == IS_OLDER, err))
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
