// SPDX-License-Identifier: MIT
#include "profiles/profile_view.h"

#include "profiles/profile.h"
#include "profiles/sql.h"

#include <stdio.h>
#include <string.h>

// A column's name is a member's, "a.name" that of the object a. Behind it may stand a mark:
// ? a flag, ! left out if NULL, { JSON of an object, which is left out if it is none.
static cJSON *value_of(const sql *q, int column, char mark)
{
    int type = sqlite3_column_type(q->stmt, column);
    if (mark == '{') {
        const char *chars = sql_get_text(q, column);
        cJSON *object = chars ? cJSON_ParseWithOpts(chars, NULL, true) : NULL;
        if (cJSON_IsObject(object))
            return object;
        cJSON_Delete(object);
        return NULL;
    }
    if (type == SQLITE_NULL)
        return mark == '!' ? NULL : cJSON_CreateNull();
    if (mark == '?')
        return cJSON_CreateBool(sql_get_int(q, column) != 0);
    return type == SQLITE_TEXT ? cJSON_CreateString(sql_get_text(q, column))
                               : cJSON_CreateNumber(sql_get_real(q, column));
}

static void add_member(cJSON *o, const char *name, cJSON *value)
{
    char part[64];
    const char *point = strchr(name, '.');
    snprintf(part, sizeof part, "%.*s", (int)strcspn(name, ".?!{"), name);
    if (!point) {
        cJSON_AddItemToObject(o, part, value);
        return;
    }
    cJSON *inner = cJSON_GetObjectItemCaseSensitive(o, part);
    add_member(inner ? inner : cJSON_AddObjectToObject(o, part), point + 1, value);
}

static void add_members(cJSON *o, const sql *q)
{
    for (int i = 0; i < sqlite3_column_count(q->stmt); ++i) {
        const char *name = sqlite3_column_name(q->stmt, i);
        cJSON *value = value_of(q, i, name[strlen(name) - 1]);
        if (value)
            add_member(o, name, value);
    }
}

// The rows that are left, each an object at the list's end. Closes the statement.
static bool add_rows(cJSON *list, sql *q)
{
    while (sql_row(q)) {
        cJSON *o = cJSON_CreateObject();
        add_members(o, q);
        cJSON_AddItemToArray(list, o);
    }
    return sql_close(q);
}

// ---------------------------------------------------------------- statements

// clang-format off
#define WHEN(ns) \
    "iif(" ns " > 0, coalesce(strftime('%Y-%m-%d %H:%M', " ns " / 1000000000, 'unixepoch'), ''), '')"
#define PLAN(t) \
    t ".share / 65536.0 AS share, " t ".mode AS mode, " \
    t ".variant_a AS variant_a, " t ".variant_b AS variant_b"
#define DEVICE(device, env, name) \
    device ".name AS '" name ".name', coalesce(" env ".part, '') AS '" name ".part', " \
    env ".driver AS '" name ".driver', " env ".platform_version AS '" name ".platform_version', "
// A figure that is known if the device which A and B are parts of was raced; if rates were
// measured.
#define OF_WHOLE(value, name) "iif(p.whole_ns > 0, p." value ", NULL) AS " name ", "
#define OF_RATES(name) "iif(p.true_pairs >= 1, p." name ", NULL) AS " name ", "
#define OF_SESSION(t) t ".session_id = (SELECT session_id FROM profile WHERE uid = ?)"

static const char profile_names[] =
    "SELECT p.uid AS uid, p.live AS 'live?', p.dead_reason AS 'dead_reason!', "
    "coalesce(w.name, '') AS scene, w.family AS family, w.dims AS dims, w.query AS 'query!', "
    "iif(w.query IS NULL, NULL, w.n) AS 'items!', " PROFILE_IS_MOVING " AS 'moving?', "
    "iif(w.query IS NULL, w.n, w.boxes) AS objects, "
    DEVICE("da", "a", "a")
    DEVICE("db", "b", "b")
    "p.share = 0 AND coalesce(p.best_share, 0) = 0 AND da.name = db.name AND "
    "coalesce(a.part, '') = coalesce(b.part, '') AND a.driver = b.driver AS 'one_device?', "
    PLAN("p") ", p.level AS level, "
    "p.median_ns * 1e-6 AS ms, p.low_ns * 1e-6 AS low_ms, p.high_ns * 1e-6 AS high_ms, "
    "p.gain AS gain, p.gain_low AS gain_low, p.gain_high AS gain_high, p.verdict AS verdict, "
    "coalesce(p.rounds, 0) AS rounds, p.watched AS watched, p.disturbed AS disturbed, "
    "p.single_ns * 1e-6 AS single_ms, "
    OF_WHOLE("whole_ns * 1e-6", "whole_ms")
    OF_WHOLE("whole_gain", "whole_gain")
    OF_WHOLE("whole_gain_low", "whole_gain_low")
    OF_WHOLE("whole_gain_high", "whole_gain_high")
    OF_RATES("missed_rate")
    OF_RATES("false_rate")
    OF_RATES("true_pairs")
    "p.terms AS 'terms{', p.objective AS objective, p.origin AS origin, p.kernels AS kernels, "
    WHEN("p.created_ns") " AS created, s.host IS ?3 AS 'here?'";

