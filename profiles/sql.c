// SPDX-License-Identifier: MIT
// Statements, and what SQLite's refusals mean to a user.
#define _POSIX_C_SOURCE 200809L
#include "profiles/sql.h"

#include "base/list.h"
#include "base/text_file.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool disk_is_full(int code, int system_code)
{
    if ((code & 0xff) == SQLITE_FULL)
        return true;
    return (code & 0xff) == SQLITE_IOERR &&
           (system_code == ENOSPC || system_code == EFBIG || system_code == EDQUOT);
}

static bool is_left_half_done(const store *s, int code)
{
    return !s->writable && ((code & 0xff) == SQLITE_READONLY || (code & 0xff) == SQLITE_CANTOPEN) &&
           s->file && unlocked_read_has_side_file(s->file);
}

// The first row of the table that SQLite does not read for its length, from 1; 0: each is read.
static uint64_t find_long_row(const store *s, const char *table)
{
    uint64_t row = 0;
    sqlite3_stmt *rows = NULL;
    char *query = sqlite3_mprintf("SELECT * FROM \"%w\"", table);
    int code = query ? sqlite3_prepare_v2(s->db, query, -1, &rows, NULL) : SQLITE_NOMEM;
    while (code == SQLITE_OK || code == SQLITE_ROW) {
        code = sqlite3_step(rows);
        ++row;
    }
    sqlite3_finalize(rows);
    sqlite3_free(query);
    return (code & 0xff) == SQLITE_TOOBIG ? row : 0;
}

static bool fail_long(const store *s, duet_error *err)
{
    sqlite3_stmt *tables = NULL;
    uint64_t row = 0;
    sqlite3_prepare_v2(s->db, "SELECT name FROM sqlite_schema WHERE type = 'table'", -1, &tables,
                       NULL);
    while (row == 0 && sqlite3_step(tables) == SQLITE_ROW) {
        const char *name = (const char *)sqlite3_column_text(tables, 0);
        row = find_long_row(s, name);
        if (row > 0)
            error_set(err, DUET_STATUS_STORE_FAILED,
                      "%s: row %" PRIu64 " of table %s is longer than %d MiB; expected what Duet "
                      "wrote there",
                      s->path, row, name, TEXT_LINE_MOST >> 20);
    }
    sqlite3_finalize(tables);
    return error_set(err, DUET_STATUS_STORE_FAILED, "%s: a text is longer than %d MiB", s->path,
                     TEXT_LINE_MOST >> 20);
}

bool sql_fail(const store *s, int code, duet_error *err)
{
    // SQLite keeps the system's code for most failures, and not for those of a COMMIT.
    int last = errno;
    int system_code = sqlite3_system_errno(s->db) ? sqlite3_system_errno(s->db) : last;
    if (!unlocked_read_check(s->file, &s->reading, err))
        return false;
    if (is_left_half_done(s, code))
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: a writer that is at work, or was killed, has rows in a file beside "
                         "it, which this user may not write; let its owner open it once",
                         s->path);
    if (disk_is_full(code, system_code))
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: the disk is full: this step was undone and all before it is kept; "
                         "free space and run the command again",
                         s->path);
    switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: another process keeps it locked; try again when that is done",
                         s->path);
    case SQLITE_READONLY:
    case SQLITE_PERM:
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: the file or its folder cannot be written; give yourself the right "
                         "to, or name another file with DUET_PROFILE",
                         s->path);
    case SQLITE_CANTOPEN:
        return error_set(err, DUET_STATUS_STORE_FAILED, "%s: cannot be opened: %s", s->path,
                         system_code ? strerror(system_code) : sqlite3_errmsg(s->db));
    case SQLITE_NOTADB:
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: is not a profile store and was left as it is; move it away or name "
                         "another file with DUET_PROFILE",
                         s->path);
    case SQLITE_CORRUPT:
        return error_set(err, DUET_STATUS_STORE_FAILED,
                         "%s: the file is damaged and was left as it is; bring back a copy, or "
                         "move it away to begin a fresh one",
                         s->path);
    case SQLITE_IOERR:
        return error_set(err, DUET_STATUS_STORE_FAILED, "%s: reading or writing it failed: %s",
                         s->path, system_code ? strerror(system_code) : sqlite3_errmsg(s->db));
    case SQLITE_TOOBIG:
        return fail_long(s, err);
    case SQLITE_NOMEM:
        return no_memory(err, "%s", s->path);
    default:
        return error_set(err, DUET_STATUS_STORE_FAILED, "%s: %s", s->path, sqlite3_errmsg(s->db));
    }
}

