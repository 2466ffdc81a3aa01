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
    SQL_COLUMN("p.uid", duet_stored_profile, uid),
    SQL_COLUMN("p.dead_reason", duet_stored_profile, replaced),
    SQL_COLUMN("w.name", duet_stored_profile, scene),
    SQL_COLUMN("w.dims", duet_stored_profile, dims),
    SQL_COLUMN("iif(w.query IS NULL, w.n, w.boxes)", duet_stored_profile, objects),
    SQL_COLUMN("coalesce(w.query, '')", duet_stored_profile, query),
    SQL_COLUMN("iif(w.query IS NULL, 0, w.n)", duet_stored_profile, items),
    SQL_COLUMN(PROFILE_IS_MOVING, duet_stored_profile, moving),
    SQL_COLUMN("da.name", duet_stored_profile, a.name),
    SQL_COLUMN("a.part", duet_stored_profile, a.part),
    SQL_COLUMN("a.driver", duet_stored_profile, a.driver),
    SQL_COLUMN("db.name", duet_stored_profile, b.name),
    SQL_COLUMN("b.part", duet_stored_profile, b.part),
    SQL_COLUMN("b.driver", duet_stored_profile, b.driver),
    SQL_COLUMN("p.share", duet_stored_profile, share),
    SQL_COLUMN("p.mode", duet_stored_profile, mode),
    SQL_COLUMN("p.variant_a", duet_stored_profile, variant_a),
    SQL_COLUMN("p.variant_b", duet_stored_profile, variant_b),
    SQL_COLUMN("p.level", duet_stored_profile, level),
    SQL_COLUMN("p.median_ns * 1e-6", duet_stored_profile, step_ms),
    SQL_COLUMN("p.low_ns * 1e-6", duet_stored_profile, low_ms),
    SQL_COLUMN("p.high_ns * 1e-6", duet_stored_profile, high_ms),
    SQL_COLUMN("p.gain", duet_stored_profile, gain),
    SQL_COLUMN("p.gain_low", duet_stored_profile, gain_low),
    SQL_COLUMN("p.gain_high", duet_stored_profile, gain_high),
    SQL_COLUMN("p.verdict", duet_stored_profile, verdict),
    SQL_COLUMN("p.rounds", duet_stored_profile, rounds),
    SQL_COLUMN("p.watched", duet_stored_profile, watched),
    SQL_COLUMN("p.disturbed", duet_stored_profile, disturbed),
    SQL_COLUMN("p.whole_ns * 1e-6", duet_stored_profile, whole_ms),
    SQL_COLUMN("p.whole_gain", duet_stored_profile, whole_gain),
    SQL_COLUMN("p.whole_gain_low", duet_stored_profile, whole_gain_low),
    SQL_COLUMN("p.whole_gain_high", duet_stored_profile, whole_gain_high),
    SQL_COLUMN("p.missed_rate", duet_stored_profile, missed_rate),
    SQL_COLUMN("p.false_rate", duet_stored_profile, false_rate),
    SQL_COLUMN("p.origin", duet_stored_profile, origin),
    SQL_COLUMN("s.id", duet_stored_profile, session),
    SQL_COLUMN("p.created_ns / 1000000000", duet_stored_profile, measured_s),
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
                   : error_set(err, DUET_STATUS_NO_MEMORY, "the profiles: no memory");
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
    SQL_COLUMN("share", duet_stored_trial, share),
    SQL_COLUMN("mode", duet_stored_trial, mode),
    SQL_COLUMN("variant_a", duet_stored_trial, variant_a),
    SQL_COLUMN("variant_b", duet_stored_trial, variant_b),
    SQL_COLUMN("(SELECT count(*) FROM sample WHERE trial_id = id)", duet_stored_trial, samples),
    SQL_COLUMN("median_ns * 1e-6", duet_stored_trial, step_ms),
    SQL_COLUMN("low_ns * 1e-6", duet_stored_trial, low_ms),
    SQL_COLUMN("high_ns * 1e-6", duet_stored_trial, high_ms),
    SQL_COLUMN("a_ns * 1e-6", duet_stored_trial, a_ms),
    SQL_COLUMN("b_ns * 1e-6", duet_stored_trial, b_ms),
    SQL_COLUMN("outcome", duet_stored_trial, outcome),
    SQL_COLUMN("reason", duet_stored_trial, reason),
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
                       "WHERE uid = ?) ORDER BY number",
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
