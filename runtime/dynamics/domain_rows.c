// SPDX-License-Identifier: MIT
// Parts of some rows by body or by contact, for who sends them: copied where they lie if the device
// works on host memory. Else the device brings them together, so that no others travel.
#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_rows.h"

#include <string.h>

static const char stage[] = "domain";

// Parts of n rows of a buffer, each of so many words, that are moved.
typedef struct some_rows {
    motion_buffer which;
    uint32_t words;
    row_parts parts;
    const uint32_t *places;
    uint32_t n;
} some_rows;

static size_t packed_bytes(const some_rows *s)
{
    return (s->parts.words[0] + s->parts.words[1]) * sizeof(cl_uint);
}

// ---------------------------------------------------------------- in place

static bool open_rows(duet_motion *m, const some_rows *s, motion_rows *rows, duet_error *err)
{
    return motion_words(m, s->which) > 0
               ? motion_rows_open(m, s->which, 0, m->n, rows, err)
               : motion_rows_of_contacts(m, s->which, s->words, rows, err);
}

static uint32_t taken_of_four(const row_parts *parts)
{
    return parts->of_four > 0 ? parts->of_four : 4;
}

static void copy_part(char *part, char *packed, uint32_t words, uint32_t of_four, bool unpacks)
{
    for (uint32_t k = 0; k < words; k += of_four) {
        const size_t bytes = (words - k < of_four ? words - k : of_four) * sizeof(cl_uint);
        char *one = part + k / of_four * 4 * sizeof(cl_uint);
        memcpy(unpacks ? one : packed, unpacks ? packed : one, bytes);
        packed += bytes;
    }
}

static void copy_row(char *row, char *packed, const row_parts *parts, bool unpacks)
{
    for (int k = 0; k < 2; ++k) {
        copy_part(row + parts->at[k] * sizeof(cl_uint), packed, parts->words[k],
                  taken_of_four(parts), unpacks);
        packed += parts->words[k] * sizeof(cl_uint);
    }
}

static bool copy_in_place(duet_motion *m, const some_rows *s, char *packed, bool unpacks,
                          duet_error *err)
{
    motion_rows rows;
    if (!open_rows(m, s, &rows, err))
        return false;
    for (uint32_t i = 0; i < s->n; ++i)
        copy_row(motion_row(&rows, s->places[i]), packed + i * packed_bytes(s), &s->parts, unpacks);
    return motion_rows_close(m, &rows, err);
}

// ---------------------------------------------------------------- by the device

static bool build(duet_motion *m, duet_error *err)
{
    motion_reading *r = &m->reading;
    const kernel_request list[] = {
        {&r->pack_rows, true, "row_parts", "pack_rows", motion_bindings},
        {&r->unpack_rows, true, "row_parts", "unpack_rows", motion_bindings},
        {&r->move_rows, true, "row_parts", "move_rows", motion_bindings},
    };
    return (r->pack_rows && r->unpack_rows && r->move_rows) ||
           motion_build_kernels(m, list, sizeof list / sizeof *list, false, err);
}

static bool prepare(duet_motion *m, const some_rows *s, duet_error *err)
{
    motion_reading *r = &m->reading;
    const row_parts *p = &s->parts;
    const size_t bytes = s->n * sizeof *s->places;
    bool ok = build(m, err) && motion_reserve(m, READ_IDS, s->n, sizeof *s->places, err) &&
              motion_reserve(m, GATHERED, s->n, packed_bytes(s), err) &&
              timeline_write_at(&m->times, stage, &m->buffers[READ_IDS], 0, s->places, bytes, err);
    r->rows = m->buffers[s->which];
    r->row_words = s->words;
    r->n_ids = s->n;
    r->of_four = taken_of_four(p);
    r->row_parts =
        (cl_int4){{(cl_int)p->at[0], (cl_int)p->words[0], (cl_int)p->at[1], (cl_int)p->words[1]}};
    return ok;
}

