// SPDX-License-Identifier: MIT
#include "cluster/border.h"

#include "cluster/cluster.h"

// ---------------------------------------------------------------- the second worker

void border_close(border *b)
{
    if (b->worker)
        b->worker->close(b->worker);
    seen_end(&b->seen);
    object_rows_end(&b->rows);
    *b = (border){0};
}

static bool open_worker(duet_cluster *c)
{
    border *b = &c->border;
    duet_world_def def = c->def.world;
    duet_error unheard; // then there is one search, of homes and ghosts
    def.plan = c->workers[0]->plan(c->workers[0]);
    if (!b->worker)
        b->worker = cluster_open_worker(c, &def, &unheard);
    return b->worker;
}

// Space for n, and the worker's devices read it where it lies.
static bool reserve(border *b, const object_form *form, uint64_t n, duet_error *err)
{
    worker *w = b->worker;
    bool fits = b->rows.ids && n <= b->rows.capacity;
    if (!fits && w->lock)
        w->lock(w, NULL, 0);
    if (!object_rows_reserve(&b->rows, form, fits ? n : n + n / 4, err))
        return false;
    b->rows.n = (uint32_t)n;
    if (!fits && w->lock)
        w->lock(w, b->rows.objects, b->rows.capacity * form->bytes);
    return true;
}

// ---------------------------------------------------------------- homes

// Homes lie where devices with memory of their own read them, and few at the border. One thread
// has nothing to do meanwhile.
static bool is_worth_it(const duet_cluster *c)
{
    const homes *h = &c->homes;
    const worker *w = c->workers[0];
    return c->parts.n == 1 && c->ranks.n > 1 && c->threads.n > 1 && !c->is_cold && h->holder &&
           w->tell_ids && w->spares_host && w->spares_host(w) && h->border.n < h->rows.n / 4;
}

void border_begin(duet_cluster *c)
{
    border *b = &c->border;
    const homes *h = &c->homes;
    seen *s = &c->seen[0];
    const sight_in_place all = {
        .n = h->rows.n, .home = (uint32_t)c->ranks.self, .n_homes = (uint32_t)c->ranks.n};
    duet_error unheard;
    if (!is_worth_it(c) || !open_worker(c))
        return;
    cluster_follow(c);
    seen_in_place(s, h, &all);
    if (!seen_leave_out(s, h->gone, h->n_gone, &unheard))
        return;
    b->homes = (worker_search){
        .worker = c->workers[0], .seen = s, .ids = cluster_ids_of_homes(c), .tells_ids = true};
    b->is_searching = true;
    worker_search_begin(&b->homes, &c->threads);
}

// ---------------------------------------------------------------- ghosts

static void copy_homes(void *cluster, uint32_t part, uint64_t first, uint64_t end)
{
    duet_cluster *c = cluster;
    const homes *h = &c->homes;
    (void)part;
    object_rows_gather(&c->border.rows, &h->form, first, &h->rows, h->border.rows + first,
                       end - first);
}

bool border_take_ghosts(duet_cluster *c, duet_error *err)
{
    border *b = &c->border;
    const homes *h = &c->homes;
    const parcels *in = &c->ghosts.in;
    if (!reserve(b, &h->form, h->border.n + h->n_gone + in->n, err))
        return false;
    parallel_each(h->threads, h->border.n, copy_homes, c);
    object_rows_gather(&b->rows, &h->form, h->border.n, &h->rows, h->gone, h->n_gone);
    homes_write_messages(h, &b->rows, h->border.n + h->n_gone, in);
    b->worker->lend(b->worker, b->rows.objects, b->rows.n);
    if (h->n_gone + in->n > 0)
        b->worker->begin(b->worker, b->rows.n, NULL);
    return seen_at_border(&b->seen, h, &c->ranks, &b->rows, in, err);
}

// ---------------------------------------------------------------- pairs

static bool search_border(border *b, duet_error *err)
{
    b->found = (worker_found){0};
    return b->seen.n_ghosts == 0 || (b->worker->find(b->worker, &b->found, err) &&
                                     seen_check_found(&b->seen, &b->found, err));
}

bool border_end(duet_cluster *c, bool ok, duet_error *err)
{
    border *b = &c->border;
    ok = ok && search_border(b, err);
    ok = worker_search_end(&b->homes, ok ? err : NULL) && ok;
    b->worker->lend(b->worker, NULL, 0); // rows may be elsewhere when it is lent them again
    b->is_searching = false;
    if (ok)
        homes_forget_renamed(&c->homes);
    c->found = b->homes.found;
    b->done = ok;
    return ok && cluster_take_found(c, false, err);
}
