// SPDX-License-Identifier: MIT
#include "profiles/level_cost.h"

#include "base/clock.h"
#include "profiles/sql.h"

static void bind_key(sql *q, const profile_level_cost_key *key)
{
    sql_int(q, key->pair_id);
    sql_int(q, key->workload_id);
    sql_text(q, key->kernels);
}

static bool clear(store *s, const profile_level_cost_key *key, duet_error *err)
{
    sql q = sql_make(
        s, "DELETE FROM level_cost WHERE pair_id = ? AND workload_id = ? AND kernels = ?", err);
    bind_key(&q, key);
    return sql_run(&q);
}

static bool insert(store *s, const profile_level_cost_key *key, const profile_level_cost *cost,
                   duet_error *err)
{
    sql q = sql_make(s,
                     "INSERT INTO level_cost (pair_id, workload_id, kernels, level, step_ns, "
                     "true_pairs, missed, invented, created_ns) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                     err);
    bind_key(&q, key);
    sql_text(&q, cost->level);
    sql_real(&q, cost->step_ns);
    sql_int(&q, (int64_t)cost->true_pairs);
    sql_int(&q, (int64_t)cost->missed);
    sql_int(&q, (int64_t)cost->invented);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q);
}

bool profile_level_costs_put(store *s, const profile_level_cost_key *key,
                             const profile_level_cost *costs, uint32_t n, duet_error *err)
{
    if (!store_begin(s, err))
        return false;
    bool ok = clear(s, key, err);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = insert(s, key, &costs[i], err);
    return store_end(s, ok, err);
}

bool profile_level_costs_get(store *s, const profile_level_cost_key *key, profile_level_cost *costs,
                             uint32_t *n, duet_error *err)
{
    sql q = sql_make(s,
                     "SELECT level, step_ns, true_pairs, missed, invented FROM level_cost "
                     "WHERE pair_id = ? AND workload_id = ? AND kernels = ? ORDER BY level",
                     err);
    bind_key(&q, key);
    for (*n = 0; *n < PROFILE_LEVEL_COSTS && sql_row(&q); ++*n) {
        profile_level_cost *cost = &costs[*n];
        *cost = (profile_level_cost){.step_ns = sql_get_real(&q, 1),
                                     .true_pairs = (uint64_t)sql_get_int(&q, 2),
                                     .missed = (uint64_t)sql_get_int(&q, 3),
                                     .invented = (uint64_t)sql_get_int(&q, 4)};
        sql_copy(cost->level, sizeof cost->level, sql_get_text(&q, 0));
    }
    return sql_close(&q);
}
