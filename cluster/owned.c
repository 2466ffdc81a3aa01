// SPDX-License-Identifier: MIT
#include "cluster/owned.h"

#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- begin and end

bool owned_begin(owned *o, uint32_t n_domains, uint32_t most_domains, parallel *threads,
                 duet_error *err)
{
    *o = (owned){.n_domains = n_domains, .most_domains = most_domains, .threads = threads};
    o->domains = calloc(n_domains, sizeof *o->domains);
    o->boxes = calloc(most_domains, sizeof *o->boxes);
    return ((o->domains && o->boxes) ||
            error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu32 " parts: no memory", n_domains)) &&
           bisection_begin(&o->planes, n_domains, err);
}

void owned_forget_domains(owned *o)
{
    for (uint32_t d = 0; d < o->n_domains; ++d)
        o->domains[d] = (domain){.box = d == 0 ? extent_all : extent_none};
}

static void release(owned *o)
{
    if (o->holder)
        o->rows.objects = NULL;
    object_rows_end(&o->rows);
    o->holder = NULL;
    o->leavers.n = 0;
}

void owned_take(owned *o, object_rows *rows)
{
    release(o);
    o->rows = *rows;
    o->widest = 0;
    o->fitted = (extent){0};
    o->placement = PLACED_ANYHOW;
    *rows = (object_rows){0};
    owned_forget_domains(o);
}

void owned_end(owned *o)
{
    release(o);
    bisection_end(&o->planes);
    free(o->domains);
    free(o->boxes);
    free(o->leavers.rows);
    free(o->boundary.rows);
    free(o->renamed.rows);
    free(o->runs.runs);
    *o = (owned){0};
}

void owned_forget_renamed(owned *o)
{
    list_clear(&o->renamed.list);
}

// ---------------------------------------------------------------- rows

static bool reserve_ids(owned *o, uint64_t n, duet_error *err)
{
    if (o->rows.ids && n <= o->rows.capacity)
        return true;
    uint64_t capacity = n + n / 16;
    uint64_t *ids = realloc(o->rows.ids, (capacity + 1) * sizeof *ids);
    o->rows.ids = ids ? ids : o->rows.ids;
    void *objects =
        o->holder || !ids ? NULL : realloc(o->rows.objects, (size_t)(capacity + 1) * o->form.bytes);
    o->rows.objects = objects ? objects : o->rows.objects;
    if (!ids || (!o->holder && !objects))
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " objects: no memory", n);
    o->rows.capacity = capacity;
    return true;
}

bool owned_map(owned *o, duet_error *err)
{
    if (!o->holder)
        return true;
    void *objects = o->holder->map(o->holder, o->rows.n, err);
    o->rows.objects = objects ? objects : o->rows.objects;
    return objects;
}

bool owned_reserve(owned *o, uint64_t more, duet_error *err)
{
    uint64_t n = o->rows.n + more;
    if (n > DUET_MOST_OBJECTS)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%" PRIu64 " objects and ghosts on one rank; expected more ranks", n);
    if (!reserve_ids(o, n, err))
        return false;
    if (!o->holder)
        return true;
    void *objects = o->holder->extend(o->holder, (uint32_t)n, o->rows.n, err);
    o->rows.objects = objects ? objects : o->rows.objects;
    return objects;
}

// ---------------------------------------------------------------- leavers and newcomers

// Begins with the last leaver, so that no leaver takes another one's row.
void owned_tidy(owned *o)
{
    for (uint64_t k = o->leavers.n; k-- > 0;) {
        uint32_t gap = o->leavers.rows[k], last = --o->rows.n;
        if (gap == last)
            continue;
        object_rows_gather(&o->rows, &o->form, gap, &o->rows, &last, 1);
        if (o->holder)
            row_list_add(&o->renamed, gap);
    }
    o->leavers.n = 0;
}

typedef struct writing {
    owned *o;
    const parcels *messages;
} writing;

static void write_messages(void *context, uint32_t part, uint64_t first, uint64_t end)
{
    const writing *w = context;
    const unsigned char *from = w->messages->rows;
    object_rows to = w->o->rows;
    (void)part;
    to.n += (uint32_t)first;
    for (uint64_t i = first; i < end; ++i) {
        const unsigned char *message = from + i * w->messages->row_bytes;
        uint64_t id;
        memcpy(&id, message, sizeof id);
        object_rows_append(&to, &w->o->form, &id, message + sizeof id, 1);
    }
}

bool owned_add_newcomers(owned *o, const parcels *messages, duet_error *err)
{
    if (!owned_reserve(o, messages->n, err))
        return false;
    writing w = {o, messages};
    parallel_each(o->threads, messages->n, write_messages, &w);
    o->rows.n += (uint32_t)messages->n;
    return true;
}

// ---------------------------------------------------------------- domains

static double unevenness_of(const owned *o)
{
    uint64_t most = 0, n = 0;
    for (uint32_t d = 0; d < o->n_domains; ++d) {
        n += o->domains[d].n;
        most = o->domains[d].n > most ? o->domains[d].n : most;
    }
    return n > 0 ? (double)most * o->n_domains / (double)n : 1;
}

bool owned_is_uneven(const owned *o)
{
    return unevenness_of(o) > 1.2 * o->unevenness;
}

// ---------------------------------------------------------------- runs

bool owned_sort_runs(owned *o, duet_error *err)
{
    run_list *l = &o->runs;
    uint64_t capacity = l->n + 1, before = 0;
    row_run *sorted = l->failed ? NULL : malloc(capacity * sizeof *sorted);
    if (!sorted)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%" PRIu64 " runs of objects: no memory",
                         l->n);
    for (uint32_t d = 0; d < o->n_domains; ++d)
        o->domains[d].n = o->domains[d].n_runs = 0;
    for (uint64_t i = 0; i < l->n; ++i)
        ++o->domains[l->runs[i].domain].n_runs;
    for (uint32_t d = 0; d < o->n_domains; ++d) {
        o->domains[d].run = before;
        before += o->domains[d].n_runs;
        o->domains[d].n_runs = 0;
    }
    for (uint64_t i = 0; i < l->n; ++i) {
        domain *d = &o->domains[l->runs[i].domain];
        row_run *run = &sorted[d->run + d->n_runs++];
        *run = l->runs[i];
        run->at = d->n;
        d->n += run->n;
    }
    free(l->runs);
    l->runs = sorted;
    l->capacity = capacity;
    return true;
}
