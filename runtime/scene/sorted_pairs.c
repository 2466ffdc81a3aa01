// SPDX-License-Identifier: MIT
#include "runtime/scene/sorted_pairs.h"

#include "base/compare.h"
#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>

duet_pair *sorted_pairs_of(const duet_result *result, duet_error *err)
{
    duet_pair *pairs = calloc(result->pairs + 1, sizeof *pairs);
    if (!pairs)
        return null_no_memory(err, "%" PRIu64 " pairs", result->pairs);
    for (uint64_t i = 0; i < result->pairs; ++i)
        pairs[i] = duet_result_get_pair(result, i);
    qsort(pairs, result->pairs, sizeof *pairs, compare_uint32_pair);
    return pairs;
}

void sorted_pairs_rename(duet_pair *pairs, uint64_t n, const uint32_t *ids)
{
    for (uint64_t i = 0; i < n; ++i) {
        uint32_t a = ids[pairs[i].a], b = ids[pairs[i].b];
        pairs[i] = a < b ? (duet_pair){a, b} : (duet_pair){b, a};
    }
    qsort(pairs, n, sizeof *pairs, compare_uint32_pair);
}

void sorted_pairs_compare(const duet_pair *found, uint64_t n_found, const duet_pair *truth,
                          uint64_t n_truth, sorted_pairs_visit *visit, void *context)
{
    uint64_t i = 0, j = 0;
    while (i < n_found || j < n_truth) {
        int ahead = i == n_found   ? 1
                    : j == n_truth ? -1
                                   : compare_uint32_pair(&found[i], &truth[j]);
        if (ahead != 0)
            visit(context, ahead < 0 ? found[i] : truth[j], ahead > 0);
        i += ahead <= 0;
        j += ahead >= 0;
    }
}

void sorted_pairs_count_wrong(void *count, duet_pair pair, bool missed)
{
    sorted_pairs_count *c = count;
    (void)pair;
    c->missed += missed;
    c->added += !missed;
}
