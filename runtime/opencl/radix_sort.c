// SPDX-License-Identifier: MIT
#include "runtime/opencl/radix_sort.h"

const binding radix_bindings[] = {BIND_BUFFER(radix_sort, "keys_in", "uint *", keys_in),
                                  BIND_BUFFER(radix_sort, "ids_in", "uint *", ids_in),
                                  BIND_BUFFER(radix_sort, "keys_out", "uint *", keys_out),
                                  BIND_BUFFER(radix_sort, "ids_out", "uint *", ids_out),
                                  BIND_BUFFER(radix_sort, "tiles", "uint *", tiles),
                                  BIND_VALUE(radix_sort, "n", n),
                                  BIND_VALUE(radix_sort, "shift", shift),
                                  BIND_VALUE(radix_sort, "first_pass", first_pass),
                                  {0}};

void radix_sort_close(radix_sort *r)
{
    buffer_release(&r->tiles);
    *r = (radix_sort){0};
}

static bool run_pass(radix_sort *r, timeline *t, const char *stage, const radix_lists *lists,
                     uint32_t bits, duet_error *err)
{
    uint32_t tile = r->count->group * r->count->per_item;
    uint32_t n_counts = (uint32_t)(((uint64_t)r->n + tile - 1) / tile) << bits;
    r->keys_in = *lists->keys;
    r->ids_in = *lists->ids;
    r->keys_out = *lists->keys_spare;
    r->ids_out = *lists->ids_spare;
    bool ok = buffer_reserve(&r->tiles, r->device, n_counts * sizeof(uint32_t), err) &&
              timeline_launch(t, stage, r->count, r->n, r, err) &&
              scan_run(r->scan, t, stage, &r->tiles, &r->tiles, n_counts, err) &&
              timeline_launch(t, stage, r->move, r->n, r, err);
    buffer_swap(lists->keys, lists->keys_spare);
    buffer_swap(lists->ids, lists->ids_spare);
    return ok;
}

static bool run(radix_sort *r, timeline *t, const char *stage, const radix_lists *lists,
                uint32_t bits, bool given, duet_error *err)
{
    uint32_t digit = (uint32_t)kernel_param(r->count, "BITS");
    bool ok = true;
    for (r->shift = 0; ok && r->shift < bits; r->shift += digit) {
        r->first_pass = !given && r->shift == 0;
        ok = run_pass(r, t, stage, lists, digit, err);
    }
    return ok;
}

bool radix_sort_run(radix_sort *r, timeline *t, const char *stage, const radix_lists *lists,
                    uint32_t n, uint32_t bits, duet_error *err)
{
    r->n = n;
    return run(r, t, stage, lists, bits, false, err);
}

bool radix_sort_ids(radix_sort *r, timeline *t, const char *stage, const radix_lists *lists,
                    uint32_t n, uint32_t bits, duet_error *err)
{
    r->n = n;
    return run(r, t, stage, lists, bits, true, err);
}
