// SPDX-License-Identifier: MIT
// Statements on an open store. Internal to this module.
//
// A statement remembers its first failure and is harmless afterwards, so that
// it is checked once, when it is closed:
//
//     sql q = sql_make(s, "SELECT id FROM env WHERE key = ?", err);
//     sql_text(&q, key);
//     if (sql_row(&q))
//         id = sql_get_int(&q, 0);
//     return sql_close(&q);
#ifndef PROFILES_SQL_H
#define PROFILES_SQL_H

#include "profiles/store.h"
#include "profiles/unlocked_read.h"

#include <sqlite3.h>
#include <stddef.h>

struct store {
    sqlite3 *db;
    char *path; // named in messages, and where it lies
    char *file; // it lies here while it is being made; else the path
    text note;
    bool writable;
    uint32_t depth;        // nested transactions
    bool broken;           // one inside failed: the outermost undoes all
    unlocked_read reading; // the file as it was opened, where it is read without locks
};

typedef struct sql {
    store *s;
    sqlite3_stmt *stmt;
    duet_error *err;
    int bound; // parameters so far
    bool failed;
} sql;

sql sql_make(store *s, const char *statement, duet_error *err);
void sql_text(sql *q, const char *value); // NULL is bound as NULL; must live until sql_close
void sql_int(sql *q, int64_t value);
void sql_real(sql *q, double value); // NULL if not finite
bool sql_row(sql *q);                // false at the end and after a failure
void sql_again(sql *q);              // to bind and run once more
bool sql_run(sql *q);                // to the end, and closes it
bool sql_close(sql *q);

int64_t sql_get_int(const sql *q, int column);
double sql_get_real(const sql *q, int column);
const char *sql_get_text(const sql *q, int column); // NULL if NULL; until the next row

// ---------------------------------------------------------------- columns

typedef enum sql_kind {
    SQL_INT,
    SQL_COUNT,
    SQL_UINT,
    SQL_BOOL,
    SQL_REAL,
    SQL_TEXT,
    SQL_CHARS
} sql_kind;

// A column and the member of a struct that stands for it. The name may be any
// expression where it is only read. A table of columns ends with {0}.
typedef struct sql_column {
    const char *name;
    sql_kind kind;
    size_t offset;
    size_t size;
} sql_column;

// clang-format off
#define SQL_KIND_OF(member)                                                   \
    _Generic(member, int64_t: SQL_INT, uint64_t: SQL_INT, uint32_t: SQL_UINT, \
             bool: SQL_BOOL, double: SQL_REAL, const char *: SQL_TEXT, char *: SQL_CHARS)
// clang-format on

#define SQL_COLUMN(name, struct_, member)                                     \
    {                                                                         \
        name, SQL_KIND_OF(((struct_ *)0)->member), offsetof(struct_, member), \
            sizeof((struct_ *)0)->member                                      \
    }

// An int64_t that is -1 where the column is NULL.
#define SQL_COUNT_COLUMN(name, struct_, member)                     \
    {                                                               \
        name, SQL_COUNT, offsetof(struct_, member), sizeof(int64_t) \
    }

// Columns of a profile_plan.
#define SQL_PLAN_COLUMNS(struct_, plan)                                               \
    SQL_COLUMN("share", struct_, plan.share), SQL_COLUMN("mode", struct_, plan.mode), \
        SQL_COLUMN("level", struct_, plan.level),                                     \
        SQL_COLUMN("variant_a", struct_, plan.variant_a),                             \
        SQL_COLUMN("variant_b", struct_, plan.variant_b)

// "t.share, t.mode" for the prefix "t.".
void sql_add_names(text *t, const char *prefix, const sql_column *columns);

// INSERT INTO table with the columns, bound by sql_bind, and `more` names with
// commas between them, which are bound after them; `end` ends the statement.
sql sql_insert(store *s, const char *table, const sql_column *columns, const char *more,
               const char *end, duet_error *err);

// Makes the statement of a text, which is freed.
sql sql_make_text(store *s, text *statement, duet_error *err);

// SELECT the columns, and what `rest` adds to them and says of where.
sql sql_select(store *s, const sql_column *columns, const char *rest, duet_error *err);

void sql_bind(sql *q, const sql_column *columns, const void *row); // NULL: each is NULL

// Fills the row from `column` on, and gives back the next column. A NULL is 0, NaN for a double, an
// empty or no text.
int sql_read(const sql *q, int column, const sql_column *columns, void *row);

// All rows that are left, each a struct of `size` bytes that holds no SQL_TEXT. The
// caller frees them, and asks sql_close whether they are all.
void *sql_rows(sql *q, const sql_column *columns, size_t size, uint32_t *n);

// ---------------------------------------------------------------- whole statements

// Runs a text of statements that give no rows.
bool sql_script(store *s, const char *statements, duet_error *err);

// The one number that a query gives; 0 if it gives none.
bool sql_number(store *s, const char *query, int64_t *number, duet_error *err);

// The id that a query with one text parameter gives; 0 if it gives none.
bool sql_find(store *s, const char *query, const char *key, int64_t *id, duet_error *err);

// Says in one line why SQLite refused: which file, and what would help.
bool sql_fail(const store *s, int code, duet_error *err);

// Copies at most size-1 bytes; what is stored was checked to fit when it came in.
void sql_copy(char *to, size_t size, const char *from);

// BAD_ARGUMENT, with what, where a text from outside this module is not one JSON
// object. SQL's own check is off in a store, whose text is not trusted.
bool sql_check_object(const char *what, const char *chars, duet_error *err);

// Joins of the rows of profiles, for a query on p, its devices da and db
// under a and b, its workload w and session s. Parameters: the uid's first digits,
// whether dead ones are wanted too.
extern const char profile_entry_from[];

// One row in the audit table.
bool store_audit(store *s, const char *what, const char *detail, duet_error *err);

// How SQLite is told of a path: as the file of that name, whatever the name is.
void store_file_name(const char *path, text *name);

// Refuses what can be no store: a folder, or a file that is no database. Makes
// the folders of one to be written.
bool store_validate_path(const char *path, store_access access, duet_error *err);

// Makes or upgrades the file of an open database that is to be written, and
// refuses one that is none of ours.
bool store_validate(store *s, duet_error *err);

// Opens for one look-up of a moment. If nobody is writing, not even SQLite's
// side files are touched; whatever was read then counts only if
// store_undisturbed afterwards.
store *store_open_look(const char *path, duet_error *err);
bool store_undisturbed(const store *s);

// "wal" where processes on one host share the file, "delete" on network file
// systems, whose memory is not shared; by statfs's f_type.
const char *store_journal(unsigned long file_system);

// The store's version, and what makes each older version the next: upgrades
// end with NULL, and the first is for a file of the first version. Earlier files are refused.
#define STORE_FIRST_VERSION 8
#define STORE_VERSION 8
#define STORE_APPLICATION 0x44554554 // "DUET"

bool migrate_upgrade(store *s, const char *const *upgrades, duet_error *err);

#endif
