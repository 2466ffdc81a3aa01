// SPDX-License-Identifier: MIT
// Rows of bodies that go between domains, in place and by the device, and ids that are found.
#include "cluster/motion/moving.h"

#include "base/rng.h"
#include "cluster/row_order.h"
#include "kernels/dynamics/records.h"

// Three words of every four, in place and by the device.
static void vectors_leave_out_their_fourth(duet_motion *m)
{
    enum { WORDS = 32, TAKEN = 12, ROW = 5 };
    const uint32_t place = ROW;
    const row_parts whole = {.words = {WORDS}}, threes = {{0, 24}, {6, 6}, 3};
    static const uint32_t at[TAKEN] = {0, 1, 2, 4, 5, 6, 24, 25, 26, 28, 29, 30};
    uint32_t all[WORDS], in_place[TAKEN], packed[TAKEN];
    void *host = m->buffers[BODIES].host;
    MUST(motion_words(m, BODIES) == WORDS, "bodies turn");
    must(domain_pack_rows(m, BODIES, &whole, &place, 1, all, ERR));
    must(domain_pack_rows(m, BODIES, &threes, &place, 1, in_place, ERR));
    m->buffers[BODIES].host = NULL;
    must(domain_pack_rows(m, BODIES, &threes, &place, 1, packed, ERR));
    m->buffers[BODIES].host = host;
    MUST(all[2] != 0 && all[7] != 0, "it falls, and has an inertia");
    for (uint32_t k = 0; k < TAKEN; ++k)
        MUST(in_place[k] == all[at[k]] && packed[k] == all[at[k]], "three of every four");
}

// Parts of rows by a device that does not work on the host's memory: as one that does has them.
FACT_OF_ONE(parts_of_rows_come_and_go)
{
    static const uint32_t places[] = {17, 3, 20};
    enum { N = sizeof places / sizeof *places };
    duet_cluster *cluster = two_domains_after_steps("80", 1, 1);
    duet_motion *m = cluster->moving->domains[0].motion;
    const uint32_t words = motion_words(m, VELOCITIES);
    const row_parts whole = {.words = {words}}, ends = {{0, words - 1}, {2, 1}, 0};
    uint32_t before[N * 8], after[N * 8], packed[3 * N], again[3 * N];
    void *host = m->buffers[VELOCITIES].host;
    MUST(words == 4 && m->n > 20 && host, "rows are of four words, and the host's");
    vectors_leave_out_their_fourth(m);
    must(domain_pack_rows(m, VELOCITIES, &whole, places, N, before, ERR));
    must(domain_pack_rows(m, VELOCITIES, &ends, places, N, packed, ERR));
    m->buffers[VELOCITIES].host = NULL;
    must(domain_pack_rows(m, VELOCITIES, &ends, places, N, again, ERR));
    MUST(memcmp(packed, again, sizeof packed) == 0, "the device packs the same");
    for (uint32_t i = 0; i < 3 * N; ++i)
        again[i] += 1000 + i;
    must(domain_unpack_rows(m, VELOCITIES, &ends, places, N, again, ERR));
    m->buffers[VELOCITIES].host = host;
    must(domain_pack_rows(m, VELOCITIES, &whole, places, N, after, ERR));
    for (uint32_t i = 0; i < N; ++i)
        for (uint32_t k = 0; k < words; ++k) {
            uint32_t at = k < 2 ? k : 2, more = k < 2 || k == words - 1 ? 1000 + 3 * i + at : 0;
            MUST(after[i * words + k] == before[i * words + k] + more,
                 "parts are written, and nothing else");
        }
    duet_cluster_destroy(cluster);
}

// Rows go where their bodies go, and those of bodies that were not there are 0.
FACT_OF_ONE(rows_move_with_their_bodies)
{
    enum { WORDS = 4, MOST = 300 };
    static const motion_buffer list[] = {VELOCITIES};
    duet_cluster *cluster = two_domains_after_steps("300", 1, 1);
    duet_motion *m = cluster->moving->domains[0].motion;
    const uint32_t n = m->n + FIXED;
    const row_parts whole = {.words = {WORDS}};
    uint32_t places[MOST], from[MOST + FIXED], before[MOST * WORDS], after[MOST * WORDS];
    MUST(m->n <= MOST && m->n > 20 && motion_words(m, VELOCITIES) == WORDS, "rows of four words");
    for (uint32_t i = 0; i < n; ++i)
        from[i] = i % 3 == 0 || i >= m->n ? NO_PLACE : m->n - 1 - i;
    for (uint32_t i = 0; i < m->n; ++i)
        places[i] = i;
    must(domain_pack_rows(m, VELOCITIES, &whole, places, m->n, before, ERR));
    must(domain_move_rows(m, list, 1, from, n, ERR));
    must(domain_pack_rows(m, VELOCITIES, &whole, places, m->n, after, ERR));
    for (uint32_t i = 0; i < m->n; ++i)
        for (uint32_t k = 0; k < WORDS; ++k) {
            const uint32_t row = from[i] == NO_PLACE ? 0 : before[from[i] * WORDS + k];
            MUST(after[i * WORDS + k] == row, "a row moves with its body");
        }
    duet_cluster_destroy(cluster);
}

