// SPDX-License-Identifier: MIT
#include "cluster/halo.h"

#include "base/error.h"
#include "cluster/moving_domains.h"

#include <stdlib.h>

// Rows lie in memory of their own.
static void end_side(halo_side *s)
{
    free(s->items.items);
    free(s->places.rows);
    for (int i = 0; i < HALO_LISTS; ++i)
        free(s->runs[i].runs);
    free(s->counts);
    free(s->pressed);
    s->rows.rows = NULL;
    parcels_end(&s->rows);
    host_block_release(&s->block);
}

void halo_end(halo *h)
{
    end_side(&h->sent);
    end_side(&h->received);
    free(h->requests);
    *h = (halo){0};
}

void halo_clear(halo *h)
{
    list_clear(&h->sent.items);
    list_clear(&h->received.items);
}

void halo_add(item_list *items, const halo_item *item)
{
    list_add(items, item, 1, sizeof *item);
}

// ---------------------------------------------------------------- items

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

static const halo_item *item_at(const halo_side *s, uint64_t i)
{
    return (const halo_item *)s->items.items + i;
}

static void find_places(halo_side *s, const moving *m)
{
    if (s->items.n > 0)
        qsort(s->items.items, s->items.n, sizeof(halo_item), compare);
    for (uint64_t i = 0; i < s->items.n; ++i) {
        halo_item *item = (halo_item *)s->items.items + i;
        item->place = moving_place(&m->domains[item->domain], item->id);
    }
}

// ---------------------------------------------------------------- lists

static void clear_list(halo_side *s, int list, int n_ranks)
{
    s->n[list] = 0;
    list_clear(&s->runs[list].list);
    memset(s->counts + (size_t)list * n_ranks, 0, (size_t)n_ranks * sizeof *s->counts);
}

// So many items from a place of a list on begin a run, or go on with that of their domain.
static void add_to_runs(halo_runs *runs, uint32_t domain, uint64_t at, uint32_t n)
{
    if (!runs->failed && (runs->n == 0 || runs->runs[runs->n - 1].domain != domain))
        list_add(&runs->list, &(halo_run){domain, (uint32_t)at, 0}, 1, sizeof(halo_run));
    if (!runs->failed)
        runs->runs[runs->n - 1].n += n;
}

// The list's memory is there.
static void add_to_list(halo_side *s, int list, const halo_item *item, int n_ranks)
{
    const uint32_t at = s->first[list] + s->n[list]++;
    s->places.rows[at] = item->place;
    ++s->counts[(size_t)list * n_ranks + item->rank];
    add_to_runs(&s->runs[list], item->domain, at, 1);
}

static bool reserve_places(halo_side *s, uint64_t n, duet_error *own)
{
    if (n > UINT32_MAX)
        return error_set(own, DUET_STATUS_TOO_MANY, "ghosts in lists: more than 2^32");
    if (n > s->places.capacity) {
        uint32_t *rows = realloc(s->places.rows, (n + n / 4) * sizeof *rows);
        if (!rows)
            return no_memory(own, "a halo");
        s->places.rows = rows;
        s->places.capacity = n + n / 4;
    }
    return true;
}

// Tells all devices of places, from so many on.
static bool tell_places(const halo_side *s, const moving *m, uint32_t from, duet_error *own)
{
    const motion_buffer list = s == &m->halo.sent ? SENT_IDS : RECEIVED_IDS;
    bool failed = false;
    for (int k = 0; k < HALO_LISTS; ++k)
        failed = failed || s->runs[k].failed;
    if (failed)
        return no_memory(own, "a halo");
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_list_ids(m->domains[k].motion, list, from, s->places.rows + from,
                        (uint32_t)s->places.n - from, own);
    return is_well(own);
}

static bool list_all(halo_side *s, const moving *m, duet_error *own)
{
    if (!s->counts)
        s->counts = malloc(HALO_LISTS * (size_t)m->ranks->n * sizeof *s->counts);
    free(s->pressed);
    s->pressed = calloc(s->items.n + 1, sizeof *s->pressed);
    if (!s->counts || !s->pressed || !reserve_places(s, s->items.n + 1, own))
        return no_memory(own, "a halo");
    for (int k = 0; k < HALO_LISTS; ++k)
        clear_list(s, k, m->ranks->n);
    s->first[HALO_ALL] = 0;
    for (uint64_t i = 0; i < s->items.n; ++i)
        add_to_list(s, HALO_ALL, item_at(s, i), m->ranks->n);
    s->places.n = s->items.n;
    return tell_places(s, m, 0, own);
}

