// SPDX-License-Identifier: MIT
// SQLite's own JSON writes and reads the lines, so that whole numbers stay whole, and its
// constraints judge what comes in.
#define _POSIX_C_SOURCE 200809L
#include "profiles/exchange.h"

#include "base/output.h"
#include "base/text_file.h"
#include "base/visible.h"
#include "profiles/fit.h"
#include "profiles/row_line.h"
#include "profiles/sql.h"
#include "profiles/subject.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <inttypes.h>
#include <string.h>

// ----------------------------------------------------------------------------- out

typedef bool line_sink(void *context, const char *line, duet_error *err);

// A name in a store may hold what a line of JSON must not.
static bool send_valid(const char *line, line_sink *sink, void *context, duet_error *err)
{
    text valid = {0};
    text_add_json(&valid, line);
    bool ok = text_ok(&valid, err) && sink(context, text_chars(&valid), err);
    text_free(&valid);
    return ok;
}

static bool send_type(store *s, const line_type *type, line_sink *sink, void *context,
                      duet_error *err)
{
    text query = {0};
    line_add_select(&query, type);
    bool ok = true;
    sql q = sql_make_text(s, &query, err);
    while (ok && sql_row(&q))
        ok = send_valid(sql_get_text(&q, 0), sink, context, err);
    return sql_close(&q) && ok;
}

// In one read transaction, so that a tuner at work cannot tear it.
static bool send_lines(store *s, line_sink *sink, void *context, duet_error *err)
{
    char head[96];
    snprintf(head, sizeof head, "{\"type\":\"store\",\"version\":%d}", STORE_VERSION);
    if (!sql_script(s, "BEGIN", err))
        return false;
    bool ok = sink(context, head, err);
    for (int i = 0; ok && i < LINE_TYPES; ++i)
        ok = send_type(s, &line_types[i], sink, context, err);
    return sql_script(s, "COMMIT", ok ? err : NULL) && ok;
}

typedef struct writing {
    FILE *out;
    const char *name; // the file's, for messages
} writing;

static bool write_failed(const writing *w, duet_error *err)
{
    return error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be written: %s", w->name,
                     strerror(errno));
}

static bool write_line(void *context, const char *line, duet_error *err)
{
    const writing *w = context;
    return fprintf(w->out, "%s\n", line) > 0 || write_failed(w, err);
}

bool profile_export(store *s, FILE *out, const char *name, duet_error *err)
{
    writing w = {out, name};
    return send_lines(s, write_line, &w, err) && store_check_read(s, err) &&
           (fflush(out) == 0 || write_failed(&w, err));
}

bool profile_export_file(store *s, profile_export_format *format, const char *path, duet_error *err)
{
    output o;
    if (output_replaces(s->path, path))
        return bad_argument(err, "%s: is the store itself; name another one", path);
    bool ok = output_open(&o, path, err) && format(s, o.stream, path, err);
    return output_close(&o, ok, err);
}

// ------------------------------------------------------------------------------ in

typedef struct import {
    store *s;
    const char *name; // the file's, for messages
    uint64_t line;
    profile_import_counts *counts;
    bool has_lines; // one that is not blank
} import;

static bool bad_line(const import *in, duet_error *err, const char *what, const char *which)
{
    return bad_input(err, "%s:%" PRIu64 ": %s%s", in->name, in->line, what, which);
}

// Says what is wrong with a line that breaks a constraint, in words of the line.
static bool explain(const import *in, int code, duet_error *err)
{
    static const char missing[] = "NOT NULL constraint failed: ";
    if ((code & 0xff) != SQLITE_CONSTRAINT && (code & 0xff) != SQLITE_MISMATCH &&
        (code & 0xff) != SQLITE_ERROR)
        return sql_fail(in->s, code, err);
    const char *message = sqlite3_errmsg(in->s->db);
    if (strncmp(message, missing, sizeof missing - 1) != 0)
        return bad_line(in, err, message, "");
    const char *column = strchr(message + sizeof missing - 1, '.') + 1;
    size_t length = strlen(column);
    if (length > 3 && strcmp(column + length - 3, "_id") == 0)
        return bad_line(in, err, "needs a row that is neither above it nor in the store, by ",
                        column);
    return bad_line(in, err, "a field is missing or not known: ", column);
}

