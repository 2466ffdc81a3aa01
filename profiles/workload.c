// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "profiles/workload.h"

#include "profiles/sql.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_words(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

// The words sorted, each once, a space between.
static void add_words(text *t, const char *words)
{
    enum { MAX_WORDS = 32 };
    text copy = {0};
    text_add(&copy, "%s", words ? words : "");
    const char *list[MAX_WORDS];
    size_t n = 0;
    char *rest = NULL;
    char *word = copy.chars ? strtok_r(copy.chars, " ", &rest) : NULL;
    for (; word && n < MAX_WORDS; word = strtok_r(NULL, " ", &rest))
        list[n++] = word;
    qsort(list, n, sizeof list[0], compare_words);
    for (size_t i = 0; i < n; ++i)
        if (i == 0 || strcmp(list[i], list[i - 1]) != 0)
            text_add(t, i == 0 ? "%s" : " %s", list[i]);
    text_free(&copy);
}

static void add_kind(text *t, const profile_workload *w)
{
    text_add(t, "%uD %s%s, level %s, effects: ", w->dims, w->shape, w->rotated ? " rotated" : "",
             w->level);
    add_words(t, w->effects && *w->effects ? w->effects : "none");
}

// To the nearest of `steps` in an octave, so that two draws seldom differ.
static double rounded(double x, int steps)
{
    return x > 0 ? exp2(round(steps * log2(x)) / steps) : 0;
}

void profile_workload_text(const profile_workload *w, text *t)
{
    enum { FINE = 4, COARSE = 1 };
    add_kind(t, w);
    text_add(t, "; n %" PRIu64 "; cells", w->n);
    for (uint32_t k = 0; k < w->dims; ++k)
        text_add(t, " %.3g", rounded(w->cells[k], FINE));
    text_add(t, " of %.3g; occupancy %.3g to %.3g; sizes 1:%.3g", rounded(w->cell, FINE),
             rounded(w->occ_mean, FINE), rounded(w->occ_p99, COARSE),
             rounded(w->size_ratio, COARSE));
}

void profile_workload_family(const profile_workload *w, text *t)
{
    add_kind(t, w);
    text_add(t, "; sizes 1:%.3g", rounded(w->size_ratio, 1));
}

static bool check_fields(const profile_workload *w, duet_error *err)
{
    if (w->dims != 2 && w->dims != 3)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "a workload's dims are 2 or 3, not %u",
                         w->dims);
    if (w->n == 0 || w->n > INT64_MAX)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "a workload has at least one object");
    if (!w->shape || !w->level)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "a workload needs a shape and a level");
    if (!(isfinite(w->cell) && isfinite(w->occ_mean) && isfinite(w->occ_p99)))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a workload's cell and occupancy are numbers");
    if (!(isfinite(w->size_ratio) && w->size_ratio >= 1))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a workload's size ratio is 1 or more, not %g", w->size_ratio);
    return true;
}

bool profile_workload_key(const profile_workload *w, char key[PROFILE_SHA], duet_error *err)
{
    if (!check_fields(w, err))
        return false;
    text t = {0};
    profile_workload_text(w, &t);
    bool ok = text_ok(&t, err);
    profile_sha(text_chars(&t), t.length, key);
    text_free(&t);
    return ok;
}

static bool insert(store *s, const profile_workload *w, const char *key, const char *family,
                   const char *effects, duet_error *err)
{
    sql q = sql_make(s,
                     "INSERT INTO workload (key, family, name, dims, n, cells_x, cells_y, cells_z, "
                     "cell, occ_mean, occ_p99, size_ratio, shape, rotated, effects, level) "
                     "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
                     "ON CONFLICT (key) DO NOTHING",
                     err);
    sql_text(&q, key);
    sql_text(&q, family);
    sql_text(&q, w->name);
    sql_int(&q, w->dims);
    sql_int(&q, (int64_t)w->n);
    sql_int(&q, w->cells[0]);
    sql_int(&q, w->cells[1]);
    sql_int(&q, w->dims == 3 ? w->cells[2] : 1);
    sql_real(&q, w->cell);
    sql_real(&q, w->occ_mean);
    sql_real(&q, w->occ_p99);
    sql_real(&q, w->size_ratio);
    sql_text(&q, w->shape);
    sql_int(&q, w->rotated);
    sql_text(&q, effects);
    sql_text(&q, w->level);
    return sql_run(&q);
}

bool profile_workload_put(store *s, const profile_workload *w, int64_t *workload_id,
                          duet_error *err)
{
    char key[PROFILE_SHA];
    if (!profile_workload_key(w, key, err))
        return false;
    text family = {0};
    text effects = {0};
    profile_workload_family(w, &family);
    add_words(&effects, w->effects);
    bool ok = text_ok(&family, err) && text_ok(&effects, err);
    if (ok && store_begin(s, err)) {
        ok = insert(s, w, key, text_chars(&family), text_chars(&effects), err);
        ok = ok && sql_find(s, "SELECT id FROM workload WHERE key = ?", key, workload_id, err);
        ok = store_end(s, ok, err);
    } else
        ok = false;
    text_free(&family);
    text_free(&effects);
    return ok;
}
