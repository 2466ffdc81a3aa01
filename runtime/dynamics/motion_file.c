// SPDX-License-Identifier: MIT
// A motion as a file: what it is, and all that its next step reads. A sum at
// the end tells a damaged file.
#include "runtime/dynamics/motion_check.h"
#include "runtime/dynamics/motion_file_commands.h"
#include "runtime/dynamics/recording.h"

#include "base/error.h"
#include "base/text_file.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

typedef struct header {
    char magic[16];
    uint32_t n;
    uint32_t dims;
    uint32_t doubles;
    uint32_t effects;
    uint32_t record;
    uint32_t n_contacts;
    uint32_t has_graph;
    float origin_edge;
    uint64_t step;
    uint64_t n_pairs;
} header;

// What follows is read where it lies, doubles first.
static_assert(sizeof(header) % sizeof(double) == 0, "doubles would lie askew");

// Commands have a part of their own, in files of motions that got some. Records of version 2
// do not say how a pair lay when its manifold was made.
static const char magic_2[16] = "duet motion 2\n";
static const char magic[16] = "duet motion 3\n";
static const char magic_commands[16] = "duet motion 4\n";

// By object first, then by contact. Rows are kept for those that sleep and for
// skins.
static const motion_buffer kept[] = {CENTRES,  CELLS,  VELOCITIES, ROTATIONS, ANGULAR_VELOCITIES,
                                     RESTS,    ASLEEP, BOXES,      STARTS,    RETURN_STARTS,
                                     RETURNS,  LINKS,  OTHERS,     CONTACTS,  TOUCHES,
                                     COLOUR_OF};

enum { N_KEPT = sizeof kept / sizeof kept[0] };

// Bytes of a buffer that count; 0 where the motion has none.
static size_t bytes_of(const duet_motion *m, motion_buffer which, uint32_t n_contacts)
{
    size_t rows = (m->effects & DUET_EFFECT_CONTACT) ? n_contacts : 0;
    size_t word = sizeof(uint32_t);
    switch (which) {
    case RETURNS:
    case OTHERS:
    case TOUCHES:
        return rows * word;
    case LINKS:
        return rows * 2 * word;
    case CONTACTS:
        return rows * m->layout.record * word;
    case COLOUR_OF:
        return (m->effects & DUET_EFFECT_CONTACT_RESPONSE) ? rows * word : 0;
    default:
        return ((size_t)m->n + 1) * motion_words(m, which) * word;
    }
}

static header header_of(const duet_motion *m)
{
    header h = {.n = m->n,
                .dims = m->def.dims,
                .doubles = m->def.doubles,
                .effects = m->effects,
                .record = m->layout.record,
                .n_contacts = m->n_contacts,
                .has_graph = product_was_made(&m->products, PRODUCT_ROWS),
                .origin_edge = m->def.origin_edge,
                .step = m->step,
                .n_pairs = m->n_pairs};
    memcpy(h.magic, m->commands ? magic_commands : magic, sizeof magic);
    return h;
}

static motion_saved parts_of(const duet_motion *m, const header *h, bool rows_stale,
                             const char *bytes, const char *path)
{
    motion_saved s = {.path = path,
                      .n_contacts = h->n_contacts,
                      .has_graph = h->has_graph,
                      .rows_stale = rows_stale,
                      .n_pairs = h->n_pairs};
    const char *at = bytes + sizeof *h;
    for (int i = 0; i < N_KEPT; ++i) {
        size_t size = bytes_of(m, kept[i], h->n_contacts);
        s.at[kept[i]] = size > 0 ? at : NULL;
        at += size;
    }
    return s;
}

// ---------------------------------------------------------------- saving

static bool add_buffer(duet_motion *m, motion_buffer which, text *file, duet_error *err)
{
    size_t bytes = bytes_of(m, which, m->n_contacts);
    if (bytes == 0)
        return true;
    char *host = malloc(bytes);
    if (!host)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu bytes", bytes);
    cl_int code = clEnqueueReadBuffer(m->device->queue, m->buffers[which].mem, CL_TRUE, 0, bytes,
                                      host, 0, NULL, NULL);
    if (code == CL_SUCCESS)
        text_add_bytes(file, host, bytes);
    free(host);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: fetching %zu bytes", m->device->info.selector, bytes);
}

static bool write_file(text *file, const char *path, duet_error *err)
{
    uint64_t sum = text_checksum(file->chars, file->length);
    text_add_bytes(file, (const char *)&sum, sizeof sum);
    return text_ok(file, err) && text_write_file(path, file->chars, file->length, err);
}