// ---------------------------------------------------------------- beginning

static uint32_t row_bytes(const moving *m, motion_buffer which)
{
    return motion_words(m->domains[0].motion, which) * (uint32_t)sizeof(uint32_t);
}

// Bodies have the longest rows.
static bool reserve_rows(halo_side *s, const moving *m, duet_error *own)
{
    const size_t body = row_bytes(m, BODIES),
                 bytes = body > sizeof(ghost_colours) ? body : sizeof(ghost_colours);
    if (!parcels_begin(&s->rows, m->ranks, (uint32_t)bytes, own) ||
        !host_block_reserve(&s->block, m->domains[0].motion->device, 1, (s->items.n + 1) * bytes,
                            own))
        return false;
    s->rows.rows = s->block.bytes;
    return true;
}

static bool settle_side(halo_side *s, const moving *m, duet_error *own)
{
    find_places(s, m);
    return list_all(s, m, own) && reserve_rows(s, m, own);
}

static bool settle(halo *h, moving *m, duet_error *own)
{
    if (!h->requests)
        h->requests = malloc(4 * (size_t)m->ranks->n * sizeof *h->requests);
    if (!h->requests || h->sent.items.failed || h->received.items.failed)
        return no_memory(own, "a halo");
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_reserve_ghosts(m->domains[k].motion, own);
    return is_well(own) && settle_side(&h->sent, m, own) && settle_side(&h->received, m, own);
}

bool halo_settle(halo *h, moving *m, duet_error *own)
{
    return ranks_agree(m->ranks, is_well(own) && settle(h, m, own), own);
}

// ---------------------------------------------------------------- rows

static size_t bytes_of(const row_parts *parts)
{
    return (parts->words[0] + parts->words[1]) * sizeof(uint32_t);
}

static row_parts whole_row(const moving *m, motion_buffer which)
{
    return (row_parts){.words = {motion_words(m->domains[0].motion, which)}};
}

// Rows that an exchange moves.
typedef struct rows_moved {
    motion_buffer which;
    row_parts parts;
} rows_moved;

typedef bool move_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                       const domain_ids *ids, void *packed, duet_error *err);

static bool pack_used(duet_motion *m, motion_buffer which, const row_parts *parts,
                      const domain_ids *ids, void *packed, duet_error *err)
{
    (void)which;
    (void)parts;
    return domain_pack_used(m, ids, packed, err);
}

static void move_items(const halo_side *s, const moving *m, int list, const rows_moved *rows,
                       move_rows *move, duet_error *own)
{
    const motion_buffer listed = s == &m->halo.sent ? SENT_IDS : RECEIVED_IDS;
    char *packed = s->rows.rows;
    for (uint64_t i = 0; is_well(own) && i < s->runs[list].n; ++i) {
        const halo_run *run = &s->runs[list].runs[i];
        const domain_ids ids = {s->places.rows + run->first, run->n, listed, run->first, false};
        move(m->domains[run->domain].motion, rows->which, &rows->parts, &ids,
             packed + (run->first - s->first[list]) * bytes_of(&rows->parts), own);
    }
}

// A device may still be reading what came before, if it was not waited for since.
static void await_unpacked(const moving *m, duet_error *own)
{
    for (uint32_t k = 0; k < m->parts; ++k)
        domain_await_rows(m->domains[k].motion, own);
}

static void count(halo_side *s, const moving *m, int list, uint32_t bytes)
{
    const size_t n = (size_t)m->ranks->n;
    s->rows.row_bytes = bytes;
    memcpy(s->rows.counts, s->counts + (size_t)list * n, n * sizeof *s->counts);
}

