// SPDX-License-Identifier: MIT
// Recorded commands, given to a motion again. The file's form is checked when it is read;
// whether its commands are right is for the calls that they go to.
#include "runtime/dynamics/motion.h"
#include "runtime/dynamics/recording.h"

#include "base/error.h"
#include "base/text_file.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

struct duet_replay {
    char *path;
    text file;
    recording_head head;
    size_t at, end;      // of the record that comes next, and of all
    uint32_t steps_left; // of the record
    duet_replay_info info;
    uint64_t commands_done;
    bool begun;
};

// ---------------------------------------------------------------- reading

static bool damaged(const char *path, duet_error *err)
{
    return error_set(err, DUET_STATUS_BAD_INPUT, "%s: the recording is cut short or damaged", path);
}

// Bytes of a record behind its head; SIZE_MAX where it is none.
static size_t size_of(const recorded *r)
{
    bool is_def = r->kind == RECORDED_DEF, is_steps = r->kind == RECORDED_STEPS;
    if (r->kind >= RECORDED_KINDS || r->unused || (r->fields && r->kind != RECORDED_BODIES) ||
        (r->n == 0) != is_def)
        return SIZE_MAX;
    if (is_steps)
        return 0;
    if (is_def)
        return sizeof(packed_def);
    return r->n * ((recorded_has_ids(r->kind) ? sizeof(uint64_t) : 0) + recorded_row(r->kind));
}

static bool count_records(duet_replay *p, duet_error *err)
{
    for (size_t at = p->at; at < p->end;) {
        recorded r;
        if (p->end - at < sizeof r)
            return damaged(p->path, err);
        memcpy(&r, p->file.chars + at, sizeof r);
        at += sizeof r;
        size_t size = size_of(&r);
        if (size > p->end - at)
            return damaged(p->path, err);
        at += size;
        *(r.kind == RECORDED_STEPS ? &p->info.steps : &p->info.commands) +=
            r.kind == RECORDED_STEPS ? r.n : 1;
    }
    return true;
}

