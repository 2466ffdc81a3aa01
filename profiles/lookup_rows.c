// SPDX-License-Identifier: MIT
#include "profiles/lookup_steps.h"

#include <math.h>
#include <string.h>

bool rows_find_pair(lookup *l)
{
    sql q = sql_make(l->s,
                     "SELECT id FROM pair WHERE env_a = (SELECT id FROM env WHERE key = ?) "
                     "AND env_b = (SELECT id FROM env WHERE key = ?)",
                     l->err);
    sql_text(&q, l->env[0]);
    sql_text(&q, l->env[1]);
    l->pair_id = sql_row(&q) ? sql_get_int(&q, 0) : 0;
    return sql_close(&q);
}

// ---------------------------------------------------------------- one row

static const sql_column found_columns[] = {
    SQL_PLAN_COLUMNS(profile_found, plan),
    SQL_COLUMN("share", profile_found, share_low),
    SQL_COLUMN("share", profile_found, share_high),
#define FIGURE(type, name) SQL_COLUMN(#name, profile_found, name),
#define WORD(name) SQL_COLUMN(#name, profile_found, name),
#define COUNT(name) SQL_COUNT_COLUMN(#name, profile_found, name),
#include "profiles/profile_figures.inl"
    SQL_COLUMN("terms", profile_found, terms),
    SQL_COLUMN("created_ns", profile_found, created_ns),
    SQL_COLUMN("session_id", profile_found, session),
    SQL_COLUMN("uid", profile_found, uid),
    SQL_COLUMN("dead_reason", profile_found, unused),
    {0},
};

// Rates that nobody measured are above every limit; certified has none.
#define WITHIN(rate, most)                                                                  \
    "(" most " > 1e299 OR ((p.true_pairs IS NOT NULL OR p.level = 'certified') AND p." rate \
    " <= " most "))"
#define ACCURATE "AND " WITHIN("missed_rate", "?3") " AND " WITHIN("false_rate", "?4") " "

#define OF_WORKLOAD "profile p WHERE p.workload_id = (SELECT id FROM workload WHERE key = ?1) "

#define SAME_SEATS                                                                         \
    "AND p.pair_id IN (SELECT pair.id FROM env a JOIN pair ON env_a = a.id JOIN env b ON " \
    "env_b = b.id WHERE a.seat = ?6 AND b.seat = ?7) ORDER BY p.created_ns DESC LIMIT 1"

// The place where a query looks, and which of the rows there it takes.
typedef struct rows_query {
    const char *columns; // beside the id
    const char *of;
    const char *which;
} rows_query;

static const rows_query exact_query = {
    "", OF_WORKLOAD, "AND p.kernels = ?5 AND p.pair_id = ?6 ORDER BY p.median_ns LIMIT 1"};

static const rows_query other_driver_query = {"", OF_WORKLOAD, "AND p.kernels = ?5 " SAME_SEATS};

static const rows_query stale_query = {"", OF_WORKLOAD, "AND p.kernels <> ?5 " SAME_SEATS};

// An accuracy without limit is above every rate that is stored.
static double limit(double rate)
{
    return isfinite(rate) ? rate : 1e300;
}

// Asks for the ids of rows, with what all queries have in common bound; `key` is of the workload,
// or of its family. Only what limits the rows is in the statement, and the columns are read by
// another if there is a row: an application's start pays for each word of SQL that is compiled.
static sql ask_rows(lookup *l, const rows_query *query, const char *key)
{
    double missed = limit(l->request->max_missed_rate), added = limit(l->request->max_false_rate);
    text statement = {0};
    text_add(&statement, "SELECT p.id%s FROM %s%sAND p.objective = ?2 AND p.live = 1 %s",
             query->columns, query->of, missed < 1e299 || added < 1e299 ? ACCURATE : "",
             query->which);
    sql q = sql_make_text(l->s, &statement, l->err);
    sql_text(&q, key);
    sql_text(&q, l->request->objective);
    sql_real(&q, missed);
    sql_real(&q, added);
    sql_text(&q, l->request->kernels);
    return q;
}

// The first id; 0 if there is none.
static bool close_rows(sql *q, int64_t *id)
{
    *id = sql_row(q) ? sql_get_int(q, 0) : 0;
    return sql_close(q);
}

// False if there is no such row.
static bool read_found(sql *q, profile_found *found)
{
    if (!sql_row(q))
        return false;
    sql_read(q, 0, found_columns, found);
    if (!*found->best_mode) {
        memcpy(found->best_mode, found->plan.mode, sizeof found->best_mode);
        found->best_share = found->plan.share;
    }
    return true;
}

