// SPDX-License-Identifier: MIT
#include "base/list.h"

#include "base/budget.h"
#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>

enum { LEAST = 32 };

void *list_room(void *items, uint64_t n, size_t size, duet_error *err)
{
    bool full = n == 0 || (n >= LEAST && (n & (n - 1)) == 0);
    uint64_t room = n < LEAST ? LEAST : 2 * n;
    if (!full)
        return items;
    if (!budget_space((size_t)room * size, err))
        return NULL;
    void *grown = realloc(items, (size_t)room * size);
    return grown ? grown : null_no_memory(err, "%" PRIu64 " items", room);
}
