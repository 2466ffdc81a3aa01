// SPDX-License-Identifier: MIT
// Parts of some rows by body or by contact, for who sends them: copied where they lie if the device
// works on host memory. Else the device brings them together, so that no others travel.
#include "kernels/dynamics/border.h"
#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_rows.h"

#include <string.h>

static const char stage[] = "domain";

// Parts of n rows of a buffer, each of so many words, that are moved.
typedef struct some_rows {
    motion_buffer which;
    uint32_t words;
    row_parts parts;
    domain_ids ids;
} some_rows;

static size_t packed_bytes(const some_rows *s)
{
    return (s->parts.words[0] + s->parts.words[1]) * sizeof(cl_uint);
}

// ---------------------------------------------------------------- in place

static bool open_rows(duet_motion *m, const some_rows *s, motion_rows *rows, duet_error *err)
{
    const uint32_t n = s->which == GHOSTS ? m->n : m->graph.n_contacts;
    return motion_words(m, s->which) > 0
               ? motion_rows_open(m, s->which, 0, m->n, rows, err)
               : motion_rows_of_words(m, s->which, n, s->words, rows, err);
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
    const uint32_t of_four[2] = {taken_of_four(parts), 4};
    for (int k = 0; k < 2; ++k) {
        copy_part(row + parts->at[k] * sizeof(cl_uint), packed, parts->words[k], of_four[k],
                  unpacks);
        packed += parts->words[k] * sizeof(cl_uint);
    }
}

static bool copy_in_place(duet_motion *m, const some_rows *s, char *packed, bool unpacks,
                          duet_error *err)
{
    motion_rows rows;
    if (!open_rows(m, s, &rows, err))
        return false;
    for (uint32_t i = 0; i < s->ids.n; ++i)
        copy_row(motion_row(&rows, s->ids.places[i]), packed + i * packed_bytes(s), &s->parts,
                 unpacks);
    return motion_rows_close(m, &rows, err);
}

// ---------------------------------------------------------------- by the device

// Places that no list has told of are sent with their rows.
static bool send_ids(duet_motion *m, const domain_ids *ids, duet_error *err)
{
    const size_t bytes = ids->n * sizeof *ids->places;
    motion_reading *r = &m->reading;
    bool ok =
        ids->listed != READ_IDS || ids->is_there ||
        (motion_reserve(m, READ_IDS, ids->n, sizeof *ids->places, err) &&
         timeline_write_at(&m->times, stage, &m->buffers[READ_IDS], 0, ids->places, bytes, err));
    r->row_ids = m->buffers[ids->listed];
    r->first_id = ids->first;
    r->n_ids = ids->n;
    return ok;
}

static bool prepare(duet_motion *m, const some_rows *s, duet_error *err)
{
    motion_reading *r = &m->reading;
    const row_parts *p = &s->parts;
    bool ok =
        motion_reserve(m, GATHERED, s->ids.n, packed_bytes(s), err) && send_ids(m, &s->ids, err);
    r->rows = m->buffers[s->which];
    r->row_words = s->words;
    r->of_four = taken_of_four(p);
    r->row_parts =
        (cl_int4){{(cl_int)p->at[0], (cl_int)p->words[0], (cl_int)p->at[1], (cl_int)p->words[1]}};
    return ok;
}

static bool pack(duet_motion *m, const some_rows *s, void *packed, duet_error *err)
{
    if (m->buffers[s->which].host)
        return copy_in_place(m, s, packed, false, err);
    return s->ids.n == 0 ||
           (prepare(m, s, err) && motion_launch(m, PACK_ROWS, err) &&
            motion_fetch(m, stage, GATHERED, 0, packed, s->ids.n * packed_bytes(s), err));
}

// Does not wait, though packed and places are the caller's (domain_await_rows).
static bool unpack(duet_motion *m, const some_rows *s, void *packed, duet_error *err)
{
    if (m->buffers[s->which].host)
        return copy_in_place(m, s, packed, true, err);
    return s->ids.n == 0 || (prepare(m, s, err) &&
                             timeline_write_at(&m->times, stage, &m->buffers[GATHERED], 0, packed,
                                               s->ids.n * packed_bytes(s), err) &&
                             motion_launch(m, UNPACK_ROWS, err));
}

