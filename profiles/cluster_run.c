// SPDX-License-Identifier: MIT
#include "profiles/cluster_run.h"

#include "base/clock.h"
#include "profiles/sql.h"

#include <inttypes.h>
#include <math.h>

// ---------------------------------------------------------------- in

static const sql_column fabric_columns[] = {
    SQL_COLUMN("mpi", profile_fabric, mpi),     SQL_COLUMN("place", profile_fabric, place),
    SQL_COLUMN("hosts", profile_fabric, hosts), SQL_COLUMN("ranks", profile_fabric, ranks),
    SQL_COLUMN("times", profile_fabric, times), {0},
};

static const sql_column run_columns[] = {
    SQL_COLUMN("scene", profile_cluster_run, scene),
    SQL_COLUMN("dims", profile_cluster_run, dims),
    SQL_COLUMN("n", profile_cluster_run, n),
    SQL_COLUMN("level", profile_cluster_run, level),
    SQL_COLUMN("parts", profile_cluster_run, parts),
    SQL_COLUMN("resident", profile_cluster_run, resident),
    SQL_COLUMN("steps", profile_cluster_run, steps),
    SQL_COLUMN("median_ns", profile_cluster_run, median_ns),
    SQL_COLUMN("low_ns", profile_cluster_run, low_ns),
    SQL_COLUMN("high_ns", profile_cluster_run, high_ns),
    {0},
};

static const sql_column rank_columns[] = {
    SQL_COLUMN("devices", profile_cluster_rank, devices),
    SQL_COLUMN("n", profile_cluster_rank, n),
    SQL_COLUMN("ghosts", profile_cluster_rank, ghosts),
    SQL_COLUMN("pairs", profile_cluster_rank, pairs),
    SQL_COLUMN("sent_bytes", profile_cluster_rank, sent_bytes),
    SQL_COLUMN("busy_ns", profile_cluster_rank, busy_ns),
    SQL_COLUMN("wait_ns", profile_cluster_rank, wait_ns),
    {0},
};

static bool put_fabric(store *s, const profile_fabric *fabric, int64_t *id, duet_error *err)
{
    char key[PROFILE_SHA];
    if (!profile_fabric_key(fabric, key, err) ||
        (fabric->times && !sql_check_object("a fabric's times", fabric->times, err)))
        return false;
    sql q = sql_insert(s, "fabric", fabric_columns, "key, latency_ns, byte_ns, measured_ns",
                       " ON CONFLICT (key) DO UPDATE SET latency_ns = excluded.latency_ns, "
                       "byte_ns = excluded.byte_ns, times = excluded.times, "
                       "measured_ns = excluded.measured_ns",
                       err);
    sql_bind(&q, fabric_columns, fabric);
    sql_text(&q, key);
    sql_real(&q, fabric->latency_ns > 0 ? fabric->latency_ns : NAN);
    sql_real(&q, fabric->byte_ns > 0 ? fabric->byte_ns : NAN);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q) && sql_find(s, "SELECT id FROM fabric WHERE key = ?", key, id, err);
}

static bool put_run(store *s, int64_t fabric_id, const profile_cluster_run *run, const char *uid,
                    int64_t *id, duet_error *err)
{
    sql q = sql_insert(s, "cluster_run", run_columns, "uid, fabric_id, created_ns", "", err);
    sql_bind(&q, run_columns, run);
    sql_text(&q, uid);
    sql_int(&q, fabric_id);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q) && sql_find(s, "SELECT id FROM cluster_run WHERE uid = ?", uid, id, err);
}

static bool put_rank(store *s, int64_t run_id, uint32_t number, const profile_cluster_rank *rank,
                     duet_error *err)
{
    sql q = sql_insert(s, "cluster_rank", rank_columns, "run_id, number", "", err);
    sql_bind(&q, rank_columns, rank);
    sql_int(&q, run_id);
    sql_int(&q, number);
    return sql_run(&q);
}

