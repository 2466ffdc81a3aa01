// SPDX-License-Identifier: MIT
#include "profiles/surface.h"

#include "base/error.h"
#include "profiles/sql.h"

#include <stdlib.h>

#define LEAST_PLANS "16" // a mode's search with a coarse grid

// The time of a launch that no other program disturbed; a file may say anything. Eleven days are
// 1e15 ns.
#define IS_SOUND                                                                           \
    "x.total_ns BETWEEN 1 AND 1000000000000000 AND x.a_ns BETWEEN 0 AND 1000000000000000 " \
    "AND x.b_ns BETWEEN 0 AND 1000000000000000 AND x.flags & 4 = 0"

static const sql_column surface_columns[] = {
    SQL_COLUMN("coalesce(w.name, '')", profile_surface, scene),
    SQL_COLUMN("w.n", profile_surface, n),
    SQL_COLUMN("coalesce(w.query, '')", profile_surface, query),
    SQL_COLUMN("w.boxes", profile_surface, boxes),
    SQL_COLUMN("trim(da.name || ' ' || coalesce(ea.part, ''))", profile_surface, a),
    SQL_COLUMN("trim(db.name || ' ' || coalesce(eb.part, ''))", profile_surface, b),
    SQL_COLUMN("t.level", profile_surface, level),
    SQL_COLUMN("count(DISTINCT t.variant_a || ',' || t.variant_b) > 1", profile_surface, joint),
    SQL_COLUMN("max(t.variant_a)", profile_surface, variant_a),
    SQL_COLUMN("max(t.variant_b)", profile_surface, variant_b),
    SQL_COLUMN("s.pair_id", profile_surface, pair_id),
    SQL_COLUMN("s.workload_id", profile_surface, workload_id),
    SQL_COLUMN("s.kernels", profile_surface, kernels),
    SQL_COLUMN("s.host", profile_surface, host),
    {0},
};

#define SURFACES(which, each)                                                                     \
    " FROM trial t JOIN session s ON s.id = t.session_id"                                         \
    " JOIN workload w ON w.id = s.workload_id JOIN pair ON pair.id = s.pair_id"                   \
    " JOIN env ea ON ea.id = env_a JOIN device da ON da.id = ea.device_id"                        \
    " JOIN env eb ON eb.id = env_b JOIN device db ON db.id = eb.device_id"                        \
    " WHERE t.outcome = 'ok' AND t.scope = 65536" which                                           \
    " AND EXISTS (SELECT 1 FROM sample x WHERE x.trial_id = t.id"                                 \
    " AND x.flags & 1 = 0 AND " IS_SOUND ")"                                                      \
    " GROUP BY s.pair_id, s.workload_id, s.kernels, s.host, t.level" each                         \
    " HAVING min(t.share) = 0 AND max(t.share) = 65536"                                           \
    " AND count(DISTINCT t.mode || t.share || t.variant_a || ',' || t.variant_b) >= " LEAST_PLANS \
    " ORDER BY w.name, w.n, w.query, s.pair_id, s.kernels, s.host"

static profile_surface *read_surfaces(store *s, const char *from, uint32_t *n, bool *ok,
                                      duet_error *err)
{
    sql q = sql_select(s, surface_columns, from, err);
    profile_surface *surfaces = sql_rows(&q, surface_columns, sizeof *surfaces, n);
    *ok = sql_close(&q) && *ok;
    return surfaces;
}

bool profile_surfaces_get(store *s, profile_surface **surfaces, uint32_t *n, duet_error *err)
{
    static const char shares[] =
        SURFACES("", ", t.variant_a, t.variant_b") ", t.variant_a, t.variant_b";
    static const char joint[] = SURFACES(" AND s.strategy = 'brute'", "");
    uint32_t n_joint = 0;
    bool ok = true;
    *surfaces = read_surfaces(s, shares, n, &ok, err);
    profile_surface *more = ok ? read_surfaces(s, joint, &n_joint, &ok, err) : NULL;
    profile_surface *all = realloc(*surfaces, (*n + n_joint + 1) * sizeof *all);
    *surfaces = all ? all : *surfaces;
    for (uint32_t i = 0; all && i < n_joint; ++i)
        if (more[i].joint) // brute without kernels to vary is of shares alone
            all[(*n)++] = more[i];
    free(more);
    return ok && (all || no_memory(err, "surfaces"));
}

static const sql_column launch_columns[] = {
    SQL_COLUMN("t.share", profile_launch, share),
    SQL_COLUMN("iif(t.share IN (0, 65536), 'own', t.mode) AS mode", profile_launch, mode),
    SQL_COLUMN("iif(t.share = 0, '', t.variant_a)", profile_launch, variant_a),
    SQL_COLUMN("iif(t.share = 65536, '', t.variant_b)", profile_launch, variant_b),
    SQL_COLUMN("x.flags & 1 AS warm_up", profile_launch, warm_up),
    SQL_COLUMN("x.total_ns", profile_launch, total_ns),
    SQL_COLUMN("x.a_ns", profile_launch, a_ns),
    SQL_COLUMN("x.b_ns", profile_launch, b_ns),
    {0},
};

#define LAUNCHES(which)                                         \
    " FROM sample x JOIN trial t ON t.id = x.trial_id"          \
    " JOIN session s ON s.id = t.session_id"                    \
    " WHERE t.outcome = 'ok' AND t.scope = 65536 AND " IS_SOUND \
    " AND s.pair_id = ? AND s.workload_id = ?"                  \
    " AND s.kernels = ? AND s.host = ? AND t.level = ?" which " ORDER BY 2, 1, 3, 4, 5, 6"

bool profile_surface_launches(store *s, const profile_surface *surface, profile_launch **launches,
                              uint32_t *n, duet_error *err)
{
    sql q = sql_select(s, launch_columns,
                       surface->joint ? LAUNCHES(" AND s.strategy = 'brute'")
                                      : LAUNCHES(" AND t.variant_a = ? AND t.variant_b = ?"),
                       err);
    sql_int(&q, surface->pair_id);
    sql_int(&q, surface->workload_id);
    sql_text(&q, surface->kernels);
    sql_text(&q, surface->host);
    sql_text(&q, surface->level);
    if (!surface->joint) {
        sql_text(&q, surface->variant_a);
        sql_text(&q, surface->variant_b);
    }
    *launches = sql_rows(&q, launch_columns, sizeof **launches, n);
    return sql_close(&q);
}
