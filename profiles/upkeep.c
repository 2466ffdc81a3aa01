// SPDX-License-Identifier: MIT
#include "profiles/upkeep.h"

#include "base/text.h"
#include "profiles/sql.h"
#include "profiles/subject.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

// ------------------------------------------------------------------------- pruning

static bool file_bytes(store *s, int64_t *bytes, duet_error *err)
{
    int64_t pages = 0;
    int64_t page_bytes = 0;
    bool ok = sql_number(s, "PRAGMA page_count", &pages, err) &&
              sql_number(s, "PRAGMA page_size", &page_bytes, err);
    *bytes = pages * page_bytes;
    return ok;
}

// Keeps `keep` of n samples, evenly: sample i stays where i * keep / n takes a value for the first
// time. An unfinished search keeps all.
static bool thin_samples(store *s, const profile_prune_def *def, uint64_t *n, duet_error *err)
{
    sql q = sql_make(
        s,
        "DELETE FROM sample WHERE (trial_id, number) IN (SELECT trial_id, number FROM "
        "(SELECT trial_id, sample.number, count(*) OVER (PARTITION BY trial_id) AS n, "
        "row_number() OVER (PARTITION BY trial_id ORDER BY sample.number) - 1 AS i FROM sample "
        "JOIN trial ON trial.id = trial_id JOIN session ON session.id = session_id "
        "WHERE trial.created_ns < ?1 AND session.state IN ('complete', 'failed')) "
        "WHERE n > ?2 AND (?2 = 0 OR (i > 0 AND i * ?2 / n = (i - 1) * ?2 / n)))",
        err);
    sql_int(&q, def->before_ns);
    sql_int(&q, def->keep_samples);
    bool ok = sql_run(&q);
    *n = ok ? (uint64_t)sqlite3_changes(s->db) : 0;
    return ok;
}

static bool drop_dead(store *s, const profile_prune_def *def, uint64_t *n, duet_error *err)
{
    sql q = sql_make(s, "DELETE FROM profile WHERE live = 0 AND created_ns < ?", err);
    sql_int(&q, def->before_ns);
    bool ok = sql_run(&q);
    *n = ok ? (uint64_t)sqlite3_changes(s->db) : 0;
    return ok;
}

static bool note_pruning(store *s, const profile_prune_counts *counts, duet_error *err)
{
    text detail = {0};
    text_add(&detail, "%" PRIu64 " samples, %" PRIu64 " profiles", counts->samples,
             counts->profiles);
    bool ok = text_ok(&detail, err) && store_audit(s, "prune", text_chars(&detail), err);
    text_free(&detail);
    return ok;
}

bool profile_prune(store *s, const profile_prune_def *def, profile_prune_counts *counts,
                   duet_error *err)
{
    *counts = (profile_prune_counts){0};
    int64_t before = 0;
    int64_t after = 0;
    if (!file_bytes(s, &before, err) || !store_begin(s, err))
        return false;
    bool ok = thin_samples(s, def, &counts->samples, err);
    ok = ok && (!def->drop_dead || drop_dead(s, def, &counts->profiles, err));
    ok = ok && note_pruning(s, counts, err);
    ok = store_end(s, ok, err);
    ok = ok && sql_script(s, "VACUUM", err) && file_bytes(s, &after, err);
    counts->bytes = ok ? before - after : 0;
    return ok;
}

// ------------------------------------------------------------------------ checking

static void add_word(text *report, const char *word)
{
    text_add(report, " ");
    text_add_visible(report, word ? word : "-", word ? strlen(word) : 1, "");
}

// One line for each row that the query gives; its columns are joined.
static bool report_rows(store *s, const char *query, const char *what, text *report,
                        uint32_t *problems, duet_error *err)
{
    sql q = sql_make(s, query, err);
    while (sql_row(&q)) {
        text_add(report, "%s", what);
        for (int i = 0; i < sqlite3_column_count(q.stmt); ++i)
            add_word(report, sql_get_text(&q, i));
        text_add(report, "\n");
        ++*problems;
    }
    return sql_close(&q);
}

static bool check_integrity(store *s, text *report, uint32_t *problems, duet_error *err)
{
    sql q = sql_make(s, "PRAGMA integrity_check", err);
    while (sql_row(&q)) {
        const char *line = sql_get_text(&q, 0);
        if (line && line[0] == 'o' && line[1] == 'k' && line[2] == '\0')
            continue;
        text_add(report, "damaged: %s\n", line ? line : "?");
        ++*problems;
    }
    return sql_close(&q);
}

static bool check_keys(store *s, const char *table, text *report, uint32_t *problems,
                       duet_error *err)
{
    char query[64];
    snprintf(query, sizeof query, "SELECT id, key FROM %s", table);
    sql q = sql_make(s, query, err);
    bool ok = true;
    while (ok && sql_row(&q)) {
        bool right = false;
        ok = key_check(s, table, sql_get_int(&q, 0), &right, err);
        if (ok && !right) {
            text_add(report, "%s", table);
            add_word(report, sql_get_text(&q, 1));
            text_add(report, ": its key is not that of its fields\n");
            ++*problems;
        }
    }
    return sql_close(&q) && ok;
}

#define NO_OBJECT(column)                                                              \
    "CASE WHEN " column " IS NULL THEN 0 WHEN NOT json_valid(" column ") THEN 1 ELSE " \
    "json_type(" column ") <> 'object' END"

static bool check_objects(store *s, text *report, uint32_t *problems, duet_error *err)
{
    return report_rows(s, "SELECT id FROM session WHERE " NO_OBJECT("options"),
                       "a session's options are no JSON object:", report, problems, err) &&
           report_rows(s, "SELECT session_id, number FROM trial WHERE " NO_OBJECT("terms"),
                       "a trial's terms are no JSON object:", report, problems, err) &&
           report_rows(s, "SELECT uid FROM profile WHERE " NO_OBJECT("terms"),
                       "a profile's terms are no JSON object:", report, problems, err);
}

bool profile_check(store *s, text *report, uint32_t *problems, duet_error *err)
{
    *problems = 0;
    return check_integrity(s, report, problems, err) &&
           report_rows(s, "PRAGMA foreign_key_check", "a row points at none:", report, problems,
                       err) &&
           check_keys(s, "device", report, problems, err) &&
           check_keys(s, "env", report, problems, err) &&
           check_keys(s, "workload", report, problems, err) &&
           check_keys(s, "script", report, problems, err) &&
           report_rows(s,
                       "SELECT uid FROM profile p WHERE trial IS NOT NULL AND NOT EXISTS "
                       "(SELECT 1 FROM trial t WHERE t.session_id = p.session_id AND "
                       "t.number = p.trial)",
                       "a profile's trial is not there:", report, problems, err) &&
           check_objects(s, report, problems, err) && text_ok(report, err);
}
