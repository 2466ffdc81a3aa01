// SPDX-License-Identifier: MIT
#include "profiles/duet_profiles.h"

#include "base/error.h"
#include "profiles/exchange.h"
#include "profiles/profile.h"
#include "profiles/sql.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct duet_profile_list {
    duet_stored_profile *items;
    uint32_t n;
};

// ---------------------------------------------------------------- profiles

static const sql_column profile_columns[] = {
#define STORED_PROFILE
#define COLUMN(type, member, value) SQL_COLUMN(value, duet_stored_profile, member),
#define DEVICE(member, name_, part_, driver_)                \
    SQL_COLUMN(name_, duet_stored_profile, member.name),     \
        SQL_COLUMN(part_, duet_stored_profile, member.part), \
        SQL_COLUMN(driver_, duet_stored_profile, member.driver),
#include "profiles/stored.inl"
    {0},
};

static bool fill(duet_profile_list *list, store *s, bool replaced_too, duet_error *err)
{
    sql q = sql_select(s, profile_columns, profile_entry_from, err);
    sql_text(&q, "");
    sql_int(&q, replaced_too);
    list->items = sql_rows(&q, profile_columns, sizeof *list->items, &list->n);
    return sql_close(&q);
}

duet_profile_list *duet_profile_list_create(const char *path, bool replaced_too, duet_error *err)
{
    PUBLIC_CALL(err);
    store *s = store_open(path, STORE_READ, err);
    if (!s)
        return NULL;
    duet_profile_list *list = calloc(1, sizeof *list);
    bool ok = list ? fill(list, s, replaced_too, err) && store_check_read(s, err)
                   : no_memory(err, "the profiles");
    store_close(s);
    if (ok)
        return list;
    duet_profile_list_destroy(list);
    return NULL;
}

void duet_profile_list_destroy(duet_profile_list *list)
{
    if (!list)
        return;
    free(list->items);
    free(list);
}

uint32_t duet_profile_list_get_count(const duet_profile_list *list)
{
    return list ? list->n : 0;
}

const duet_stored_profile *duet_profile_list_get_profile(const duet_profile_list *list, uint32_t i)
{
    return list && i < list->n ? &list->items[i] : NULL;
}

// ---------------------------------------------------------------- trials

static const sql_column trial_columns[] = {
#define STORED_TRIAL
#define COLUMN(type, member, value) SQL_COLUMN(value, duet_stored_trial, member),
#include "profiles/stored.inl"
    {0},
};

// None if the profile has no session.
static bool read_trials(store *s, const char *uid, duet_stored_trial **trials, uint32_t *n,
                        duet_error *err)
{
    char whole[PROFILE_ID];
    if (!profile_find(s, uid, whole, err))
        return false;
    sql q = sql_select(s, trial_columns,
                       " FROM trial WHERE session_id = (SELECT session_id FROM profile "
                       "WHERE uid = ?) AND scope = 65536 ORDER BY number",
                       err);
    sql_text(&q, whole);
    *trials = sql_rows(&q, trial_columns, sizeof **trials, n);
    return sql_close(&q);
}

bool duet_profile_get_trials(const char *path, const char *uid, duet_stored_trial **trials,
                             uint32_t *n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(uid, __func__, "uid", err) || !error_given(trials, __func__, "trials", err) ||
        !error_given(n, __func__, "n", err))
        return false;
    duet_stored_trial *list = NULL;
    uint32_t n_list = 0;
    store *s = store_open(path, STORE_READ, err);
    bool ok = s && read_trials(s, uid, &list, &n_list, err) && store_check_read(s, err);
    store_close(s);
    if (!ok) {
        free(list);
        list = NULL;
    }
    *trials = list;
    *n = ok ? n_list : 0;
    return ok;
}

// ---------------------------------------------------------------- which one is used

typedef bool profile_change(store *s, const char *uid, duet_error *err);

static bool change(const char *path, const char *uid, profile_change *by, duet_error *err)
{
    store *s = store_open(path, STORE_WRITE, err);
    bool ok = s && by(s, uid, err);
    store_close(s);
    return ok;
}

bool duet_profile_use(const char *path, const char *uid, duet_error *err)
{
    PUBLIC_CALL(err);
    return error_given(uid, __func__, "uid", err) && change(path, uid, profile_use, err);
}

bool duet_profile_forget(const char *path, const char *uid, duet_error *err)
{
    PUBLIC_CALL(err);
    return error_given(uid, __func__, "uid", err) && change(path, uid, profile_forget, err);
}

// ---------------------------------------------------------------- rows out and in

bool duet_profiles_export(const char *path, const char *file, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(file, __func__, "file", err))
        return false;
    store *s = store_open(path, STORE_READ, err);
    bool ok = s && profile_export_file(s, profile_export, file, err);
    store_close(s);
    return ok;
}

static bool import_file(store *s, FILE *in, const char *name, duet_import_counts *counts,
                        duet_error *err)
{
    profile_import_counts c;
    bool ok = profile_import(s, in, name, &c, err);
    if (ok && counts)
        *counts = (duet_import_counts){c.added, c.known};
    return ok;
}

bool duet_profiles_import(const char *path, const char *file, duet_import_counts *counts,
                          duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(file, __func__, "file", err))
        return false;
    FILE *in = fopen(file, "r");
    if (!in)
        return error_set(err, errno == ENOENT ? DUET_STATUS_NOT_FOUND : DUET_STATUS_IO_FAILED,
                         "%s: %s", file, strerror(errno));
    store *s = store_open(path, STORE_WRITE, err);
    bool ok = s && import_file(s, in, file, counts, err);
    store_close(s);
    fclose(in);
    return ok;
}