// Rows in new places, as their definition says.
FACT_OF_ONE(rows_are_spliced)
{
    enum { MOST = 200 };
    uint32_t from[MOST], fresh[MOST], rows[MOST], expected[MOST], came[MOST];
    rng random = rng_seed(job_seed);
    for (int round = 0; round < 2000; ++round) {
        const uint32_t before = rng_below(&random, MOST / 2), odds = 1 + rng_below(&random, 9);
        domain_bodies b = {.from = from, .fresh = fresh};
        for (uint32_t i = 0; i <= before; ++i) {
            for (uint32_t n = rng_below(&random, odds) ? 0 : rng_below(&random, 3); n > 0; --n)
                if (b.n < MOST - before) {
                    came[b.n_fresh] = expected[b.n] = 1000 + b.n_fresh;
                    fresh[b.n_fresh++] = b.n;
                    from[b.n++] = NO_PLACE;
                }
            if (i < before && rng_below(&random, odds) < 5) {
                expected[b.n] = i;
                from[b.n++] = i;
            }
        }
        for (uint32_t i = 0; i < before; ++i)
            rows[i] = i;
        domain_splice(&b, rows, came, sizeof *rows);
        MUST(memcmp(rows, expected, b.n * sizeof *rows) == 0, "rows go to their places");
    }
}

typedef struct long_row {
    uint64_t key, words[5];
} long_row;

static uint64_t key_of_long(const void *row)
{
    return ((const long_row *)row)->key;
}

// Ascending stretches of keys, some of them twice. Each key comes once, with its row, in order.
FACT_OF_ONE(rows_come_in_order)
{
    enum { KEYS_MOST = 300 };
    rng r = rng_seed(job_seed);
    for (int round = 0; round < 60; ++round) {
        uint64_t seen[KEYS_MOST] = {0}, key = 0, n_seen = 0, at = 0;
        item_list rows = {0};
        for (uint32_t i = 0, n = rng_below(&r, 400); i < n; ++i) {
            key = rng_below(&r, 9) == 0 ? rng_below(&r, KEYS_MOST) : key + rng_below(&r, 3);
            key = round == 0 ? i : key % KEYS_MOST;
            if (key >= KEYS_MOST)
                break;
            n_seen += seen[key]++ == 0;
            const long_row row = {key, {key, key + 1, key + 2, key + 3, key + 4}};
            list_add(&rows, &row, 1, sizeof row);
        }
        MUST(row_order(&rows, sizeof(long_row), key_of_long) && rows.n == n_seen, "each key once");
        for (key = 0; key < KEYS_MOST; ++key) {
            const long_row *row = (const long_row *)rows.items + at;
            at += seen[key] > 0;
            MUST(seen[key] == 0 || (row->key == key && row->words[4] == key + 4), "rows in order");
        }
        free(rows.items);
    }
}

FACT_OF_ONE(ids_are_found_at_their_places)
{
    enum { IDS = 2000 };
    rng r = rng_seed(job_seed);
    for (uint32_t one_of = 1; one_of < 400; one_of += 57) {
        moving_domain d = {0};
        moving m = {.n_all = IDS};
        uint32_t places[IDS + 40];
        for (uint32_t id = 0; id < IDS; ++id) {
            const moving_body b = {.id = id};
            const bool is_here = rng_below(&r, one_of) == 0;
            places[id] = is_here ? (uint32_t)d.bodies.n : UINT32_MAX;
            if (is_here)
                list_add(&d.bodies.list, &b, 1, sizeof b);
        }
        for (uint32_t id = IDS; id < IDS + 40; ++id) { // that came after the others were counted

            places[id] = (uint32_t)d.bodies.n;
            list_add(&d.bodies.list, &(moving_body){.id = id}, 1, sizeof(moving_body));
        }
        for (int indexed = 0; indexed < 2; ++indexed) {
            for (uint32_t id = 0; id < IDS + 40; ++id)
                MUST(moving_place(&d, id) == places[id], "the place of an id");
            moving_index_places(&m, &d, ERR);
        }
        free(d.bodies.rows);
        free(d.index.firsts);
    }
}
