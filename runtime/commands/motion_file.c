// SPDX-License-Identifier: MIT
// A motion as a file: what it is, and all that its next step reads. A sum at the end tells a
// damaged file.
#include "runtime/commands/kept_motion.h"
#include "runtime/commands/motion_check.h"
#include "runtime/commands/saved_motion.h"

#include "base/error.h"
#include "base/output.h"
#include "base/text_file.h"
#include "runtime/bodies/ground_def.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

// The data behind the head are read where they lie: vectors of four words.
static_assert(sizeof(saved_head) == 240 && sizeof(saved_head) % sizeof(cl_int4) == 0,
              "no byte of a file is left to chance");

static const char magic[16] = "duet motion 2\n";

// By object first, then by contact. Rows are kept for those that sleep and for
// skins.
static const motion_buffer kept[] = {CENTRES,  CELLS,  VELOCITIES, ROTATIONS, ANGULAR_VELOCITIES,
                                     RESTS,    ASLEEP, BOXES,      STARTS,    RETURN_STARTS,
                                     RETURNS,  LINKS,  OTHERS,     CONTACTS,  TOUCHES,
                                     COLOUR_OF};

enum { N_KEPT = sizeof kept / sizeof kept[0] };

// Bytes that a file has of a buffer; 0 if the motion has no such buffer.
static size_t bytes_of(const duet_motion *m, const saved_head *h, motion_buffer which)
{
    size_t rows = (m->effects & DUET_EFFECT_CONTACT) ? h->n_contacts : 0;
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
        return ((size_t)h->n + 1) * motion_words(m, which) * word;
    }
}

static saved_head head_of(const duet_motion *m)
{
    const motion_commands *c = m->commands;
    saved_head h = {.n = m->n,
                    .dims = m->def.dims,
                    .doubles = m->def.doubles,
                    .effects = m->effects,
                    .record = m->layout.record,
                    .n_contacts = m->graph.n_contacts,
                    .has_graph = product_was_made(&m->products, PRODUCT_ROWS),
                    .rows_stale = product_is_forgotten(&m->products, PRODUCT_PAIRS),
                    .n_targets = c ? c->n_targets : 0,
                    .pushed = c && c->n_pushed > 0,
                    .origin_edge = m->def.origin_edge,
                    .step = m->step,
                    .n_pairs = m->graph.n_pairs,
                    .margin = m->margin,
                    .def = packed_def_of(&m->def)};
    memcpy(h.magic, magic, sizeof magic);
    saved_ground_count(m, &h);
    return h;
}

static motion_saved parts_of(const duet_motion *m, const saved_head *h, const char *bytes,
                             const char *path)
{
    motion_saved s = {.path = path,
                      .n_contacts = h->n_contacts,
                      .has_graph = h->has_graph,
                      .rows_stale = h->rows_stale,
                      .n_pairs = h->n_pairs};
    const char *at = bytes + sizeof *h;
    for (int i = 0; i < N_KEPT; ++i) {
        size_t size = bytes_of(m, h, kept[i]);
        s.at[kept[i]] = size > 0 ? at : NULL;
        at += size;
    }
    return s;
}

// ---------------------------------------------------------------- saving

static bool add_buffer(duet_motion *m, const saved_head *h, motion_buffer which, text *file,
                       duet_error *err)
{
    size_t bytes = bytes_of(m, h, which);
    if (bytes == 0)
        return true;
    char *host = malloc(bytes);
    if (!host)
        return no_memory(err, "%zu bytes", bytes);
    cl_int code = clEnqueueReadBuffer(m->device->queue, m->buffers[which].mem, CL_TRUE, 0, bytes,
                                      host, 0, NULL, NULL);
    if (code == CL_SUCCESS)
        text_add_bytes(file, host, bytes);
    free(host);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: fetching %zu bytes", m->device->info.selector, bytes);
}

// The points that a contact does not have.
static void clear_points(const duet_motion *m, const motion_saved *s, char *contacts)
{
    const uint32_t *touches = s->at[TOUCHES];
    const uint32_t record = m->layout.record;
    char *row = contacts;
    for (uint32_t i = 0; i < s->n_contacts; ++i, row += record * sizeof(float)) {
        uint32_t points = touches[i] & TOUCH_POINTS;
        uint32_t used = points > 0 ? m->layout.head + points * m->layout.point : 0;
        if (used < record)
            memset(row + used * sizeof(float), 0, (record - used) * sizeof(float));
    }
}

