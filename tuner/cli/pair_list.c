// SPDX-License-Identifier: MIT
#include "tuner/cli/pair_list.h"

#include "runtime/base/error.h"

#include <inttypes.h>
#include <stdlib.h>

int pair_list_order(const void *x, const void *y)
{
    const duet_pair *p = x;
    const duet_pair *q = y;
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    return (p->b > q->b) - (p->b < q->b);
}

duet_pair *pair_list_sorted(const duet_result *result, duet_error *err)
{
    duet_pair *pairs = calloc(result->pairs + 1, sizeof *pairs);
    if (!pairs) {
        error_set(err, DUET_NO_MEMORY, "%" PRIu64 " pairs: no memory", result->pairs);
        return NULL;
    }
    for (uint64_t i = 0; i < result->pairs; ++i)
        pairs[i] = duet_result_pair(result, i);
    qsort(pairs, result->pairs, sizeof *pairs, pair_list_order);
    return pairs;
}