static bool read_replay(duet_replay *p, duet_error *err)
{
    uint64_t sum;
    if (!text_read_file(&p->file, p->path, err) ||
        !text_check_magic(&p->file, recording_magic, p->path, err))
        return false;
    if (p->file.length < sizeof p->head + sizeof sum)
        return damaged(p->path, err);
    memcpy(&p->head, p->file.chars, sizeof p->head);
    p->at = sizeof p->head;
    p->end = p->file.length - sizeof sum;
    memcpy(&sum, p->file.chars + p->end, sizeof sum);
    return sum == text_checksum(p->file.chars, p->end) ? count_records(p, err)
                                                       : damaged(p->path, err);
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
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a replay");
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

// Of a record: ids, rows, and bodies made of them. Copies, so that all lies as it must.
typedef struct order {
    recorded head;
    uint64_t *ids;
    void *rows;
    duet_body *bodies;
} order;

static void forget_order(order *o)
{
    free(o->ids);
    free(o->rows);
    free(o->bodies);
}

static void *copy_of(const char *from, size_t bytes)
{
    void *to = malloc(bytes + 1);
    if (to)
        memcpy(to, from, bytes);
    return to;
}

static bool make_bodies(order *o, const char *from)
{
    o->bodies = malloc((size_t)o->head.n * sizeof *o->bodies);
    for (uint32_t i = 0; o->bodies && i < o->head.n; ++i, from += sizeof(packed_body)) {
        packed_body row;
        memcpy(&row, from, sizeof row);
        o->bodies[i] = packed_to_body(&row);
    }
    return o->bodies;
}

static bool take_order(duet_replay *p, order *o, duet_error *err)
{
    size_t n = o->head.n, size = size_of(&o->head);
    size_t id_bytes = recorded_has_ids(o->head.kind) ? n * sizeof *o->ids : 0;
    o->ids = copy_of(p->file.chars + p->at, id_bytes);
    o->rows = copy_of(p->file.chars + p->at + id_bytes, size - id_bytes);
    p->at += size;
    bool ok = o->ids && o->rows;
    if (ok && o->head.kind == RECORDED_BODIES)
        ok = make_bodies(o, o->rows);
    if (ok && o->head.kind == RECORDED_ADD)
        ok = make_bodies(o, (char *)o->rows + n * sizeof(duet_pose));
    return ok || error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu recorded bodies", n);
}

static bool give_def(duet_motion *m, const packed_def *to, duet_error *err)
{
    duet_motion_def def = *duet_motion_get_def(m);
    packed_to_def(to, &def);
    return duet_motion_set_def(m, &def, err);
}

static bool give(duet_motion *m, const order *o, duet_error *err)
{
    const duet_body_list list = {.ids = o->ids, .n = o->head.n};
    switch (o->head.kind) {
    case RECORDED_ADD:
        return duet_motion_add_bodies(m, o->rows, o->bodies, list.n, NULL, err);
    case RECORDED_REMOVE:
        return duet_motion_remove_bodies(m, list, err);
    case RECORDED_DISABLE:
        return duet_motion_disable_bodies(m, list, err);
    case RECORDED_ENABLE:
        return duet_motion_enable_bodies(m, list, err);
    case RECORDED_WAKE:
        return duet_motion_wake_bodies(m, list, err);
    case RECORDED_SLEEP:
        return duet_motion_sleep_bodies(m, list, err);
    case RECORDED_USER_DATA:
        return duet_motion_set_user_data(m, list, o->rows, err);
    case RECORDED_BODIES:
        return duet_motion_set_bodies(m, list, o->head.fields, o->bodies, err);
    case RECORDED_POSES:
        return duet_motion_set_poses(m, list, o->rows, err);
    case RECORDED_FORCES:
        return duet_motion_apply_forces(m, list, o->rows, err);
    case RECORDED_IMPULSES:
        return duet_motion_apply_impulses(m, list, o->rows, err);
    case RECORDED_TARGETS:
        return duet_motion_set_targets(m, list, o->rows, err);
    default:
        return give_def(m, o->rows, err);
    }
}

static bool is_refusal(duet_status status)
{
    return status == DUET_STATUS_BAD_ARGUMENT || status == DUET_STATUS_BAD_OBJECT;
}

// A record that is a command is given to the motion.
static bool give_next(duet_replay *p, const recorded *head, duet_motion *m, duet_error *err)
{
    order o = {.head = *head};
    duet_error why = {0};
    bool ok = take_order(p, &o, err);
    ++p->commands_done;
    if (ok && !give(m, &o, &why)) {
        duet_status status = is_refusal(why.status) ? DUET_STATUS_BAD_INPUT : why.status;
        ok = error_set(err, status, "%s: command %" PRIu64 " of %" PRIu64 ": %s", p->path,
                       p->commands_done, p->info.commands, why.text);
    }
    forget_order(&o);
    return ok;
}

// Gives commands up to the next step; steps_left is 0 where there is none.
static bool give_commands(duet_replay *p, duet_motion *m, duet_error *err)
{
    bool ok = true;
    while (ok && p->steps_left == 0 && p->at < p->end) {
        recorded head;
        memcpy(&head, p->file.chars + p->at, sizeof head);
        p->at += sizeof head;
        if (head.kind == RECORDED_STEPS)
            p->steps_left = head.n;
        else
            ok = give_next(p, &head, m, err);
    }
    return ok;
}

// ---------------------------------------------------------------- steps

static bool check_begin(duet_replay *p, duet_motion *m, duet_error *err)
{
    uint64_t hash;
    if (p->begun)
        return true;
    if (!duet_motion_get_hash(m, &hash, err))
        return false;
    p->begun = duet_motion_get_count(m) == p->head.n && m->step == p->head.step &&
               hash == p->head.hash && duet_motion_get_def(m)->dims == p->head.dims;
    return p->begun ||
           error_set(err, DUET_STATUS_BAD_INPUT,
                     "%s: recorded from step %" PRIu64 ", %u places and the state hash %016" PRIx64
                     "; the motion is at step %" PRIu64 " with %u places and %016" PRIx64,
                     p->path, p->head.step, p->head.n, p->head.hash, m->step,
                     duet_motion_get_count(m), hash);
}

static bool check_end(const duet_replay *p, duet_motion *m, duet_error *err)
{
    uint64_t hash;
    return duet_motion_get_hash(m, &hash, err) &&
           (hash == p->head.end_hash ||
            error_set(err, DUET_STATUS_WRONG_RESULT,
                      "%s: the state hash is %016" PRIx64 " at the end; expected the recorded "
                      "%016" PRIx64,
                      p->path, hash, p->head.end_hash));
}

bool duet_replay_advance(duet_replay *p, duet_motion *m, duet_motion_result *result,
                         duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(p, __func__, "replay", err) || !error_given(m, __func__, "motion", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    if (p->info.steps_done == p->info.steps)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: all %" PRIu64 " recorded steps are done", p->path, p->info.steps);
    if (!check_begin(p, m, err) || !give_commands(p, m, err) ||
        !duet_motion_advance(m, result, err))
        return false;
    --p->steps_left;
    ++p->info.steps_done;
    return p->info.steps_done < p->info.steps || (give_commands(p, m, err) && check_end(p, m, err));
}
