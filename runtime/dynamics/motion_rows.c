// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_rows.h"

#include "base/error.h"

#include <stdlib.h>

bool motion_rows_open(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last,
                      uint32_t words, bool reals, motion_rows *rows, duet_error *err)
{
    bool doubles = reals && m->def.doubles;
    size_t row = (size_t)words * (doubles ? 2 : 1) * sizeof(uint32_t);
    buffer *b = &m->buffers[which];
    *rows = (motion_rows){
        .of = b, .first = first, .row = row, .size = (last - first) * row, .doubles = doubles};
    size_t at = first * row;
    if (b->host) {
        rows->bytes = (char *)b->host + at;
        return timeline_read(&m->times, "fetch", b, b->host, at + rows->size, err);
    }
    rows->bytes = malloc(rows->size + 1);
    if (!rows->bytes)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", rows->size);
    bool ok = timeline_read_at(&m->times, "fetch", b, at, rows->bytes, rows->size, err);
    if (!ok)
        motion_rows_drop(rows);
    return ok;
}

bool motion_rows_close(duet_motion *m, motion_rows *rows, duet_error *err)
{
    size_t at = rows->first * rows->row;
    bool ok =
        rows->of->host
            ? timeline_write(&m->times, "send", rows->of, rows->of->host, at + rows->size, err)
            : timeline_write_at(&m->times, "send", rows->of, at, rows->bytes, rows->size, err);
    ok = ok && timeline_finish(&m->times, err);
    motion_rows_drop(rows);
    return ok;
}

void motion_rows_drop(motion_rows *rows)
{
    if (rows->of && !rows->of->host)
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
