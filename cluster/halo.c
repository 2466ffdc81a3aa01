// SPDX-License-Identifier: MIT
#include "cluster/halo.h"

#include "base/error.h"
#include "cluster/moving_domains.h"
#include "runtime/dynamics/motion_rows.h"

#include <stdlib.h>

void halo_end(halo *h)
{
    free(h->sent.items);
    free(h->received.items);
    parcels_end(&h->out);
    parcels_end(&h->in);
    free(h->requests);
    *h = (halo){0};
}

void halo_clear(halo *h)
{
    list_clear(&h->sent);
    list_clear(&h->received);
}

void halo_add(item_list *items, const halo_item *item)
{
    list_add(items, item, 1, sizeof *item);
}

// ---------------------------------------------------------------- lists

// By the other side's rank; then as the sender and the receiver both know it.
static int compare(const void *left, const void *right)
{
    const halo_item *a = left, *b = right;
    const uint32_t keys[][2] = {
        {a->rank, b->rank}, {a->to, b->to}, {a->from, b->from}, {a->id, b->id}};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
        if (keys[i][0] != keys[i][1])
            return keys[i][0] < keys[i][1] ? -1 : 1;
    return 0;
}

static halo_item *item_at(const item_list *items, uint64_t i)
{
    return (halo_item *)items->items + i;
}

static void settle_list(item_list *items, const moving *m)
{
    if (items->n > 0)
        qsort(items->items, items->n, sizeof(halo_item), compare);
    for (uint64_t i = 0; i < items->n; ++i) {
        halo_item *item = item_at(items, i);
        item->place = moving_place(m, &m->domains[item->domain], item->id);
    }
}

static uint32_t row_bytes(const moving *m, motion_buffer which)
{
    return motion_words(m->domains[0].motion, which) * (uint32_t)sizeof(uint32_t);
}

// BODIES have the longest rows.
static bool reserve(parcels *p, const item_list *items, const moving *m, duet_error *own)
{
    if (!parcels_begin(p, m->ranks, row_bytes(m, BODIES), own))
        return false;
    for (uint64_t i = 0; i < items->n; ++i)
        ++p->counts[item_at(items, i)->rank];
    return parcels_reserve(p, m->ranks, NULL, own);
}

static bool settle(halo *h, const moving *m, duet_error *own)
{
    if (!h->requests)
        h->requests = malloc(4 * (size_t)m->ranks->n * sizeof *h->requests);
    if (!h->requests || h->sent.failed || h->received.failed)
        return error_set(own, DUET_STATUS_NO_MEMORY, "a halo: no memory");
    settle_list(&h->sent, m);
    settle_list(&h->received, m);
    return reserve(&h->out, &h->sent, m, own) && reserve(&h->in, &h->received, m, own);
}

bool halo_settle(halo *h, moving *m, duet_error *own)
{
    return ranks_agree(m->ranks, is_well(own) && settle(h, m, own), own);
}

// ---------------------------------------------------------------- rows

static bool open_rows(const moving *m, motion_buffer which, motion_rows *rows, duet_error *own)
{
    bool ok = true;
    for (uint32_t d = 0; ok && d < m->parts; ++d) {
        duet_motion *motion = m->domains[d].motion;
        ok = motion->n == 0 || motion_rows_open(motion, which, 0, motion->n, &rows[d], own);
    }
    return ok;
}

static void close_rows(const moving *m, motion_rows *rows, bool changed, duet_error *own)
{
    for (uint32_t d = 0; d < m->parts; ++d)
        if (changed && rows[d].bytes)
            motion_rows_close(m->domains[d].motion, &rows[d], own);
        else
            motion_rows_drop(&rows[d]);
}

static void pack(const halo *h, const motion_rows *rows)
{
    const size_t row = h->out.row_bytes;
    for (uint64_t i = 0; i < h->sent.n; ++i) {
        const halo_item *item = item_at(&h->sent, i);
        memcpy((char *)h->out.rows + i * row, motion_row(&rows[item->domain], item->place), row);
    }
}

static void unpack(const halo *h, const motion_rows *rows)
{
    const size_t row = h->in.row_bytes;
    for (uint64_t i = 0; i < h->received.n; ++i) {
        const halo_item *item = item_at(&h->received, i);
        memcpy(motion_row(&rows[item->domain], item->place), (char *)h->in.rows + i * row, row);
    }
}

void halo_exchange(halo *h, moving *m, motion_buffer which, duet_error *own)
{
    if (h->sent.n == 0 && h->received.n == 0)
        return;
    motion_rows *rows = calloc(m->parts, sizeof *rows);
    if (!rows)
        error_set(own, DUET_STATUS_NO_MEMORY, "a halo: no memory");
    h->out.row_bytes = h->in.row_bytes = row_bytes(m, which);
    bool opened = is_well(own) && open_rows(m, which, rows, own);
    if (opened)
        pack(h, rows);
    parcels_pass(m->ranks, &h->out, &h->in, h->requests);
    if (opened)
        unpack(h, rows);
    if (rows)
        close_rows(m, rows, opened, own);
    free(rows);
}
