// SPDX-License-Identifier: MIT
// The open store and its transactions.
#include "profiles/store.h"

#include "base/clock.h"
#include "profiles/sql.h"

#include <assert.h>
#include <stdlib.h>

void store_close(store *s)
{
    if (!s)
        return;
    assert(s->depth == 0);
    sqlite3_close(s->db);
    text_free(&s->note);
    free(s->path);
    free(s->file);
    free(s);
}

// To SQLite a leading "file:" or ":" is no part of a name; after a slash it is.
void store_file_name(const char *path, text *name)
{
    text_add(name, "%s%s", *path == '/' ? "" : "./", path);
}

bool store_check_read(const store *s, duet_error *err)
{
    return unlocked_read_check(s->file, &s->reading, err);
}

bool store_undisturbed(const store *s)
{
    return !s->reading.holds || unlocked_read_holds(s->file, &s->reading);
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
            return error_set(err, DUET_STATUS_STORE_FAILED, "%s: is open for reading only",
                             s->path);
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