// What could not be loaded is told while the motion is still there.
bool duet_motion_save(duet_motion *m, const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) || !error_given(path, __func__, "path", err))
        return false;
    text file = {0};
    header h = header_of(m);
    text_add_bytes(&file, (const char *)&h, sizeof h);
    bool ok = timeline_finish(&m->times, err);
    for (int i = 0; ok && i < N_KEPT; ++i)
        ok = add_buffer(m, kept[i], &file, err);
    if (ok && text_ok(&file, err)) {
        motion_saved parts = parts_of(m, &h, motion_rows_are_stale(m), file.chars, path);
        ok = motion_check(m, &parts, err) && (!m->commands || motion_add_commands(m, &file, err)) &&
             write_file(&file, path, err);
    } else {
        ok = false;
    }
    text_free(&file);
    return ok;
}

// ---------------------------------------------------------------- loading

static bool check_header(const duet_motion *m, const header *h, const char *path, duet_error *err)
{
    const struct {
        const char *what;
        uint32_t file;
        uint32_t motion;
    } same[] = {
        {"objects", h->n, m->n},
        {"dimensions", h->dims, m->def.dims},
        {"doubles", h->doubles, m->def.doubles},
        {"effects", h->effects, m->effects},
        {"floats a contact", h->record, m->layout.record},
    };
    for (size_t i = 0; i < sizeof same / sizeof same[0]; ++i)
        if (same[i].file != same[i].motion)
            return error_set(err, DUET_STATUS_BAD_INPUT, "%s: %s: %u in the file, %u in the motion",
                             path, same[i].what, same[i].file, same[i].motion);
    return h->origin_edge == m->def.origin_edge ||
           error_set(err, DUET_STATUS_BAD_INPUT,
                     "%s: origin_edge: %g in the file, %g in the motion", path,
                     (double)h->origin_edge, (double)m->def.origin_edge);
}

// Bytes of the header and the buffers.
static size_t kept_bytes(const duet_motion *m, const header *h)
{
    size_t bytes = sizeof *h;
    for (int i = 0; i < N_KEPT; ++i)
        bytes += bytes_of(m, kept[i], h->n_contacts);
    return bytes;
}

static bool has_commands(const header *h)
{
    return memcmp(h->magic, magic_commands, sizeof magic_commands) == 0;
}

static bool is_version_2(const header *h)
{
    return memcmp(h->magic, magic_2, sizeof magic_2) == 0;
}

static bool read_header(const text *file, const char *path, header *h, duet_error *err)
{
    *h = (header){.n = 0};
    if (file->length >= sizeof *h + sizeof(uint64_t))
        memcpy(h, file->chars, sizeof *h);
    return has_commands(h) || is_version_2(h) || memcmp(h->magic, magic, sizeof magic) == 0 ||
           error_set(err, DUET_STATUS_BAD_INPUT, "%s: not a saved motion", path);
}

// m has as many objects as the file's commands say.
static bool check_file(const duet_motion *m, const text *file, const char *path, const header *h,
                       duet_error *err)
{
    if (!check_header(m, h, path, err))
        return false;
    uint64_t sum = 0;
    size_t end = file->length - sizeof sum, whole = kept_bytes(m, h);
    memcpy(&sum, file->chars + end, sizeof sum);
    if (has_commands(h) && whole <= end)
        whole += motion_commands_size(file->chars + whole, end - whole, h->n);
    return (end == whole && sum == text_checksum(file->chars, end)) ||
           error_set(err, DUET_STATUS_BAD_INPUT, "%s: the saved motion is cut short or damaged",
                     path);
}

// Where a pair lay unlike any pair can lie, its manifold is made anew in the next step.
enum { OLD_HEAD = AT_BASES };
static const float nowhere = 1e18f;

static void add_records(const duet_motion *m, const char *old, uint32_t old_record, uint32_t n,
                        text *to)
{
    const motion_layout *l = &m->layout;
    float record[64] = {0};
    assert(l->record <= sizeof record / sizeof *record);
    size_t points = (size_t)l->points * l->point * sizeof(float);
    for (uint32_t i = 0; i < n; ++i, old += old_record * sizeof(float)) {
        memcpy(record, old, OLD_HEAD * sizeof(float));
        for (int k = 0; k < 3; ++k)
            record[AT_OFFSET + k] = nowhere;
        memcpy(record + l->head, old + OLD_HEAD * sizeof(float), points);
        text_add_bytes(to, (const char *)record, l->record * sizeof(float));
    }
}

