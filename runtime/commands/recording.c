// SPDX-License-Identifier: MIT
#include "runtime/commands/recording.h"

#include "base/error.h"
#include "base/text_file.h"
#include "runtime/commands/saved_motion.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static_assert(sizeof(recording_head) == 40, "no byte of a file is left to chance");

const char recording_magic[16] = "duet commands 2\n";

recorded_sizes recorded_sizes_of(const command_op *op)
{
    switch (op->form) {
    case COMMAND_ADD:
        return (recorded_sizes){.row = op->row, .body = sizeof(packed_body)};
    case COMMAND_DEF:
        return (recorded_sizes){.row = sizeof(packed_def)};
    case COMMAND_FIELDS:
        return (recorded_sizes){.ids = sizeof(uint64_t), .body = sizeof(packed_body)};
    default:
        return (recorded_sizes){.ids = sizeof(uint64_t), .row = op->row};
    }
}

// ---------------------------------------------------------------- noting

static void add(text *to, const void *bytes, size_t n)
{
    if (n > 0)
        text_add_bytes(to, bytes, n);
}

static void add_def(text *to, const duet_motion_def *def)
{
    const packed_def packed = packed_def_of(def);
    add(to, &packed, sizeof packed);
}

void recording_add(duet_motion *m, const command *c)
{
    text *to = m->recording;
    const uint32_t n = c->list.n;
    const recorded_sizes sizes = recorded_sizes_of(c->op);
    const recorded r = {.kind = c->op->number, .n = n, .fields = c->fields};
    if (!to || n == 0)
        return;
    recorded_steps_add(m);
    add(to, &r, sizeof r);
    add(to, c->ids, n * sizes.ids);
    if (c->op->form == COMMAND_DEF)
        add_def(to, c->rows);
    else
        add(to, c->rows, n * sizes.row);
    for (uint32_t i = 0; sizes.body > 0 && i < n; ++i) {
        const packed_body b = packed_body_of(&c->bodies[i]);
        add(to, &b, sizeof b);
    }
}

// ---------------------------------------------------------------- the ground

uint64_t recorded_ground_sum(const duet_motion *m)
{
    text ground = {0};
    saved_ground_add(m, &ground);
    uint64_t sum = ground.length > 0 ? text_checksum(ground.chars, ground.length) : 0;
    text_free(&ground);
    return sum;
}

static void add_ground(text *to, const duet_motion *m)
{
    const recorded r = {.kind = RECORDED_GROUND, .n = 1};
    uint64_t sum = recorded_ground_sum(m);
    if (sum == 0)
        return;
    add(to, &r, sizeof r);
    add(to, &sum, sizeof sum);
}

// ---------------------------------------------------------------- files

bool duet_motion_record(duet_motion *m, duet_error *err)
{
    PUBLIC_CALL(err);
    uint64_t hash;
    if (!motion_is_whole(m, __func__, err) || !duet_motion_get_hash(m, &hash, err))
        return false;
    recording_head head = {.dims = m->def.dims, .n = m->n, .step = m->step, .hash = hash};
    memcpy(head.magic, recording_magic, sizeof recording_magic);
    text *fresh = calloc(1, sizeof *fresh);
    if (!fresh)
        return no_memory(err, "a recording");
    add(fresh, &head, sizeof head);
    add_ground(fresh, m);
    motion_forget_recording(m);
    recorded_steps_begin(m, fresh);
    return true;
}

bool duet_motion_save_recording(duet_motion *m, const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    uint64_t hash;
    if (!error_given(m, __func__, "motion", err) || !error_given(path, __func__, "path", err))
        return false;
    if (!m->recording)
        return bad_argument(
            err, "%s: nothing is recorded; expected duet_motion_record before, and no load since",
            __func__);
    if (!motion_is_whole(m, __func__, err) || !text_ok(m->recording, err) ||
        !duet_motion_get_hash(m, &hash, err))
        return false;
    text file = {0};
    recorded_steps_add(m);
    add(&file, text_chars(m->recording), m->recording->length);
    add(&file, &hash, sizeof hash);
    uint64_t sum = text_checksum(text_chars(&file), file.length);
    add(&file, &sum, sizeof sum);
    bool ok = text_ok(&file, err) && text_write_file(path, file.chars, file.length, err);
    text_free(&file);
    return ok;
}