static bool pack(duet_motion *m, const some_rows *s, void *packed, duet_error *err)
{
    if (m->buffers[s->which].host)
        return copy_in_place(m, s, packed, false, err);
    return s->n == 0 ||
           (prepare(m, s, err) && motion_launch(m, stage, m->reading.pack_rows, s->n, err) &&
            motion_fetch(m, stage, GATHERED, 0, packed, s->n * packed_bytes(s), err));
}

// Does not wait, though packed and places are the caller's (domain_await_rows).
static bool unpack(duet_motion *m, const some_rows *s, void *packed, duet_error *err)
{
    if (m->buffers[s->which].host)
        return copy_in_place(m, s, packed, true, err);
    return s->n == 0 || (prepare(m, s, err) &&
                         timeline_write_at(&m->times, stage, &m->buffers[GATHERED], 0, packed,
                                           s->n * packed_bytes(s), err) &&
                         motion_launch(m, stage, m->reading.unpack_rows, s->n, err));
}

// Rows of the host's memory are written in place.
bool domain_await_rows(duet_motion *m, duet_error *err)
{
    return m->buffers[CENTRES].host || timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- rows by body

// The buffer that rows went to takes the place of the other.
static bool move_rows(duet_motion *m, motion_buffer which, uint32_t n, duet_error *err)
{
    const uint32_t words = motion_words(m, which);
    if (!motion_reserve(m, GATHERED, n, words * sizeof(cl_uint), err))
        return false;
    m->reading.rows = m->buffers[which];
    m->reading.row_words = words;
    if (!motion_launch(m, stage, m->reading.move_rows, n, err) || !timeline_finish(&m->times, err))
        return false;
    buffer_swap(&m->buffers[which], &m->buffers[GATHERED]);
    return true;
}

bool domain_move_rows(duet_motion *m, const motion_buffer *list, int n_list, const uint32_t *from,
                      uint32_t n, duet_error *err)
{
    bool ok =
        build(m, err) && motion_reserve(m, READ_IDS, n, sizeof *from, err) &&
        timeline_write_at(&m->times, stage, &m->buffers[READ_IDS], 0, from, n * sizeof *from, err);
    m->reading.n_ids = n;
    for (int i = 0; ok && i < n_list; ++i)
        ok = motion_words(m, list[i]) == 0 || move_rows(m, list[i], n, err);
    return ok;
}

bool domain_pack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                      const uint32_t *places, uint32_t n, void *packed, duet_error *err)
{
    return pack(m, &(some_rows){which, motion_words(m, which), *parts, places, n}, packed, err);
}

bool domain_unpack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                        const uint32_t *places, uint32_t n, void *packed, duet_error *err)
{
    return unpack(m, &(some_rows){which, motion_words(m, which), *parts, places, n}, packed, err);
}

// ---------------------------------------------------------------- contacts

typedef bool move_some(duet_motion *m, const some_rows *s, void *packed, duet_error *err);

static bool move_contacts(duet_motion *m, const domain_contacts *c, move_some *move,
                          duet_error *err)
{
    const uint32_t record = m->layout.record;
    const some_rows touches = {TOUCHES, 1, {.words = {1}}, c->rows, c->n},
                    colours = {COLOUR_OF, 1, {.words = {1}}, c->rows, c->n},
                    records = {CONTACTS, record, {.words = {record}}, c->rows, c->n};
    return move(m, &touches, c->touches, err) && move(m, &colours, c->colours, err) &&
           move(m, &records, c->records, err);
}

bool domain_read_rows(duet_motion *m, domain_contacts *c, duet_error *err)
{
    return move_contacts(m, c, pack, err);
}

bool domain_write_rows(duet_motion *m, const domain_contacts *c, duet_error *err)
{
    return move_contacts(m, c, unpack, err) && domain_await_rows(m, err);
}

bool domain_write_colours(duet_motion *m, const domain_contacts *told, duet_error *err)
{
    const some_rows colours = {COLOUR_OF, 1, {.words = {1}}, told->rows, told->n};
    return unpack(m, &colours, told->colours, err) && domain_await_rows(m, err);
}