// Makes what version 2 wrote what it would be today.
static bool renew(const duet_motion *m, text *file, const char *path, header *h, duet_error *err)
{
    duet_motion as = *m;
    as.n = h->n;
    if (m->effects & DUET_EFFECT_CONTACT_RESPONSE)
        as.layout.record -= m->layout.head - OLD_HEAD;
    if (!check_file(&as, file, path, h, err))
        return false;
    text renewed = {0};
    const char *at = file->chars + sizeof *h;
    memcpy(h->magic, magic, sizeof magic);
    h->record = m->layout.record;
    text_add_bytes(&renewed, (const char *)h, sizeof *h);
    for (int i = 0; i < N_KEPT; ++i) {
        size_t bytes = bytes_of(&as, kept[i], h->n_contacts);
        if (kept[i] == CONTACTS && as.layout.record != m->layout.record && bytes > 0)
            add_records(m, at, as.layout.record, h->n_contacts, &renewed);
        else
            text_add_bytes(&renewed, at, bytes);
        at += bytes;
    }
    uint64_t sum = text_ok(&renewed, err) ? text_checksum(renewed.chars, renewed.length) : 0;
    text_add_bytes(&renewed, (const char *)&sum, sizeof sum);
    text_free(file);
    *file = renewed;
    return text_ok(file, err);
}

// As large as the motion's own, and space for the record after the last, as rows that
// are made have it.
static size_t capacity_of(const duet_motion *m, motion_buffer which, size_t bytes)
{
    size_t needed = bytes + m->layout.record * sizeof(float);
    return needed > m->buffers[which].bytes ? needed : m->buffers[which].bytes;
}

static bool put_buffer(duet_motion *m, buffer *to, size_t capacity, const void *from, size_t bytes,
                       duet_error *err)
{
    return buffer_reserve(to, m->device, capacity, err) &&
           timeline_fill(&m->times, "clear", to, 0, 0, capacity / sizeof(uint32_t), err) &&
           timeline_write_at(&m->times, "send", to, 0, from, bytes, err);
}

static bool put_all(duet_motion *m, const motion_saved *s, buffer fresh[], duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && i < N_KEPT; ++i) {
        motion_buffer which = kept[i];
        size_t bytes = bytes_of(m, which, s->n_contacts);
        ok = bytes == 0 ||
             put_buffer(m, &fresh[which], capacity_of(m, which, bytes), s->at[which], bytes, err);
    }
    return ok && timeline_finish(&m->times, err);
}

// Into buffers of their own first: a device that fails on the way leaves the motion as
// it was.
static bool replace_all(duet_motion *m, const motion_saved *s, duet_error *err)
{
    buffer fresh[MOTION_BUFFERS] = {{0}};
    bool ok = put_all(m, s, fresh, err);
    timeline_clear(&m->times);
    for (int which = 0; which < MOTION_BUFFERS; ++which) {
        buffer before = m->buffers[which];
        if (ok && fresh[which].mem) {
            m->buffers[which] = fresh[which];
            fresh[which] = before;
        }
        buffer_release(&fresh[which]);
    }
    return ok;
}

static bool put_parts(duet_motion *m, const text *file, const char *path, const header *h,
                      bool rows_stale, duet_error *err)
{
    motion_saved parts = parts_of(m, h, rows_stale, file->chars, path);
    return motion_check(m, &parts, err) && timeline_finish(&m->times, err) &&
           replace_all(m, &parts, err);
}

// Into a motion of other objects than the file's, beside it first.
static bool replace_objects(duet_motion *m, const text *file, const char *path, const header *h,
                            duet_error *err)
{
    if (!timeline_finish(&m->times, err)) // what it waits for is not to be released twice
        return false;
    duet_motion as = *m;
    as.n = has_commands(h) ? h->n : m->commands->given.n;
    as.products = products_of_saved(h->has_graph);
    as.altered.n = 0;
    if (!check_file(&as, file, path, h, err))
        return false;
    const char *commands = has_commands(h) ? file->chars + kept_bytes(&as, h) : NULL;
    bool ok = motion_take_commands(&as, commands, path, err) &&
              put_parts(&as, file, path, h, motion_rows_are_stale(&as), err);
    if (ok)
        motion_adopt(m, &as);
    else
        motion_forget_copy(&as);
    return ok;
}

bool duet_motion_load(duet_motion *m, const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_loadable(m, __func__, err) || !error_given(path, __func__, "path", err))
        return false;
    text file = {0};
    header h;
    bool ok = text_read_file(&file, path, err) && read_header(&file, path, &h, err) &&
              (!is_version_2(&h) || renew(m, &file, path, &h, err));
    if (ok && (has_commands(&h) || m->commands)) {
        ok = replace_objects(m, &file, path, &h, err);
    } else {
        ok = ok && check_file(m, &file, path, &h, err) && put_parts(m, &file, path, &h, false, err);
        if (ok)
            m->products = products_of_saved(h.has_graph);
    }
    text_free(&file);
    if (!ok)
        return false;
    motion_forget_recording(m);
    motion_forget_maps(m);
    motion_forget_events(&m->told);
    m->told.touching.n = 0;
    m->reading.n_told = 0;
    m->step = h.step;
    m->n_contacts = h.n_contacts;
    m->n_pairs = h.n_pairs;
    motion_mend(m);
    return true;
}
