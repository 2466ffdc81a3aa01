// SPDX-License-Identifier: MIT
// Recorded commands, given to a motion again. The file's form is checked when it is read;
// whether its commands are right is for the calls that they go to.
#include "runtime/commands/replay.h"

#include "runtime/commands/commands.h"
#include "runtime/commands/recording.h"

#include "base/error.h"
#include "base/text_file.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct duet_replay {
    char *path;
    text file;
    recording_head head;
    uint64_t ground; // sum of the ground that it was recorded on; 0: none
    uint64_t end_hash;
    size_t at, end;      // offsets of the next record, and of the end of all
    uint32_t steps_left; // the record's
    uint64_t
        equal_step; // the last of the motion's steps whose hash was seen to be the recorded one
    duet_replay_info info;
    uint64_t commands_done;
    bool begun;
};

// ---------------------------------------------------------------- reading

static bool damaged(const char *path, duet_error *err)
{
    return bad_input(err, "%s: the recording is cut short or damaged", path);
}

// Bytes of a record behind its head; SIZE_MAX if it is none.
static size_t size_of(const recorded *r)
{
    const command_op *op = command_op_at(r->kind);
    if (r->kind == RECORDED_HASH)
        return r->n == 1 && !r->fields && !r->unused ? sizeof(uint64_t) : SIZE_MAX;
    if (r->n == 0 || r->unused || (!op && r->kind != RECORDED_STEPS) ||
        (r->fields && (!op || op->form != COMMAND_FIELDS)) ||
        (op && op->form == COMMAND_DEF && r->n != 1))
        return SIZE_MAX;
    const recorded_sizes each = op ? recorded_sizes_of(op) : (recorded_sizes){0};
    return r->n * (each.ids + each.row + each.body);
}

// A hash is of the state that a step left: it comes behind steps.
static bool count_records(duet_replay *p, duet_error *err)
{
    uint32_t before = RECORDED_HASH;
    for (size_t at = p->at; at < p->end;) {
        recorded r;
        if (p->end - at < sizeof r)
            return damaged(p->path, err);
        memcpy(&r, p->file.chars + at, sizeof r);
        at += sizeof r;
        size_t size = size_of(&r);
        if (size > p->end - at || (r.kind == RECORDED_HASH && before != RECORDED_STEPS))
            return damaged(p->path, err);
        at += size;
        before = r.kind;
        p->info.steps += r.kind == RECORDED_STEPS ? r.n : 0;
        p->info.commands += r.kind != RECORDED_STEPS && r.kind != RECORDED_HASH;
    }
    return true;
}

// Takes the ground's sum if that is the first record; elsewhere no record has its kind.
static void take_ground(duet_replay *p)
{
    recorded r;
    if (p->end - p->at < sizeof r + sizeof p->ground)
        return;
    memcpy(&r, p->file.chars + p->at, sizeof r);
    if (r.kind != RECORDED_GROUND || r.n != 1 || r.fields || r.unused)
        return;
    memcpy(&p->ground, p->file.chars + p->at + sizeof r, sizeof p->ground);
    p->at += sizeof r + sizeof p->ground;
}

static bool read_replay(duet_replay *p, duet_error *err)
{
    uint64_t sum;
    if (!text_read_file(&p->file, p->path, err) ||
        !text_check_magic(&p->file, recording_magic, p->path, err))
        return false;
    if (p->file.length < sizeof p->head + sizeof p->end_hash + sizeof sum)
        return damaged(p->path, err);
    memcpy(&p->head, p->file.chars, sizeof p->head);
    memcpy(&sum, p->file.chars + p->file.length - sizeof sum, sizeof sum);
    p->at = sizeof p->head;
    p->equal_step = p->head.step;
    p->end = p->file.length - sizeof sum - sizeof p->end_hash;
    memcpy(&p->end_hash, p->file.chars + p->end, sizeof p->end_hash);
    if (sum != text_checksum(p->file.chars, p->file.length - sizeof sum))
        return damaged(p->path, err);
    take_ground(p);
    return count_records(p, err);
}

duet_replay *duet_replay_create(const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(path, __func__, "path", err))
        return NULL;
    duet_replay *p = calloc(1, sizeof *p);
    size_t length = strlen(path) + 1;
    if (p)
        p->path = malloc(length);
    if (!p || !p->path) {
        free(p);
        no_memory(err, "a replay");
        return NULL;
    }
    memcpy(p->path, path, length);
    if (read_replay(p, err))
        return p;
    duet_replay_destroy(p);
    return NULL;
}

void duet_replay_destroy(duet_replay *p)
{
    if (!p)
        return;
    text_free(&p->file);
    free(p->path);
    free(p);
}

duet_replay_info duet_replay_get_info(const duet_replay *p)
{
    return p ? p->info : (duet_replay_info){0};
}

// ---------------------------------------------------------------- commands

static void *copy_of(const char **from, size_t bytes)
{
    void *to = malloc(bytes + 1);
    if (to)
        memcpy(to, *from, bytes);
    *from += bytes;
    return to;
}

