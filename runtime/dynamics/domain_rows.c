// SPDX-License-Identifier: MIT
// Parts of some bodies' rows, for who sends them: copied where they lie if the device works on host
// memory. Else the device brings them together, so that no others travel.
#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_rows.h"

#include <string.h>

static const char stage[] = "domain";

static size_t packed_bytes(const row_parts *parts)
{
    return (parts->words[0] + parts->words[1]) * sizeof(cl_uint);
}

// ---------------------------------------------------------------- in place

static void copy_row(char *row, char *packed, const row_parts *parts, bool unpacks)
{
    for (int k = 0; k < 2; ++k) {
        char *part = row + parts->at[k] * sizeof(cl_uint);
        const size_t bytes = parts->words[k] * sizeof(cl_uint);
        memcpy(unpacks ? part : packed, unpacks ? packed : part, bytes);
        packed += bytes;
    }
}

static bool copy_in_place(duet_motion *m, motion_buffer which, const row_parts *parts,
                          const uint32_t *places, uint32_t n, char *packed, bool unpacks,
                          duet_error *err)
{
    motion_rows rows;
    if (!motion_rows_open(m, which, 0, m->n, &rows, err))
        return false;
    for (uint32_t i = 0; i < n; ++i)
        copy_row(motion_row(&rows, places[i]), packed + i * packed_bytes(parts), parts, unpacks);
    return motion_rows_close(m, &rows, err);
}

// ---------------------------------------------------------------- by the device

static bool prepare(duet_motion *m, motion_buffer which, const row_parts *parts,
                    const uint32_t *places, uint32_t n, duet_error *err)
{
    motion_reading *r = &m->reading;
    const kernel_request list[] = {
        {&r->pack_rows, true, "row_parts", "pack_rows", motion_bindings},
        {&r->unpack_rows, true, "row_parts", "unpack_rows", motion_bindings},
    };
    bool ok = (r->pack_rows && r->unpack_rows) ||
              motion_build_kernels(m, list, sizeof list / sizeof *list, false, err);
    ok = ok && motion_reserve(m, READ_IDS, n, sizeof *places, err) &&
         motion_reserve(m, GATHERED, n, packed_bytes(parts), err) &&
         timeline_write_at(&m->times, stage, &m->buffers[READ_IDS], 0, places, n * sizeof *places,
                           err);
    r->rows = m->buffers[which];
    r->row_words = motion_words(m, which);
    r->n_ids = n;
    r->row_parts = (cl_int4){{(cl_int)parts->at[0], (cl_int)parts->words[0], (cl_int)parts->at[1],
                              (cl_int)parts->words[1]}};
    return ok;
}

bool domain_pack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                      const uint32_t *places, uint32_t n, void *packed, duet_error *err)
{
    if (m->buffers[which].host)
        return copy_in_place(m, which, parts, places, n, packed, false, err);
    return prepare(m, which, parts, places, n, err) &&
           motion_launch(m, stage, m->reading.pack_rows, n, err) &&
           motion_fetch(m, stage, GATHERED, 0, packed, n * packed_bytes(parts), err);
}

bool domain_unpack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                        const uint32_t *places, uint32_t n, void *packed, duet_error *err)
{
    if (m->buffers[which].host)
        return copy_in_place(m, which, parts, places, n, packed, true, err);
    return prepare(m, which, parts, places, n, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[GATHERED], 0, packed,
                             n * packed_bytes(parts), err) &&
           motion_launch(m, stage, m->reading.unpack_rows, n, err);
}