static const char session_of_profile[] =
    "SELECT s.id AS id, state, strategy, options AS 'options{', script.body AS 'script!', "
    "tool_version, host, seed, resumed, "
    "(SELECT coalesce(sum(launches), 0) FROM trial WHERE session_id = s.id) AS launches, "
    "load, timer_ns, "
    WHEN("started_ns") " AS started, " WHEN("coalesce(ended_ns, 0)") " AS ended "
    "FROM session s LEFT JOIN script ON script.key = s.script "
    "WHERE s.id = (SELECT session_id FROM profile WHERE uid = ?)";

static const char trials_of_profile[] =
    "SELECT number, " PLAN("t") ", level, outcome, reason AS 'reason!', "
    "(SELECT count(*) FROM sample WHERE trial_id = t.id) AS samples, outliers, "
    "median_ns * 1e-6 AS ms, low_ns * 1e-6 AS low_ms, high_ns * 1e-6 AS high_ms, "
    "a_ns * 1e-6 AS a_ms, b_ns * 1e-6 AS b_ms, terms AS 'terms{' "
    "FROM trial t WHERE " OF_SESSION("t") " AND scope = 65536 ORDER BY number";

// In the order of their time, a plan is on the front if it takes less energy than all before it.
static const char front_of_profile[] =
    "WITH plan AS (SELECT share, mode, variant_a, variant_b, "
    "avg(coalesce(median_ns * 1e-6, 0)) AS ms, avg(json_extract(terms, '$.joules')) AS joules "
    "FROM trial t WHERE " OF_SESSION("t") " AND iif(json_valid(terms), "
    "json_type(terms, '$.joules') IN ('integer', 'real') AND "
    "json_extract(terms, '$.joules') > 0, 0) "
    "GROUP BY share, mode, variant_a, variant_b), "
    "front AS (SELECT *, min(joules) OVER (ORDER BY ms, joules "
    "ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING) AS least FROM plan) "
    "SELECT " PLAN("front") ", ms, joules FROM front "
    "WHERE least IS NULL OR joules < least ORDER BY ms, joules";
// clang-format on

// ---------------------------------------------------------------- what they give

bool profile_view_add(store *s, const char *uid, bool dead_too, const char *more, cJSON *list,
                      duet_error *err)
{
    char host[PROFILE_SHA];
    text statement = {0};
    profile_host(host);
    text_add(&statement, "%s%s%s", profile_names, more, profile_entry_from);
    sql q = sql_make_text(s, &statement, err);
    sql_text(&q, uid);
    sql_int(&q, dead_too);
    sql_text(&q, host);
    return add_rows(list, &q);
}

// Adds the rows of a statement about the profile of that uid.
static bool add_rows_of(store *s, const char *statement, const char *uid, cJSON *list,
                        duet_error *err)
{
    sql q = sql_make(s, statement, err);
    sql_text(&q, uid);
    return add_rows(list, &q);
}

bool profile_view_add_session(store *s, const char *uid, cJSON *o, duet_error *err)
{
    cJSON *list = cJSON_CreateArray();
    bool ok = add_rows_of(s, session_of_profile, uid, list, err);
    if (cJSON_GetArraySize(list) > 0)
        cJSON_AddItemToObject(o, "session", cJSON_DetachItemFromArray(list, 0));
    cJSON_Delete(list);
    return ok;
}

bool profile_view_add_trials(store *s, const char *uid, cJSON *o, duet_error *err)
{
    cJSON *front = cJSON_CreateArray();
    cJSON *trials = cJSON_AddArrayToObject(o, "trials");
    bool ok = add_rows_of(s, trials_of_profile, uid, trials, err) &&
              add_rows_of(s, front_of_profile, uid, front, err);
    if (cJSON_GetArraySize(front) > 0)
        cJSON_AddItemToObject(o, "pareto", front);
    else
        cJSON_Delete(front);
    return ok;
}