// Rows of the host's memory are written in place.
bool domain_await_rows(duet_motion *m, duet_error *err)
{
    return m->buffers[CENTRES].host || timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- rows by body

// The buffer that rows went to takes the place of the other, which the driver keeps as long as a
// kernel reads it.
static bool move_rows(duet_motion *m, motion_buffer which, uint32_t n, duet_error *err)
{
    const uint32_t words = motion_words(m, which);
    if (!motion_reserve(m, GATHERED, n, words * sizeof(cl_uint), err))
        return false;
    m->reading.rows = m->buffers[which];
    m->reading.row_words = words;
    if (!motion_launch(m, GATHER_ROWS, err))
        return false;
    buffer_swap(&m->buffers[which], &m->buffers[GATHERED]);
    return true;
}

bool domain_move_rows(duet_motion *m, const motion_buffer *list, int n_list, const uint32_t *from,
                      uint32_t n, duet_error *err)
{
    bool ok =
        motion_reserve(m, READ_IDS, n, sizeof *from, err) &&
        timeline_write_at(&m->times, stage, &m->buffers[READ_IDS], 0, from, n * sizeof *from, err);
    m->reading.n_ids = n;
    for (int i = 0; ok && i < n_list; ++i)
        ok = motion_words(m, list[i]) == 0 || move_rows(m, list[i], n, err);
    return ok && timeline_finish(&m->times, err);
}

static some_rows rows_of(const duet_motion *m, motion_buffer which, const row_parts *parts,
                         const domain_ids *ids)
{
    const uint32_t words = which == GHOSTS ? GHOST_WORDS : motion_words(m, which);
    return (some_rows){which, words, parts ? *parts : (row_parts){.words = {words}}, *ids};
}

bool domain_pack_listed(duet_motion *m, motion_buffer which, const row_parts *parts,
                        const domain_ids *ids, void *packed, duet_error *err)
{
    const some_rows rows = rows_of(m, which, parts, ids);
    return pack(m, &rows, packed, err);
}

bool domain_unpack_listed(duet_motion *m, motion_buffer which, const row_parts *parts,
                          const domain_ids *ids, void *packed, duet_error *err)
{
    const some_rows rows = rows_of(m, which, parts, ids);
    return unpack(m, &rows, packed, err);
}

bool domain_pack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                      const uint32_t *places, uint32_t n, void *packed, duet_error *err)
{
    return domain_pack_listed(m, which, parts, &(domain_ids){places, n, READ_IDS, 0, false}, packed,
                              err);
}

bool domain_unpack_rows(duet_motion *m, motion_buffer which, const row_parts *parts,
                        const uint32_t *places, uint32_t n, void *packed, duet_error *err)
{
    return domain_unpack_listed(m, which, parts, &(domain_ids){places, n, READ_IDS, 0, false},
                                packed, err);
}

bool domain_list_ids(duet_motion *m, motion_buffer which, uint32_t at, const uint32_t *places,
                     uint32_t n, duet_error *err)
{
    return motion_extend(m, which, at * sizeof *places, (at + n) * sizeof *places, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[which], at * sizeof *places, places,
                             n * sizeof *places, err);
}

bool domain_pack_used(duet_motion *m, const domain_ids *ids, uint32_t *used, duet_error *err)
{
    const size_t bytes = ids->n * sizeof *used;
    memset(used, 0, bytes);
    if (ids->n == 0 || m->graph.n_contacts == 0 || !product_is_right(&m->products, PRODUCT_ROWS))
        return true;
    return motion_reserve(m, GATHERED, ids->n, sizeof *used, err) && send_ids(m, ids, err) &&
           motion_launch(m, USED_COLOURS, err) &&
           motion_fetch(m, stage, GATHERED, 0, used, bytes, err);
}

bool domain_read_used(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t *used,
                      duet_error *err)
{
    return domain_pack_used(m, &(domain_ids){places, n, READ_IDS, 0, false}, used, err);
}

// ---------------------------------------------------------------- contacts

bool domain_read_rows(duet_motion *m, domain_contacts *c, duet_error *err)
{
    const uint32_t record = m->layout.record;
    const domain_ids ids = {c->rows, c->n, READ_IDS, 0, false};
    const some_rows touches = {TOUCHES, 1, {.words = {1}}, ids},
                    colours = {COLOUR_OF, 1, {.words = {1}}, ids},
                    records = {CONTACTS, record, {.words = {record}}, ids};
    return pack(m, &touches, c->touches, err) && pack(m, &colours, c->colours, err) &&
           pack(m, &records, c->records, err);
}

bool domain_write_colours(duet_motion *m, const domain_contacts *told, duet_error *err)
{
    const some_rows colours = {
        COLOUR_OF, 1, {.words = {1}}, {told->rows, told->n, READ_IDS, 0, false}};
    return unpack(m, &colours, told->colours, err) && domain_await_rows(m, err);
}