// Contacts with walls have no return.
static void clear_returns(const duet_motion *m, const motion_saved *s, char *returns)
{
    const uint32_t used = ((const uint32_t *)s->at[RETURN_STARTS])[m->n];
    if (used < s->n_contacts)
        memset(returns + used * sizeof(uint32_t), 0, (s->n_contacts - used) * sizeof(uint32_t));
}

// Zeroes what no step reads. Buffers hold there what they held before, and equal states shall have
// equal bytes.
static void clear_spare(const duet_motion *m, const motion_saved *s, char *bytes)
{
    if (!s->at[CONTACTS])
        return;
    clear_points(m, s, bytes + ((const char *)s->at[CONTACTS] - bytes));
    clear_returns(m, s, bytes + ((const char *)s->at[RETURNS] - bytes));
}

static bool write_file(text *file, const char *path, duet_error *err)
{
    uint64_t sum = text_checksum(file->chars, file->length);
    text_add_bytes(file, (const char *)&sum, sizeof sum);
    output o;
    if (!text_ok(file, err))
        return false;
    bool ok = output_open(&o, path, err);
    if (ok)
        fwrite(file->chars, 1, file->length, o.stream); // a failure stays with the stream
    ok = ok && output_sync(&o, err);
    return output_close(&o, ok, err);
}

// Adds head and buffers.
static bool add_buffers(duet_motion *m, const saved_head *h, text *file, duet_error *err)
{
    text_add_bytes(file, (const char *)h, sizeof *h);
    bool ok = timeline_finish(&m->times, err);
    for (int i = 0; ok && i < N_KEPT; ++i)
        ok = add_buffer(m, h, kept[i], file, err);
    return ok && text_ok(file, err);
}

static bool add_rest(duet_motion *m, text *file, duet_error *err)
{
    bool ok = saved_places_add(m, file, err);
    saved_ground_add(m, file);
    return ok && text_ok(file, err);
}

// A file that could not be loaded is told while the motion is still there.
bool duet_motion_save(duet_motion *m, const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) || !error_given(path, __func__, "path", err))
        return false;
    text file = {0};
    saved_head h = head_of(m);
    bool ok = add_buffers(m, &h, &file, err);
    if (ok) {
        motion_saved parts = parts_of(m, &h, file.chars, path);
        clear_spare(m, &parts, file.chars);
        ok =
            motion_check(m, &parts, err) && add_rest(m, &file, err) && write_file(&file, path, err);
    }
    text_free(&file);
    return ok;
}

bool motion_keep(duet_motion *m, text *to, duet_error *err)
{
    const saved_head h = head_of(m);
    to->length = 0;
    return add_buffers(m, &h, to, err) && add_rest(m, to, err);
}

// ---------------------------------------------------------------- loading

// A skin changes no bits.
static uint32_t effects_but_skin(uint32_t effects)
{
    return effects & ~(uint32_t)DUET_EFFECT_SKIN;
}

static bool check_head(const duet_motion *m, const saved_head *h, const char *path, duet_error *err)
{
    const struct {
        const char *what;
        double file, motion;
    } same[] = {
        {"dimensions", h->dims, m->def.dims},
        {"doubles", h->doubles, m->def.doubles},
        {"effects", effects_but_skin(h->effects), effects_but_skin(m->effects)},
        {"floats a contact", h->record, m->layout.record},
        {"origin_edge", (double)h->origin_edge, (double)m->def.origin_edge},
        {"grounds", h->ground[0] > 0, saved_ground_is_kept(m)},
        {"meshes", h->has_mesh, saved_ground_is_kept(m) && m->def.mesh},
        {"slop", h->margin / MOTION_SLOPS, m->margin / MOTION_SLOPS},
    };
    for (size_t i = 0; i < sizeof same / sizeof same[0]; ++i)
        if (same[i].file != same[i].motion)
            return bad_input(err,
                             "%s: %s: %.10g in the file, %.10g in the motion; expected a motion "
                             "saved of the same scene",
                             path, same[i].what, same[i].file, same[i].motion);
    return true;
}

// Bytes of the head and the buffers.
static size_t kept_bytes(const duet_motion *m, const saved_head *h)
{
    size_t bytes = sizeof *h;
    for (int i = 0; i < N_KEPT; ++i)
        bytes += bytes_of(m, h, kept[i]);
    return bytes;
}