static bool read_row(lookup *l, int64_t id, profile_found *found)
{
    sql q = sql_select(l->s, found_columns, " FROM profile WHERE id = ?", l->err);
    sql_int(&q, id);
    read_found(&q, found);
    return sql_close(&q);
}

static bool take_row(lookup *l, int64_t id, bool *held)
{
    *held = id != 0;
    if (!*held)
        return true;
    *l->found = (profile_found){0};
    return read_row(l, id, l->found) && why_found(l, id);
}

static bool find_by_seats(lookup *l, const rows_query *query, bool *held)
{
    int64_t id;
    sql q = ask_rows(l, query, l->workload);
    sql_text(&q, l->seat[0]);
    sql_text(&q, l->seat[1]);
    return close_rows(&q, &id) && take_row(l, id, held);
}

bool rows_take_exact(lookup *l, bool *held)
{
    int64_t id;
    sql q = ask_rows(l, &exact_query, l->workload);
    sql_int(&q, l->pair_id);
    return close_rows(&q, &id) && take_row(l, id, held);
}

bool rows_take_other_driver(lookup *l, bool *held)
{
    return find_by_seats(l, &other_driver_query, held);
}

bool rows_take_stale(lookup *l, bool *held)
{
    return find_by_seats(l, &stale_query, held);
}

bool profile_read(store *s, const char *uid, profile_found *found, duet_error *err)
{
    sql q = sql_select(s, found_columns, " FROM profile WHERE uid = ?", err);
    sql_text(&q, uid);
    *found = (profile_found){.grade = PROFILE_DEFAULT};
    if (read_found(&q, found))
        found->grade = PROFILE_EXACT;
    return sql_close(&q);
}

bool rows_are_measured(lookup *l, bool *measured)
{
    sql q = sql_make(l->s,
                     "SELECT 1 FROM workload w JOIN profile p ON p.workload_id = w.id "
                     "WHERE w.family = ? AND p.live = 1 LIMIT 1",
                     l->err);
    sql_text(&q, text_chars(&l->family));
    *measured = sql_row(&q);
    return sql_close(&q);
}

// ---------------------------------------------------------------- neighbours

// CROSS: by the family first, which has few sizes.
#define OF_FAMILY "workload w CROSS JOIN profile p ON p.workload_id = w.id WHERE w.family = ?1 "
#define SAME_PAIR "AND p.kernels = ?5 AND p.pair_id = ?6 "
#define QUANTITIES ", w.n, w.occ_mean, w.occ_p99, w.size_ratio, iif(w.dims = 3, cells_z, cells_y)"
_Static_assert(NEIGHBOUR_OBJECTS == 0 && NEIGHBOUR_OCCUPANCY == 1 && NEIGHBOUR_CROWDING == 2 &&
                   NEIGHBOUR_SIZES == 3 && NEIGHBOUR_LAYERS == 4,
               "the order of the columns");

static const rows_query below_query = {QUANTITIES, OF_FAMILY,
                                       SAME_PAIR "AND w.n < ?7 ORDER BY w.n DESC"};
static const rows_query above_query = {QUANTITIES, OF_FAMILY,
                                       SAME_PAIR "AND w.n >= ?7 ORDER BY w.n"};

// From the workload's size outwards, up to the first scene that is alike.
static bool look_outwards(lookup *l, const rows_query *query, neighbour *alike)
{
    neighbours *all = &l->near;
    int64_t nearest_id = 0, alike_id = 0;
    sql q = ask_rows(l, query, text_chars(&l->family));
    sql_int(&q, l->pair_id);
    sql_int(&q, (int64_t)l->at.n);
    while (alike_id == 0 && sql_row(&q)) {
        neighbour near = {0};
        for (int i = 0; i < NEIGHBOUR_QUANTITIES; ++i)
            near.quantities[i] = sql_get_real(&q, 1 + i);
        if (!neighbour_is_there(&all->nearest) ||
            neighbour_ratio(near.quantities, all->at, NULL) <
                neighbour_ratio(all->nearest.quantities, all->at, NULL)) {
            all->nearest = near;
            nearest_id = sql_get_int(&q, 0);
        }
        if (neighbour_is_alike(near.quantities, all->at)) {
            *alike = near;
            alike_id = sql_get_int(&q, 0);
        }
    }
    return sql_close(&q) && (nearest_id == 0 || read_row(l, nearest_id, &all->nearest.found)) &&
           (alike_id == 0 || read_row(l, alike_id, &alike->found));
}

bool rows_find_neighbours(lookup *l)
{
    l->near = (neighbours){0};
    neighbour_describe(&l->at, l->near.at);
    return l->pair_id == 0 || (look_outwards(l, &below_query, &l->near.below) &&
                               look_outwards(l, &above_query, &l->near.above));
}