// Sends rows of a list from one side to the other. Returns how many requests wait.
static int send(halo *h, moving *m, int list, halo_side *from, halo_side *to,
                const rows_moved *rows, move_rows *pack, duet_error *own)
{
    const uint32_t bytes = (uint32_t)bytes_of(&rows->parts);
    count(from, m, list, bytes);
    count(to, m, list, bytes);
    move_items(from, m, list, rows, pack, own);
    if (from->n[list] == 0 || m->parts > 1)
        await_unpacked(m, own);
    return parcels_begin_pass(m->ranks, &from->rows, &to->rows, h->requests);
}

// Brings rows of a list from one side to the other, where they are unpacked, or looked at: NULL.
static void move(halo *h, moving *m, int list, halo_side *from, halo_side *to,
                 const rows_moved *rows, move_rows *pack, move_rows *unpack, duet_error *own)
{
    const int n = send(h, m, list, from, to, rows, pack, own);
    parcels_end_pass(m->ranks, n, h->requests);
    if (unpack)
        move_items(to, m, list, rows, unpack, own);
}

bool halo_comes(const halo *h, uint32_t colour)
{
    return h->sent.n[colour] > 0 || h->received.n[colour] > 0;
}

// As measured in docs/notes/performance.md.
uint32_t halo_least_inner(const ranks *r)
{
    enum { LEAST = 1 << 12, LEAST_ON_HOST = 1 << 14 };
    return r->n_on_host < r->n ? LEAST : LEAST_ON_HOST;
}

static int begin_exchange(halo *h, moving *m, int list, const rows_moved *rows, duet_error *own)
{
    if (!halo_comes(h, (uint32_t)list))
        return 0;
    ++h->n_exchanges;
    h->n_rows += h->sent.n[list];
    return send(h, m, list, &h->sent, &h->received, rows, domain_pack_listed, own);
}

static void end_exchange(halo *h, moving *m, int list, const rows_moved *rows, int n,
                         duet_error *own)
{
    if (!halo_comes(h, (uint32_t)list))
        return;
    parcels_end_pass(m->ranks, n, h->requests);
    move_items(&h->received, m, list, rows, domain_unpack_listed, own);
}

static void exchange(halo *h, moving *m, int list, const rows_moved *rows, duet_error *own)
{
    end_exchange(h, m, list, rows, begin_exchange(h, m, list, rows, own), own);
}

void halo_exchange(halo *h, moving *m, motion_buffer which, duet_error *own)
{
    exchange(h, m, HALO_ALL, &(rows_moved){which, whole_row(m, which)}, own);
}

// ---------------------------------------------------------------- after a colour

enum { VECTOR = 4 };

// Velocities of a body lie first (kernels/dynamics/records.h). The fourth numbers of vectors are no
// part of them.
static row_parts velocities_of(const duet_motion *motion)
{
    enum { SENT = 3 };
    const bool turns = motion->layout.body == BODY_OF(1);
    return (row_parts){.words = {(turns ? 2 : 1) * SENT}, .of_four = SENT};
}

int halo_begin_after(halo *h, moving *m, uint32_t colour, duet_error *own)
{
    const rows_moved rows = {BODIES, velocities_of(m->domains[0].motion)};
    return begin_exchange(h, m, (int)colour, &rows, own);
}

void halo_end_after(halo *h, moving *m, uint32_t colour, int n, duet_error *own)
{
    const rows_moved rows = {BODIES, velocities_of(m->domains[0].motion)};
    end_exchange(h, m, (int)colour, &rows, n, own);
}

void halo_exchange_after(halo *h, moving *m, uint32_t colour, duet_error *own)
{
    halo_end_after(h, m, colour, halo_begin_after(h, m, colour, own), own);
}

// Both sides see the same rows.
static void note_pressed(halo_side *s)
{
    const uint32_t *asleep = s->rows.rows;
    for (uint64_t i = 0; i < s->items.n; ++i)
        s->pressed[i] = (asleep[i] & PRESSED) != 0;
}

void halo_exchange_asleep(halo *h, moving *m, duet_error *own)
{
    halo_exchange(h, m, ASLEEP, own);
    note_pressed(&h->sent);
    note_pressed(&h->received);
}