static sql parse(const import *in, const char *query, const char *line, duet_error *err)
{
    sql q = sql_make(in->s, query, err);
    sql_text(&q, line);
    return q;
}

static bool check_head(const import *in, const sql *q, duet_error *err)
{
    return sql_get_int(q, 1) == STORE_VERSION ||
           bad_line(in, err, "comes from another version of Duet, which this one cannot read", "");
}

// The line's type; NULL for the first line, which is no row.
static bool find_type(const import *in, const char *line, const line_type **type, duet_error *err)
{
    sql q = parse(in,
                  "SELECT coalesce(json_extract(?1, '$.type'), '(none)'), "
                  "json_extract(?1, '$.version') "
                  "WHERE json_valid(?1) AND json_type(?1) = 'object'",
                  line, err);
    *type = NULL;
    bool ok = sql_row(&q) || bad_line(in, err, "is not a JSON object", "");
    if (ok) {
        const char *name = sql_get_text(&q, 0);
        *type = line_type_named(name);
        if (strcmp(name, "store") == 0)
            ok = check_head(in, &q, err);
        else if (!*type)
            ok = bad_line(in, err,
                          "its type is not one of store, device, env, pair, workload, level_cost, "
                          "script, session, trial, profile: ",
                          name);
    }
    return sql_close(&q) && ok;
}

static bool check_fields(const import *in, const line_type *type, const char *line, duet_error *err)
{
    sql q = parse(in,
                  "SELECT key FROM json_each(?1) GROUP BY key HAVING count(*) > 1 "
                  "OR instr(' type ' || ?2 || ' ', ' ' || key || ' ') = 0",
                  line, err);
    sql_text(&q, type->fields);
    bool known = !sql_row(&q) ||
                 bad_line(in, err, "has an unknown or repeated field: ", sql_get_text(&q, 0));
    return sql_close(&q) && known;
}

// SQLite would take the text of a string for an object as well.
static bool check_objects(const import *in, const line_type *type, const cJSON *row,
                          duet_error *err)
{
    const cJSON *field;
    cJSON_ArrayForEach(field, row)
    {
        if (line_is_object(type, field->string) && !cJSON_IsNull(field) && !cJSON_IsObject(field))
            return bad_line(in, err, "is not a JSON object: ", field->string);
    }
    return true;
}

// Whether a string of the line has a NUL, which would cut it: an escape behind an even number of
// backslashes.
static bool has_nul(const char *line)
{
    for (const char *at = line; (at = strstr(at, "\\u0000")); ++at) {
        const char *first = at;
        while (first > line && first[-1] == '\\')
            --first;
        if ((at - first) % 2 == 0)
            return true;
    }
    return false;
}

// Two readers must agree on the line, so that what comes in can go out again.
static bool check_json(const import *in, const line_type *type, const char *line, duet_error *err)
{
    cJSON *row = cJSON_ParseWithOpts(line, NULL, true);
    bool ok = cJSON_IsObject(row) || bad_line(in, err, "is not a JSON object", "");
    ok = ok && check_objects(in, type, row, err) &&
         (!has_nul(line) || bad_line(in, err, "has a string with a NUL", ""));
    cJSON_Delete(row);
    return ok;
}

// Runs a statement on the line; id is parameter 2, where it has one.
static bool run(const import *in, const char *statement, const char *line, int64_t id,
                duet_error *err)
{
    sqlite3_stmt *stmt = NULL;
    int code = sqlite3_prepare_v2(in->s->db, statement, -1, &stmt, NULL);
    if (code == SQLITE_OK) {
        sqlite3_bind_text(stmt, 1, line, -1, SQLITE_STATIC);
        if (sqlite3_bind_parameter_count(stmt) > 1)
            sqlite3_bind_int64(stmt, 2, id);
        code = sqlite3_step(stmt);
    }
    bool ok = code == SQLITE_DONE || explain(in, code, err);
    sqlite3_finalize(stmt);
    return ok;
}

static bool insert_row(const import *in, const line_type *type, const char *line, duet_error *err)
{
    text statement = {0};
    line_add_insert(&statement, type);
    bool ok = text_ok(&statement, err) && run(in, text_chars(&statement), line, 0, err);
    text_free(&statement);
    return ok;
}

