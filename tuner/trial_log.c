// SPDX-License-Identifier: MIT
#include "tuner/trial_log.h"

#include "base/list.h"

#include <stdlib.h>
#include <string.h>

void trial_log_free(trial_log *t)
{
    free(t->entries);
    *t = (trial_log){0};
}

bool trial_log_add(trial_log *t, const trial *entry, duet_error *err)
{
    trial *entries = list_room(t->entries, t->n, sizeof *entries, err);
    if (!entries)
        return false;
    t->entries = entries;
    t->entries[t->n++] = *entry;
    return true;
}

bool trial_log_same_plan(const duet_plan *a, const duet_plan *b)
{
    return a->share == b->share && a->mode == b->mode && strcmp(a->variant_a, b->variant_a) == 0 &&
           strcmp(a->variant_b, b->variant_b) == 0;
}

const trial *trial_log_next(trial_log *t, const duet_plan *plan, int32_t scope)
{
    if (t->played == t->n)
        return NULL;
    const trial *entry = &t->entries[t->played];
    if (entry->scope != scope || !trial_log_same_plan(&entry->plan, plan)) {
        t->n = t->played;
        return NULL;
    }
    ++t->played;
    return entry;
}

const trial *trial_log_of(const trial_log *t, const duet_plan *plan, int32_t scope,
                          const trial *after)
{
    const trial *end = t->entries + t->played, *at = after ? after + 1 : t->entries;
    while (at < end && !(at->usable && at->scope == scope && trial_log_same_plan(&at->plan, plan)))
        ++at;
    return at < end ? at : NULL;
}