// As push_sleepers writes them (kernels/dynamics/update_sleep.cl).
void halo_exchange_ways(halo *h, moving *m, uint32_t round, duet_error *own)
{
    const rows_moved rows = {BODIES, {.at = {(~round & 1u) * VECTOR}, .words = {VECTOR}}};
    exchange(h, m, HALO_PRESSED, &rows, own);
}

// Its move and its turn of the step lie together, too.
static rows_moved late_rows(const duet_motion *motion)
{
    const bool turns = motion->layout.body == BODY_OF(1);
    row_parts parts = velocities_of(motion);
    parts.at[1] = BODY_DELTA_POSITION_OF(turns) * VECTOR;
    parts.words[1] = (turns ? 2 : 1) * VECTOR;
    return (rows_moved){BODIES, parts};
}

int halo_begin_late(halo *h, moving *m, duet_error *own)
{
    const rows_moved rows = late_rows(m->domains[0].motion);
    return begin_exchange(h, m, HALO_LATE, &rows, own);
}

void halo_end_late(halo *h, moving *m, int n, duet_error *own)
{
    const rows_moved rows = late_rows(m->domains[0].motion);
    end_exchange(h, m, HALO_LATE, &rows, n, own);
}

// ---------------------------------------------------------------- what comes when

void halo_tell_home(halo *h, moving *m, duet_error *own)
{
    const rows_moved rows = {GHOSTS, {.at = {GHOST_AT_HOME}, .words = {1}}};
    move(h, m, HALO_ALL, &h->sent, &h->received, &rows, pack_used, domain_unpack_listed, own);
}

// The lists that a ghost is in, a bit for each. Contacts without a colour of their own leave it
// wrong, for not all need be here.
static uint64_t lists_of(const halo_side *s, const ghost_colours *colours, uint64_t i)
{
    const ghost_colours *c = &colours[i];
    const uint32_t lost = c->at_home & ~(c->here & ((1u << HALO_COLOURS) - 1));
    return (uint64_t)c->comes | (uint64_t)(c->here != 0 && lost != 0) << HALO_ANY |
           (uint64_t)(c->here == 0 && c->at_home != 0) << HALO_LATE |
           (uint64_t)s->pressed[i] << HALO_PRESSED;
}

// Makes space for each list behind the one of all.
static bool lay_lists(halo_side *s, const ghost_colours *colours, int n_ranks, duet_error *own)
{
    uint32_t n[HALO_LISTS] = {0};
    uint64_t all = s->items.n;
    for (uint64_t i = 0; i < s->items.n; ++i)
        for (uint64_t left = lists_of(s, colours, i); left != 0; left &= left - 1)
            ++n[__builtin_ctzll(left)];
    for (int k = 0; k < HALO_ALL; ++k) {
        clear_list(s, k, n_ranks);
        s->first[k] = (uint32_t)all;
        all += n[k];
    }
    s->places.n = all;
    return reserve_places(s, all, own);
}

// The end of the items from one on that have its rank and its domain here.
static uint64_t end_of_alike(const halo_side *s, uint64_t first)
{
    const halo_item *of = item_at(s, first);
    uint64_t end = first + 1;
    while (end < s->items.n && item_at(s, end)->rank == of->rank &&
           item_at(s, end)->domain == of->domain)
        ++end;
    return end;
}

// Items that are alike are counted, and are a run, all at once.
static void note_alike(halo_side *s, const halo_item *of, const uint32_t before[HALO_ALL],
                       int n_ranks)
{
    for (int k = 0; k < HALO_ALL; ++k) {
        const uint32_t n = s->n[k] - before[k];
        if (n == 0)
            continue;
        s->counts[(size_t)k * n_ranks + of->rank] += n;
        add_to_runs(&s->runs[k], of->domain, s->first[k] + before[k], n);
    }
}

static void list_alike(halo_side *s, const ghost_colours *colours, uint64_t first, uint64_t end,
                       int n_ranks)
{
    uint32_t before[HALO_ALL];
    memcpy(before, s->n, sizeof before);
    for (uint64_t i = first; i < end; ++i) {
        const uint32_t place = item_at(s, i)->place;
        for (uint64_t left = lists_of(s, colours, i); left != 0; left &= left - 1) {
            const int list = __builtin_ctzll(left);
            s->places.rows[s->first[list] + s->n[list]++] = place;
        }
    }
    note_alike(s, item_at(s, first), before, n_ranks);
}

