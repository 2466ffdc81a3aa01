// SPDX-License-Identifier: MIT
#include "profiles/duet_profiles.h"

#include "profiles/exchange.h"
#include "profiles/profile.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

struct duet_profile_list {
    duet_stored_profile *items;
    uint32_t n;
    uint32_t capacity;
    bool full; // memory ran out
};

static store *open_store(const char *path, store_access access, duet_error *err)
{
    text user = {0};
    bool ok = path || store_user_path(&user, err);
    store *s = ok ? store_open(path ? path : text_chars(&user), access, err) : NULL;
    text_free(&user);
    return s;
}

static void copy(char *to, size_t size, const char *from)
{
    snprintf(to, size, "%s", from ? from : "");
}

#define COPY(to, from) copy(to, sizeof(to), from)

// The list with space for one more, or NULL.
static void *grow(void *items, uint32_t n, uint32_t *capacity, size_t size)
{
    if (n < *capacity)
        return items;
    *capacity = *capacity ? 2 * *capacity : 16;
    return realloc(items, *capacity * size);
}

// ---------------------------------------------------------------- profiles

static duet_stored_device read_device(const profile_entry_device *d)
{
    duet_stored_device device = {0};
    COPY(device.name, d->name);
    COPY(device.part, d->part);
    COPY(device.driver, d->driver);
    return device;
}

static duet_stored_profile read_entry(const profile_entry *e)
{
    const profile_row *row = &e->row;
    duet_stored_profile p = {
        .dims = (uint32_t)e->dims,
        .objects = (uint64_t)e->n,
        .a = read_device(&e->a),
        .b = read_device(&e->b),
        .share = row->plan.share,
        .step_ms = row->median_ns * 1e-6,
        .low_ms = row->low_ns * 1e-6,
        .high_ms = row->high_ns * 1e-6,
        .gain = row->gain,
        .gain_low = row->gain_low,
        .gain_high = row->gain_high,
        .missed_rate = row->missed_rate,
        .false_rate = row->false_rate,
        .measured_s = e->created_ns / 1000000000,
    };
    COPY(p.uid, e->uid);
    COPY(p.replaced, e->dead_reason);
    COPY(p.scene, e->scene);
    COPY(p.mode, row->plan.mode);
    COPY(p.variant_a, row->plan.variant_a);
    COPY(p.variant_b, row->plan.variant_b);
    COPY(p.level, row->plan.level);
    COPY(p.verdict, row->verdict);
    COPY(p.origin, row->origin);
    COPY(p.session, e->session.id);
    return p;
}

static bool add_profile(void *context, const profile_entry *e)
{
    duet_profile_list *list = context;
    duet_stored_profile *items = grow(list->items, list->n, &list->capacity, sizeof *list->items);
    list->full = !items;
    if (list->full)
        return false;
    list->items = items;
    list->items[list->n++] = read_entry(e);
    return true;
}

static bool fill(duet_profile_list *list, store *s, const char *uid, bool replaced_too,
                 duet_error *err)
{
    return profile_entry_each(s, uid, replaced_too, add_profile, list, err) &&
           (!list->full || error_set(err, DUET_STATUS_NO_MEMORY, "the profiles: no memory"));
}

duet_profile_list *duet_profile_list_create(const char *path, bool replaced_too, duet_error *err)
{
    store *s = open_store(path, STORE_READ, err);
    if (!s)
        return NULL;
    duet_profile_list *list = calloc(1, sizeof *list);
    bool ok = list ? fill(list, s, NULL, replaced_too, err) && store_check_read(s, err)
                   : error_set(err, DUET_STATUS_NO_MEMORY, "the profiles: no memory");
    store_close(s);
    if (ok)
        return list;
    duet_profile_list_destroy(list);
    return NULL;
}

void duet_profile_list_destroy(duet_profile_list *list)
{
    if (!list)
        return;
    free(list->items);
    free(list);
}

uint32_t duet_profile_list_get_count(const duet_profile_list *list)
{
    return list ? list->n : 0;
}

const duet_stored_profile *duet_profile_list_get_profile(const duet_profile_list *list, uint32_t i)
{
    return list && i < list->n ? &list->items[i] : NULL;
}

