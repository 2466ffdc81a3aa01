// SPDX-License-Identifier: MIT
#include "profiles/level_cost.h"

#include "base/clock.h"
#include "profiles/sql.h"

static void bind_cost_key(sql *q, const profile_level_cost_key *key)
{
    sql_int(q, key->pair_id);
    sql_int(q, key->workload_id);
    sql_text(q, key->kernels);
}

static bool clear_costs(store *s, const profile_level_cost_key *key, duet_error *err)
{
    sql q = sql_make(
        s, "DELETE FROM level_cost WHERE pair_id = ? AND workload_id = ? AND kernels = ?", err);
    bind_cost_key(&q, key);
    return sql_run(&q);
}

static const sql_column cost_columns[] = {
    SQL_COLUMN("level", profile_level_cost, level),
    SQL_COLUMN("step_ns", profile_level_cost, step_ns),
    SQL_COLUMN("true_pairs", profile_level_cost, true_pairs),
    SQL_COLUMN("missed", profile_level_cost, missed),
    SQL_COLUMN("invented", profile_level_cost, invented),
    {0},
};

static bool insert_cost(store *s, const profile_level_cost_key *key, const profile_level_cost *cost,
                        duet_error *err)
{
    sql q = sql_insert(s, "level_cost", cost_columns, "pair_id, workload_id, kernels, created_ns",
                       "", err);
    sql_bind(&q, cost_columns, cost);
    bind_cost_key(&q, key);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q);
}

bool profile_level_costs_put(store *s, const profile_level_cost_key *key,
                             const profile_level_cost *costs, uint32_t n, duet_error *err)
{
    if (!store_begin(s, err))
        return false;
    bool ok = clear_costs(s, key, err);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = insert_cost(s, key, &costs[i], err);
    return store_end(s, ok, err);
}

bool profile_level_costs_get(store *s, const profile_level_cost_key *key, profile_level_cost *costs,
                             uint32_t *n, duet_error *err)
{
    sql q = sql_select(
        s, cost_columns,
        " FROM level_cost WHERE pair_id = ? AND workload_id = ? AND kernels = ? ORDER BY level",
        err);
    bind_cost_key(&q, key);
    for (*n = 0; *n < PROFILE_LEVEL_COSTS && sql_row(&q); ++*n)
        sql_read(&q, 0, cost_columns, &costs[*n]);
    return sql_close(&q);
}
