// SPDX-License-Identifier: MIT
// Rows of a buffer by object, changed by the host between steps.
//
// Rows are changed in place if B works on host memory. Else rows between the first and the last
// that is asked for are fetched, changed, and sent back.
#ifndef RUNTIME_MOTION_ROWS_H
#define RUNTIME_MOTION_ROWS_H

#include "runtime/dynamics/motion.h"

typedef struct motion_rows {
    buffer *of;
    uint32_t first; // the row that bytes begins with
    size_t row;     // bytes of one
    size_t size;
    bool doubles;
    char *bytes;
    cl_command_queue mapped_by; // the queue that mapped the buffer's memory; NULL: none did
} motion_rows;

// Rows [first, last) of a buffer by object; the first n, all of which are written; those from the
// least of n places to the greatest; or the n of another buffer, of so many words each. Afterwards
// they are closed, or dropped if nothing was changed.
bool motion_rows_open(duet_motion *m, motion_buffer which, uint32_t first, uint32_t last,
                      motion_rows *rows, duet_error *err);
bool motion_rows_fresh(duet_motion *m, motion_buffer which, uint32_t n, motion_rows *rows,
                       duet_error *err);
bool motion_rows_at(duet_motion *m, motion_buffer which, const uint32_t *places, uint32_t n,
                    motion_rows *rows, duet_error *err);
bool motion_rows_of_words(duet_motion *m, motion_buffer which, uint32_t n, uint32_t words,
                          motion_rows *rows, duet_error *err);
bool motion_rows_close(duet_motion *m, motion_rows *rows, duet_error *err);
void motion_rows_drop(motion_rows *rows);

static inline void *motion_row(const motion_rows *rows, uint32_t place)
{
    return rows->bytes + (size_t)(place - rows->first) * rows->row;
}

// Number k of a row of floats, or of doubles.
static inline double motion_row_get(const motion_rows *rows, uint32_t place, uint32_t k)
{
    const void *row = motion_row(rows, place);
    return rows->doubles ? ((const double *)row)[k] : (double)((const float *)row)[k];
}

static inline void motion_row_set(const motion_rows *rows, uint32_t place, uint32_t k, double value)
{
    void *row = motion_row(rows, place);
    if (rows->doubles)
        ((double *)row)[k] = value;
    else
        ((float *)row)[k] = (float)value;
}

#endif
