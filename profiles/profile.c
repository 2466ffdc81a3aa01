// SPDX-License-Identifier: MIT
#include "profiles/profile.h"

#include "base/clock.h"
#include "profiles/json.h"
#include "profiles/sql.h"

static bool retire_live(store *s, const profile_row *row, const char *reason, duet_error *err)
{
    sql q = sql_make(s,
                     "UPDATE profile SET live = 0, dead_reason = ? WHERE workload_id = ? AND "
                     "pair_id = ? AND objective = ? AND kernels = ? AND level = ? AND live = 1",
                     err);
    sql_text(&q, reason);
    sql_int(&q, row->workload_id);
    sql_int(&q, row->pair_id);
    sql_text(&q, row->objective);
    sql_text(&q, row->kernels);
    sql_text(&q, row->plan.level);
    return sql_run(&q);
}

static bool insert(store *s, const profile_row *row, const char *uid, duet_error *err)
{
    sql q = sql_make(
        s,
        "INSERT INTO profile (uid, pair_id, workload_id, kernels, objective, level, share, mode, "
        "variant_a, variant_b, median_ns, low_ns, high_ns, gain, gain_low, gain_high, verdict, "
        "missed_rate, false_rate, true_pairs, single_ns, best_share, best_mode, terms, origin, "
        "session_id, trial, created_ns, live) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, nullif(?, -1), "
        "nullif(?, 0.0), ?, ?, ?, ?, ?, nullif(?, -1), ?, 1)",
        err);
    sql_text(&q, uid);
    sql_int(&q, row->pair_id);
    sql_int(&q, row->workload_id);
    sql_text(&q, row->kernels);
    sql_text(&q, row->objective);
    sql_text(&q, row->plan.level);
    sql_int(&q, row->plan.share);
    sql_text(&q, row->plan.mode);
    sql_text(&q, row->plan.variant_a);
    sql_text(&q, row->plan.variant_b);
    sql_real(&q, row->median_ns);
    sql_real(&q, row->low_ns);
    sql_real(&q, row->high_ns);
    sql_real(&q, row->gain);
    sql_real(&q, row->gain_low);
    sql_real(&q, row->gain_high);
    sql_text(&q, row->verdict);
    sql_real(&q, row->missed_rate);
    sql_real(&q, row->false_rate);
    sql_int(&q, row->true_pairs);
    sql_real(&q, row->single_ns);
    sql_int(&q, row->best_mode ? row->best_share : row->plan.share);
    sql_text(&q, row->best_mode ? row->best_mode : row->plan.mode);
    sql_text(&q, row->terms);
    sql_text(&q, row->origin);
    sql_text(&q, row->session);
    sql_int(&q, row->trial_number);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q);
}

bool profile_put(store *s, const profile_row *row, const char *reason, duet_error *err)
{
    char uid[PROFILE_ID];
    if (row->terms && !json_check_object("a profile's terms", row->terms, err))
        return false;
    if (!profile_new_id(uid, err) || !store_begin(s, err))
        return false;
    bool ok = retire_live(s, row, reason, err);
    ok = ok && insert(s, row, uid, err);
    return store_end(s, ok, err);
}
