// SPDX-License-Identifier: MIT
#include "runtime/opencl/scan.h"

// Up to so many blocks each adds up those before it by itself, which spares a launch.
enum { MOST_ADDED_BLOCKS = 2048 };

const binding scan_bindings[] = {BIND_BUFFER(scan, "values", "uint *", values),
                                 BIND_BUFFER(scan, "to", "uint *", to),
                                 BIND_BUFFER(scan, "sums", "uint *", sums),
                                 BIND_VALUE(scan, "n", n),
                                 BIND_VALUE(scan, "n_blocks", n_blocks),
                                 BIND_VALUE(scan, "use_tops", use_tops),
                                 {0}};

void scan_close(scan *s)
{
    buffer_release(&s->sums);
    *s = (scan){0};
}

static uint32_t count_blocks(const scan *s, uint32_t n)
{
    uint32_t block = SCAN_BLOCK(s);
    return (uint32_t)(((uint64_t)n + block - 1) / block);
}

bool scan_reserve(scan *s, uint32_t n, duet_error *err)
{
    return buffer_reserve(&s->sums, s->device, count_blocks(s, n) * sizeof(uint32_t), err);
}

static void set_args(scan *s, const buffer *values, const buffer *to, uint32_t n)
{
    s->values = *values;
    s->to = *to;
    s->n = n;
    s->n_blocks = count_blocks(s, n);
    s->use_tops = s->n_blocks > MOST_ADDED_BLOCKS;
}

static bool run(scan *s, timeline *t, const char *stage, bool summed, duet_error *err)
{
    return (summed || timeline_launch(t, stage, s->block_sums, s->n, s, err)) &&
           (!s->use_tops || timeline_launch(t, stage, s->top_sums, 1, s, err)) &&
           timeline_launch(t, stage, s->blocks, s->n, s, err);
}

bool scan_run_summed(scan *s, timeline *t, const char *stage, const buffer *values,
                     const buffer *to, uint32_t n, duet_error *err)
{
    set_args(s, values, to, n);
    return run(s, t, stage, true, err);
}

bool scan_run(scan *s, timeline *t, const char *stage, const buffer *values, const buffer *to,
              uint32_t n, duet_error *err)
{
    set_args(s, values, to, n);
    return scan_reserve(s, n, err) && run(s, t, stage, false, err);
}