static duet_body *bodies_of(const char *from, uint32_t n)
{
    duet_body *bodies = malloc(n * sizeof *bodies);
    for (uint32_t i = 0; bodies && i < n; ++i, from += sizeof(packed_body)) {
        packed_body row;
        memcpy(&row, from, sizeof row);
        bodies[i] = packed_to_body(&row);
    }
    return bodies;
}

// Copies a record's ids, rows and bodies, so that all lies as it must.
static bool copy_record(const recorded *record, const char *from, const duet_motion_def *def,
                        replayed *r, duet_error *err)
{
    const command_op *op = command_op_at(record->kind);
    const recorded_sizes each = recorded_sizes_of(op);
    r->ids = copy_of(&from, record->n * each.ids);
    r->rows = copy_of(&from, record->n * each.row);
    r->bodies = each.body > 0 ? bodies_of(from, record->n) : NULL;
    r->c = (command){.op = op,
                     .list = {.ids = each.ids > 0 ? r->ids : NULL, .n = record->n},
                     .fields = record->fields,
                     .rows = each.row > 0 ? r->rows : r->bodies,
                     .new_bodies = r->bodies};
    if (!r->ids || !r->rows || (!r->bodies && each.body > 0))
        return no_memory(err, "%u recorded bodies", record->n);
    if (op->form != COMMAND_DEF)
        return true;
    r->def = *def;
    packed_to_def(r->rows, &r->def);
    r->c.rows = &r->def;
    return true;
}

void replayed_free(replayed *r)
{
    free(r->ids);
    free(r->rows);
    free(r->bodies);
}

replay_place replay_get_place(const duet_replay *p)
{
    return (replay_place){.at = p->at,
                          .steps_left = p->steps_left,
                          .steps_done = p->info.steps_done,
                          .commands_done = p->commands_done,
                          .equal_step = p->equal_step,
                          .begun = p->begun};
}

void replay_set_place(duet_replay *p, const replay_place *place)
{
    p->at = place->at;
    p->steps_left = place->steps_left;
    p->info.steps_done = place->steps_done;
    p->commands_done = place->commands_done;
    p->equal_step = place->equal_step;
    p->begun = place->begun;
}

static bool is_refusal(duet_status status)
{
    return status == DUET_STATUS_BAD_ARGUMENT || status == DUET_STATUS_BAD_OBJECT;
}

bool replay_blame(const char *path, uint64_t number, uint64_t n, const duet_error *why,
                  duet_error *err)
{
    duet_status status = is_refusal(why->status) ? DUET_STATUS_BAD_INPUT : why->status;
    return error_set(err, status, "%s: command %" PRIu64 " of %" PRIu64 ": %s", path, number, n,
                     why->text);
}

// Reads the head of the next record, which is none of a step that was not made yet.
static bool next_is(const duet_replay *p, recorded *head)
{
    if (p->steps_left > 0 || p->at == p->end)
        return false;
    memcpy(head, p->file.chars + p->at, sizeof *head);
    return true;
}

bool replay_has_hash(const duet_replay *p)
{
    recorded head;
    return next_is(p, &head) && head.kind == RECORDED_HASH;
}

static void skip_hash(duet_replay *p)
{
    if (replay_has_hash(p))
        p->at += sizeof(recorded) + sizeof(uint64_t);
}

bool replay_take(duet_replay *p, const duet_motion_def *def, replayed *r, duet_error *err)
{
    recorded head;
    *r = (replayed){0};
    skip_hash(p); // of who did not compare it
    if (!next_is(p, &head))
        return true;
    const char *from = p->file.chars + p->at + sizeof head;
    p->at += sizeof head + size_of(&head);
    if (head.kind == RECORDED_STEPS) {
        p->steps_left = head.n;
        return true;
    }
    ++p->commands_done;
    return copy_record(&head, from, def, r, err);
}

// Gives commands up to the next step; steps_left is 0 if there is none.
static bool give_commands(duet_replay *p, duet_motion *m, duet_error *err)
{
    bool ok = true, given = true;
    while (ok && given) {
        duet_error why = {0};
        replayed r;
        ok = replay_take(p, duet_motion_get_def(m), &r, &why);
        given = ok && r.c.op;
        ok = ok && (!given || command_give(m, &r.c, &why));
        if (!ok)
            replay_blame(p->path, p->commands_done, p->info.commands, &why, err);
        replayed_free(&r);
    }
    return ok;
}

// ---------------------------------------------------------------- steps

static uint64_t step_of(const duet_replay *p)
{
    return p->head.step + p->info.steps_done;
}

static bool check_ground(const duet_replay *p, uint64_t sum, duet_error *err)
{
    return p->ground == sum || bad_input(err, "%s: recorded on %s; the motion has %s", p->path,
                                         p->ground ? "a ground" : "no ground",
                                         sum == 0    ? "none"
                                         : p->ground ? "another"
                                                     : "one");
}

