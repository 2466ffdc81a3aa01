// SPDX-License-Identifier: MIT
// A CUSUM of the log ratio in units of its own deviation, with half a unit of
// slack: at a limit of twelve a steady machine raises a false alarm once in
// about a million steps, and a shift of two units is seen within ten.
#include "profiles/drift.h"

#include "profiles/sql.h"
#include "runtime/base/clock.h"

#include <math.h>

#define SMOOTHING 0.05
#define LEAST_DEVIATION 0.05 // a shift of less is not worth tuning for
#define SLACK 0.5
#define LIMIT 12.0
#define MOST_A_STEP 4.0 // so that a hiccup of one step does not raise it

static double clamp(double x, double most)
{
    return fmin(most, fmax(-most, x));
}

bool profile_drift_update(profile_drift *drift, double measured_ns, double expected_ns)
{
    if (!(measured_ns > 0 && expected_ns > 0))
        return false;
    if (drift->n++ == 0)
        drift->variance = LEAST_DEVIATION * LEAST_DEVIATION;
    double deviation = fmax(LEAST_DEVIATION, sqrt(drift->variance));
    double x = clamp(log(measured_ns / expected_ns), MOST_A_STEP * deviation);
    double off = x - drift->mean;
    drift->mean += SMOOTHING * off;
    drift->variance = (1 - SMOOTHING) * (drift->variance + SMOOTHING * off * off);
    drift->up = fmax(0, drift->up + x / deviation - SLACK);
    drift->down = fmax(0, drift->down - x / deviation - SLACK);
    return drift->up > LIMIT || drift->down > LIMIT;
}

bool profile_drift_save(store *s, const char *uid, const profile_drift *drift, duet_error *err)
{
    if (!store_begin(s, err))
        return false;
    sql q = sql_make(s,
                     "INSERT OR REPLACE INTO drift (profile_id, n, mean, variance, up, down, "
                     "at_ns) SELECT id, ?, ?, ?, ?, ?, ? FROM profile WHERE uid = ?",
                     err);
    sql_int(&q, (int64_t)drift->n);
    sql_real(&q, drift->mean);
    sql_real(&q, drift->variance);
    sql_real(&q, drift->up);
    sql_real(&q, drift->down);
    sql_int(&q, clock_calendar_ns());
    sql_text(&q, uid);
    bool ok = sql_run(&q);
    if (ok && sqlite3_changes(s->db) == 0)
        ok = error_set(err, DUET_NOT_FOUND, "%s: has no profile %s", s->path, uid);
    return store_end(s, ok, err);
}

bool profile_drift_load(store *s, const char *uid, profile_drift *drift, duet_error *err)
{
    *drift = (profile_drift){0};
    sql q = sql_make(s,
                     "SELECT d.n, d.mean, d.variance, d.up, d.down FROM drift d "
                     "JOIN profile p ON p.id = profile_id WHERE uid = ?",
                     err);
    sql_text(&q, uid);
    if (sql_row(&q))
        *drift = (profile_drift){
            .n = (uint64_t)sql_get_int(&q, 0),
            .mean = sql_get_real(&q, 1),
            .variance = sql_get_real(&q, 2),
            .up = sql_get_real(&q, 3),
            .down = sql_get_real(&q, 4),
        };
    return sql_close(&q);
}
