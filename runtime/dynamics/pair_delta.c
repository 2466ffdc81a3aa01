// SPDX-License-Identifier: MIT
// Compares the pairs of a still world with those of its last step.
#include "runtime/dynamics/pair_list.h"

#include "base/error.h"

#include <stdlib.h>

struct duet_pair_delta {
    pair_list pairs, now;
    pair_changes changes;
};

duet_pair_delta *duet_pair_delta_create(duet_error *err)
{
    PUBLIC_CALL(err);
    duet_pair_delta *delta = calloc(1, sizeof *delta);
    if (!delta)
        no_memory(err, "a delta of pairs");
    return delta;
}

void duet_pair_delta_destroy(duet_pair_delta *delta)
{
    if (!delta)
        return;
    pair_list_free(&delta->pairs);
    pair_list_free(&delta->now);
    pair_changes_free(&delta->changes);
    free(delta);
}

static bool join(pair_list *list, const duet_span spans[2], duet_error *err)
{
    if (!pair_list_reserve(list, (size_t)(spans[0].n + spans[1].n), err))
        return false;
    list->n = 0;
    for (int k = 0; k < 2; ++k)
        for (uint64_t i = 0; i < spans[k].n; ++i)
            list->pairs[list->n++] = spans[k].pairs[i];
    return pair_list_sort(list, err);
}

bool duet_pair_delta_update(duet_pair_delta *delta, const duet_span spans[2],
                            duet_pair_delta_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(delta, __func__, "delta", err) ||
        !error_given(spans, __func__, "spans", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    for (int k = 0; k < 2; ++k)
        if (spans[k].n > 0 && !error_given(spans[k].pairs, __func__, "pairs", err))
            return false;
    if (!join(&delta->now, spans, err) ||
        !pair_changes_find(&delta->changes, &delta->pairs, &delta->now, err))
        return false;
    pair_list kept = delta->pairs;
    delta->pairs = delta->now;
    delta->now = kept;
    *result = (duet_pair_delta_result){delta->changes.events, delta->changes.n_events,
                                       delta->changes.stays.pairs, delta->changes.stays.n};
    return true;
}