static bool check_whole(const duet_motion *m, const saved_head *h, const text *file,
                        const char *path, duet_error *err)
{
    uint64_t sum = 0;
    size_t end = file->length - sizeof sum;
    memcpy(&sum, file->chars + end, sizeof sum);
    return (end == kept_bytes(m, h) + saved_places_size(h) + saved_ground_size(h) &&
            sum == text_checksum(file->chars, end)) ||
           bad_input(err, "%s: the saved motion is cut short or damaged", path);
}

static bool read_head(saved_head *h, const text *file, const char *path, duet_error *err)
{
    if (!text_check_magic(file, magic, path, err))
        return false;
    if (file->length < sizeof *h + sizeof(uint64_t))
        return bad_input(err, "%s: the saved motion is cut short or damaged", path);
    memcpy(h, file->chars, sizeof *h);
    return true;
}

static bool put_buffer(duet_motion *m, buffer *to, const void *from, size_t bytes, duet_error *err)
{
    // Space for the record after the last, as rows that are made have it.
    size_t capacity = bytes + m->layout.record * sizeof(float);
    capacity = capacity > to->bytes ? capacity : to->bytes;
    return buffer_reserve(to, m->device, capacity, err) &&
           timeline_fill(&m->times, "clear", to, 0, 0, capacity / sizeof(uint32_t), err) &&
           timeline_write_at(&m->times, "send", to, 0, from, bytes, err);
}

static bool put_buffers(duet_motion *m, const saved_head *h, const motion_saved *s, duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && i < N_KEPT; ++i)
        if (s->at[kept[i]])
            ok = put_buffer(m, &m->buffers[kept[i]], s->at[kept[i]], bytes_of(m, h, kept[i]), err);
    return ok && timeline_finish(&m->times, err);
}

static void take_counts(duet_motion *copy, const saved_head *h)
{
    copy->step = h->step;
    copy->graph.n_contacts = h->n_contacts;
    copy->graph.n_without = 0;
    copy->graph.n_pairs = (cl_uint)h->n_pairs;
    copy->products = products_of_saved(h->has_graph);
    altered_forget(&copy->altered);
    // Bounds with a skin reach further; and rows of a ground that moves are made again, of pairs.
    if (h->rows_stale || h->effects != copy->effects || ground_def_carrier(&copy->def) > 0)
        motion_alter_all(copy);
    motion_forget_events(&copy->told);
    copy->told.touching.n = 0;
    copy->reading.n_told = 0;
}

static bool fill_copy(duet_motion *copy, const saved_head *h, const char *bytes, const char *path,
                      duet_error *err)
{
    const motion_saved parts = parts_of(copy, h, bytes, path);
    if (!motion_check(copy, &parts, err) || !put_buffers(copy, h, &parts, err))
        return false;
    take_counts(copy, h);
    return true;
}

// Maps are of the buffers that go.
static void adopt(duet_motion *m, duet_motion *copy)
{
    motion_forget_maps(m);
    copy->maps = NULL;
    copy->mapped = 0;
    saved_copy_adopt(m, copy);
}

static bool replace(duet_motion *m, const saved_head *h, const char *bytes, const char *path,
                    duet_error *err)
{
    duet_motion copy = saved_copy_begin(m, h->n);
    bool ok = saved_places_take(&copy, h, bytes + kept_bytes(m, h), path, err) &&
              fill_copy(&copy, h, bytes, path, err);
    timeline_clear(&copy.times);
    if (ok)
        adopt(m, &copy);
    else
        saved_copy_free(&copy);
    return ok;
}

// Events of the motion's timeline are released before the copy has them, too.
static bool load(duet_motion *m, const saved_head *h, const text *file, const char *path,
                 duet_error *err)
{
    if (!timeline_finish(&m->times, err) || !replace(m, h, file->chars, path, err))
        return false;
    motion_forget_recording(m);
    motion_mend(m);
    return true;
}

bool duet_motion_load(duet_motion *m, const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_loadable(m, __func__, err) || !error_given(path, __func__, "path", err))
        return false;
    text file = {0};
    saved_head h;
    bool ok = text_read_file(&file, path, err) && read_head(&h, &file, path, err) &&
              check_head(m, &h, path, err) && check_whole(m, &h, &file, path, err) &&
              load(m, &h, &file, path, err);
    text_free(&file);
    return ok;
}

bool motion_return(duet_motion *m, const text *from, duet_error *err)
{
    saved_head h;
    memcpy(&h, from->chars, sizeof h);
    return load(m, &h, from, "a kept state", err);
}
