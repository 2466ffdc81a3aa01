// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_rows.h"

#include "base/error.h"

#include <stdlib.h>

// Rows of host memory, once all that was launched is done: mapped, or as they lie.
static bool map_rows(duet_motion *m, motion_rows *rows, size_t at, duet_error *err)
{
    const device *d = m->device;
    const buffer *const seen[] = {rows->of};
    cl_int code = CL_SUCCESS;
    if (d->quirks & DRIVER_IN_PLACE) {
        rows->bytes = (char *)rows->of->host + at;
        return m->times.sent == SENT_SEEN || timeline_see(&m->times, "send", seen, 1, err);
    }
    ++m->times.n_waits;
    ++m->times.all_waits;
    rows->bytes = clEnqueueMapBuffer(d->queue, rows->of->mem, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE,
                                     at, rows->size, 0, NULL, NULL, &code);
    if (!rows->bytes)
        return error_set_cl(err, code, "%s: mapping %zu bytes", d->info.selector, rows->size);
    rows->mapped_by = d->queue;
    return true;
}

// Fresh rows are not fetched: all are written before they are sent.
static bool fetch_rows(duet_motion *m, motion_rows *rows, size_t at, bool fresh, duet_error *err)
{
    rows->bytes = malloc(rows->size + 1);
    if (!rows->bytes)
        return no_memory(err, "%zu bytes", rows->size);
    bool ok =
        fresh || timeline_read_at(&m->times, "fetch", rows->of, at, rows->bytes, rows->size, err);
    if (!ok)
        motion_rows_drop(rows);
    return ok;
}

static bool are_of_host(const motion_rows *rows)
{
    return rows->of && rows->of->host && rows->size > 0;
}

static bool open_rows(duet_motion *m, motion_rows *rows, bool fresh, duet_error *err)
{
    size_t at = rows->first * rows->row;
    return are_of_host(rows) ? map_rows(m, rows, at, err) : fetch_rows(m, rows, at, fresh, err);
}

static motion_rows rows_of(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last)
{
    size_t row = motion_words(m, which) * sizeof(uint32_t);
    return (motion_rows){.of = &m->buffers[which],
                         .first = first,
                         .row = row,
                         .size = (last - first) * row,
                         .doubles = motion_has_doubles(m, which)};
}

bool motion_rows_open(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last,
                      motion_rows *rows, duet_error *err)
{
    *rows = rows_of(m, which, first, last);
    return open_rows(m, rows, false, err);
}

bool motion_rows_fresh(duet_motion *m, motion_buffer which, uint32_t n, motion_rows *rows,
                       duet_error *err)
{
    *rows = rows_of(m, which, 0, n);
    return open_rows(m, rows, true, err);
}

bool motion_rows_at(duet_motion *m, motion_buffer which, const uint32_t *places, uint32_t n,
                    motion_rows *rows, duet_error *err)
{
    uint32_t first = UINT32_MAX, last = 0;
    for (uint32_t i = 0; i < n; ++i) {
        first = places[i] < first ? places[i] : first;
        last = places[i] >= last ? places[i] + 1 : last;
    }
    return motion_rows_open(m, which, first, last, rows, err);
}

bool motion_rows_of_words(duet_motion *m, motion_buffer which, uint32_t n, uint32_t words,
                          motion_rows *rows, duet_error *err)
{
    size_t row = words * sizeof(uint32_t);
    *rows = (motion_rows){.of = &m->buffers[which], .row = row, .size = n * row};
    return open_rows(m, rows, false, err);
}

// Mapped memory is the device's again before the queue's next command.
bool motion_rows_close(duet_motion *m, motion_rows *rows, duet_error *err)
{
    size_t at = rows->first * rows->row;
    bool ok = are_of_host(rows) ||
              (timeline_write_at(&m->times, "send", rows->of, at, rows->bytes, rows->size, err) &&
               timeline_finish(&m->times, err));
    motion_rows_drop(rows);
    return ok;
}

void motion_rows_drop(motion_rows *rows)
{
    if (rows->mapped_by)
        clEnqueueUnmapMemObject(rows->mapped_by, rows->of->mem, rows->bytes, 0, NULL, NULL);
    else if (!are_of_host(rows))
        free(rows->bytes);
    *rows = (motion_rows){0};
}