static bool take_row(const import *in, const line_type *type, const char *line, duet_error *err)
{
    if (!insert_row(in, type, line, err))
        return false;
    if (sqlite3_changes(in->s->db) == 0) {
        ++in->counts->known;
        return true;
    }
    ++in->counts->added;
    int64_t id = sqlite3_last_insert_rowid(in->s->db);
    bool right = true;
    if (strncmp(type->fields, "key ", 4) == 0 && !key_check(in->s, type->name, id, &right, err))
        return false;
    if (!right)
        return bad_line(in, err, "its key is not that of its fields", "");
    return !type->parts || run(in, type->parts, line, id, err);
}

static bool take_line(void *context, const char *line, duet_error *err)
{
    import *in = context;
    ++in->line;
    if (line[strspn(line, " \t\r\n")] == '\0')
        return true;
    in->has_lines = true;
    if (!utf8_is_valid(line))
        return bad_line(in, err, "is not UTF-8", "");
    const line_type *type = NULL;
    return find_type(in, line, &type, err) &&
           (!type || (check_fields(in, type, line, err) && check_json(in, type, line, err) &&
                      take_row(in, type, line, err)));
}

// With its end; a NUL ends it too, and too many bytes: a device may never end a line.
static bool read_line(FILE *file, text *line)
{
    int c = 0;
    line->length = 0;
    while (line->length <= TEXT_LINE_MOST && !line->failed && (c = getc(file)) != EOF) {
        text_add_bytes(line, &(char){(char)c}, 1);
        if (c == '\n' || c == '\0')
            break;
    }
    return line->length > 0 || line->failed;
}

// Says why the text can be no line; NULL: it may be one.
static const char *what_is_wrong(const text *line)
{
    return line->length > TEXT_LINE_MOST        ? "is longer than 16 MiB"
           : strlen(line->chars) < line->length ? "has a NUL byte"
                                                : NULL;
}

static bool take_file(import *in, FILE *file, duet_error *err)
{
    text line = {0};
    bool ok = true;
    while (ok && read_line(file, &line)) {
        ok = text_ok(&line, err);
        const char *wrong = ok ? what_is_wrong(&line) : NULL;
        if (wrong)
            ++in->line, ok = bad_line(in, err, wrong, "");
        ok = ok && take_line(in, line.chars, err);
    }
    if (ok && ferror(file))
        ok = error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be read: %s", in->name,
                       strerror(errno));
    text_free(&line);
    if (ok && !in->has_lines)
        ok = bad_input(err, "%s: is empty; expected what 'duet profiles export' wrote", in->name);
    return ok;
}

static bool finish(const import *in, const char *what, duet_error *err)
{
    text detail = {0};
    text_add(&detail, "%" PRIu64 " rows added, %" PRIu64 " known", in->counts->added,
             in->counts->known);
    bool ok = fit_all(in->s, err) && text_ok(&detail, err) &&
              store_audit(in->s, what, text_chars(&detail), err);
    text_free(&detail);
    return ok;
}

bool profile_import(store *s, FILE *file, const char *name, profile_import_counts *counts,
                    duet_error *err)
{
    *counts = (profile_import_counts){0};
import in = {.s = s, .name = name, .counts = counts };
    if (!store_begin(s, err))
        return false;
    bool ok = take_file(&in, file, err) && finish(&in, "import", err);
    return store_end(s, ok, err);
}

bool profile_merge(store *s, const char *other_path, profile_import_counts *counts, duet_error *err)
{
    *counts = (profile_import_counts){0};
    if (output_replaces(s->path, other_path))
        return bad_argument(err, "%s: is the store itself; name another one", other_path);
    store *other = store_open(other_path, STORE_READ, err);
    if (!other)
        return false;
import in = {.s = s, .name = other_path, .counts = counts };
    bool ok = store_begin(s, err);
    if (ok) {
        ok = send_lines(other, take_line, &in, err) && store_check_read(other, err) &&
             finish(&in, "merge", err);
        ok = store_end(s, ok, err);
    }
    store_close(other);
    return ok;
}
