// SPDX-License-Identifier: MIT
#include "cluster/row_order.h"

// ---------------------------------------------------------------- by digits

enum { DIGIT_BITS = 8, DIGITS = 1 << DIGIT_BITS };

static uint32_t digit_of(const keyed_row *row, int shift)
{
    return (uint32_t)(row->key >> shift) & (DIGITS - 1);
}

static void move_by_digit(const keyed_row *from, uint64_t n, int shift, keyed_row *to)
{
    uint64_t starts[DIGITS + 1] = {0};
    for (uint64_t i = 0; i < n; ++i)
        ++starts[digit_of(&from[i], shift) + 1];
    for (int k = 0; k < DIGITS; ++k)
        starts[k + 1] += starts[k];
    for (uint64_t i = 0; i < n; ++i)
        to[starts[digit_of(&from[i], shift)]++] = from[i];
}

// So many bits are an even number of digits.
void keys_order(keyed_row *rows, uint64_t n, int bits)
{
    keyed_row *spare = rows + n;
    for (int shift = 0; shift < bits; shift += 2 * DIGIT_BITS) {
        move_by_digit(rows, n, shift, spare);
        move_by_digit(spare, n, shift + DIGIT_BITS, rows);
    }
}

// ---------------------------------------------------------------- by what ascends

// The end of the keys that ascend from one on.
static uint64_t end_of_run(const keyed_row *rows, uint64_t first, uint64_t n)
{
    uint64_t end = first + 1;
    while (end < n && rows[end - 1].key <= rows[end].key)
        ++end;
    return end;
}

// Merges [first, middle) and [middle, end) of rows, which both ascend.
static void merge(const keyed_row *rows, uint64_t first, uint64_t middle, uint64_t end,
                  keyed_row *to)
{
    uint64_t left = first, right = middle;
    for (uint64_t i = first; i < end; ++i)
        to[i] = right == end || (left < middle && rows[left].key <= rows[right].key)
                    ? rows[left++]
                    : rows[right++];
}

// Merges runs in pairs; returns how many there were.
static uint64_t merge_runs(const keyed_row *rows, uint64_t n, keyed_row *to)
{
    uint64_t runs = 0;
    for (uint64_t first = 0, end; first < n; first = end, runs += 2) {
        const uint64_t middle = end_of_run(rows, first, n);
        if (middle == n) {
            memcpy(to + first, rows + first, (n - first) * sizeof *rows);
            return runs + 1;
        }
        end = end_of_run(rows, middle, n);
        merge(rows, first, middle, end, to);
    }
    return runs;
}

// Returns the one of both arrays in which all ascend.
static keyed_row *sort_keys(keyed_row *rows, keyed_row *spare, uint64_t n)
{
    while (merge_runs(rows, n, spare) > 1) {
        keyed_row *sorted = spare;
        spare = rows;
        rows = sorted;
    }
    return rows;
}

// Returns the keys in order, in `memory`, which is to be freed; NULL without memory.
static const keyed_row *order_of(const char *rows, uint64_t n, size_t bytes, row_key *key_of,
                                 keyed_row **memory)
{
    keyed_row *keys = *memory = malloc(2 * n * sizeof *keys);
    for (uint64_t i = 0; keys && i < n; ++i)
        keys[i] = (keyed_row){key_of(rows + i * bytes), i};
    return keys ? sort_keys(keys, keys + n, n) : NULL;
}

// ---------------------------------------------------------------- rows

static bool ascend(const char *rows, uint64_t n, size_t bytes, row_key *key_of)
{
    for (uint64_t i = 1; i < n; ++i)
        if (key_of(rows + (i - 1) * bytes) >= key_of(rows + i * bytes))
            return false;
    return true;
}

bool rows_sort(void *rows, uint64_t n, size_t bytes, row_key *key_of)
{
    if (ascend(rows, n, bytes, key_of))
        return true;
    keyed_row *memory;
    const keyed_row *keys = order_of(rows, n, bytes, key_of, &memory);
    char *before = malloc(n * bytes), *to = rows;
    const bool ok = keys && before;
    if (ok)
        memcpy(before, rows, n * bytes);
    for (uint64_t i = 0; ok && i < n; ++i)
        memcpy(to + i * bytes, before + keys[i].row * bytes, bytes);
    free(memory);
    free(before);
    return ok;
}

bool row_order(item_list *rows, size_t bytes, row_key *key_of)
{
    const uint64_t n = rows->n;
    if (ascend(rows->items, n, bytes, key_of))
        return true;
    keyed_row *memory;
    const keyed_row *keys = order_of(rows->items, n, bytes, key_of, &memory);
    char *ordered = malloc(n * bytes), *from = rows->items;
    const bool ok = keys && ordered;
    uint64_t kept = 0;
    for (uint64_t i = 0; ok && i < n; ++i)
        if (i == 0 || keys[i].key != keys[i - 1].key)
            memcpy(ordered + kept++ * bytes, from + keys[i].row * bytes, bytes);
    free(memory);
    free(ok ? from : ordered);
    if (ok)
        *rows = (item_list){.items = ordered, .n = kept, .capacity = n};
    return ok;
}
