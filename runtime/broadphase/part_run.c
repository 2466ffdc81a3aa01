// SPDX-License-Identifier: MIT
// A part's way through a step.
#include "runtime/broadphase/part.h"

#include "base/clock.h"

static bool get_grid(part *p, duet_error *err)
{
    bool ok =
        p->task.role == GRID_RECEIVED
            ? part_receive_grid(p, p->task.other, err)
            : part_update_views(p, err) && (p->state == PART_CROWDED || part_build_grid(p, err));
    if (ok && p->state == PART_BEGUN)
        part_enter(p, PART_HAS_GRID);
    return ok;
}

static bool search(part *p, duet_error *err)
{
    bool ok = part_search(p, err);
    if (ok && p->state == PART_HAS_GRID)
        part_enter(p, PART_DONE);
    return ok;
}

void part_run(void *arg)
{
    part *p = arg;
    uint64_t begun = clock_steady_ns();
    bool ok = p->state == PART_HAS_GRID || get_grid(p, &p->err);
    if (ok && p->state == PART_HAS_GRID)
        ok = search(p, &p->err);
    if (!ok) {
        part_enter(p, PART_FAILED);
        part_invalidate(p);
        compaction_cancel(p->task.lists);
    }
    p->bytes = part_bytes(p);
    p->result.wall_ms += clock_ms_since(begun);
}

bool part_share_grid(part *from, part *to, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    bool ok = get_grid(from, err) && part_update_views(to, err) && part_send_grid(from, to, err);
    from->result.wall_ms = clock_ms_since(begun);
    if (!ok) {
        part_invalidate(to);
        part_invalidate(from);
    }
    return ok;
}
