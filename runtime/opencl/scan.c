// SPDX-License-Identifier: MIT
#include "runtime/opencl/scan.h"

// Up to so many blocks each adds up those before it by itself, which spares a launch.
enum { MOST_ADDED_BLOCKS = 2048 };

const binding scan_bindings[] = {BIND_BUFFER(scan, "values", "uint *", values),
                                 BIND_BUFFER(scan, "to", "uint *", to),
                                 BIND_BUFFER(scan, "sums", "uint *", sums),
                                 BIND_BUFFER(scan, "told", "uint *", told),
                                 BIND_VALUE(scan, "n", n),
                                 BIND_VALUE(scan, "n_blocks", n_blocks),
                                 BIND_VALUE(scan, "use_tops", use_tops),
                                 BIND_VALUE(scan, "stamp", stamp),
                                 {0}};

void scan_close(scan *s)
{
    buffer_release(&s->sums);
    buffer_release(&s->told);
    *s = (scan){0};
}

// ---------------------------------------------------------------- blocks, on a GPU

static uint32_t divided(uint32_t n, uint32_t by)
{
    return (uint32_t)(((uint64_t)n + by - 1) / by);
}

static bool run_blocks(scan *s, timeline *t, const char *stage, duet_error *err)
{
    s->n_blocks = divided(s->n, s->blocks->group * s->blocks->per_item);
    s->use_tops = s->n_blocks > MOST_ADDED_BLOCKS;
    return buffer_reserve(&s->sums, s->device, s->n_blocks * sizeof(uint32_t), err) &&
           timeline_launch(t, stage, s->block_sums, s->n, s, err) &&
           (!s->use_tops || timeline_launch(t, stage, s->top_sums, 1, s, err)) &&
           timeline_launch(t, stage, s->blocks, s->n, s, err);
}

// ---------------------------------------------------------------- parts, on a CPU

// A part has at least so many values.
enum { LEAST_PART = 4096 };

// Stamps begin anew with new words, and before there is no next one. New words are larger; their
// handle may be that of those before.
static bool begin_stamp(scan *s, timeline *t, const char *stage, uint32_t parts, duet_error *err)
{
    const size_t before = s->told.bytes;
    if (!buffer_reserve(&s->told, s->device, parts * 2 * sizeof(uint32_t), err))
        return false;
    if (s->told.bytes == before && s->stamp < UINT32_MAX) {
        ++s->stamp;
        return true;
    }
    s->stamp = UINT32_MAX; // until the words are zeroed
    if (!timeline_fill(t, stage, &s->told, 0, 0, s->told.bytes / sizeof(uint32_t), err))
        return false;
    s->stamp = 1;
    return true;
}

// Each thread has a part, whole groups.
static bool run_at_once(scan *s, timeline *t, const char *stage, duet_error *err)
{
    const kernel *k = s->at_once;
    const uint32_t most = divided(s->n, LEAST_PART), units = s->device->info.units;
    const uint32_t parts = divided(units > 0 && units < most ? units : most, k->group) * k->group;
    return begin_stamp(s, t, stage, parts, err) &&
           timeline_launch(t, stage, k, (uint64_t)parts * k->per_item, s, err);
}

bool scan_run(scan *s, timeline *t, const char *stage, const buffer *values, const buffer *to,
              uint32_t n, duet_error *err)
{
    s->values = *values;
    s->to = *to;
    s->n = n;
    return s->at_once ? run_at_once(s, t, stage, err) : run_blocks(s, t, stage, err);
}