static void check(sql *q, int code)
{
    if (q->failed || code == SQLITE_OK)
        return;
    q->failed = true;
    sql_fail(q->s, code, q->err);
}

sql sql_make(store *s, const char *statement, duet_error *err)
{
    sql q = {.s = s, .err = err};
    check(&q, sqlite3_prepare_v2(s->db, statement, -1, &q.stmt, NULL));
    return q;
}

void sql_text(sql *q, const char *value)
{
    ++q->bound;
    if (!q->failed)
        check(q, sqlite3_bind_text(q->stmt, q->bound, value, -1, SQLITE_STATIC));
}

void sql_int(sql *q, int64_t value)
{
    ++q->bound;
    if (!q->failed)
        check(q, sqlite3_bind_int64(q->stmt, q->bound, value));
}

void sql_real(sql *q, double value)
{
    ++q->bound;
    if (q->failed)
        return;
    check(q, isfinite(value) ? sqlite3_bind_double(q->stmt, q->bound, value)
                             : sqlite3_bind_null(q->stmt, q->bound));
}

bool sql_row(sql *q)
{
    if (q->failed)
        return false;
    int code = sqlite3_step(q->stmt);
    if (code == SQLITE_ROW)
        return true;
    if (code != SQLITE_DONE)
        check(q, code);
    return false;
}

void sql_again(sql *q)
{
    q->bound = 0;
    if (!q->failed)
        sqlite3_reset(q->stmt);
}

bool sql_close(sql *q)
{
    sqlite3_finalize(q->stmt);
    q->stmt = NULL;
    return !q->failed;
}

bool sql_run(sql *q)
{
    while (sql_row(q))
        ;
    return sql_close(q);
}

int64_t sql_get_int(const sql *q, int column)
{
    return sqlite3_column_int64(q->stmt, column);
}

double sql_get_real(const sql *q, int column)
{
    return sqlite3_column_double(q->stmt, column);
}

const char *sql_get_text(const sql *q, int column)
{
    return (const char *)sqlite3_column_text(q->stmt, column);
}

// ---------------------------------------------------------------- columns

void sql_add_names(text *t, const char *prefix, const sql_column *columns)
{
    for (const sql_column *c = columns; c->name; ++c)
        text_add(t, "%s%s%s", c == columns ? "" : ", ", prefix, c->name);
}

sql sql_make_text(store *s, text *statement, duet_error *err)
{
    sql q = text_ok(statement, err) ? sql_make(s, text_chars(statement), err)
                                    : (sql){.s = s, .err = err, .failed = true};
    text_free(statement);
    return q;
}

sql sql_insert(store *s, const char *table, const sql_column *columns, const char *more,
               const char *end, duet_error *err)
{
    text t = {0};
    text_add(&t, "INSERT INTO %s (", table);
    sql_add_names(&t, "", columns);
    text_add(&t, ", %s) VALUES (?", more);
    for (const sql_column *c = columns; c->name; ++c)
        text_add(&t, ", ?");
    for (const char *comma = strchr(more, ','); comma; comma = strchr(comma + 1, ','))
        text_add(&t, ", ?");
    text_add(&t, ") %s", end);
    return sql_make_text(s, &t, err);
}

sql sql_select(store *s, const sql_column *columns, const char *rest, duet_error *err)
{
    text t = {0};
    text_add(&t, "SELECT ");
    sql_add_names(&t, "", columns);
    text_add(&t, "%s", rest);
    return sql_make_text(s, &t, err);
}