static void list_ghosts(halo_side *s, const moving *m, duet_error *own)
{
    const ghost_colours *colours = s->rows.rows;
    if (!lay_lists(s, colours, m->ranks->n, own))
        return;
    for (uint64_t first = 0, end; first < s->items.n; first = end) {
        end = end_of_alike(s, first);
        list_alike(s, colours, first, end, m->ranks->n);
    }
    tell_places(s, m, (uint32_t)s->items.n, own);
}

void halo_ask(halo *h, moving *m, duet_error *own)
{
    const rows_moved rows = {GHOSTS, {.words = {GHOST_WORDS}}};
    move(h, m, HALO_ALL, &h->received, &h->sent, &rows, domain_pack_listed, NULL, own);
    if (is_well(own))
        list_ghosts(&h->sent, m, own);
    if (is_well(own))
        list_ghosts(&h->received, m, own);
}

// ---------------------------------------------------------------- contacts

// Contacts that one side asks for, in the order of ghosts and of colours.
typedef struct asked_list {
    LIST_OF(asked_contact, contacts) list;
    halo_runs runs;
} asked_list;

static void list_asked(const halo_side *s, parcels *rows, asked_list *asked)
{
    const ghost_colours *colours = s->rows.rows;
    for (uint64_t i = 0; i < s->items.n; ++i) {
        const halo_item *item = item_at(s, i);
        for (uint32_t left = colours[i].asked; left != 0; left &= left - 1) {
            const asked_contact one = {item->place, (uint32_t)__builtin_ctz(left)};
            add_to_runs(&asked->runs, item->domain, asked->list.n, 1);
            list_add(&asked->list.list, &one, 1, sizeof one);
            ++rows->counts[item->rank];
        }
    }
}

static void end_asked(asked_list *asked)
{
    free(asked->list.contacts);
    free(asked->runs.runs);
}

static void read_asked(const halo_side *s, const moving *m, parcels *out, duet_error *own)
{
    asked_list asked = {0};
    list_asked(s, out, &asked);
    bool ok = parcels_reserve(out, m->ranks, NULL, own);
    if (asked.list.failed || asked.runs.failed)
        ok = no_memory(own, "contacts of ghosts");
    for (uint64_t i = 0; ok && i < asked.runs.n; ++i) {
        const halo_run *run = &asked.runs.runs[i];
        ok =
            domain_read_asked(m->domains[run->domain].motion, asked.list.contacts + run->first,
                              run->n, (char *)out->rows + (size_t)run->first * out->row_bytes, own);
    }
    end_asked(&asked);
}

static void take_asked(halo_side *s, const moving *m, const parcels *in, duet_error *own)
{
    asked_list asked = {0};
    memset(s->rows.counts, 0, (size_t)m->ranks->n * sizeof *s->rows.counts);
    list_asked(s, &s->rows, &asked);
    bool ok = !asked.list.failed && !asked.runs.failed;
    if (!ok)
        no_memory(own, "contacts of ghosts");
    for (uint64_t i = 0; ok && i < asked.runs.n; ++i) {
        const halo_run *run = &asked.runs.runs[i];
        ok = domain_take_asked(m->domains[run->domain].motion, asked.list.contacts + run->first,
                               run->n, (const char *)in->rows + (size_t)run->first * in->row_bytes,
                               own);
    }
    end_asked(&asked);
}

bool halo_bring_asked(halo *h, moving *m, duet_error *own)
{
    parcels out = {0}, in = {0};
    const uint32_t bytes = (uint32_t)domain_asked_bytes(m->domains[0].motion);
    if (m->every == 1)
        return true;
    if (is_well(own) && parcels_begin(&out, m->ranks, bytes, own))
        read_asked(&h->sent, m, &out, own);
    bool ok = parcels_exchange(m->ranks, is_well(own), &out, &in, own);
    h->n_asked += ok ? in.n : 0;
    if (ok)
        take_asked(&h->received, m, &in, own);
    parcels_end(&out);
    parcels_end(&in);
    return ok;
}