bool replay_check_begin(const duet_replay *p, const replay_begin *b, duet_error *err)
{
    const recording_head *head = &p->head;
    if (!check_ground(p, b->ground, err))
        return false;
    return (b->n == head->n && b->step == head->step && b->hash == head->hash &&
            b->dims == head->dims) ||
           bad_input(err,
                     "%s: recorded from step %" PRIu64 ", %u places and the state hash %016" PRIx64
                     "; the motion is at step %" PRIu64 " with %u places and %016" PRIx64,
                     p->path, head->step, head->n, head->hash, b->step, b->n, b->hash);
}

// The record that comes next is no step that was not made yet.
static void pass_record(duet_replay *p)
{
    recorded head;
    memcpy(&head, p->file.chars + p->at, sizeof head);
    p->at += sizeof head + size_of(&head);
    if (head.kind == RECORDED_STEPS)
        p->steps_left = head.n;
    else
        p->commands_done += head.kind != RECORDED_HASH;
}

bool replay_pass(duet_replay *p, const replay_begin *b, duet_error *err)
{
    const uint64_t first = p->head.step, last = first + p->info.steps;
    if (!check_ground(p, b->ground, err))
        return false;
    if (b->dims != p->head.dims || b->step < first || b->step > last)
        return bad_input(err,
                         "%s: recorded from step %" PRIu64 " to %" PRIu64
                         " in %uD; the motion is at step %" PRIu64 " in %uD",
                         p->path, first, last, p->head.dims, b->step, b->dims);
    while (step_of(p) < b->step) {
        if (p->steps_left == 0)
            pass_record(p);
        else
            replay_note_step(p);
    }
    p->begun = true;
    return true;
}

static bool check_begin(duet_replay *p, duet_motion *m, duet_error *err)
{
    if (p->begun)
        return true;
    replay_begin b = {.n = duet_motion_get_count(m),
                      .dims = duet_motion_get_def(m)->dims,
                      .step = m->step,
                      .ground = recorded_ground_sum(m)};
    p->begun = duet_motion_get_hash(m, &b.hash, err) && replay_check_begin(p, &b, err);
    return p->begun;
}

bool replay_note_step(duet_replay *p)
{
    --p->steps_left;
    return ++p->info.steps_done == p->info.steps;
}

// Names the steps one of which is the first that differs.
static bool refuse_hash(const duet_replay *p, const char *when, uint64_t hash, uint64_t expected,
                        duet_error *err)
{
    const uint64_t first = p->equal_step + 1, last = step_of(p);
    char where[80];
    if (first > last)
        snprintf(where, sizeof where, "the commands after step %" PRIu64 " differ", last);
    else if (first == last)
        snprintf(where, sizeof where, "step %" PRIu64 " is the first that differs", last);
    else
        snprintf(where, sizeof where,
                 "the first step that differs is one of %" PRIu64 " to %" PRIu64, first, last);
    return error_set(err, DUET_STATUS_WRONG_RESULT,
                     "%s: the state hash is %016" PRIx64 " at %s; expected the recorded "
                     "%016" PRIx64 "; %s",
                     p->path, hash, when, expected, where);
}

bool replay_check_hash(duet_replay *p, uint64_t hash, duet_error *err)
{
    uint64_t expected;
    char when[32];
    memcpy(&expected, p->file.chars + p->at + sizeof(recorded), sizeof expected);
    skip_hash(p);
    snprintf(when, sizeof when, "step %" PRIu64, step_of(p));
    if (hash != expected)
        return refuse_hash(p, when, hash, expected, err);
    p->equal_step = step_of(p);
    return true;
}

bool replay_check_end(const duet_replay *p, uint64_t hash, duet_error *err)
{
    return hash == p->end_hash || refuse_hash(p, "the end", hash, p->end_hash, err);
}

static bool compare_hash(duet_replay *p, duet_motion *m, duet_error *err)
{
    uint64_t hash;
    return !replay_has_hash(p) ||
           (duet_motion_get_hash(m, &hash, err) && replay_check_hash(p, hash, err));
}

static bool end(duet_replay *p, duet_motion *m, duet_error *err)
{
    uint64_t hash;
    return give_commands(p, m, err) && duet_motion_get_hash(m, &hash, err) &&
           replay_check_end(p, hash, err);
}

bool replay_give(duet_replay *p, duet_motion *m, bool *given, duet_error *err)
{
    uint64_t before = p->commands_done;
    bool ok = check_begin(p, m, err) && give_commands(p, m, err);
    *given = p->commands_done > before;
    return ok;
}

bool duet_replay_advance(duet_replay *p, duet_motion *m, duet_motion_result *result,
                         duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(p, __func__, "replay", err) || !error_given(m, __func__, "motion", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    if (p->info.steps_done == p->info.steps)
        return bad_argument(err, "%s: all %" PRIu64 " recorded steps are done", p->path,
                            p->info.steps);
    if (!check_begin(p, m, err) || !give_commands(p, m, err) ||
        !duet_motion_advance(m, result, err))
        return false;
    bool is_last = replay_note_step(p);
    return compare_hash(p, m, err) && (!is_last || end(p, m, err));
}
