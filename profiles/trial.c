// SPDX-License-Identifier: MIT
#include "profiles/trial.h"

#include "base/clock.h"
#include "profiles/json.h"
#include "profiles/sql.h"

#include <stdlib.h>
#include <string.h>

// Statistics exist only of a trial that was measured.
static void bind_statistic(sql *q, const profile_trial *trial, double value)
{
    if (strcmp(trial->outcome, "ok") == 0)
        sql_real(q, value);
    else
        sql_text(q, NULL);
}

static uint32_t count_launches(const profile_trial *trial)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < trial->n_samples; ++i)
        n += (trial->samples[i].flags & PROFILE_SAMPLE_WARM_UP) == 0;
    return n;
}

static bool insert_trial(store *s, const char *session, int64_t number, const profile_trial *trial,
                         duet_error *err)
{
    sql q = sql_make(s,
                     "INSERT INTO trial (session_id, number, share, mode, level, variant_a, "
                     "variant_b, outcome, reason, build_ms, launches, outliers, median_ns, mad_ns, "
                     "low_ns, high_ns, a_ns, b_ns, terms, created_ns) "
                     "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                     err);
    sql_text(&q, session);
    sql_int(&q, number);
    sql_int(&q, trial->plan.share);
    sql_text(&q, trial->plan.mode);
    sql_text(&q, trial->plan.level);
    sql_text(&q, trial->plan.variant_a);
    sql_text(&q, trial->plan.variant_b);
    sql_text(&q, trial->outcome);
    sql_text(&q, trial->reason);
    sql_real(&q, trial->build_ms);
    sql_int(&q, count_launches(trial));
    sql_int(&q, trial->outliers);
    bind_statistic(&q, trial, trial->median_ns);
    bind_statistic(&q, trial, trial->mad_ns);
    bind_statistic(&q, trial, trial->low_ns);
    bind_statistic(&q, trial, trial->high_ns);
    bind_statistic(&q, trial, trial->a_ns);
    bind_statistic(&q, trial, trial->b_ns);
    sql_text(&q, trial->terms);
    sql_int(&q, clock_calendar_ns());
    return sql_run(&q);
}

static bool insert_samples(store *s, int64_t trial_id, const profile_trial *trial, duet_error *err)
{
    sql q = sql_make(s, "INSERT INTO sample VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", err);
    for (uint32_t i = 0; i < trial->n_samples; ++i) {
        const profile_sample *sample = &trial->samples[i];
        sql_again(&q);
        sql_int(&q, trial_id);
        sql_int(&q, i);
        sql_int(&q, sample->total_ns);
        sql_int(&q, sample->a_ns);
        sql_int(&q, sample->b_ns);
        sql_int(&q, sample->transfer_ns);
        sql_int(&q, sample->merge_ns);
        sql_int(&q, sample->flags);
        sql_int(&q, sample->at_ns);
        sql_row(&q);
    }
    return sql_close(&q);
}

bool profile_trial_add(store *s, const char *session, const profile_trial *trial,
                       const char *search_state, int64_t *number, duet_error *err)
{
    if (trial->terms && !json_check_object("a trial's terms", trial->terms, err))
        return false;
    if (!store_begin(s, err))
        return false;
    bool ok = profile_session_save(s, session, search_state, err);
    ok = ok && sql_find(s, "SELECT count(*) FROM trial WHERE session_id = ?", session, number, err);
    ok = ok && insert_trial(s, session, *number, trial, err);
    ok = ok && insert_samples(s, sqlite3_last_insert_rowid(s->db), trial, err);
    return store_end(s, ok, err);
}

bool profile_trial_find(store *s, const char *session, const profile_plan *plan, int64_t *number,
                        duet_error *err)
{
    sql q =
        sql_make(s,
                 "SELECT coalesce(max(number), -1) FROM trial WHERE session_id = ? AND "
                 "share = ? AND mode = ? AND variant_a = ? AND variant_b = ? AND outcome = 'ok'",
                 err);
    sql_text(&q, session);
    sql_int(&q, plan->share);
    sql_text(&q, plan->mode);
    sql_text(&q, plan->variant_a);
    sql_text(&q, plan->variant_b);
    *number = sql_row(&q) ? sql_get_int(&q, 0) : -1;
    return sql_close(&q);
}

// ------------------------------------------------------------------- reading

typedef struct sample_list {
    profile_sample *samples;
    uint32_t n;
    uint32_t capacity;
} sample_list;

static bool make_room(sample_list *list, duet_error *err)
{
    if (list->n < list->capacity)
        return true;
    uint32_t capacity = list->capacity ? 2 * list->capacity : 64;
    profile_sample *samples = realloc(list->samples, capacity * sizeof *samples);
    if (!samples)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%u samples: no memory", capacity);
    list->samples = samples;
    list->capacity = capacity;
    return true;
}

static bool read_samples(store *s, int64_t trial_id, sample_list *list, duet_error *err)
{
    sql q = sql_make(s,
                     "SELECT total_ns, a_ns, b_ns, transfer_ns, merge_ns, flags, at_ns "
                     "FROM sample WHERE trial_id = ? ORDER BY number",
                     err);
    sql_int(&q, trial_id);
    list->n = 0;
    bool ok = true;
    while (ok && sql_row(&q)) {
        ok = make_room(list, err);
        if (ok)
            list->samples[list->n++] = (profile_sample){
                .total_ns = sql_get_int(&q, 0),
                .a_ns = sql_get_int(&q, 1),
                .b_ns = sql_get_int(&q, 2),
                .transfer_ns = sql_get_int(&q, 3),
                .merge_ns = sql_get_int(&q, 4),
                .flags = (uint32_t)sql_get_int(&q, 5),
                .at_ns = sql_get_int(&q, 6),
            };
    }
    return sql_close(&q) && ok;
}

static profile_trial read_trial(const sql *q)
{
    profile_trial trial = {
        .plan.share = (uint32_t)sql_get_int(q, 2),
        .outcome = sql_get_text(q, 7),
        .reason = sql_get_text(q, 8),
        .build_ms = sql_get_real(q, 9),
        .outliers = (uint32_t)sql_get_int(q, 10),
        .median_ns = sql_get_real(q, 11),
        .mad_ns = sql_get_real(q, 12),
        .low_ns = sql_get_real(q, 13),
        .high_ns = sql_get_real(q, 14),
        .a_ns = sql_get_real(q, 15),
        .b_ns = sql_get_real(q, 16),
        .terms = sql_get_text(q, 17),
    };
    sql_copy(trial.plan.mode, sizeof trial.plan.mode, sql_get_text(q, 3));
    sql_copy(trial.plan.level, sizeof trial.plan.level, sql_get_text(q, 4));
    sql_copy(trial.plan.variant_a, sizeof trial.plan.variant_a, sql_get_text(q, 5));
    sql_copy(trial.plan.variant_b, sizeof trial.plan.variant_b, sql_get_text(q, 6));
    return trial;
}

bool profile_trial_each(store *s, const char *session, profile_trial_visit *visit, void *context,
                        duet_error *err)
{
    sql q = sql_make(s,
                     "SELECT id, number, share, mode, level, variant_a, variant_b, outcome, "
                     "reason, build_ms, outliers, median_ns, mad_ns, low_ns, high_ns, a_ns, b_ns, "
                     "terms FROM trial WHERE session_id = ? ORDER BY number",
                     err);
    sql_text(&q, session);
    sample_list list = {0};
    bool ok = true;
    bool more = true;
    while (ok && more && sql_row(&q)) {
        ok = read_samples(s, sql_get_int(&q, 0), &list, err);
        profile_trial trial = read_trial(&q);
        trial.samples = list.samples;
        trial.n_samples = list.n;
        more = ok && visit(context, sql_get_int(&q, 1), &trial);
    }
    free(list.samples);
    return sql_close(&q) && ok;
}