static void bind_column(sql *q, const sql_column *c, const void *member)
{
    switch (c->kind) {
    case SQL_INT:
        sql_int(q, *(const int64_t *)member);
        break;
    case SQL_COUNT:
        if (*(const int64_t *)member < 0)
            sql_text(q, NULL);
        else
            sql_int(q, *(const int64_t *)member);
        break;
    case SQL_UINT:
        sql_int(q, *(const uint32_t *)member);
        break;
    case SQL_BOOL:
        sql_int(q, *(const bool *)member);
        break;
    case SQL_REAL:
        sql_real(q, *(const double *)member);
        break;
    case SQL_TEXT:
        sql_text(q, *(const char *const *)member);
        break;
    case SQL_CHARS:
        sql_text(q, member);
        break;
    }
}

void sql_bind(sql *q, const sql_column *columns, const void *row)
{
    for (const sql_column *c = columns; c->name; ++c) {
        if (row)
            bind_column(q, c, (const char *)row + c->offset);
        else
            sql_text(q, NULL);
    }
}

static void read_column(const sql *q, int column, const sql_column *c, void *member)
{
    bool is_null = sqlite3_column_type(q->stmt, column) == SQLITE_NULL;
    switch (c->kind) {
    case SQL_INT:
        *(int64_t *)member = sql_get_int(q, column);
        break;
    case SQL_COUNT:
        *(int64_t *)member = is_null ? -1 : sql_get_int(q, column);
        break;
    case SQL_UINT:
        *(uint32_t *)member = (uint32_t)sql_get_int(q, column);
        break;
    case SQL_BOOL:
        *(bool *)member = sql_get_int(q, column) != 0;
        break;
    case SQL_REAL:
        *(double *)member = is_null ? NAN : sql_get_real(q, column);
        break;
    case SQL_TEXT:
        *(const char **)member = sql_get_text(q, column);
        break;
    case SQL_CHARS:
        sql_copy(member, c->size, sql_get_text(q, column));
        break;
    }
}

int sql_read(const sql *q, int column, const sql_column *columns, void *row)
{
    for (const sql_column *c = columns; c->name; ++c)
        read_column(q, column++, c, (char *)row + c->offset);
    return column;
}

void *sql_rows(sql *q, const sql_column *columns, size_t size, uint32_t *n)
{
    char *rows = NULL;
    for (*n = 0; sql_row(q); ++*n) {
        char *grown = list_room(rows, *n, size, NULL);
        if (!grown) {
            check(q, SQLITE_NOMEM);
            break;
        }
        rows = grown;
        sql_read(q, 0, columns, memset(rows + *n * size, 0, size));
    }
    return rows;
}

// ---------------------------------------------------------------- whole statements

bool sql_script(store *s, const char *statements, duet_error *err)
{
    int code = sqlite3_exec(s->db, statements, NULL, NULL, NULL);
    return code == SQLITE_OK || sql_fail(s, code, err);
}

bool sql_number(store *s, const char *query, int64_t *number, duet_error *err)
{
    sql q = sql_make(s, query, err);
    *number = sql_row(&q) ? sql_get_int(&q, 0) : 0;
    return sql_close(&q);
}

bool sql_find(store *s, const char *query, const char *key, int64_t *id, duet_error *err)
{
    sql q = sql_make(s, query, err);
    sql_text(&q, key);
    *id = sql_row(&q) ? sql_get_int(&q, 0) : 0;
    return sql_close(&q);
}

void sql_copy(char *to, size_t size, const char *from)
{
    size_t length = from ? strnlen(from, size - 1) : 0;
    if (length > 0)
        memcpy(to, from, length);
    to[length] = '\0';
}

bool sql_check_object(const char *what, const char *chars, duet_error *err)
{
    cJSON *json = cJSON_ParseWithOpts(chars, NULL, true);
    bool ok = cJSON_IsObject(json);
    cJSON_Delete(json);
    return ok || bad_argument(err, "%s must be one JSON object, not: %.60s", what, chars);
}