// ---------------------------------------------------------------- trials

typedef struct trial_list {
    duet_stored_trial *items;
    uint32_t n;
    uint32_t capacity;
    bool full;
} trial_list;

static bool add_trial(void *context, int64_t number, const profile_trial *trial)
{
    (void)number;
    trial_list *list = context;
    duet_stored_trial *items = grow(list->items, list->n, &list->capacity, sizeof *list->items);
    list->full = !items;
    if (list->full)
        return false;
    list->items = items;
    duet_stored_trial *t = &list->items[list->n++];
    *t = (duet_stored_trial){
        .share = trial->plan.share,
        .samples = trial->n_samples,
        .step_ms = trial->median_ns * 1e-6,
        .low_ms = trial->low_ns * 1e-6,
        .high_ms = trial->high_ns * 1e-6,
        .a_ms = trial->a_ns * 1e-6,
        .b_ms = trial->b_ns * 1e-6,
    };
    COPY(t->mode, trial->plan.mode);
    COPY(t->variant_a, trial->plan.variant_a);
    COPY(t->variant_b, trial->plan.variant_b);
    COPY(t->outcome, trial->outcome);
    COPY(t->reason, trial->reason);
    return true;
}

static bool check_one(const store *s, const duet_profile_list *found, const char *uid,
                      duet_error *err)
{
    if (found->n == 0)
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "%s: no profile begins with '%s'; 'duet profiles list' shows them",
                         store_path(s), uid);
    return found->n == 1 || error_set(err, DUET_STATUS_BAD_ARGUMENT,
                                      "%s: %" PRIu32 " profiles begin with '%s'; give more digits",
                                      store_path(s), found->n, uid);
}

static bool read_trials(store *s, const char *uid, trial_list *trials, duet_error *err)
{
    duet_profile_list found = {0};
    bool ok = fill(&found, s, uid, true, err) && check_one(s, &found, uid, err);
    if (ok && *found.items[0].session)
        ok = profile_trial_each(s, found.items[0].session, add_trial, trials, err);
    free(found.items);
    return ok && (!trials->full || error_set(err, DUET_STATUS_NO_MEMORY, "the trials: no memory"));
}

bool duet_profile_get_trials(const char *path, const char *uid, duet_stored_trial **trials,
                             uint32_t *n, duet_error *err)
{
    if (!error_given(uid, __func__, "uid", err) || !error_given(trials, __func__, "trials", err) ||
        !error_given(n, __func__, "n", err))
        return false;
    trial_list list = {0};
    store *s = open_store(path, STORE_READ, err);
    bool ok = s && read_trials(s, uid, &list, err) && store_check_read(s, err);
    store_close(s);
    if (!ok) {
        free(list.items);
        list = (trial_list){0};
    }
    *trials = list.items;
    *n = list.n;
    return ok;
}

// ---------------------------------------------------------------- rows out and in

bool duet_profiles_export(const char *path, const char *file, duet_error *err)
{
    if (!error_given(file, __func__, "file", err))
        return false;
    store *s = open_store(path, STORE_READ, err);
    bool ok = s && profile_export_file(s, file, err);
    store_close(s);
    return ok;
}

static bool import_file(store *s, FILE *in, const char *name, duet_import_counts *counts,
                        duet_error *err)
{
    profile_import_counts c;
    bool ok = profile_import(s, in, name, &c, err);
    if (ok && counts)
        *counts = (duet_import_counts){c.added, c.known};
    return ok;
}

bool duet_profiles_import(const char *path, const char *file, duet_import_counts *counts,
                          duet_error *err)
{
    if (!error_given(file, __func__, "file", err))
        return false;
    FILE *in = fopen(file, "r");
    if (!in)
        return error_set(err, errno == ENOENT ? DUET_STATUS_NOT_FOUND : DUET_STATUS_IO_FAILED,
                         "%s: %s", file, strerror(errno));
    store *s = open_store(path, STORE_WRITE, err);
    bool ok = s && import_file(s, in, file, counts, err);
    store_close(s);
    fclose(in);
    return ok;
}
