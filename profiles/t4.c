// SPDX-License-Identifier: MIT
// SQLite makes the JSON of each row, so that numbers stay as they are stored; what is written
// around the rows makes them one document.
#include "profiles/t4.h"

#include "base/blob.h"
#include "profiles/sql.h"

#include <assert.h>
#include <errno.h>
#include <string.h>

static const char head[] = "{\"schema_version\":\"1.0.0\",\n"
                           "\"metadata\":{\"timeunit\":\"milliseconds\",\n"
                           "\"hardware\":{\"hardware_description\":[";

// Writes the texts of a query's only column with commas between them.
static bool write_rows(store *s, const char *query, FILE *out, duet_error *err)
{
    text row = {0};
    sql q = sql_make(s, query, err);
    for (bool first = true; sql_row(&q); first = false) {
        row.length = 0;
        text_add(&row, first ? "\n" : ",\n");
        text_add_json(&row, sql_get_text(&q, 0));
        fputs(text_chars(&row), out);
    }
    bool ok = text_ok(&row, err);
    text_free(&row);
    return sql_close(&q) && ok;
}

static bool write_document(store *s, FILE *out, duet_error *err)
{
    const blob *results = blob_find("profiles/t4.sql");
    assert(results);
    fputs(head, out);
    bool ok = write_rows(s,
                         "SELECT json_object('kind', kind, 'vendor', vendor, 'name', name, "
                         "'units', units) FROM device ORDER BY key",
                         out, err);
    fputs("]}},\n\"results\":[", out);
    ok = ok && write_rows(s, results->bytes, out, err);
    fputs("]}\n", out);
    return ok;
}

// In one read transaction, so that a tuner at work cannot tear it.
bool profile_export_t4(store *s, FILE *out, const char *name, duet_error *err)
{
    if (!sql_script(s, "BEGIN", err))
        return false;
    bool ok = write_document(s, out, err);
    ok = sql_script(s, "COMMIT", ok ? err : NULL) && ok && store_check_read(s, err);
    return ok && ((fflush(out) == 0 && !ferror(out)) ||
                  error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be written: %s", name,
                            strerror(errno)));
}