bool cluster_run_put(store *s, const profile_fabric *fabric, const profile_cluster_run *run,
                     const profile_cluster_rank *ranks, char uid[PROFILE_ID], duet_error *err)
{
    int64_t fabric_id = 0, id = 0;
    if (!profile_new_id(uid, err) || !store_begin(s, err))
        return false;
    bool ok = put_fabric(s, fabric, &fabric_id, err) && put_run(s, fabric_id, run, uid, &id, err);
    for (uint32_t i = 0; ok && i < fabric->ranks; ++i)
        ok = put_rank(s, id, i, &ranks[i], err);
    return store_end(s, ok, err);
}

// ---------------------------------------------------------------- as people see them

// But those of the run and of the fabric.
static const sql_column entry_columns[] = {
    SQL_COLUMN("r.id", cluster_run_entry, id),
    SQL_COLUMN("r.uid", cluster_run_entry, uid),
    SQL_COLUMN("r.created_ns", cluster_run_entry, created_ns),
    SQL_COLUMN("coalesce(f.latency_ns, 0)", cluster_run_entry, fabric.latency_ns),
    SQL_COLUMN("coalesce(f.byte_ns, 0)", cluster_run_entry, fabric.byte_ns),
    SQL_COLUMN("f.measured_ns", cluster_run_entry, measured_ns),
    SQL_COLUMN("(SELECT sum(busy_ns) / sum(busy_ns + wait_ns) FROM cluster_rank "
               "WHERE run_id = r.id)",
               cluster_run_entry, efficiency),
    {0},
};

bool cluster_run_each(store *s, const char *uid, cluster_run_visit *visit, void *context,
                      duet_error *err)
{
    text rest = {0};
    text_add(&rest, ", ");
    sql_add_names(&rest, "r.", run_columns);
    text_add(&rest, ", ");
    sql_add_names(&rest, "f.", fabric_columns);
    text_add(&rest, " FROM cluster_run r JOIN fabric f ON f.id = r.fabric_id "
                    "WHERE substr(r.uid, 1, length(?1)) = ?1 ORDER BY r.created_ns, r.uid");
    bool ok = text_ok(&rest, err);
    sql q = sql_select(s, entry_columns, text_chars(&rest), err);
    sql_text(&q, uid ? uid : "");
    for (bool more = ok; more && sql_row(&q);) {
        cluster_run_entry entry = {0};
        int at = sql_read(&q, 0, entry_columns, &entry);
        at = sql_read(&q, at, run_columns, &entry.run);
        sql_read(&q, at, fabric_columns, &entry.fabric);
        more = visit(context, &entry);
    }
    text_free(&rest);
    return sql_close(&q) && ok;
}

bool cluster_rank_each(store *s, int64_t run_id, cluster_rank_visit *visit, void *context,
                       duet_error *err)
{
    sql q = sql_select(s, rank_columns,
                       ", number FROM cluster_rank WHERE run_id = ? ORDER BY number", err);
    sql_int(&q, run_id);
    for (bool more = true; more && sql_row(&q);) {
        profile_cluster_rank row = {0};
        int rest = sql_read(&q, 0, rank_columns, &row);
        more = visit(context, (uint32_t)sql_get_int(&q, rest), &row);
    }
    return sql_close(&q);
}

bool cluster_run_find(store *s, const char *uid, char whole[PROFILE_ID], duet_error *err)
{
    int64_t n = 0;
    sql q = sql_make(s,
                     "SELECT uid FROM cluster_run WHERE substr(uid, 1, length(?1)) = ?1 AND NOT "
                     "EXISTS (SELECT 1 FROM profile WHERE substr(uid, 1, length(?1)) = ?1)",
                     err);
    sql_text(&q, uid);
    *whole = '\0';
    for (; sql_row(&q); ++n)
        sql_copy(whole, PROFILE_ID, sql_get_text(&q, 0));
    return sql_close(&q) &&
           (n < 2 || error_set(err, DUET_STATUS_BAD_ARGUMENT,
                               "%s: %" PRId64 " runs of clusters begin with '%s'; give more digits",
                               s->path, n, uid));
}

bool cluster_run_forget(store *s, const char *whole, duet_error *err)
{
    if (!store_begin(s, err))
        return false;
    sql q = sql_make(s, "DELETE FROM cluster_run WHERE uid = ?", err);
    sql_text(&q, whole);
    return store_end(s, sql_run(&q) && store_audit(s, "forget", whole, err), err);
}
