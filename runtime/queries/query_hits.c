// SPDX-License-Identifier: MIT
#include "runtime/queries/query_hits.h"

#include "base/compare.h"

#include <stdlib.h>
#include <string.h>

uint32_t *hits_at(const hit_list *list, uint32_t words, uint64_t i)
{
    uint32_t *hits = list->block.bytes;
    return hits ? hits + i * words : NULL;
}

bool hits_reserve(hit_list *list, uint32_t words, const device *d, uint64_t more, duet_error *err)
{
    host_block grown = {0};
    uint64_t wanted = list->n + more;
    size_t bytes = words * sizeof(uint32_t);
    if (wanted <= list->capacity)
        return true;
    uint64_t capacity = wanted + wanted / 4;
    if (!host_block_reserve(&grown, d, d ? 1 : 0, (size_t)capacity * bytes, err))
        return false;
    if (list->n > 0)
        memcpy(grown.bytes, list->block.bytes, (size_t)list->n * bytes);
    host_block_release(&list->block);
    list->block = grown;
    list->capacity = capacity;
    return true;
}

// ---------------------------------------------------------------- order

static float value_of(const uint32_t *hit)
{
    float value;
    memcpy(&value, &hit[2], sizeof value);
    return value;
}

int hits_compare(const void *x, const void *y)
{
    const uint32_t *a = x, *b = y;
    float of_a = value_of(a), of_b = value_of(b);
    if (a[0] != b[0] || of_a == of_b)
        return compare_uint32_pair(a, b);
    return of_a < of_b ? -1 : 1;
}

typedef int comparison(const void *x, const void *y);

static comparison *comparison_of(uint32_t words)
{
    return words > 2 ? hits_compare : compare_uint32_pair;
}

void hits_sort(uint32_t *hits, uint32_t words, uint64_t n)
{
    if (n > 0)
        qsort(hits, (size_t)n, words * sizeof *hits, comparison_of(words));
}

// By item first, which is a place, then the few of each item.
bool hits_sort_by_item(uint32_t *hits, uint32_t words, uint64_t n, uint32_t first_item,
                       uint32_t n_items)
{
    uint64_t *end = calloc((size_t)n_items + 1, sizeof *end);
    uint32_t *by_item = malloc((size_t)(n + 1) * words * sizeof *by_item);
    bool ok = end && by_item;
    for (uint64_t i = 0; ok && i < n; ++i)
        ++end[hits[i * words] - first_item + 1];
    for (uint32_t item = 0; ok && item < n_items; ++item)
        end[item + 1] += end[item];
    for (uint64_t i = 0; ok && i < n; ++i) {
        uint64_t place = end[hits[i * words] - first_item]++;
        memcpy(by_item + place * words, hits + i * words, words * sizeof *hits);
    }
    for (uint32_t item = 0; ok && item < n_items; ++item) {
        uint64_t first = item > 0 ? end[item - 1] : 0;
        if (end[item] - first > 1)
            hits_sort(by_item + first * words, words, end[item] - first);
    }
    if (ok && n > 0)
        memcpy(hits, by_item, (size_t)n * words * sizeof *hits);
    free(end);
    free(by_item);
    return ok;
}
