// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_rows.h"

#include "base/error.h"

#include <stdlib.h>

static bool map(duet_motion *m, motion_rows *rows, size_t at, duet_error *err)
{
    const device *d = m->device;
    cl_int code = CL_SUCCESS;
    ++m->times.n_waits;
    rows->bytes = clEnqueueMapBuffer(d->queue, rows->of->mem, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE,
                                     at, rows->size, 0, NULL, NULL, &code);
    if (!rows->bytes)
        return error_set_cl(err, code, "%s: mapping %zu bytes", d->info.selector, rows->size);
    rows->mapped_by = d->queue;
    return true;
}

static bool fetch(duet_motion *m, motion_rows *rows, size_t at, duet_error *err)
{
    rows->bytes = malloc(rows->size + 1);
    if (!rows->bytes)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", rows->size);
    bool ok = timeline_read_at(&m->times, "fetch", rows->of, at, rows->bytes, rows->size, err);
    if (!ok)
        motion_rows_drop(rows);
    return ok;
}

bool motion_rows_open(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last,
                      uint32_t words, bool reals, motion_rows *rows, duet_error *err)
{
    bool doubles = reals && m->def.doubles;
    size_t row = (size_t)words * (doubles ? 2 : 1) * sizeof(uint32_t);
    buffer *b = &m->buffers[which];
    *rows = (motion_rows){
        .of = b, .first = first, .row = row, .size = (last - first) * row, .doubles = doubles};
    return b->host && rows->size > 0 ? map(m, rows, first * row, err)
                                     : fetch(m, rows, first * row, err);
}

// What is mapped is the device's again before the queue's next command.
bool motion_rows_close(duet_motion *m, motion_rows *rows, duet_error *err)
{
    size_t at = rows->first * rows->row;
    bool ok = rows->mapped_by ||
              (timeline_write_at(&m->times, "send", rows->of, at, rows->bytes, rows->size, err) &&
               timeline_finish(&m->times, err));
    motion_rows_drop(rows);
    return ok;
}

void motion_rows_drop(motion_rows *rows)
{
    if (rows->mapped_by)
        clEnqueueUnmapMemObject(rows->mapped_by, rows->of->mem, rows->bytes, 0, NULL, NULL);
    else
        free(rows->bytes);
    *rows = (motion_rows){0};
}

void motion_span_of(const uint32_t *places, uint32_t n, uint32_t *first, uint32_t *last)
{
    *first = UINT32_MAX;
    *last = 0;
    for (uint32_t i = 0; i < n; ++i) {
        *first = places[i] < *first ? places[i] : *first;
        *last = places[i] >= *last ? places[i] + 1 : *last;
    }
}
