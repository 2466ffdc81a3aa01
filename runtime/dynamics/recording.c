// SPDX-License-Identifier: MIT
#include "runtime/dynamics/recording.h"

#include "base/error.h"
#include "base/text_file.h"
#include "runtime/dynamics/motion_commands.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static_assert(sizeof(recording_head) == 48 && sizeof(recorded) == 16,
              "no byte of a file is left to chance");

const char recording_magic[16] = "duet commands 1\n";

size_t recorded_row(uint32_t kind)
{
    static const size_t sizes[RECORDED_KINDS] = {
        [RECORDED_ADD] = sizeof(duet_pose) + sizeof(packed_body),
        [RECORDED_USER_DATA] = sizeof(uint64_t),
        [RECORDED_BODIES] = sizeof(packed_body),
        [RECORDED_POSES] = sizeof(duet_pose),
        [RECORDED_FORCES] = sizeof(duet_force),
        [RECORDED_IMPULSES] = sizeof(duet_impulse),
        [RECORDED_TARGETS] = sizeof(duet_transform),
    };
    return kind < RECORDED_KINDS ? sizes[kind] : 0;
}

bool recorded_has_ids(uint32_t kind)
{
    return kind != RECORDED_STEPS && kind != RECORDED_ADD && kind != RECORDED_DEF;
}

// ---------------------------------------------------------------- noting

static void add(text *to, const void *bytes, size_t n)
{
    if (n > 0)
        text_add_bytes(to, bytes, n);
}

static void add_steps(text *to, uint64_t steps)
{
    while (steps > 0) {
        uint32_t some = steps < UINT32_MAX ? (uint32_t)steps : UINT32_MAX;
        const recorded r = {.kind = RECORDED_STEPS, .n = some};
        add(to, &r, sizeof r);
        steps -= some;
    }
}

// The text of a motion that is recorded, with the steps that came before; NULL where it is not.
static text *begin(duet_motion *m, recorded_kind kind, uint32_t n, uint32_t fields)
{
    if (!m->recording)
        return NULL;
    text *to = &m->recording->records;
    const recorded r = {.kind = kind, .n = n, .fields = fields};
    add_steps(to, m->recording->steps);
    m->recording->steps = 0;
    add(to, &r, sizeof r);
    return to;
}

static void add_ids(duet_motion *m, text *to, recorded_kind kind, const uint32_t *places,
                    uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i) {
        // The removed one's, not the next one's.
        uint32_t generation = m->commands->generations[places[i]] - (kind == RECORDED_REMOVE);
        const uint64_t id = (uint64_t)generation << 32 | places[i];
        add(to, &id, sizeof id);
    }
}

static void add_bodies(text *to, const duet_body *bodies, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i) {
        const packed_body b = packed_body_of(&bodies[i]);
        add(to, &b, sizeof b);
    }
}

void motion_note(duet_motion *m, recorded_kind kind, const uint32_t *places, uint32_t n,
                 const void *rows)
{
    text *to = n > 0 ? begin(m, kind, n, 0) : NULL;
    if (!to)
        return;
    add_ids(m, to, kind, places, n);
    add(to, rows, n * recorded_row(kind)); // of no kind that has bodies
}

void motion_note_bodies(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t fields,
                        const duet_body *bodies)
{
    text *to = n > 0 ? begin(m, RECORDED_BODIES, n, fields) : NULL;
    if (!to)
        return;
    add_ids(m, to, RECORDED_BODIES, places, n);
    add_bodies(to, bodies, n);
}

void motion_note_arrivals(duet_motion *m, const duet_pose *poses, const duet_body *bodies,
                          uint32_t n)
{
    text *to = n > 0 ? begin(m, RECORDED_ADD, n, 0) : NULL;
    if (!to)
        return;
    add(to, poses, n * sizeof *poses);
    add_bodies(to, bodies, n);
}

void motion_note_def(duet_motion *m)
{
    text *to = begin(m, RECORDED_DEF, 0, 0);
    const packed_def d = packed_def_of(&m->def);
    if (to)
        add(to, &d, sizeof d);
}

void motion_forget_recording(duet_motion *m)
{
    if (m->recording)
        text_free(&m->recording->records);
    free(m->recording);
    m->recording = NULL;
}

// ---------------------------------------------------------------- files

bool duet_motion_record(duet_motion *m, duet_error *err)
{
    PUBLIC_CALL(err);
    uint64_t hash;
    if (!motion_is_whole(m, __func__, err) || !duet_motion_get_hash(m, &hash, err))
        return false;
    motion_recording *fresh = calloc(1, sizeof *fresh);
    if (!fresh)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a recording");
    fresh->head = (recording_head){.dims = m->def.dims, .n = m->n, .step = m->step, .hash = hash};
    memcpy(fresh->head.magic, recording_magic, sizeof recording_magic);
    motion_forget_recording(m);
    m->recording = fresh;
    return true;
}

bool duet_motion_save_recording(duet_motion *m, const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(m, __func__, "motion", err) || !error_given(path, __func__, "path", err))
        return false;
    if (!m->recording)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: nothing is recorded; expected duet_motion_record before, and no load "
                         "since",
                         __func__);
    if (!motion_is_whole(m, __func__, err))
        return false;
    recording_head head = m->recording->head;
    const text *records = &m->recording->records;
    text file = {0};
    bool ok = duet_motion_get_hash(m, &head.end_hash, err) && text_ok(records, err);
    add(&file, &head, sizeof head);
    add(&file, text_chars(records), records->length);
    add_steps(&file, m->recording->steps);
    uint64_t sum = ok && text_ok(&file, err) ? text_checksum(file.chars, file.length) : 0;
    add(&file, &sum, sizeof sum);
    ok = ok && text_ok(&file, err) && text_write_file(path, file.chars, file.length, err);
    text_free(&file);
    return ok;
}
